"""The command ``npss``, and parts that commands of other packages reuse."""

from npss._pages.motion import motion_page
from npss.commands._leaderboard import add_leaderboard_options, leaderboard_of, show_leaderboard
from npss.commands._main import main
from npss.commands._metrics import add_metrics
from npss.commands._report import write_report

__all__ = [
    "add_leaderboard_options",
    "add_metrics",
    "leaderboard_of",
    "main",
    "motion_page",
    "show_leaderboard",
    "write_report",
]
