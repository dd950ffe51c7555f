"""The data set and the model in docs/extending.md, run as printed."""

import argparse
import json
import re
import sys
from collections.abc import Callable
from copy import copy
from dataclasses import make_dataclass, replace

import numpy as np
import pytest

pytest.importorskip("torch")

from npss import gait
from npss.ranking import read_actions
from npss_baselines.__main__ import _parser, main
from npss_baselines.commands import train_manifold, train_options
from npss_baselines.data import SOURCES, PoseSource, Source, register_source
from npss_baselines.data.registry import RESERVED
from npss_baselines.data.synthetic import Synthetic
from npss_baselines.manifold.training import config as manifold_config
from npss_baselines.models import MODELS, register_model
from npss_baselines.models.recipe import Recipe
from npss_baselines.runs import config
from pages import PROJECT, marked
from registered import restored

PAGE = PROJECT / "docs" / "extending.md"
SUBJECTS = ("anna", "ben", "carla", "dora")


def printed(kind, name):
    return marked(PAGE, kind, name)


@pytest.fixture
def _registries():
    """Forget the sources and models that a test registers."""
    with restored(SOURCES, MODELS):
        yield


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """Write a plugin to the current folder; unregister it afterwards."""
    if not PAGE.exists():
        pytest.skip("the documentation is not beside the tests")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])

    def write(name):
        (tmp_path / f"{name}.py").write_text(printed("file", f"{name}.py"), encoding="utf-8")

    with restored(SOURCES, MODELS):
        yield write
    for name in ("our_walks", "one_cell"):
        sys.modules.pop(name, None)


def run(capsys, line):
    assert main(line.split()[1:]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def test_the_examples_are_short():
    for name in ("our_walks.py", "one_cell.py"):
        assert len(printed("file", name).splitlines()) <= 36


def test_a_data_set(plugin, tmp_path, capsys):
    plugin("our_walks")
    for seed, subject in enumerate(SUBJECTS):
        (tmp_path / "motion" / subject).mkdir(parents=True)
        for action, walk in zip(("walk", "turn"), gait.gait(2, 360, seed=seed), strict=True):
            np.save(tmp_path / "motion" / subject / f"{action}.npy", walk)
    evaluate, sensitivity, train, predict, manifold = printed("command", "a data set").splitlines()
    records = json.loads(run(capsys, evaluate))
    assert {record["action"] for record in records} == {"walk", "turn"}
    assert "protocol:our-walks-all" in records[0]["signature"]
    assert json.loads(run(capsys, sensitivity))[0]["distortion"] == "zero-velocity"
    run(capsys, train)
    content = json.loads((tmp_path / "run" / config.FILE).read_text(encoding="utf-8"))
    assert (content["data"], content["subjects"], content["actions"]) == (
        "our-walks",
        ["anna", "ben"],
        ["walk", "turn"],
    )
    assert (content["paths"], content["plugins"]) == ({"our-walks": str(tmp_path / "motion")}, ["our_walks"])
    run(capsys, predict)
    target = np.load(tmp_path / "motion" / "dora" / "walk.npy")[50:150]
    np.testing.assert_array_equal(read_actions(tmp_path / "predicted.npz")["walk"].gt[0], target)
    assert "(our-walks) of 2 subjects; validating on" in run(capsys, manifold)
    assert json.loads((tmp_path / "manifold" / config.FILE).read_text(encoding="utf-8"))["plugins"] == ["our_walks"]


def test_a_model(plugin, tmp_path, capsys):
    pytest.importorskip("pandas")
    plugin("one_cell")
    train, resume, predict, evaluate, leaderboard = printed("command", "a model").splitlines()
    assert "weights of iteration" in run(capsys, train)
    run(capsys, resume)
    run(capsys, predict)
    assert read_actions(tmp_path / "run.npz")["gait"].pred.shape == (64, 100, 99)
    assert [record["model"] for record in json.loads(run(capsys, evaluate))] == ["run", "zero-velocity"]
    assert "run" in run(capsys, leaderboard)
    assert "one-cell" in run(capsys, "npss-baselines params --format json")


@pytest.mark.usefixtures("_registries")
def test_a_data_set_of_positions_is_for_the_manifold_alone():
    class Positions(Source):
        name, description = "positions", "folder of positions"

        def clips(self, folder, **_):
            return Synthetic().clips(folder)

    register_source(Positions())
    assert "positions" in SOURCES
    with pytest.raises(SystemExit):
        main(["evaluate", "--positions", "x"])


def parsers(parser):
    """Yield a parser and the parsers of its subcommands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for subparser in action.choices.values():
                yield from parsers(subparser)


def test_a_source_cannot_have_the_option_of_a_command():
    every = [*parsers(_parser()), train_options._add_options(config.parser_of("erd"))]
    every.append(train_manifold._add_options(manifold_config.parser_of(manifold_config.defaults())))
    names = {name for parser in every for action in parser._actions for name in (action.dest, *action.option_strings)}
    names |= {name for parser in every for name in parser._defaults}
    options = {source.option for source in SOURCES.values()}
    names = {name.lstrip("-").replace("_", "-") for name in names if not re.search("[.=]", name)} - options
    assert sorted(RESERVED) == sorted({*names, "arguments", "parser"})
    for option in RESERVED:
        with pytest.raises(ValueError, match=rf"^source: option: --{option} is an option of the commands; choose"):
            register_source(type("Other", (Synthetic,), {"name": "other", "option": option})())


@pytest.mark.usefixtures("_registries")
def test_replacing_registered_sources_and_models():
    kind = type("Other", (Synthetic,), {"name": "other", "option": "other"})
    spec = replace(MODELS["erd"], name="other")
    for register, entry, registry in ((register_source, kind(), SOURCES), (register_model, spec, MODELS)):
        register(entry)
        with pytest.raises(ValueError, match=r" 'other' is registered already$"):
            register(entry)
        register(copy(entry), replace=True)
        assert registry["other"] is not entry
        with pytest.raises(ValueError, match=r" is registered already$"):
            register(next(iter(registry.values())), replace=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "synthetic", "option": "other"}, "the source 'synthetic' is registered already"),
        ({"name": "other", "option": "h36m"}, "source: option: --h36m is the option of another source; choose another"),
        ({"name": "other", "option": "other", "description": "100 %"}, "source: description: expected text without %"),
        ({"name": "Other"}, "source: name: expected lower-case letters, digits and hyphens, got 'Other'"),
        ({"name": "other", "option": "--o"}, "source: option: expected lower-case letters"),
    ],
)
def test_invalid_registrations(changes, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        register_source(type("Other", (Synthetic,), changes)())


def test_registrations_of_other_types():
    for changes in ({"name": 1}, {"name": "other", "option": None}, {"name": "other", "description": b"bytes"}):
        with pytest.raises(TypeError, match=rf"^source: {[*changes][-1]}: expected text, got "):
            register_source(type("Other", (Synthetic,), changes)())
    for name in ("manifold", "-other"):
        with pytest.raises(ValueError, match=rf"^spec: name: expected another name for .* got '{name}'$"):
            register_model(replace(MODELS["erd"], name=name))
    for changes in ({"build": None}, {"recipe": {}}):
        with pytest.raises(TypeError, match=rf"^spec: {next(iter(changes))}: expected a"):
            register_model(replace(MODELS["erd"], name="other", **changes))
    with pytest.raises(TypeError, match=r"^source: expected an npss_baselines\.data\.Source, got"):
        register_source(PoseSource)
    with pytest.raises(TypeError, match=r"^spec: expected a ModelSpec, got 'erd'"):
        register_model("erd")


@pytest.mark.parametrize("kind", [Callable, type, object, list, tuple[Callable, ...], int | type, Recipe])
def test_a_configuration_holds_plain_data(kind):
    """A file that names a function or a class would have it imported."""
    config = make_dataclass("Config", [("units", int, 3), ("act", kind, None)])()
    with pytest.raises(TypeError, match=r"^spec: config: act: expected plain data, got the type "):
        register_model(replace(MODELS["erd"], name="other", config=config))
    with pytest.raises(TypeError, match=r"^spec: config: expected an instance of a dataclass, got"):
        register_model(replace(MODELS["erd"], name="other", config=type(config)))


@pytest.mark.usefixtures("_registries")
def test_configurations_of_the_models_are_plain_data():
    for name, spec in list(MODELS.items()):
        register_model(replace(spec, name=f"other-{name}"))


def test_the_folder_of_another_source_is_refused(tmp_path, capsys):
    command = ["train", "erd", "--data", "synthetic", "--h36m", str(tmp_path), "--out", str(tmp_path / "run")]
    assert main(command) == 2
    assert "--h36m: this run trains on --data synthetic" in capsys.readouterr().err
