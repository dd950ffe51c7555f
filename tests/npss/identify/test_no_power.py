"""Tests of npss.identify where features have no power, and where motion is small."""

import numpy as np
import pytest

import nearest_versions
import npss
from nearest_versions import NAMED, RELEASED, function_of

EMPTY = "a prediction without power counts as an empty distribution (0/0 -> 0)"
POSE = "a prediction without power counts as a constant pose"


@pytest.mark.parametrize("name", NAMED)
@pytest.mark.parametrize(("empty", "zero", "words"), [("empty", "empty", EMPTY), ("dc", "dc", POSE)])
def test_rules_do_not_change_the_name(name, empty, zero, words):
    result = npss.identify(function_of({**NAMED[name], "empty": empty}))
    assert (result.convention, result.differences) == (name, {})
    assert result.no_power == words
    assert result.custom.zero == zero
    assert "\nThe same in npss: " in str(result)
    assert str(result).startswith(f"It computes `{name}`.\nWithout power: {words}.\n")


def test_nan():
    result = npss.identify(function_of(RELEASED))
    assert result.no_power == "nan where a feature has no power"
    assert "\nThe same in npss, but for features without power: " in str(result)


def test_errors():
    def strict(gt, pred):
        if not (gt.any(axis=1).all() and pred.any(axis=1).all()):
            raise ZeroDivisionError
        return nearest_versions.score(gt, pred, RELEASED)

    result = npss.identify(strict)
    assert (result.convention, result.no_power) == (
        "released",
        "raises ZeroDivisionError where a feature has no power",
    )


def test_a_total_of_0_replaced_by_1():
    def replaced(gt, pred):
        powers = [np.fft.fft(motion, axis=1).real ** 2 for motion in (gt, pred)]
        totals = [np.where(power.sum(axis=1) == 0, 1.0, power.sum(axis=1)) for power in powers]
        first, second = (np.cumsum(power / total[:, None], axis=1) for power, total in zip(powers, totals, strict=True))
        return np.average(np.abs(first - second).sum(axis=1), weights=totals[0])

    result = npss.identify(replaced)
    assert result.convention == "released"
    assert "a ground truth without power counts as an empty distribution (0/0 -> 0), with the weight 1" in (
        result.no_power
    )


def test_nan_features_are_left_out():
    def left_out(gt, pred):
        distance, of_gt, _ = nearest_versions.distances_and_totals(gt, pred, **RELEASED)
        known = np.isfinite(distance)
        return np.average(distance[known], weights=of_gt[known])

    result = npss.identify(left_out)
    assert (result.convention, result.no_power) == ("released", "a prediction without power does not count")


def test_nan_distances_are_0():
    def as_zero(gt, pred):
        distance, of_gt, _ = nearest_versions.distances_and_totals(gt, pred, **RELEASED)
        return np.average(np.nan_to_num(distance), weights=of_gt)

    result = npss.identify(as_zero)
    assert (result.convention, result.no_power) == (
        "released",
        "a prediction without power counts as a perfect prediction",
    )


@pytest.mark.parametrize("exponent", [5, 6, 8, 10, 12, 15])
@pytest.mark.parametrize("name", ["released", "literal"])
def test_epsilons(name, exponent):
    epsilon = 10.0**-exponent
    result = npss.identify(function_of({**NAMED[name], "epsilon": epsilon}))
    assert result.convention == name
    assert f"an epsilon of {epsilon:.3g} added to total powers, so small motion gets another score" in result.no_power
    assert "\nThe same in npss, but for features without power and small motion: " in str(result)


@pytest.mark.parametrize(
    ("normalise", "words"),
    [
        (lambda power, total: (power / np.maximum(total, 1e-8)[:, None], total), "as the least total power"),
        (
            lambda power, total: (power / (total + 1e-8)[:, None], total + 1e-8),
            "added to total powers, in the weights too",
        ),
        (
            lambda power, total: (power / np.where(total > 1e-8, total, 1)[:, None], total),
            "below which a total power counts as 1",
        ),
    ],
)
def test_other_epsilons(normalise, words):
    def with_epsilon(gt, pred):
        powers = [np.fft.fft(motion, axis=1).real ** 2 for motion in (gt, pred)]
        (first, weight), (second, _) = (normalise(power, power.sum(axis=1)) for power in powers)
        return np.average(np.abs(np.cumsum(first - second, axis=1)).sum(axis=1), weights=weight)

    result = npss.identify(with_epsilon)
    assert result.convention == "released"
    assert f"an epsilon of 1e-08 {words}, so" in result.no_power


def test_a_large_epsilon_has_no_name():
    result = npss.identify(function_of({**RELEASED, "epsilon": 1.0}))
    assert result.convention is None
    assert "it changes with the scale of both motions, by " in str(result)


def test_features_without_power_over_features():
    """No power of a frame, where the transform runs over features."""
    result = npss.identify(function_of({**RELEASED, "axis": "features", "empty": "empty"}))
    assert result.no_power == EMPTY
