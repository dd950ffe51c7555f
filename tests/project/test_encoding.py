"""Tests that all code states the encoding of text files: UTF-8 in any locale."""

import ast
from pathlib import Path

import pytest

import npss
import npss_baselines

TESTS = Path(__file__).parents[1]
FOLDERS = [
    Path(npss.__file__).parent,
    Path(npss_baselines.__file__).parent,
    TESTS,
    TESTS.parent / "benchmarks",
    TESTS.parent / ".ci",
    TESTS.parent / "docs",
]


def implicit(tree):
    """Yield the lines of calls that do not state the encoding of text."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name = getattr(call.func, "attr", getattr(call.func, "id", None))
        options = {option.arg: option.value for option in call.keywords}
        values = [value.value for value in (*call.args, *options.values()) if isinstance(value, ast.Constant)]
        texts = [value for value in values if isinstance(value, str)]
        modes = [text for text in texts if text.strip("rwax+t") == ""]
        binary = any("b" in text and text.strip("rwaxb+") == "" for text in texts)
        opens_path = name == "open" and not binary and (modes or not call.args) and ast.unparse(call.func) != "os.open"
        accesses_text = name in ("read_text", "write_text") and isinstance(call.func, ast.Attribute)
        runs_process = any(
            ast.unparse(options[option]) == "True" for option in {"text", "universal_newlines"} & options.keys()
        )
        if (accesses_text or opens_path or runs_process) and "encoding" not in options:
            yield call.lineno


@pytest.mark.parametrize(
    ("code", "lines"),
    [
        ("path.read_text()", [1]),
        ("path.open()", [1]),
        ("open('w')\nopen(path, 'w')", [1, 2]),
        ("subprocess.run(command, text=True)", [1]),
        ("path.read_text(encoding='utf-8')\npath.open('wb')\nread_text(path)\nurllib.request.urlopen(x)", []),
    ],
)
def test_implicit_encodings_are_found(code, lines):
    assert list(implicit(ast.parse(code))) == lines


def test_all_encodings_are_stated():
    files = [file for folder in FOLDERS for file in sorted(folder.rglob("*.py"))]
    lines = [f"{file}:{line}" for file in files for line in implicit(ast.parse(file.read_text(encoding="utf-8")))]
    assert not lines
    assert len(files) > 100
