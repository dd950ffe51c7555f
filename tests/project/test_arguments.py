"""Tests of argument names: one name each for seed frames, randomness and times, and errors for former names."""

import dataclasses
import inspect
import re
from importlib import import_module
from typing import Literal, get_args, get_origin

import numpy as np
import pytest

import npss
from modules import MODULES
from npss import gait, predictors, records, study
from npss.rotations import _contract
from npss.rotations._contract import conversion
from npss.validation import generator, renamed

FORMER = [
    (npss.unwrap, "seed", "seed_frames"),
    (records.measure, "seed", "seed_frames"),
    (predictors.zero_velocity, "seed", "seed_frames"),
    (predictors.running_average, "seed", "seed_frames"),
    (predictors.repeat, "seed", "seed_frames"),
    (predictors.periodic, "seed", "seed_frames"),
    (predictors.gated_periodic, "seed", "seed_frames"),
    (gait.gait, "rng", "seed"),
    (study.design, "rng", "seed"),
    (study.simulate_votes, "rng", "seed"),
    (npss.score_windows, "edges_s", "edges_ms"),
    (records.measure, "edges_s", "edges_ms"),
]
FORMER_OF_BASELINES = {
    ("predictor_of", "rng", "seed"),
    ("Run.predictor", "rng", "seed"),
    ("ModelPredictor.__call__", "seed", "seed_frames"),
    ("zeros", "rng", "seed"),
    ("kinect", "rng", "seed"),
    ("sample_codes", "rng", "seed"),
    ("pairs", "rng", "seed"),
}


def refuses(function, former, present):
    name = function.__name__
    with pytest.raises(TypeError, match=rf"^{name}\(\) has no argument '{former}': it is called '{present}'$"):
        function(**{former: 0})
    parameters = inspect.signature(function).parameters
    assert present in parameters
    assert former not in parameters


@pytest.mark.parametrize(("function", "former", "present"), FORMER)
def test_former_names_are_refused(function, former, present):
    refuses(function, former, present)


def test_former_names_of_baselines_are_refused():
    pytest.importorskip("torch")
    functions = dict(own_functions("npss_baselines."))
    for name, former, present in FORMER_OF_BASELINES:
        (function,) = (candidate for candidate in functions.values() if candidate.__qualname__ == name)
        refuses(function, former, present)


def test_renamed_changes_nothing_else():
    def draw(a, *, seed=0):
        """Draw."""
        return a, seed

    changed = renamed(rng="seed")(draw)
    assert changed(1) == (1, 0)
    assert changed(1, seed=2) == changed(a=1, seed=2) == (1, 2)
    assert (changed.__name__, changed.__doc__, inspect.signature(changed)) == ("draw", "Draw.", inspect.signature(draw))
    with pytest.raises(TypeError, match="unexpected keyword argument 'other'"):
        changed(1, other=2)


def own_functions(prefix):
    """Yield the functions and methods that modules define, with full names."""
    for name in MODULES:
        if name.startswith(prefix):
            module = import_module(name)
            for owner in (module, *(value for value in vars(module).values() if inspect.isclass(value))):
                for value in vars(owner).values():
                    if inspect.isfunction(value) and value.__module__ == name:
                        yield f"{name}.{value.__qualname__}", value


def public_functions():
    """Yield the name and signature of every public function and method."""
    for name, function in own_functions("npss"):
        if not function.__name__.startswith("_") or function.__name__ == "__init__":
            yield name, inspect.signature(function)


def test_no_other_argument_names_for_randomness_or_times():
    pytest.importorskip("torch")
    arguments = {
        f"{function}({argument})"
        for function, signature in public_functions()
        for argument in signature.parameters
        if argument in ("rng", "random_state", "generator") or argument.endswith(("_s", "_sec", "_seconds"))
    }
    assert arguments == set()


def test_seeds():
    expected = np.random.default_rng(5).random(3).tolist()
    for seed in (5, np.int64(5), np.random.default_rng(5)):
        assert generator(seed).random(3).tolist() == expected
    own = np.random.default_rng(0)
    assert generator(own) is own


def test_tables_state_the_seed_of_intervals():
    pytest.importorskip("pandas")
    reports = {"m": npss.report(*MOTIONS)}
    for seed, text in ((3, "resamples, seed 3;"), (np.random.default_rng(3), "resamples, a generator of your own;")):
        assert text in npss.leaderboard(reports, seed=seed).to_text()


@pytest.mark.parametrize("seed", [None, 1.0, "1", True, [1], np.random.RandomState(0)])
def test_invalid_seeds(seed):
    with pytest.raises(TypeError, match=r"^seed: expected a whole number or a numpy\.random\.Generator, got"):
        generator(seed)


def test_negative_seed():
    with pytest.raises(ValueError, match=r"^seed: expected a whole number >= 0, got -1"):
        generator(-1)


RANDOM = {
    "gait": lambda seed: gait.gait(1, 5, seed=seed).tolist(),
    "design": lambda seed: study.design(["a", "b"], range(4), 9, seed=seed),
    "simulate_votes": lambda seed: study.simulate_votes(
        [study.Question(1, 0, "a", "b")], {"a": 0.0, "b": 0.0}, 30, action="walking", seed=seed
    ),
    "interval": lambda seed: npss.report(*MOTIONS).interval(seed=seed),
    "compare": lambda seed: npss.compare(*MOTIONS, MOTIONS[1] ** 2, seed=seed).p_value,
}
MOTIONS = np.random.default_rng(0).normal(size=(2, 20, 30, 2)).cumsum(axis=2)


@pytest.mark.parametrize("name", RANDOM)
def test_numbers_repeat_and_generators_advance(name):
    draw = RANDOM[name]
    own = np.random.default_rng(3)
    assert draw(3) == draw(3) == draw(own)
    assert draw(own) != draw(3)


def documented_choices():
    """Yield the choices ``name : {'a', 'b'} or ...`` in docstrings of public functions."""
    for name in MODULES:
        if not name.startswith("npss."):
            continue
        module = import_module(name)
        classes = [value for value in vars(module).values() if inspect.isclass(value) and value.__module__ == name]
        functions = [value for value in vars(module).values() if inspect.isfunction(value) and value.__module__ == name]
        functions += [value for owner in classes for value in vars(owner).values() if inspect.isfunction(value)]
        for documented in [*functions, *classes]:
            for names, text in re.findall(r"^ *([a-z_, ]+) : [^{\n]*\{(.*?)\}", documented.__doc__ or "", re.M):
                for argument in names.split(", "):
                    yield documented, argument, set(re.findall(r"'([^']*)'", text))


def named_in(kind):
    """Return the values of every Literal in a type."""
    if get_origin(kind) is Literal:
        return set(get_args(kind))
    return {value for part in get_args(kind) for value in named_in(part)}


def test_choices_are_typed_as_literals():
    pytest.importorskip("torch")
    checked = set()
    for documented, argument, choices in documented_choices():
        own = inspect.unwrap(documented)
        owner = own.__init__ if inspect.isclass(own) and argument not in own.__annotations__ else own
        if inspect.isclass(owner):
            scope = vars(import_module(owner.__module__))
        else:
            scope = owner.__globals__
        kind = eval(owner.__annotations__[argument], dict(scope))
        if kind is not str or not own.__module__.startswith("npss._"):  # what only this library calls may be plain text
            assert named_in(kind) == choices, (documented, argument)
            checked.add(argument)
    assert {"convention", "alternative", "columns", "average", "unwrapped", "choice", "nan_policy"} <= checked


def public_classes():
    for space in (npss, npss.files, npss.protocol, npss.ranking, npss.skeleton, study):
        for name in space.__all__:
            value = getattr(space, name)
            if inspect.isclass(value):
                yield value


def test_result_fields_are_documented_as_attributes():
    made_by_users = {"Convention", "Format", "InBetweening", "Skeleton"}
    seen = 0
    for kind in public_classes():
        fields = [field.name for field in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else []
        fields += getattr(kind, "_fields", ())
        section = "Parameters" if kind.__name__ in made_by_users else "Attributes"
        if fields:
            assert f"\n{section}\n---" in inspect.getdoc(kind), kind
            text = inspect.getdoc(kind).partition(f"\n{section}\n")[2]
            assert [
                name for name in fields if name[0] != "_" and not re.search(rf"^[a-z_, ]*\b{name}\b.* : ", text, re.M)
            ] == []
            seen += 1
    assert seen > 12


def test_intervals_have_named_ends():
    gt = np.random.default_rng(0).normal(size=(12, 20, 2)).cumsum(axis=1)
    comparison = npss.compare(gt, gt + 1, 0 * gt)
    few = npss.compare(gt[:3], gt[:3] + 1, 0 * gt[:3])
    tested = study.binomial_test(8, 10, 5, 10)
    intervals = [npss.report(gt, 0 * gt).interval(), comparison.interval(), few.interval()]
    intervals += [study.wilson_interval(3, 9), tested.interval_a, tested.interval_b, tested.interval_difference]
    assert {type(interval) for interval in intervals} == {npss.Interval}
    assert all(interval.low <= interval.high for interval in intervals)


def test_all_arguments_of_public_functions_are_documented():
    missing = [
        f"{function.__name__}({argument})"
        for space in (npss, npss.rotations, npss.protocol, npss.skeleton, npss.plot, study, predictors)
        for function in (getattr(space, name) for name in space.__all__)
        if inspect.isfunction(function)
        for argument in inspect.signature(function).parameters
        if not re.search(rf"^(?:[*\w]+, )*\**{argument}\b.*$", section(function, "Parameters"), re.M)
    ]
    assert missing == []
    for name in npss.rotations.__all__:
        assert "{" not in section(getattr(npss.rotations, name), "Raises")


def test_conversion_without_docstring():
    """As under ``python -OO``."""
    assert conversion(_contract.EXPMAP, _contract.EULER)(lambda v: v).__doc__ is None


def section(documented, title):
    """Return a section of a docstring."""
    return re.split(r"\n(?=\w[\w ]*\n---)", inspect.getdoc(documented).partition(f"\n{title}\n")[2])[0]
