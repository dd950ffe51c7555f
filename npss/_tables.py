"""Tables as text: aligned for people, or in Markdown."""

from __future__ import annotations

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
