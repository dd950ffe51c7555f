"""Text files are UTF-8 whatever the locale: everything that opens one says so."""

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


def silent(tree):
    """Yield the lines of calls that leave the encoding of text to the locale."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name = getattr(call.func, "attr", getattr(call.func, "id", None))
        options = {option.arg: option.value for option in call.keywords}
        said = [one.value for one in (*call.args, *options.values()) if isinstance(one, ast.Constant)]
        modes = [one for one in said if isinstance(one, str) and one.strip("rwax+t") == ""]
        binary = any(isinstance(one, str) and "b" in one and one.strip("rwaxb+") == "" for one in said)
        of_a_path = name == "open" and not binary and (modes or not call.args) and ast.unparse(call.func) != "os.open"
        of_text = name in ("read_text", "write_text") and isinstance(call.func, ast.Attribute)
        of_a_process = any(
            ast.unparse(options[one]) == "True" for one in {"text", "universal_newlines"} & options.keys()
        )
        if (of_text or of_a_path or of_a_process) and "encoding" not in options:
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
def test_the_test_sees_them(code, lines):
    assert list(silent(ast.parse(code))) == lines


def test_everything_says_its_encoding():
    files = [file for folder in FOLDERS for file in sorted(folder.rglob("*.py"))]
    found = [f"{file}:{line}" for file in files for line in silent(ast.parse(file.read_text(encoding="utf-8")))]
    assert not found
    assert len(files) > 100
