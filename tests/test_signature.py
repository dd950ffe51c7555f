"""Signatures: written, read back, equal where the values are equal and different where they differ."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss

VALUES = st.one_of(
    st.booleans(),
    st.integers(-(10**15), 10**15),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12),
    st.text('|:+%"\\ 0123456789.-etrufalsn,=', max_size=12),
)
NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True).filter(
    lambda name: name not in ("metric", "version", "convention")
)
CONVENTIONS = st.one_of(
    st.sampled_from(["paper", "released", "literal"]),
    st.builds(
        npss.Convention,
        power=st.sampled_from(["magnitude", "real"]),
        bins=st.sampled_from(["two-sided", "one-sided"]),
        distance=st.sampled_from(["cdf", "spectrum"]),
        weight=st.sampled_from(["power", "uniform"]),
        zero=st.sampled_from(["dc", "empty"]),
    ).filter(lambda convention: convention not in npss.CONVENTIONS.values()),
)


@given(convention=CONVENTIONS, context=st.dictionaries(NAMES, VALUES, max_size=5))
def test_reads_back(convention, context):
    text = npss.signature(convention, **context)
    assert npss.parse_signature(text) == {"metric": "npss", "version": 1, "convention": convention, **context}
    assert npss.signature(**npss.parse_signature(text)) == text
    assert text.isprintable() or not all(str(value).isprintable() for value in context.values())


@given(context=st.dictionaries(NAMES, VALUES, min_size=1, max_size=5), other=VALUES)
def test_differs_where_a_value_differs(context, other):
    name = next(iter(context))
    value = context[name]
    differs = value != other or isinstance(value, bool) != isinstance(other, bool)
    assert (npss.signature(**context) != npss.signature(**{**context, name: other})) == differs


@given(context=st.dictionaries(NAMES, VALUES, max_size=6), seed=st.randoms())
def test_does_not_depend_on_the_order_of_keywords(context, seed):
    items = list(context.items())
    seed.shuffle(items)
    assert npss.signature(**dict(items)) == npss.signature(**context)


def test_looks_as_documented():
    assert (
        npss.signature("paper", unwrap="off", fps=25, frames=100, representation="euler", seed=3, window="0-1")
        == "npss|version:1|convention:paper|representation:euler|frames:100|fps:25|window:0-1|unwrap:off|seed:3"
    )


def test_a_named_convention_has_its_name_whoever_built_it():
    assert npss.signature(npss.Convention()) == npss.signature("paper")
    assert npss.signature(npss.Convention(power="real", zero="empty")) == npss.signature("released")


def test_several_conventions_or_none():
    text = npss.signature(("paper", "released"), metric="npss+euler_error")
    assert text == "npss+euler_error|version:1|convention:paper+released"
    assert npss.parse_signature(text)["convention"] == ("paper", "released")
    assert npss.signature(None, metric="mse") == "mse|version:1"
    assert npss.parse_signature("mse|version:1")["convention"] is None


def test_numbers_are_equal_whatever_holds_them():
    assert npss.signature(fps=25.0) == npss.signature(fps=25) == npss.signature(fps=np.float32(25))
    assert npss.signature(frames=np.int64(3)) == npss.signature(frames=3)


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({"fps": float("nan")}, ValueError, "fps: nan has no place"),
        ({"fps": None}, TypeError, "fps: expected text, a number or a truth value"),
        ({"fps": [25]}, TypeError, "fps: expected text"),
        ({"convention": "mine"}, ValueError, "convention: expected one of"),
        ({"convention": ()}, ValueError, "convention: expected at least one"),
        ({"convention": 3}, TypeError, "convention: expected a sequence"),
        ({"metric": "mse"}, ValueError, "convention: mse has none; pass None"),
        ({"version": "one"}, TypeError, "version: expected a positive integer"),
        ({"version": 1.5}, TypeError, "version: expected a positive integer"),
        ({"metric": "NPSS|"}, ValueError, "metric: expected lower-case names"),
        ({"metric": 3}, TypeError, "metric: expected text"),
        ({"späte": 1}, ValueError, "späte: a signature's fields are named by"),
    ],
)
def test_values_that_have_no_signature(keywords, error, message):
    with pytest.raises(error, match=message):
        npss.signature(**keywords)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "npss",
        "NPSS|version:1",
        "npss|convention:paper",
        "npss|version:1.5",
        "npss|version:one",
        "npss|version:true",
        "npss|version:1|convention:mine",
        "npss|version:1|convention:power=real",
        "npss|version:1|convention:power=real,bins",
        "npss|version:1|convention:power=odd,bins=two-sided,distance=cdf,weight=power,zero=dc",
        "npss|version:1|fps",
        "npss|version:1|fps:25|fps:25",
        "npss|version:1|metric:npss",
        'npss|version:1|x:"unfinished',
        "npss|version:1||fps:25",
    ],
)
def test_text_that_is_no_signature(text):
    with pytest.raises(ValueError, match=r"signature|convention|power"):
        npss.parse_signature(text)


def test_what_is_no_text():
    with pytest.raises(TypeError, match="signature: expected text"):
        npss.parse_signature(None)


class TestConvention:
    def test_is_frozen_and_hashable(self):
        convention = npss.Convention()
        with pytest.raises(AttributeError):
            convention.power = "real"
        assert {convention: 1}[npss.CONVENTIONS["paper"]] == 1

    @pytest.mark.parametrize(
        ("field", "value", "error"), [("power", "imag", ValueError), ("bins", None, TypeError), ("zero", 0, TypeError)]
    )
    def test_choices_are_checked(self, field, value, error):
        with pytest.raises(error, match=f"{field}: expected one of"):
            npss.Convention(**{field: value})

    def test_its_choices_have_names_and_the_named_ones_stay_what_they_are(self):
        with pytest.raises(TypeError):
            npss.Convention("real")
        with pytest.raises(TypeError):
            npss.CONVENTIONS["paper"] = npss.Convention(power="real")

    def test_the_named_ones(self):
        assert set(npss.CONVENTIONS) == {"paper", "released", "literal"}
        assert len(set(npss.CONVENTIONS.values())) == 3


PUBLISHED = {"representation": "euler", "frames": 100, "fps": 25, "protocol": "srnn-8", "unwrap": "off"}


class TestExplain:
    def test_comparable(self):
        text = npss.explain(npss.signature("released", **PUBLISHED))
        assert "NPSS: comparable with tables 4 and 5 of the NPSS paper" in text
        assert "the square of the real part alone" in text
        assert "NPSS: not comparable with the LaFAN1" in text

    @pytest.mark.parametrize(
        ("change", "reason"),
        [
            ({"convention": "paper"}, "the convention must be released"),
            ({"frames": 50}, "frames must be 100, not 50"),
            ({"unwrap": "target"}, "unwrap must be off, not target"),
            ({"version": 2}, "version must be 1, not 2"),
            ({"window": "0-3"}, "window must be 0-1 or 1-2 or 2-4, not 0-3"),
            ({"fps": 50}, "fps must be 25, not 50"),
            ({"protocol": "random-256"}, "protocol must be srnn-8, not random-256"),
            ({"representation": "expmap"}, "representation must be euler, not expmap"),
        ],
    )
    def test_not_comparable(self, change, reason):
        text = npss.explain(npss.signature(**{"convention": "released", **PUBLISHED, **change}))
        assert f"NPSS: not comparable with tables 4 and 5 of the NPSS paper (Human3.6M): {reason}." in text

    @pytest.mark.parametrize(
        "change",
        [{"frames": 25}, {"unwrap": "target"}, {"columns": "pred"}, {"average": "up-to"}, {"fps": 50}],
    )
    def test_euler_errors_that_are_not_comparable(self, change):
        context = {**PUBLISHED, "columns": "gt", "average": "at"}
        assert "Euler error: comparable" in npss.explain(npss.signature(None, metric="euler_error", **context))
        text = npss.explain(npss.signature(None, metric="euler_error", **{**context, **change}))
        ((name, value),) = change.items()
        assert "Euler error: not comparable" in text
        assert f"{name} must be {context[name]}, not {value}" in text

    def test_a_field_that_no_table_knows(self):
        text = npss.explain(npss.signature("released", **PUBLISHED, subject=9))
        assert "cannot be told: not stated: what subject means" in text

    def test_a_window_of_table_5(self):
        assert "NPSS: comparable" in npss.explain(npss.signature("released", **PUBLISHED, window="1-2"))

    def test_it_says_whether_jumps_were_removed(self):
        assert "jumps of 2 pi removed: yes, over the scored frames alone" in npss.explain(
            npss.signature(**{**PUBLISHED, "unwrap": "target"})
        )

    def test_cannot_be_told(self):
        text = npss.explain("npss|version:1|convention:released|frames:100")
        assert "cannot be told: not stated: representation, fps, protocol, unwrap" in text

    def test_lafan1(self):
        text = npss.explain(
            npss.signature(
                "released", representation="global-quaternions", fps=30, frames=45, protocol="lafan1", unwrap="off"
            )
        )
        assert "NPSS: comparable with the LaFAN1 in-betweening tables." in text

    def test_a_record_of_several_numbers(self):
        text = npss.explain(
            npss.signature(("paper", "released"), metric="npss+euler_error", columns="gt", average="at", **PUBLISHED)
        )
        assert "Euler error: comparable with tables 6 and 7" in text
        assert "NPSS released (of the several scores, that one alone): comparable with tables 4 and 5" in text

    def test_unwrapping_is_of_npss_alone(self):
        text = npss.explain(
            npss.signature(
                "released", metric="npss+euler_error", columns="gt", average="at", **{**PUBLISHED, "unwrap": "target"}
            )
        )
        assert "Euler error: comparable" in text
        assert "NPSS: not comparable" in text

    def test_conventions_of_its_own_and_other_metrics(self):
        text = npss.explain(npss.signature(npss.Convention(bins="one-sided", distance="spectrum", weight="uniform")))
        assert "a convention of its own" in text
        assert "only the T//2 + 1 bins" in text
        assert "Nothing else is stated." in text
        assert "true mean" not in npss.explain("mse|version:1")
        assert "MSE: the mean" in npss.explain("mse|version:1|frames:3")
        assert "fid: not a metric of this library" in npss.explain("fid|version:1")
        assert "something: else" in npss.explain("mse|version:1|something:else")
