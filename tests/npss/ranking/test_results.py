"""Results from records and reports, and invalid records."""

import copy
import math

import numpy as np
import pytest

import npss
from npss.ranking._results import results_of_record
from npss.ranking._standings import standings
from npss.records import measure


@pytest.fixture(scope="module")
def record():
    rng = np.random.default_rng(6)
    gt = rng.normal(size=(6, 50, 3)).cumsum(axis=1)
    pred = gt + rng.normal(size=gt.shape)
    measured = measure(gt, pred, fps=25, at_ms=(80, 400), edges_ms=(0, 1000, 2000), sequences=True, frames=50)
    return {"model": "m", "action": "a", **measured}


def test_records_have_the_intervals_of_reports(record):
    rng = np.random.default_rng(6)
    gt = rng.normal(size=(6, 50, 3)).cumsum(axis=1)
    pred = gt + rng.normal(size=gt.shape)
    results = results_of_record(record)
    assert [one.column for one in results] == [
        *("NPSS paper", "NPSS released", "NPSS literal"),
        *(f"NPSS {name} {window} s" for name in npss.CONVENTIONS for window in ("0-1", "1-2")),
        *("Euler error 80 ms", "Euler error 400 ms"),
    ]
    found = {one.result.column: one for one in standings(results)}
    for name in npss.CONVENTIONS:
        expected = npss.report(gt, pred, convention=name).interval()
        assert (found[f"NPSS {name}"].low, found[f"NPSS {name}"].high) == pytest.approx(expected, rel=1e-9)
        assert found[f"NPSS {name} 0-1 s"].low is None
    euler = found["Euler error 400 ms"]
    assert euler.result.numerator.mean() == pytest.approx(euler.result.value)
    assert euler.low < euler.result.value < euler.high


@pytest.mark.parametrize("field", ["model", "action", "signature"])
def test_invalid_records(field):
    record = {"model": "m", "action": "a", "signature": "npss|version:1", field: None}
    with pytest.raises(ValueError, match=f"records: expected text as '{field}' in each, got None"):
        results_of_record(record)


def change(record, path, value):
    """Return the record with another value at a path such as "sequences/npss/paper/0"; None removes it."""
    changed = copy.deepcopy(record)
    *parents, last = path.split("/")
    place = changed
    for name in parents:
        place = place[int(name) if isinstance(place, list) else name]
    last = int(last) if isinstance(place, list) else last
    if value is None:
        del place[last]
    else:
        place[last] = value
    return changed


NO_NUMBERS = ["0.5", True, [], {}, math.nan, math.inf, -0.5, 10**400]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
@pytest.mark.parametrize(
    "path",
    [
        *("npss/paper", "npss_windows/released/0-1", "euler_error/80"),
        *(
            "sequences/npss/literal/0",
            "sequences/weight/paper/5",
            "sequences/euler_error/400/1",
        ),
    ],
)
def test_invalid_numbers(record, path, value):
    with pytest.raises(ValueError, match=r"^records: 'm' on 'a': .*expected a finite number that is not negative"):
        results_of_record(change(record, path, value))


@pytest.mark.parametrize("value", [[], "x", 3, {1: 2.0}], ids=repr)
@pytest.mark.parametrize(
    "path",
    ["npss", "npss_windows", "npss_windows/paper", "euler_error", "sequences", "sequences/npss", "sequences/weight"],
)
def test_invalid_objects(record, path, value):
    with pytest.raises(ValueError, match=r"^records: 'm' on 'a': .*expected an object, got "):
        results_of_record(change(record, path, value))


@pytest.mark.parametrize("value", [[], "x", 3, {}], ids=repr)
@pytest.mark.parametrize("path", ["sequences/npss/paper", "sequences/weight/paper"])
def test_invalid_lists(record, path, value):
    with pytest.raises(ValueError, match=r"^records: 'm' on 'a': .*expected a list with a number for each sequence"):
        results_of_record(change(record, path, value))


@pytest.mark.parametrize("value", [[], "x", 3, {}, [1.0], [[1.0, 2.0]], [None]], ids=repr)
def test_invalid_fingerprints(record, value):
    with pytest.raises(ValueError, match=r"^records: 'm' on 'a': sequences: fingerprint: expected (a list|9 numbers)"):
        results_of_record(change(record, "sequences/fingerprint", value))


@pytest.mark.parametrize("value", ["0.5", True, [], None, math.nan, -math.inf, 10**400], ids=repr)
def test_invalid_projections(record, value):
    row = [*record["sequences"]["fingerprint"][2][:-1], value]
    with pytest.raises(ValueError, match=r"sequences: fingerprint: expected a finite number, got"):
        results_of_record(change(record, "sequences/fingerprint/2", row))


def test_records_of_an_older_npss_have_fingerprints_of_their_own(record):
    old = change(change(record, "sequences/statistics", None), "sequences/fingerprint", [0.5] * 6)
    assert results_of_record(old)[0].fingerprint.shape == (6,)
    with pytest.raises(ValueError, match="fingerprint: a norm is negative"):
        results_of_record(change(record, "sequences/fingerprint/3/0", -1.0))
    with pytest.raises(ValueError, match="expected a finite number that is not negative"):
        results_of_record(change(record, "sequences/statistics", None))
    with pytest.raises(ValueError, match="statistics: expected a version from 1 to 2, got 3"):
        results_of_record(change(record, "sequences/statistics", 3))
    with pytest.raises(ValueError, match="cannot be compared: an older npss measured one of them"):
        standings(results_of_record(record) + results_of_record(old | {"model": "old"}))


@pytest.mark.parametrize("path", ["sequences/npss/paper/0", "sequences/weight/paper/0", "sequences/fingerprint/0"])
def test_lists_of_unequal_length(record, path):
    with pytest.raises(ValueError, match=r"sequences: lists of npss: paper differ in length: \[5, 6\]"):
        results_of_record(change(record, path, None))


@pytest.mark.parametrize("path", ["npss/paper", "euler_error/80", "sequences/npss/paper", "sequences/weight/paper"])
def test_contradictory_numbers(record, path):
    value = {
        "npss/paper": 9.0,
        "euler_error/80": 9.0,
        "sequences/npss/paper": [9.0] * 6,
        "sequences/weight/paper": [0.0] * 6,
    }
    with pytest.raises(ValueError, match=r"the weighted mean of .* is not .*, which the record states"):
        results_of_record(change(record, path, value[path]))


@pytest.mark.parametrize("field", ["model", "action", "signature"])
@pytest.mark.parametrize("value", [None, 3, [], ""])
def test_records_without_a_name(record, field, value):
    if value == "" and field == "action":
        assert results_of_record({**record, field: value})[0].value == record["npss"]["paper"]
        return
    with pytest.raises(ValueError, match=r"^records: "):
        results_of_record({**record, field: value})


def test_other_fields_that_are_wrong(record):
    with pytest.raises(ValueError, match="convention: expected one of"):
        results_of_record(change(record, "npss/mine", 3.0))
    with pytest.raises(ValueError, match="convention: expected one of"):
        results_of_record(change(record, "npss_windows/mine", {"0-1": 3.0}))
    with pytest.raises(ValueError, match="source: expected text"):
        results_of_record({**record, "source": 3})
    with pytest.raises(ValueError, match=r"weight of npss: paper: expected a list .* got None"):
        results_of_record(change(record, "sequences/weight/paper", None))


def test_names_are_one_line(record):
    (first, *_) = results_of_record({**record, "model": "my\n model", "action": "a\tb"})
    assert (first.model, first.action) == ("my model", "a b")


def test_optional_fields(record):
    bare = {name: record[name] for name in ("model", "action", "npss", "signature")}
    assert [one.weight for one in results_of_record(bare)] == [None] * 3
    assert results_of_record({name: record[name] for name in ("model", "action", "signature")}) == []


SIGNATURE = "g|version:1|frames:50"


@pytest.fixture
def with_another(record):
    """A record with another metric."""
    record = copy.deepcopy(record) | {"metrics": {"G": 2.0}}
    record["signatures"]["G"] = SIGNATURE
    record["sequences"]["metrics"] = {"G": [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]}
    return record


def test_other_metrics_are_ranked_separately(with_another):
    found = {one.result.column: one for one in standings(results_of_record(with_another))}
    assert (found["G"].result.value, found["G"].result.signature) == (2.0, SIGNATURE)
    assert found["G"].low < 2.0 < found["G"].high
    (alone,) = [one for one in results_of_record(change(with_another, "sequences", None)) if one.column == "G"]
    assert alone.weight is None
    other = {**change(with_another, "signatures/G", "g|version:2|frames:50"), "model": "other"}
    with pytest.raises(ValueError, match=r"a, G: 'm' and 'other' are different numbers"):
        standings(results_of_record(with_another) + results_of_record(other))


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("metrics/G", -1.0, "metrics: G: expected a finite number"),
        ("metrics/G", 3.0, "the weighted mean of metrics: G is not 3.0"),
        ("metrics", [], "metrics: expected an object"),
        ("metrics", {"NPSS paper": 1.0}, "metrics: 'NPSS paper' is not a valid name for another metric"),
        ("metrics", {"Euler error 80 ms": 1.0}, "metrics: 'Euler error 80 ms' is not a valid name"),
        ("metrics", {"a\nb": 1.0}, "metrics: 'a.*b' is not a valid name"),
        ("metrics", {"": 1.0}, "metrics: '' is not a valid name"),
        ("signatures/G", None, "signatures: expected one for 'G', got None"),
        ("signatures/G", "G", "signature: 'G' does not begin with a metric"),
        ("signatures", 3, "signatures: expected an object"),
        ("sequences/metrics/G/0", None, "lists of metrics: G differ in length"),
        ("sequences/metrics", 3, "sequences: metrics: expected an object"),
    ],
)
def test_invalid_other_metrics(with_another, path, value, message):
    with pytest.raises(ValueError, match=f"^records: 'm' on 'a': {message}|^records: 'm' on 'a': sequences: {message}"):
        results_of_record(change(with_another, path, value))
