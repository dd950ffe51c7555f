"""Tests of npss.identify: every combination of choices is told from its numbers."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nearest_versions
import npss
from nearest_versions import AXES, NAMED, RELEASED, combinations, function_of

#: Motion that identify does not know.
GT, PRED = np.random.default_rng(5).normal(size=(2, 3, 30, 12)) + 1


def expected_of(choices):
    """Return the axes that differ from each named convention that differs least."""
    differing = {name: {axis for axis in AXES if choices[axis] != named[axis]} for name, named in NAMED.items()}
    least = min(map(len, differing.values()))
    return {name: axes for name, axes in differing.items() if len(axes) == least}


def is_identified(choices):
    result = npss.identify(function_of(choices))
    expected = expected_of(choices)
    named = [name for name, axes in expected.items() if not axes]
    right = set(result.differences) == expected.get(result.nearest)
    right = right and [result.convention] == (named or [None])
    reproducible = choices["power"] in ("real", "magnitude") and choices["axis"] != "mixed"
    if result.call is None or not reproducible:
        return right and result.call is None and not reproducible
    reproduced = eval(result.call, {"npss": npss, "np": np, "gt": GT, "pred": PRED})
    # Both are sums of thousands of numbers in float64.
    return right and reproduced == pytest.approx(nearest_versions.score(GT, PRED, choices), rel=1e-9)


def test_there_are_some_hundred():
    assert len([*combinations()]) == 1920


@pytest.mark.parametrize(("power", "mean"), [*product(AXES["power"], AXES["mean"])])
def test_over_frames(power, mean):
    several = [*combinations(power=power, mean=mean, axis="time", factor="none")]
    assert len(several) == 20
    assert [choices for choices in several if not is_identified(choices)] == []


@pytest.mark.parametrize(("axis", "power"), [*product(("features", "mixed"), AXES["power"])])
def test_over_features(axis, power):
    several = [*combinations(power=power, axis=axis, factor="none", mean="kept")]
    assert len(several) == 20
    assert [choices for choices in several if not is_identified(choices)] == []


@pytest.mark.parametrize("axis", ["features", "mixed"])
def test_over_features_without_mean(axis):
    several = [*combinations(power="real", axis=axis, factor="none", mean="removed", aggregation="set")]
    assert len(several) == 12
    assert [choices for choices in several if not is_identified(choices)] == []


@pytest.mark.parametrize("factor", AXES["factor"][1:])
def test_factors(factor):
    several = [*combinations(factor=factor, axis="time", mean="kept", bins="two-sided", power="real")]
    assert len(several) == 10
    assert [choices for choices in several if not is_identified(choices)] == []


@pytest.mark.parametrize("name", NAMED)
def test_named_conventions(name):
    result = npss.identify(function_of(NAMED[name]))
    assert (result.convention, result.nearest, result.differences) == (name, name, {})
    assert result.custom == npss.CONVENTIONS[name]
    assert result.call == f'npss.score(gt, pred, convention="{name}")'
    assert result.example[0] == pytest.approx(result.example[1], rel=1e-9)
    assert str(result).startswith(f"It computes `{name}`.\nWithout power: nan where a feature has no power.\n")


@pytest.mark.parametrize(
    "choices",
    [
        {**RELEASED, "weight": "uniform", "aggregation": "set"},
        {**RELEASED, "weight": "uniform", "aggregation": "sequence"},
    ],
)
def test_the_same_function_has_one_name(choices):
    result = npss.identify(function_of(choices))
    assert result.differences == {"weight": "none"}
    assert result.custom == npss.Convention(power="real", weight="uniform", zero="empty")


def test_totals_of_normalised_spectra_are_no_weights():
    def npss_of(gt, pred):
        distance, of_gt, _ = nearest_versions.distances_and_totals(gt, pred, **RELEASED)
        return np.average(distance, weights=of_gt / of_gt)

    assert npss.identify(npss_of).differences == {"weight": "none"}


def test_weights_normalised_over_the_set_then_averaged():
    def npss_of(gt, pred):
        distance, of_gt, _ = nearest_versions.distances_and_totals(gt, pred, **RELEASED)
        return np.mean(np.sum(distance * of_gt / np.sum(of_gt), axis=1))

    result = npss.identify(npss_of)
    assert result.differences == {"factor": "divided by N"}
    assert 'npss.score(gt, pred, convention="released") / len(gt)' in str(result)


def test_the_sentence():
    choices = {**RELEASED, "weight": "pred", "aggregation": "sequence"}
    lines = str(npss.identify(function_of(choices))).splitlines()
    assert lines[:2] == [
        "It computes none of the named conventions; nearest: `released`.",
        "What differs: weights: the prediction's total power (arguments swapped?); aggregation: per sequence, then "
        "averaged.",
    ]
    assert lines[-1] == (
        "NPSS: not comparable with the LaFAN1 in-betweening tables: its weights must be the ground truth's total "
        "power; it must average over the whole set."
    )


def test_two_numbers_on_one_example():
    result = npss.identify(function_of({**RELEASED, "aggregation": "sequence"}))
    own, named = result.example
    assert own != pytest.approx(named, rel=0.01)
    assert f": {own:.6g}; npss by `released`: {named:.6g}." in str(result)


def test_words_about_tables():
    text = str(npss.identify(function_of(RELEASED)))
    explained = npss.explain(npss.signature("released")).splitlines()[-2:]
    assert text.splitlines()[-2:] == explained
    assert "may or may not be comparable with tables 4 and 5" in text


@pytest.mark.parametrize("number", [0.3, 2.0, 100.0])
def test_any_constant_factor(number):
    result = npss.identify(lambda gt, pred: number * nearest_versions.score(gt, pred, RELEASED))
    assert result.differences == {"factor": f"times {number:g}"}


def test_a_sum_instead_of_a_mean():
    choices = {**RELEASED, "weight": "uniform"}
    result = npss.identify(lambda gt, pred: nearest_versions.score(gt, pred, choices) * gt.shape[0] * gt.shape[2])
    assert result.differences == {"weight": "none", "factor": "times N, times D"}


def test_an_unknown_aggregation():
    def median(gt, pred):
        return np.median([nearest_versions.score(g[None], p[None], RELEASED) for g, p in zip(gt, pred, strict=True)])

    result = npss.identify(median)
    assert (result.convention, result.nearest) == (None, "released")
    assert result.differences == {"aggregation": "over sequences in an unknown way"}


def batched(size, weighted):
    """Return a function that averages the scores of batches."""

    def npss_of(gt, pred):
        tops = range(0, len(gt), size)
        scores = [nearest_versions.score(gt[top : top + size], pred[top : top + size], RELEASED) for top in tops]
        return np.average(scores, weights=[len(gt[top : top + size]) for top in tops] if weighted else None)

    return npss_of


@pytest.mark.parametrize(
    ("size", "weighted", "words"),
    [
        (64, False, "per batch, then averaged"),
        (32, True, "per batch, then averaged by the size of batches"),
        (41, False, "over sequences in an unknown way"),
    ],
)
def test_batches_within_a_function(size, weighted, words):
    result = npss.identify(batched(size, weighted))
    assert (result.convention, result.nearest, result.differences) == (None, "released", {"aggregation": words})
    own, named = result.example
    assert own != pytest.approx(named, rel=1e-6)
    assert "\nOn one example (140 sequences, 6 frames of 12 features): " in str(result)


IMPOSTERS = {
    "odd numbers of frames": lambda value, gt: value * (1.01 if gt.shape[1] % 2 else 1),
    "one sequence": lambda value, gt: value * (1.01 if len(gt) == 1 else 1),
    "many frames": lambda value, gt: value * (1.01 if gt.shape[1] > 60 else 1),
    "hundreds of frames": lambda value, gt: value * (1.01 if gt.shape[1] > 200 else 1),
    "hundreds of features": lambda value, gt: value * (1.01 if gt.shape[2] > 100 else 1),
    "hundreds of sequences": lambda value, gt: value * (1.01 if len(gt) > 100 else 1),
    "large scores": lambda value, gt: min(value, 2.0),
    "loud motion": lambda value, gt: value * (1.01 if np.abs(gt).max() > 10 else 1),
    "large motion": lambda value, gt: value * (1.01 if np.abs(gt).max() > 1e4 else 1),
    "small motion": lambda value, gt: value * (1.01 if np.abs(gt).max() < 1e-3 else 1),
    "a shift of the mean": lambda value, gt: value * (1.01 if abs(gt.mean()) < 0.1 else 1),
}


@pytest.mark.parametrize("where", IMPOSTERS)
def test_never_named_if_it_differs_anywhere(where):
    result = npss.identify(lambda gt, pred: IMPOSTERS[where](nearest_versions.score(gt, pred, RELEASED), gt))
    assert result.convention is None
    assert result.nearest is None or result.differences


@pytest.mark.parametrize(
    "change",
    [
        lambda motion: motion * np.hanning(motion.shape[1])[:, np.newaxis],
        lambda motion: np.pad(motion, ((0, 0), (0, 28), (0, 0))),
        lambda motion: motion[:, :50],
        lambda motion: (motion + np.pi) % (2 * np.pi) - np.pi,
        lambda motion: np.unwrap(motion, axis=1),
        lambda motion: motion / np.linalg.norm(motion, axis=2, keepdims=True),
        lambda motion: np.diff(motion, axis=1),
        lambda motion: motion.round(1),
    ],
    ids=["window", "padding", "first 50 frames", "wrapped", "unwrapped", "unit", "velocity", "rounded"],
)
def test_never_named_if_motion_is_changed_first(change):
    assert npss.identify(lambda gt, pred: nearest_versions.score(change(gt), change(pred), RELEASED)).convention is None


def test_never_named_if_constant_features_are_left_out():
    def of_moving(gt, pred):
        moving = gt.std(axis=(0, 1)) > 1e-4
        return nearest_versions.score(gt[:, :, moving], pred[:, :, moving], RELEASED)

    result = npss.identify(of_moving)
    assert (result.convention, result.nearest, set(result.differences)) == (None, "released", {"motion", "scale"})


def divergence(gt, pred):
    """Return the power spectrum KL divergence."""
    first, second = (np.abs(np.fft.fft(motion, axis=1)) ** 2 + 1e-9 for motion in (gt, pred))
    first, second = (power / power.sum(axis=1, keepdims=True) for power in (first, second))
    return (first * np.log(first / second)).sum(axis=1).mean()


NO_NPSS = {
    "mean squared error": (lambda gt, pred: ((gt - pred) ** 2).mean(), "it changes with the scale of both motions"),
    "mean absolute error": (lambda gt, pred: np.abs(gt - pred).mean(), "it changes with the scale of the prediction"),
    "cosine distance": (
        lambda gt, pred: 1 - (gt * pred).sum() / np.linalg.norm(gt) / np.linalg.norm(pred),
        "its numbers differ",
    ),
    "correlation": (lambda gt, pred: np.corrcoef(gt.ravel(), pred.ravel())[0, 1], "it is not 0 for equal motions"),
    "divergence": (divergence, ""),
    "constant": (lambda gt, pred: 0.5, "it is not 0 for equal motions"),
    "zero": (lambda gt, pred: 0.0, "it is 0 for all motions"),
    "nan": (lambda gt, pred: np.nan, "it is not finite for ordinary motion"),
    "an array": (lambda gt, pred: ((gt - pred) ** 2).mean(axis=(1, 2)), "it changes with the scale of both motions"),
}


@pytest.mark.parametrize("name", NO_NPSS)
def test_no_npss(name):
    function, reason = NO_NPSS[name]
    result = npss.identify(function)
    assert (result.convention, result.nearest, result.differences) == (None, None, {})
    assert str(result).startswith("It computes no NPSS: ")
    assert reason in str(result)


@settings(max_examples=max(1, settings.default.max_examples // 3))
@given(
    st.fixed_dictionaries({axis: st.sampled_from(choices) for axis, choices in AXES.items() if axis != "factor"}),
    st.floats(0.05, 20).filter(lambda number: abs(number - 1) > 0.01),
)
def test_any_combination_times_any_number(choices, number):
    choices = {**choices, "factor": "none"}
    if choices["weight"] == "uniform":
        choices["aggregation"] = "set"  # the same function
    result = npss.identify(lambda gt, pred: number * nearest_versions.score(gt, pred, choices))
    axes = expected_of(choices)[result.nearest]
    assert set(result.differences) == axes | {"factor"}
    assert result.differences["factor"] == f"times {number:.6g}"
