"""Rank several models on one ground truth: files of predictions, leaderboards."""

from npss.ranking._names import names_of_paths
from npss.ranking._submissions import (
    Submissions,
    check_truths,
    known_blocks,
    read_actions,
    records_of,
    sample_files,
)

__all__ = [
    "Submissions",
    "check_truths",
    "known_blocks",
    "names_of_paths",
    "read_actions",
    "records_of",
    "sample_files",
]
