"""The style of pictures: colours for colour-blind readers, figures, footnotes."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Literal, ParamSpec, TypeVar

from npss.ranking._names import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "COLOURS",
    "DASHES",
    "GREY",
    "SMALL",
    "TINY",
    "TRUTH",
    "by_defaults",
    "footnote",
    "label",
    "new_figure",
    "tidy",
]

Given = ParamSpec("Given")
Drawn = TypeVar("Drawn")

#: Colours of M. Okabe and K. Ito, "Color Universal Design", 2008, without black and yellow.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
#: Dashes for black-and-white print; with the colours, they give twelve different lines.
DASHES = ("-", "--", ":", "-.")
#: Colour of the ground truth.
TRUTH = "#000000"
#: Colour of secondary text and lines.
GREY = "#767676"
#: Size of labels, in points.
SMALL = 8
#: Size of footnotes and legends, in points.
TINY = 7
_LONGEST = 40  # letters of a name; a longer name would push the axes off the figure
_LETTER = 0.56  # average width of a letter, in units of the font size


def by_defaults(draw: Callable[Given, Drawn]) -> Callable[Given, Drawn]:
    """Make a function draw by matplotlib's default settings; a user's ``text.usetex`` would read names as TeX.

    Parameters
    ----------
    draw : callable
        The function.

    Returns
    -------
    callable
        The decorated function. If matplotlib is missing, it raises an ImportError that says how to install it.
    """

    @wraps(draw)
    def drawn(*args: Given.args, **options: Given.kwargs) -> Drawn:
        from npss.plot._figure import defaults

        with defaults():
            return draw(*args, **options)

    return drawn


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure that is independent of any global state.

    Parameters
    ----------
    width, height : float
        Size in inches.

    Returns
    -------
    Figure
        A figure without axes.
    """
    from npss.plot._figure import Picture

    return Picture(figsize=(width, height), dpi=150, layout="constrained")


def label(name: str) -> str:
    r"""Escape a name for matplotlib, which would read ``$`` as a formula and hide names that begin with ``_``.

    A long name is cut in the middle, since most names differ at their ends.

    Parameters
    ----------
    name : str
        The name of a model or feature.

    Returns
    -------
    str
        The label, on one line.

    Examples
    --------
    >>> print(label("cost in $"))
    cost in \$
    """
    short = one_line(name)
    if len(short) > _LONGEST:
        short = f"{short[: _LONGEST // 2]}…{short[1 - _LONGEST // 2 :]}"
    escaped = short.replace("$", r"\$")
    return f"\N{ZERO WIDTH SPACE}{escaped}" if escaped.startswith("_") else escaped


def footnote(figure: Figure, *lines: str) -> None:
    """Write a footnote below the axes.

    Parameters
    ----------
    figure : Figure
        The figure.
    *lines : str
        The lines; long ones are broken.
    """
    n_letters = int(figure.get_figwidth() * 72 / (_LETTER * TINY))
    text = "\n".join(_broken(line, n_letters) for line in lines).replace("$", r"\$")
    figure.supxlabel(text, x=0.01, ha="left", fontsize=TINY, color=GREY)


def _broken(line: str, n_letters: int) -> str:
    """Break a line after spaces, commas and a signature's bars."""
    lines = [""]
    for part in re.findall(r"[^ ,|]*[ ,|]?", line):
        if len(lines[-1]) + len(part) > n_letters:
            lines.append("    ")
        lines[-1] += part
    return "\n".join(lines)


def tidy(axes: Axes, *, grid: Literal["both", "x", "y", "none"] = "both") -> None:
    """Remove all lines that do not help to read values.

    Parameters
    ----------
    axes : Axes
        The axes.
    grid : {'both', 'x', 'y', 'none'}, optional
        The axis with grid lines.
    """
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=SMALL)
    if grid != "none":
        axes.grid(axis=grid, color="#DDDDDD", linewidth=0.6)
        axes.set_axisbelow(True)
