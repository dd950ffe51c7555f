"""What is public: few names, sorted, documented, with examples that run; and nothing but numpy behind them."""

import doctest
import importlib
import inspect
import subprocess
import sys

import pytest

import npss
from modules import MODULES

NAMESPACES = (
    *(npss, npss.metrics, npss.plot, npss.protocol, npss.published, npss.records, npss.rotations, npss.skeleton),
    npss.study,
)
FUNCTIONS = [
    (space.__name__, name) for space in NAMESPACES for name in space.__all__ if inspect.isfunction(getattr(space, name))
]


@pytest.mark.parametrize("space", NAMESPACES, ids=lambda space: space.__name__)
def test_public_names_are_sorted_and_exist(space):
    assert list(space.__all__) == sorted(
        space.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name)
    )
    assert all(hasattr(space, name) for name in space.__all__)


@pytest.mark.parametrize("name", ["npss", "npss_baselines", *MODULES])
def test_examples_run(name):
    if name.startswith(("npss_baselines.", "npss.torch")):
        pytest.importorskip("torch")
    module = importlib.import_module(name)
    results = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert results.failed == 0


@pytest.mark.parametrize(("space", "name"), FUNCTIONS)
def test_public_functions_are_documented_in_whole(space, name):
    text = inspect.getdoc(getattr(sys.modules[space], name))
    for section in ("Parameters", "Returns", "Raises", "Examples"):
        assert f"\n{section}\n---" in text, section


@pytest.mark.parametrize(("space", "name"), FUNCTIONS)
def test_what_is_given_has_a_name_and_options_have_to_be_called_by_theirs(space, name):
    parameters = inspect.signature(getattr(sys.modules[space], name)).parameters.values()
    assert all(parameter.kind != parameter.POSITIONAL_ONLY for parameter in parameters)
    by_place = [one for one in parameters if one.kind == one.POSITIONAL_OR_KEYWORD and one.default is not one.empty]
    assert by_place in ([], by_place[:1])  # `signature("released")`


def test_what_is_imported_late_is_there_all_the_same():
    assert set(npss.__all__) <= set(dir(npss))
    with pytest.raises(AttributeError, match="module 'npss' has no attribute 'scores'"):
        _ = npss.scores


def test_importing_npss_imports_numpy_alone():
    code = (
        "import sys, numpy; before = set(sys.modules); import npss; "
        "tops = {name.partition('.')[0] for name in set(sys.modules) - before}; "
        "print(*sorted(tops - set(sys.stdlib_module_names) - {'npss', 'numpy'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.strip() == ""


def test_both_packages_have_the_one_version():
    from importlib.metadata import requires, version

    assert version("npss-metric") == version("npss-baselines") == npss.__version__
    assert f"npss-metric[h5]=={npss.__version__}" in requires("npss-baselines")
