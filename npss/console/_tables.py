"""Tables as aligned text or Markdown."""

from __future__ import annotations

import re
from collections.abc import Sequence


def table(header: Sequence[str], rows: Sequence[Sequence[str]], align: str, *, markdown: bool = False) -> str:
    """Return a table as text.

    Parameters
    ----------
    header : sequence of str
        The names of the columns.
    rows : sequence of sequence of str
        The cells; each row as long as the header.
    align : str
        A letter for each column: ``'l'`` to align it to the left, ``'r'`` to the right.
    markdown : bool, optional
        Write a Markdown table.

    Returns
    -------
    str
        Its lines.

    Raises
    ------
    ValueError
        If rows, header and alignment differ in length.

    Examples
    --------
    >>> print(table(["model", "NPSS"], [["vgru-d", "0.5"]], "lr"))
    model   NPSS
    ------  ----
    vgru-d   0.5
    """
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    columns = list(zip(widths, align, strict=True))

    def line(cells: Sequence[str]) -> str:
        aligned = [
            cell.ljust(width) if side == "l" else cell.rjust(width)
            for cell, (width, side) in zip(cells, columns, strict=True)
        ]
        return f"| {' | '.join(aligned)} |" if markdown else "  ".join(aligned).rstrip()

    rules = ["-" * (width - 1) + (":" if markdown and side == "r" else "-") for width, side in columns]
    return "\n".join([line(header), line(rules), *(line(row) for row in rows)])


def markdown_text(text: str) -> str:
    r"""Escape text for Markdown, which then shows it unchanged: no markup, formula or strikethrough.

    Parameters
    ----------
    text : str
        One line.

    Returns
    -------
    str
        The escaped text.

    Examples
    --------
    >>> print(markdown_text("~a_b~ $x$"))
    \~a\_b\~ \$x\$
    """
    escaped = re.sub(r"[\\`*_\[\]<>|~$^#]", r"\\\g<0>", text)
    escaped = re.sub(r"^(?:(?=[-+])|(\d+)(?=[.)](?:\s|$)))", r"\1\\", escaped)  # no list, no rule
    return escaped.replace("&", "&amp;")


def markdown_code(text: str) -> str:
    """Format text as code in Markdown, even if it contains backticks.

    Parameters
    ----------
    text : str
        One line.

    Returns
    -------
    str
        The text between as many backticks as needed.

    Examples
    --------
    >>> print(markdown_code("a`b"))
    `` a`b ``
    """
    ticks = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    blank = " " * (len(ticks) > 1)
    return f"{ticks}{blank}{text}{blank}{ticks}"
