"""Sensitivity of the Euler error and NPSS to distortions of the ground truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss import CONVENTIONS, euler_error, poses_to_euler, protocol, score, signature
from npss.console import table
from npss.metrics import METRICS
from npss.predictors import zero_velocity
from npss.protocol import MOVES
from npss.records import Record
from npss.validation import Float64
from npss_baselines.data import PoseSource
from npss_baselines.data.tasks import N_SEED, N_TARGET

NPSS, EULER_ERROR = METRICS["npss"], METRICS["euler_error"]
TEMPI = (0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.3, 1.4)
SKIP_EVERY = (20, 10, 5, 4, 3)
SHIFTS = (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
NOISE = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3)
OFFSETS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
_STRIDE_S = (0.8, 1.8)  # range of a stride's duration: longer than half a stride, which looks similar


class Motion(NamedTuple):
    """The test windows with their clips, which have motion after each window."""

    protocol: str
    clips: list[Float64]  # (T, 99) each: Euler angles at 25 frames per second
    starts: list[int]  # the first target frame in each clip

    def at(self, frames: Sequence[npt.ArrayLike]) -> Float64:
        """Interpolate each clip linearly at its frames; return ``(N, 100, 99)``."""
        return np.stack([_between(clip, np.asarray(at)) for clip, at in zip(self.clips, frames, strict=True)])


def motion_of(source: PoseSource, folder: Path) -> Motion:
    """Return the test windows of a source's first default action, with the motion around them."""
    action, protocol = source.default_actions[0], source.protocols[0]
    clips = source.test_clips(folder, action)
    windows = source.windows(protocol, [len(clip) for clip in clips])
    angles = [poses_to_euler(clip.astype(np.float64)) for clip in clips]
    return Motion(protocol, [angles[window.clip] for window in windows], [window.target.start for window in windows])


def distorted(motion: Motion) -> Iterator[tuple[str, float, str, Float64]]:
    """Yield distortions of the windows: name, strength, unit, and ``(N, 100, 99)`` Euler angles.

    In time, by linear interpolation of the clip at other frames:

    - tempo: every step takes 1 / strength of its time, from the last seed frame on;
    - skipped frames: every k-th frame is left out, and later ones move up;
    - phase shift: the same motion, some strides later; a stride is measured from the seed to two seconds after the
      window.

    In space, in the features that move, like the Euler error's:

    - noise: independent Gaussian noise in each frame, of this standard deviation;
    - offset: a constant added to every angle.

    The first yield, as a yardstick, is zero-velocity.
    """
    seeds = np.stack([clip[start - 1 : start] for clip, start in zip(motion.clips, motion.starts, strict=True)])
    yield "zero-velocity", 0.0, "", zero_velocity(seeds, N_TARGET)
    frames = np.arange(N_TARGET)
    for tempo in TEMPI:
        yield "tempo", tempo, "times as fast", motion.at([start - 1 + tempo * (frames + 1) for start in motion.starts])
    undistorted = motion.at([start + frames for start in motion.starts])
    yield "skipped frames", 0.0, "share of frames", undistorted
    for k in SKIP_EVERY:
        yield (
            *("skipped frames", 1 / k, "share of frames"),
            motion.at([start + frames + frames // (k - 1) for start in motion.starts]),
        )
    surroundings = [slice(start - N_SEED, start + N_TARGET + N_SEED) for start in motion.starts]
    strides = [stride(clip[around]) for clip, around in zip(motion.clips, surroundings, strict=True)]
    for shift in SHIFTS:
        later = [start + frames + shift * length for start, length in zip(motion.starts, strides, strict=True)]
        yield "phase shift", shift, "strides", motion.at(later)
    moves = undistorted.std(axis=1, keepdims=True) > MOVES
    noise = np.random.default_rng(0).standard_normal(undistorted.shape) * moves
    for deviation in NOISE:
        yield "noise", deviation, "standard deviation (rad)", undistorted + deviation * noise
    for offset in OFFSETS:
        yield "offset", offset, "rad", undistorted + offset * moves


def stride(clip: Float64) -> int:
    """Return the frames of a stride: the lag of the highest autocorrelation of a clip ``(T, D)``."""
    swings = clip - clip.mean(axis=0)
    lags = range(*(round(seconds * protocol.FPS) for seconds in _STRIDE_S))
    return max(lags, key=lambda lag: float(np.mean(swings[lag:] * swings[:-lag])))


def study(motion: Motion) -> list[Record]:
    """Measure every distortion.

    Returns
    -------
    list of dict
        ``distortion``, ``strength``, ``unit``; ``euler_error``, averaged over all frames, in radians; ``npss`` by
        convention; ``signatures`` by metric or convention.
    """
    gt = motion.at([start + np.arange(N_TARGET) for start in motion.starts])
    end_ms = protocol.frames_to_ms([N_TARGET - 1])[0]
    context: dict[str, Any] = {
        "representation": "euler",
        "frames": N_TARGET,
        "fps": protocol.FPS,
        "protocol": motion.protocol,
        "unwrap": "off",
    }
    signatures: dict[str, str] = {name: signature(name, **context) for name in CONVENTIONS}
    signatures[EULER_ERROR.name] = signature(
        None, metric=EULER_ERROR.name, columns="gt", average="up-to", at_ms=end_ms, **context
    )
    return [
        {
            "distortion": name,
            "strength": strength,
            "unit": unit,
            "euler_error": euler_error(gt, pred, fps=protocol.FPS, at_ms=(end_ms,), average="up-to")[end_ms],
            "npss": {convention: score(gt, pred, convention=convention) for convention in CONVENTIONS},
            "signatures": signatures,
        }
        for name, strength, unit, pred in distorted(motion)
    ]


def tabulate(records: Sequence[Record], *, markdown: bool = False) -> str:
    """Format records as a table."""
    scores = [NPSS.column(convention=name) for name in records[0]["npss"]]
    header = ["distortion", "strength", "unit", EULER_ERROR.labelled, *scores]
    rows = [
        [
            *(record["distortion"], f"{record['strength']:.4g}", record["unit"]),
            *(f"{value:.4f}" for value in (record["euler_error"], *record["npss"].values())),
        ]
        for record in records
    ]
    lines = [f"    {line}" for line in records[0]["signatures"].values()]
    return "\n".join([table(header, rows, "lrl" + "r" * (len(header) - 3), markdown=markdown), "", *lines])


def _between(clip: Float64, at: Float64) -> Float64:
    """Interpolate a clip linearly at positions in frames."""
    if at.max() > len(clip) - 1:
        raise ValueError(f"clip: {len(clip)} frames, but a distortion reads frame {at.max():.4g}")
    before = np.floor(at).astype(int)
    share = (at - before)[:, np.newaxis]
    values: Float64 = (1 - share) * clip[before] + share * clip[np.minimum(before + 1, len(clip) - 1)]
    return values
