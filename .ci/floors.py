#!/usr/bin/env python3
"""Print the oldest versions that ``pyproject.toml`` promises, as constraints for pip."""

import re
import tomllib
from itertools import chain
from pathlib import Path

project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
for requirement in sorted({*project["dependencies"], *chain(*project["optional-dependencies"].values())}):
    if match := re.fullmatch(r"([\w.-]+)(?:\[[\w,-]+\])?>=([\w.]+)", requirement):
        print("==".join(match.groups()))
