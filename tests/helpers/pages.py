"""Read the code blocks and the commands of the documentation's pages."""

import re
from pathlib import Path

PROJECT = Path(__file__).parents[2]
PAGES = [
    *PROJECT.glob("README.md"),
    *sorted((PROJECT / "docs").glob("*.md")),
    *sorted((PROJECT / "docs/api").glob("*.md")),
]
#: A command of either package, perhaps after another one, or after variables of its environment.
COMMAND = re.compile(r"(?:^|&& )(?:[A-Z_]+=\S+ )*((?:npss|npss-baselines) .*)")


def blocks(page, *languages):
    """Return the code blocks of a page that are marked with one of the languages; the empty one means none."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"^```([^\n]*)\n(.*?)^```$", text, flags=re.M | re.S)
    return [block for language, block in found if language in languages]


def commands(page):
    """Return the lines of a page's blocks that have a command of either package."""
    lines = "".join(blocks(page, "sh", "")).replace("\\\n", " ").splitlines()
    return [line.strip() for line in lines if COMMAND.search(line.strip())]
