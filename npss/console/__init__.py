"""Parts of command lines: parser, progress, tables, output in any encoding."""

from npss.console._completion import add_completion
from npss.console._parser import Parser, add_plugin, meant
from npss.console._progress import Progress, duration
from npss.console._run import run
from npss.console._tables import markdown_code, markdown_text, table
from npss.console._versions import installed, versions

__all__ = [
    "Parser",
    "Progress",
    "add_completion",
    "add_plugin",
    "duration",
    "installed",
    "markdown_code",
    "markdown_text",
    "meant",
    "run",
    "table",
    "versions",
]
