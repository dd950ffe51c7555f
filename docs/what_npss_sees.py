"""Draw the pictures and write the tables of the page "What NPSS sees", from generated walks.

Sphinx does so when it builds the page; as a program, this writes the picture of the README.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np
from moving import SIZE, figures, svg

import npss
import npss.plot
from npss import rotations
from npss.console import table
from npss.gait import gait
from npss.protocol import FPS
from npss.skeleton import FEATURE_NAMES, H36M, poses_to_positions
from npss.validation import Float64

N_WALKS, N_SEED, N_TARGET = 16, 50, 100
#: Which of the walks is drawn.
DRAWN = 0
_TRUTH, _PREDICTED = "#8a8f98", "#d55e00"


@cache
def variations() -> dict[str, Float64]:
    """Return the truth, and predictions that differ from it in one way: poses ``(N, T, 99)`` by name."""
    walks = gait(N_WALKS, 2 * (N_SEED + N_TARGET), seed=0)
    start = N_SEED + N_TARGET // 2

    def from_frame(first: float, tempo: float = 1.0) -> Float64:
        frames = first + tempo * np.arange(N_TARGET)
        before = np.floor(frames).astype(int)
        share = (frames - before)[:, np.newaxis]
        return (1 - share) * walks[:, before] + share * walks[:, before + 1]

    truth = from_frame(start)
    return {
        "truth": truth,
        "half a step later": from_frame(start + 6),
        "a tenth faster": from_frame(start, 1.1),
        "twice as fast": from_frame(start, 2.0),
        "backwards": truth[:, ::-1],
        "with half the swing": truth.mean(axis=1, keepdims=True) + 0.5 * (truth - truth.mean(axis=1, keepdims=True)),
        "standing still": np.repeat(walks[:, start - 1 : start], N_TARGET, axis=1),
    }


def scores() -> str:
    """Return the table of the variations, in Markdown."""
    truth, *others = variations()
    gt = npss.poses_to_euler(variations()[truth])
    rows = []
    for name in others:
        pred = npss.poses_to_euler(variations()[name])
        errors = npss.euler_error(gt, pred, fps=FPS, at_ms=(400, 1000))
        values = [*(npss.score(gt, pred, convention=c) for c in npss.CONVENTIONS), *errors.values()]
        rows.append([f"![{name}](_drawn/{name.replace(' ', '-')}.svg)", name, *(f"{value:.3f}" for value in values)])
    head = ["", "prediction", *(f"NPSS {name}" for name in npss.CONVENTIONS), "Euler error, 400 ms", "1000 ms"]
    lines = [
        *(npss.signature(name, representation="euler", frames=N_TARGET, fps=FPS) for name in npss.CONVENTIONS),
        npss.signature(None, metric="euler_error", representation="euler", frames=N_TARGET, fps=FPS, **_AT),
    ]
    return "\n".join([table(head, rows, "llrrrrr", markdown=True), "", *(f"    {line}" for line in lines), ""])


_AT = {"average": "at", "columns": "gt"}


def representations() -> str:
    """Return the table of one prediction in several representations, in Markdown."""
    joints = [motion[..., 3:].reshape(*motion.shape[:-1], -1, 3) for motion in map(variations().get, _PAIR)]
    views: Mapping[str, Callable[[Float64], Float64]] = {
        "quaternions": lambda x: rotations.continuous(rotations.expmap_to_quaternion(x), axis=1),
        "rotation matrices": rotations.expmap_to_matrix,
        "6D": rotations.expmap_to_sixd,
        "Euler angles": rotations.expmap_to_euler,
        "exponential maps": lambda x: x,
    }
    rows = []
    for name, view in views.items():
        gt, pred = (view(x).reshape(*x.shape[:2], -1) for x in joints)
        rows.append([name, *(f"{npss.score(gt, pred, convention=c):.4f}" for c in npss.CONVENTIONS)])
    return table(["the same motion as", *npss.CONVENTIONS], rows, "lrrr", markdown=True) + "\n"


_PAIR = ("truth", "a tenth faster")


def moving(*names: str) -> str:
    """Return the paths of figures side by side that move, each with the name of its motion, as SVG."""
    places = [poses_to_positions(variations()[name][DRAWN, ::_EVERY]) for name in names]
    colours = [_TRUTH if name == "truth" else _PREDICTED for name in names]
    return figures(places, colours, _BONES, N_TARGET / FPS)


def picture() -> str:
    """Return the picture of the README: a walk, three predictions of it, and what two metrics say of each."""
    names = ("truth", *_PICTURED)
    lines = [f'<text x="{SIZE / 2}" y="{SIZE + 20}">a walk</text>']
    for column, name in enumerate(_PICTURED, 1):
        gt, pred = (npss.poses_to_euler(variations()[motion]) for motion in ("truth", name))
        error = npss.euler_error(gt, pred, fps=FPS, at_ms=(400,))[400]
        texts = (name, f"NPSS {npss.score(gt, pred):.2f}", f"Euler error {error:.2f}")
        lines += [
            f'<text x="{(column + 0.5) * SIZE}" y="{SIZE + 20 * line}">{text}</text>'
            for line, text in enumerate(texts, 1)
        ]
    width, height = len(names) * SIZE, SIZE + 70
    return svg(
        width,
        height,
        f'<rect width="{width}" height="{height}" rx="8" fill="#fff"/>{moving(*names)}'
        f'<g font-family="sans-serif" font-size="13" text-anchor="middle" fill="#222">{"".join(lines)}</g>',
    )


_PICTURED = ("half a step later", "with half the swing", "standing still")
#: Frames from one that is drawn to the next; those between are interpolated.
_EVERY = 2
#: Bones with a length: the hips and shoulders of the skeleton have joints in one place.
_BONES = [(a, b) for a, b in H36M.bones if H36M.offsets[b].any()]


def draw(folder: Path) -> None:
    """Draw everything into a folder."""
    truth, *others = variations()
    for name in others:
        text = svg(2 * SIZE, SIZE, moving(truth, name))
        (folder / f"{name.replace(' ', '-')}.svg").write_text(text, encoding="utf-8")
    euler = {name: npss.poses_to_euler(motion) for name, motion in variations().items()}
    knee = FEATURE_NAMES.index("RightLeg.x")
    for name in ("half a step later", "a tenth faster", "standing still"):
        figure = npss.plot.spectra(
            euler[truth], euler[name], fps=FPS, feature=knee, names=("truth", name), feature_names=FEATURE_NAMES
        )
        figure.savefig(folder / f"spectra-{name.replace(' ', '-')}.svg")
    (folder / "scores.md").write_text(scores(), encoding="utf-8")
    (folder / "representations.md").write_text(representations(), encoding="utf-8")


if __name__ == "__main__":
    Path(__file__).with_name("walks.svg").write_text(picture(), encoding="utf-8")
