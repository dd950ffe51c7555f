"""Accumulators: any split, any order, the same bits."""

import json
import pickle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from strategies import pairs

pytestmark = pytest.mark.numeric

CONVENTIONS = st.sampled_from([*npss.CONVENTIONS, npss.Convention(bins="one-sided", weight="uniform")])


@given(pair=pairs(max_n=8), convention=CONVENTIONS, cuts=st.lists(st.integers(0, 8), max_size=4), order=st.randoms())
def test_any_split_and_any_order_give_the_bits_of_one_pass(pair, convention, cuts, order):
    gt, pred = pair
    edges = sorted({0, len(gt), *(min(cut, len(gt)) for cut in cuts)})
    parts = [npss.Accumulator(convention=convention).update(gt[a:b], pred[a:b]) for a, b in pairwise(edges)]
    whole = npss.score(gt, pred, convention=convention)
    in_turn = npss.Accumulator(convention=convention)
    for a, b in pairwise(edges):
        assert in_turn.update(gt[a:b], pred[a:b]) is in_turn
    assert in_turn.result() == whole
    order.shuffle(parts)
    while len(parts) > 1:
        first = parts.pop(order.randrange(len(parts)))
        second = parts.pop(order.randrange(len(parts)))
        parts.append(first | second)
    assert parts[0].result() == whole
    assert parts[0].report()["sequences"] == len(gt)


@given(pair=pairs(max_n=1), convention=CONVENTIONS)
def test_a_sequence_alone_has_two_axes(pair, convention):
    gt, pred = pair
    assert npss.Accumulator(convention=convention).update(gt[0], pred[0]).state() == (
        npss.Accumulator(convention=convention).update(gt, pred).state()
    )


@given(pair=pairs(), convention=CONVENTIONS)
def test_states_survive_json_and_pickle(pair, convention):
    accumulator = npss.Accumulator(convention=convention).update(*pair)
    for copy in (
        npss.Accumulator.from_state(json.loads(json.dumps(accumulator.state()))),
        pickle.loads(pickle.dumps(accumulator)),
    ):
        assert copy.state() == accumulator.state()
        assert copy.result() == accumulator.result()
        assert copy.update(*pair).result() == accumulator.result()


@pytest.fixture
def pair():
    return np.random.default_rng(0).normal(size=(2, 5, 12, 3))


def test_huge_and_tiny_sets_merge(pair):
    gt, pred = pair
    both = [np.concatenate([gt * 1e300, gt * 1e-300]), np.concatenate([pred, pred])]
    parts = [npss.Accumulator().update(gt * scale, pred) for scale in (1e-300, 1e300)]
    assert (parts[0] | parts[1]).result() == npss.score(*both)


def test_merging_in_place_and_not(pair):
    gt, pred = pair
    first, second = (npss.Accumulator().update(gt[s], pred[s]) for s in (slice(2), slice(2, None)))
    before = first.state(), second.state()
    merged = first | second
    assert (first.state(), second.state()) == before
    same = first
    first |= second
    assert first is same
    assert first.state() == merged.state()
    empty = npss.Accumulator()
    assert (empty | first).state() == (first | empty).state() == first.state()


def test_the_state_of_an_empty_accumulator(pair):
    assert npss.Accumulator().state() == {
        "signature": "npss|version:1|convention:paper|frames:0",
        "features": 0,
        "sequences": 0,
        "numerator": "0",
        "denominator": "0",
    }


def test_the_report_and_the_repr(pair):
    accumulator = npss.Accumulator(convention="released").update(*pair)
    assert repr(accumulator) == "<npss.Accumulator of 5 sequences, convention released>"
    assert accumulator.report() == {
        "npss": npss.score(*pair, convention="released"),
        "sequences": 5,
        "features": 3,
        "signature": "npss|version:1|convention:released|frames:12",
    }


class TestRefuses:
    def test_other_conventions(self, pair):
        with pytest.raises(ValueError, match="convention: released cannot be merged into paper"):
            npss.Accumulator().update(*pair) | npss.Accumulator(convention="released").update(*pair)

    def test_other_shapes(self, pair):
        accumulator = npss.Accumulator().update(*pair)
        state = accumulator.state()
        with pytest.raises(ValueError, match="gt: 10 frames of 3 features; this accumulator holds sequences of 12"):
            accumulator.update(*pair[:, :, :10])
        with pytest.raises(ValueError, match="gt: 12 frames of 2 features"):
            accumulator.update(*pair[..., :2])
        with pytest.raises(ValueError, match="the other accumulator: 10 frames"):
            accumulator |= npss.Accumulator().update(*pair[:, :, :10])
        assert accumulator.state() == state

    def test_bad_batches_and_stays_unchanged(self, pair):
        accumulator = npss.Accumulator().update(*pair)
        state = accumulator.state()
        bad = pair[0].copy()
        bad[-1, -1, -1] = np.nan
        with pytest.raises(ValueError, match=r"pred: nan at index \(4, 11, 2\)"):
            accumulator.update(pair[0], bad)
        with pytest.raises(ValueError, match="gt: one frame"):
            npss.Accumulator().update(*pair[:, :, :1])
        assert accumulator.state() == state

    def test_empty_accumulators(self, pair):
        with pytest.raises(ValueError, match="the accumulator is empty"):
            npss.Accumulator().result()
        powerless = npss.Accumulator().update(0 * pair[0], pair[1])
        with pytest.raises(ValueError, match="gt: no power"):
            powerless.result()
        assert powerless.update(*pair).result() == npss.score(*pair)

    def test_other_operands(self):
        with pytest.raises(TypeError):
            npss.Accumulator() | 3
        accumulator = npss.Accumulator()
        with pytest.raises(TypeError):
            accumulator |= {}

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"signature": "npss|version:2|convention:paper|frames:12"}, "version"),
            ({"signature": "npss|version:0|convention:paper|frames:12"}, "version"),
            ({"signature": "npss|version:1|convention:paper"}, "of metric version 1"),
            ({"signature": "mse|version:1|frames:12"}, "of metric version 1"),
            ({"signature": "npss|version:1|convention:paper|frames:many"}, "signature"),
            ({"signature": "nonsense"}, "signature"),
            ({"features": -1}, "features and sequences must be whole numbers"),
            ({"features": 2.5}, "features and sequences must be whole numbers"),
            ({"features": True}, "features and sequences must be whole numbers"),
            ({"sequences": 0}, "contradict each other"),
            ({"numerator": "-1"}, "contradict each other"),
            ({"numerator": "xyz"}, "numerator and denominator must be hexadecimal"),
            ({"numerator": 3}, "numerator and denominator must be hexadecimal"),
            ({"extra": 1}, "expected a dict with the keys"),
        ],
    )
    def test_invalid_states(self, pair, change, message):
        state = npss.Accumulator().update(*pair).state()
        with pytest.raises(ValueError, match=message):
            npss.Accumulator.from_state({**state, **change})
        with pytest.raises(ValueError, match="state: expected a dict"):
            npss.Accumulator.from_state([])
