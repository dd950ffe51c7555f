"""Read the code blocks and the commands of the documentation's pages, and run their programs."""

import re
import subprocess
import sys
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


def marked(page, kind, name):
    """Return the code block after the comment ``<!-- KIND: NAME -->``."""
    text = page.read_text(encoding="utf-8")
    (block,) = re.findall(rf"^<!-- {kind}: {re.escape(name)} -->\n```\w+\n(.*?)^```$", text, flags=re.M | re.S)
    return block


def printed(program, folder):
    """Run a program in a folder, in a process of its own, and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", program], capture_output=True, encoding="utf-8", cwd=folder, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def commands(page):
    """Return the lines of a page's blocks that have a command of either package."""
    lines = "".join(blocks(page, "sh", "")).replace("\\\n", " ").splitlines()
    return [line.strip() for line in lines if COMMAND.search(line.strip())]
