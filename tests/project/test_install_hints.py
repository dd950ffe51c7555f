"""What to install: one wording, and from the project's folder, since names on an index may be somebody else's."""

import re
from pathlib import Path

import pytest

import npss
import npss_baselines
from npss.extras import install_hint

ROOT = Path(__file__).parents[2]
PACKAGES = [Path(package.__file__).parent for package in (npss, npss_baselines)]
HINT = re.compile(r"pip3? install ([^`\n]*)")
#: The folder, or the baselines in it, with extras or without; or a tool of other people.
KNOWN = re.compile(r"(?:-[ce] \S+\.txt |-e )*'?\\?\.|(?:cosmic-ray|nox|pre-commit)\b|\{\}")
#: An extra of a name that the index may know, but for the pin in the metadata.
EXTRA = re.compile(
    r"npss(?:-metric|-baselines)?\[(?:all|h5|manifold|pandas|plot|study|torch|torchmetrics)\b[\w,]*\](?!==)"
)


def texts():
    """Return code, tests and pages, as far as they are beside these tests."""
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
    """Return the hints that install something else."""
    hints = [hint for hint in HINT.findall(text) if not KNOWN.match(hint)]
    return hints + [hint for hint in HINT.findall(text) if re.search(r"(?<![\w./-])npss(?![\w ]*demo)", hint)]


@pytest.mark.parametrize("package", ["npss", "'npss[h5]'", "-U npss-metric", "npss-baselines", "pandas", ". npss"])
def test_other_hints_are_seen(package):
    assert strange_hints(f"Try `pip install {package}`.")


def test_hints_install_from_the_projects_folder():
    assert {path: hints for path, text in texts().items() if (hints := strange_hints(text))} == {}
    assert {path: hints for path, text in texts().items() if (hints := EXTRA.findall(text))} == {}


def test_code_has_the_wording_in_one_place():
    files = [path for folder in PACKAGES for path in folder.rglob("*.py")]
    assert [path.name for path in files if HINT.search(path.read_text(encoding="utf-8"))] == ["extras.py"]
    assert install_hint("h5") == "in the project's folder: pip install '.[h5]'"
