"""Tests of install hints: one wording, from the project's folder, since index names can belong to others."""

import re
from pathlib import Path

import pytest

import npss
import npss_baselines
from npss.extras import install_hint

ROOT = Path(__file__).parents[2]
PACKAGES = [Path(package.__file__).parent for package in (npss, npss_baselines)]
HINT = re.compile(r"pip3? install ([^`\n]*)")
#: The project folder or its baselines, with or without extras; or a tool of other projects.
KNOWN = re.compile(r"(?:-[ce] \S+\.txt |-e )*'?\\?\.|(?:cosmic-ray|lightning|nox|pre-commit)\b|\{\}")
#: An extra of a name on the index, except the pin in the metadata.
EXTRA = re.compile(
    r"npss(?:-metric|-baselines)?\[(?:all|h5|manifold|pandas|plot|reproduce|study|torch|torchmetrics)\b[\w,]*\](?!==)"
)


def texts():
    """Return the text of all code, tests and pages."""
    folders = [*PACKAGES, *(ROOT / name for name in ("tests", "docs", "benchmarks", ".github"))]
    files = [path for folder in folders for path in folder.rglob("*.*")] + [
        *ROOT.glob("*.*"),
        *ROOT.glob("baselines/*.md"),
    ]
    kinds = (".html", ".js", ".md", ".py")
    return {
        str(path): path.read_text(encoding="utf-8")
        for path in files
        if path.suffix in kinds and path != Path(__file__) and "_build" not in path.parts
    }


def strange_hints(text):
    """Return hints to install anything else."""
    hints = [hint for hint in HINT.findall(text) if not KNOWN.match(hint)]
    return hints + [hint for hint in HINT.findall(text) if re.search(r"(?<![\w./-])npss(?![\w ]*demo)", hint)]


@pytest.mark.parametrize("package", ["npss", "'npss[h5]'", "-U npss-metric", "npss-baselines", "pandas", ". npss"])
def test_other_hints_are_found(package):
    assert strange_hints(f"Try `pip install {package}`.")


def test_hints_install_from_the_project_folder():
    assert {path: hints for path, text in texts().items() if (hints := strange_hints(text))} == {}
    assert {path: hints for path, text in texts().items() if (hints := EXTRA.findall(text))} == {}


def test_wording_is_in_one_place():
    files = [path for folder in PACKAGES for path in folder.rglob("*.py")]
    assert [path.name for path in files if HINT.search(path.read_text(encoding="utf-8"))] == ["extras.py"]
    assert install_hint("h5") == "in the project's folder: pip install '.[h5]'"
