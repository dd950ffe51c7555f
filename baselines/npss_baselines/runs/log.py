"""The log of a training: a table with one row per validation."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from npss.files import write_atomically

#: The file of the table.
FILE = "metrics.csv"


def write(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write all rows atomically; a row that lacks a column is empty there."""

    def write_rows(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, dict.fromkeys(name for row in rows for name in row))
            writer.writeheader()
            writer.writerows(rows)

    write_atomically(folder / FILE, write_rows)
