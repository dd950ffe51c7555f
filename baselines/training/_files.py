"""Files that are whole whenever somebody looks, however the process that writes them ends."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any


def write_atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Let `write` write a file beside `path`, and rename it; what a killed process left there is overwritten."""
    part = path.with_name(f"{path.name}.part")
    write(part)
    part.replace(path)
