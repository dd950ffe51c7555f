"""The page of a report: leaderboards, diagnosis, pictures, moving skeletons and signatures."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

import numpy.typing as npt

from npss._pages._html import figure, pack, page, positions_array
from npss.ranking._render import CITE
from npss.skeleton import Skeleton


class Figure(NamedTuple):
    """A picture with a title and a caption."""

    title: str
    image: str | bytes  # SVG as text, or the bytes of a PNG file
    caption: str


def report_page(
    *,
    title: str,
    boards: Sequence[str],
    notes: Sequence[str] = (),
    signatures: Sequence[str],
    parts: Sequence[tuple[str, Sequence[str]]] = (),
    figures: Sequence[Figure],
    findings: Sequence[tuple[str, Sequence[str]]],
    clips: Mapping[str, Mapping[str, npt.ArrayLike]],
    fps: float,
    skeleton: Skeleton,
) -> str:
    """Make the page of a report, without empty parts.

    Parameters
    ----------
    title : str
        The headline.
    boards : sequence of str
        Tables as trusted HTML, ``<table class="board">``. The first column stays in sight; ``mark`` is superscript;
        rows of class ``published`` are muted.
    notes : sequence of str, optional
        Notes on the tables.
    signatures : sequence of str
        The signatures of the numbers.
    parts : sequence of (str, sequence of str), optional
        What the scores are made of: headings, each with its lines.
    figures : sequence of Figure
        The pictures.
    findings : sequence of (str, sequence of str)
        The diagnosis: headings, each with its findings.
    clips : mapping of str to mapping of str to (N, T, J, 3) array_like
        Positions in millimetres, by action and label; the first label of each action is drawn as ground truth.
    fps : float
        Frames per second of the clips.
    skeleton : Skeleton
        The skeleton to draw.

    Returns
    -------
    str
        The page as HTML.

    Raises
    ------
    TypeError
        If positions are not real numbers.
    ValueError
        If a shape is wrong, the labels of an action have different numbers of sequences, or positions are not finite or
        too far from the origin.
    """
    shown = [
        {"name": action, "motions": _motions(f"clips[{action!r}]", labelled, skeleton)}
        for action, labelled in clips.items()
    ]
    sections = [
        ("leaderboard", "Leaderboard", "".join(map(_board, boards)) + _list("note", notes)),
        ("motion", "Motion", _MOTION if shown else ""),
        ("parts", "What the scores are made of", "".join(_lines(heading, lines) for heading, lines in parts)),
        ("diagnosis", "Diagnosis", "".join(_lines(heading, lines) for heading, lines in findings)),
        ("pictures", "Pictures", f'<div class="gallery">{"".join(map(_picture, figures))}</div>' if figures else ""),
        ("signatures", "Signatures", _SIGNATURES + "".join(map(_signature, signatures)) if signatures else ""),
        ("cite", "How to cite", f"<p>{escape(CITE)}</p>"),
    ]
    filled = [section for section in sections if section[2]]
    links = "".join(f'<li><a href="#{name}">{heading}</a></li>' for name, heading, _ in filled)
    body = "\n".join(f'<section id="{name}"><h2>{heading}</h2>\n{html}\n</section>' for name, heading, html in filled)
    return page(
        title=title,
        body=f"<main>\n<h1>{escape(title)}</h1>\n<nav><ul>{links}</ul></nav>\n{body}\n</main>",
        scripts=("player.js", "report.js"),
        data={"figure": figure(skeleton, fps), "clips": shown},
    )


_MOTION = """<div class="row">
<div class="field"><label for="action">Action</label><select id="action"></select></div>
<div class="field"><label for="sequence">Sequence</label><select id="sequence"></select></div>
</div>
<div id="player"></div>
<p class="note">Drag a figure to turn all of them.</p>"""
_SIGNATURES = "<p>Scores with the same signature are comparable.</p>"


def _motions(name: str, labelled: Mapping[str, npt.ArrayLike], skeleton: Skeleton) -> list[dict[str, object]]:
    arrays = {label: positions_array(f"{name}[{label!r}]", values, skeleton) for label, values in labelled.items()}
    if not arrays:
        raise ValueError(f"{name}: no motion")
    if len(counts := {len(array) for array in arrays.values()}) > 1:
        raise ValueError(f"{name}: labels have different numbers of sequences: {sorted(counts)}")
    return [
        {"label": label, "sequences": [pack(sequence, skeleton) for sequence in array]}
        for label, array in arrays.items()
    ]


def _board(html: str) -> str:
    # Focusable, so that keys can scroll it.
    return f'<div class="scroll" tabindex="0" role="region" aria-label="Table">{html}</div>\n'


def _lines(heading: str, lines: Sequence[str]) -> str:
    return f"<h3>{escape(heading)}</h3>\n{_list('', lines)}"


def _list(style: str, lines: Sequence[str]) -> str:
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f'<ul class="{style}">{items}</ul>\n' if lines else ""


def _picture(figure: Figure) -> str:
    # As the source of an image, an SVG can neither run scripts nor share names with another.
    svg = isinstance(figure.image, str)
    image = figure.image.encode() if isinstance(figure.image, str) else figure.image
    source = f"data:image/{'svg+xml' if svg else 'png'};base64,{base64.b64encode(image).decode()}"
    return (
        f'<figure><h3>{escape(figure.title)}</h3><img src="{source}" alt="{escape(figure.title)}">'
        f"<figcaption>{escape(figure.caption)}</figcaption></figure>\n"
    )


def _signature(signature: str) -> str:
    return (
        f'<div class="signature"><code>{escape(signature)}</code>'
        '<button type="button" class="copy">Copy</button></div>\n'
    )
