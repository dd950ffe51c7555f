"""Tests of the public API: `docs/api` matches `__all__`, docstrings are complete, examples run, numpy is enough."""

import ast
import doctest
import importlib
import inspect
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

import npss
import npss_baselines
from modules import MODULES

ROOT = Path(__file__).parents[2]
PUBLIC = ["npss", *(name for name in MODULES if name.startswith("npss.") and "._" not in name)]
#: Modules for packages on top of npss. All other modules are for users, and have examples.
SHARED = ("commands", "console", "extras", "files", "plot.style", "plugins", "ranking", "records", "validation")
FUNCTIONS = []
for _name in PUBLIC:
    if not _name.startswith("npss.torch") or importlib.util.find_spec("torch"):
        _module = importlib.import_module(_name)
        FUNCTIONS += [
            (_name, name) for name in getattr(_module, "__all__", ()) if inspect.isfunction(getattr(_module, name))
        ]


def public_names(name):
    """Read `__all__` without importing the module, whose dependencies can be missing."""
    package = npss if name.partition(".")[0] == "npss" else npss_baselines
    path = Path(package.__file__).parents[1].joinpath(*name.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    values = [
        node.value
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign) and any(getattr(target, "id", "") == "__all__" for target in node.targets)
    ]
    return [name for value in values for name in ast.literal_eval(value)]


def documented_names():
    """Return the names that `docs/api` documents, by module."""
    names = defaultdict(set)
    for page in sorted((ROOT / "docs" / "api").glob("*.md")):
        module = ""
        for kind, name, options in re.findall(
            r"^\.\. (\S+):: (\S+)\n((?: +:.*\n)*)", page.read_text(encoding="utf-8"), flags=re.MULTILINE
        ):
            if kind in ("automodule", "py:module"):
                module = name
                names[name].update(public_names(name) if ":members:" in options else ())
                if excluded := re.search(r":exclude-members: (.*)", options):
                    names[name].difference_update(excluded[1].split(", "))
                if parent := name.rpartition(".")[0]:
                    names[parent].add(name.rpartition(".")[2])
            else:
                parent, _, last = name.rpartition(".")
                names[parent or module].add(last)
    return names


def test_documentation_matches_all():
    documented = documented_names()
    assert {name for name in documented if name.partition(".")[0] == "npss"} == set(PUBLIC)
    assert {*BASELINES} <= set(documented)
    for name in documented:
        submodules = {module.rpartition(".")[2] for module in documented if module.rpartition(".")[0] == name}
        names = set(public_names(name))
        elsewhere = {"Interval"} if name == "npss.study" else set()  # documented as npss.Interval
        assert documented[name] - submodules == names - submodules - elsewhere, name


#: Public modules of npss_baselines: those with `__all__`.
BASELINES = [name for name in MODULES if name.startswith("npss_baselines.") and public_names(name)]


@pytest.mark.parametrize("name", [*PUBLIC, *BASELINES])
def test_public_names_are_sorted_and_exist(name):
    names = public_names(name)
    assert names
    assert names == sorted(names, key=lambda name: (not name.isupper(), not name[0].isupper(), name))
    if name.startswith(("npss.torch", "npss_baselines.")):
        pytest.importorskip("torch")
    module = importlib.import_module(name)
    assert all(hasattr(module, name) for name in names)


@pytest.mark.parametrize("name", BASELINES)
def test_public_functions_of_baselines_have_docstring_sections(name):
    pytest.importorskip("torch")
    module = importlib.import_module(name)
    functions = [getattr(module, name) for name in public_names(name) if inspect.isfunction(getattr(module, name))]
    for function in functions:
        returns = inspect.signature(function).return_annotation not in ("None", None)
        sections = [
            *["Parameters"] * bool(inspect.signature(function).parameters),
            *["Returns"] * returns,
            *["Raises"] * any(isinstance(node, ast.Raise) for node in ast.walk(ast.parse(inspect.getsource(function)))),
        ]
        assert [section for section in sections if f"\n{section}\n---" not in inspect.getdoc(function)] == [], function


def test_baselines_import_only_public_names():
    private = [
        f"{path}:{node.lineno}: {module} {name}"
        for path in sorted(Path(npss_baselines.__file__).parent.rglob("*.py"))
        for node, module, name in imports_of_npss(ast.parse(path.read_text(encoding="utf-8")))
        if not (module in PUBLIC and (name in public_names(module) or f"{module}.{name}" in PUBLIC))
    ]
    assert private == []


def imports_of_npss(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "npss" and not node.level:
            yield from ((node, node.module, alias.name) for alias in node.names)
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names if alias.name.partition(".")[0] == "npss"]
            yield from ((node, *(name if "." in name else f"{name}.score").rsplit(".", 1)) for name in names)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "npss":
            yield node, "npss", node.attr


@pytest.mark.parametrize("name", ["npss", "npss_baselines", *MODULES])
def test_examples_run(name):
    if name.startswith(("npss_baselines.", "npss.torch")):
        pytest.importorskip("torch")
    module = importlib.import_module(name)
    results = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert results.failed == 0


@pytest.mark.parametrize(("space", "name"), FUNCTIONS)
def test_public_functions_have_all_docstring_sections(space, name):
    function = getattr(sys.modules[space], name)
    signature = inspect.signature(function)
    sections = ["Parameters"] * bool(signature.parameters)
    if space.removeprefix("npss.") in SHARED:
        sections += ["Returns"] * (signature.return_annotation != "None")
        nodes = ast.walk(ast.parse(inspect.getsource(function).lstrip()))
        sections += ["Raises"] * any(isinstance(node, ast.Raise) for node in nodes)
    else:
        sections += ["Returns", "Raises", "Examples"]
    text = inspect.getdoc(function)
    for section in sections:
        assert f"\n{section}\n---" in text, section


@pytest.mark.parametrize(("space", "name"), FUNCTIONS)
def test_options_are_keywords(space, name):
    parameters = inspect.signature(getattr(sys.modules[space], name)).parameters.values()
    assert all(parameter.kind != parameter.POSITIONAL_ONLY for parameter in parameters)
    positional = [
        parameter
        for parameter in parameters
        if parameter.kind == parameter.POSITIONAL_OR_KEYWORD and parameter.default is not parameter.empty
    ]
    assert positional in ([], positional[:1])  # `signature("released")`


def test_lazy_imports():
    assert set(npss.__all__) <= set(dir(npss))
    with pytest.raises(AttributeError, match="module 'npss' has no attribute 'scores'"):
        _ = npss.scores


def test_every_name_is_there_without_pandas():
    code = "import inspect, sys; sys.modules['pandas'] = None; import npss; inspect.getmembers(npss)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8")
    assert (done.returncode, done.stderr) == (0, "")


def test_importing_npss_imports_only_numpy():
    code = (
        "import sys, numpy; before = set(sys.modules); import npss; "
        "tops = {name.partition('.')[0] for name in set(sys.modules) - before}; "
        "print(*sorted(tops - set(sys.stdlib_module_names) - {'npss', 'numpy'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.strip() == ""


def test_both_packages_have_the_same_version():
    from importlib.metadata import requires, version

    assert version("npss-metric") == version("npss-baselines") == npss.__version__
    assert f"npss-metric[h5]=={npss.__version__}" in requires("npss-baselines")
