"""Blocks: groups of sequences that depend on each other, the unit of everything that is said of chance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: The rules by which intervals and p-values are made, and ground truths recognised; records state it.
STATISTICS_VERSION = 2


def statistics_version(sequences: Mapping[str, Any]) -> int:
    """Return by which rules the ``sequences`` of a record are to be read; older records state none, and are of 1.

    Raises
    ------
    ValueError
        If they are of rules that are not known here.
    """
    version = sequences.get("statistics", 1)
    if isinstance(version, bool) or version not in range(1, STATISTICS_VERSION + 1):
        raise ValueError(
            f"sequences: statistics: expected a version from 1 to {STATISTICS_VERSION}, got {version!r:.100}; "
            "a newer npss may have written the record"
        )
    return int(version)
