"""The table of a run: a row for each time that the model was measured."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from npss.files import write_atomically

#: The file of a run that holds it.
FILE = "metrics.csv"


def write(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write all rows, or leave what was there; the columns are the names of all of them, empty where a row has none."""

    def write_rows(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, dict.fromkeys(name for row in rows for name in row))
            writer.writeheader()
            writer.writerows(rows)

    write_atomically(folder / FILE, write_rows)
