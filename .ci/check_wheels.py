#!/usr/bin/env python3
"""Check both built wheels: of one version, typed, licensed, pinned to each other, with all files and nothing else."""

import csv
import re
import sys
import zipfile
from email.parser import Parser
from pathlib import Path

root = Path(__file__).parent.parent
(version,) = re.findall(r'^__version__ = "(.*)"$', (root / "npss" / "__init__.py").read_text(encoding="utf-8"), re.M)
for name, package in (("npss_metric", "npss"), ("npss_baselines", "npss_baselines")):
    with zipfile.ZipFile(Path(sys.argv[1], f"{name}-{version}-py3-none-any.whl")) as wheel:
        info = f"{name}-{version}.dist-info"
        files = set(wheel.namelist())
        assert {file.partition("/")[0] for file in files} == {package, info}, files
        assert {f"{package}/py.typed", f"{info}/entry_points.txt", f"{info}/licenses/LICENSE"} <= files, files
        parent = root if package == "npss" else root / "baselines"
        kept = {path for path in (parent / package).rglob("*") if path.is_file() and path.parent.name != "__pycache__"}
        packed = {file for file in files if not file.startswith(info)}
        assert packed == {path.relative_to(parent).as_posix() for path in kept}, packed
        if package == "npss":
            tables = {name: wheel.read(f"npss/{name}.csv").decode() for name in ("published", "measured")}
            rows = list(csv.DictReader(tables["measured"].splitlines()))
            assert {("zero-velocity", "walking", "npss"), ("repeat-50", "smoking", "euler_error")} <= {
                (row["model"], row["action"], row["metric"]) for row in rows
            }, rows[:3]
        metadata = Parser().parsestr(wheel.read(f"{info}/METADATA").decode())
    requirements = metadata.get_all("Requires-Dist")
    always = [line for line in requirements if "extra ==" not in line]
    assert metadata["Version"] == version, metadata["Version"]
    if package == "npss":
        assert [re.match(r"\w+", line)[0] for line in always] == ["numpy"], always
    else:
        assert f"npss-metric[h5]=={version}" in always, always
    print(f"{name} {version}: {len(files)} files; needs {', '.join(always)}")
