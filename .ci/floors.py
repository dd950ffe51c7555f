#!/usr/bin/env python3
"""Print the oldest versions that the core and its tests promise to work with, as constraints for pip."""

import re
import tomllib
from itertools import chain
from pathlib import Path

root = Path(__file__).parent.parent
project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
tests = (root / "tests" / "requirements-core.txt").read_text(encoding="utf-8").splitlines()
for requirement in sorted({*project["dependencies"], *chain(*project["optional-dependencies"].values()), *tests}):
    if match := re.fullmatch(r"([\w.-]+)(?:\[[\w,-]+\])?>=([\w.]+)", requirement):
        print("==".join(match.groups()))
