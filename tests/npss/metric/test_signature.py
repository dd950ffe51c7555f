"""Signatures: written, parsed, and equal if and only if their values are equal."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
import npss.plot
from npss._metric.fields import ARGUMENTS, FIELDS, FIRST
from npss.records import measure

VALUES = st.one_of(
    st.booleans(),
    st.integers(-(10**15), 10**15),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12),
    st.text('|:+%"\\ 0123456789.-etrufalsn,=', max_size=12),
)
NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True).filter(
    lambda name: name not in (*ARGUMENTS, *FIELDS)
)
EXTRAS = st.dictionaries(NAMES, VALUES, max_size=5)


def values_of(field):
    """Valid values of a known field."""
    of_kind = {
        "text": st.text(max_size=12),
        "one of": st.sampled_from([*field.means, ""][: len(field.means)]),
        "number": st.one_of(st.integers(1, 10**15), st.floats(0, exclude_min=True, allow_infinity=False)),
        "whole number": st.integers(0, 10**15),
        "any": VALUES,
    }
    return of_kind[field.kind]


CONTEXTS = st.fixed_dictionaries({}, optional={name: values_of(field) for name, field in FIELDS.items()})
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


@given(convention=CONVENTIONS, context=CONTEXTS, extra=EXTRAS)
def test_round_trip(convention, context, extra):
    text = npss.signature(convention, extra=extra, **context)
    own = {"extra": extra} if extra else {}
    assert npss.parse_signature(text) == {"metric": "npss", "version": 1, "convention": convention, **context, **own}
    assert npss.signature(**npss.parse_signature(text)) == text
    assert text.isprintable() or not all(str(value).isprintable() for value in (*context.values(), *extra.values()))


@given(extra=st.dictionaries(NAMES, VALUES, min_size=1, max_size=5), other=VALUES)
def test_differs_where_a_value_differs(extra, other):
    name = next(iter(extra))
    value = extra[name]
    differs = value != other or isinstance(value, bool) != isinstance(other, bool)
    assert (npss.signature(extra=extra) != npss.signature(extra={**extra, name: other})) == differs


@given(context=CONTEXTS, extra=EXTRAS, seed=st.randoms())
def test_does_not_depend_on_the_order_of_keywords(context, extra, seed):
    items, own = list(context.items()), list(extra.items())
    seed.shuffle(items)
    seed.shuffle(own)
    assert npss.signature(extra=dict(own), **dict(items)) == npss.signature(extra=extra, **context)


@given(context=CONTEXTS, extra=EXTRAS)
def test_the_order_in_which_fields_are_printed(context, extra):
    """The first ones in the order of the table, all others, known or not, by name."""
    parts = npss.signature(extra=extra, **context).split("|")[3:]
    names = [part.partition(":")[0] for part in parts]
    others = [name for name in names if name not in FIRST]
    assert names == [name for name in FIRST if name in context] + others
    assert others == sorted({*context, *extra} - set(FIRST))


def test_the_documented_examples():
    assert (
        npss.signature("paper", unwrap="off", fps=25, frames=100, representation="euler", seed=3, window="0-1")
        == "npss|version:1|convention:paper|representation:euler|frames:100|fps:25|window:0-1|unwrap:off|seed:3"
    )


def test_a_convention_equal_to_a_named_one_has_its_name():
    assert npss.signature(npss.Convention()) == npss.signature("paper")
    assert npss.signature(npss.Convention(power="real", zero="empty")) == npss.signature("released")


def test_several_conventions_or_none():
    text = npss.signature(("paper", "released"), metric="npss+euler_error")
    assert text == "npss+euler_error|version:1|convention:paper+released"
    assert npss.parse_signature(text)["convention"] == ("paper", "released")
    assert npss.signature(None, metric="mse") == "mse|version:1"
    assert npss.parse_signature("mse|version:1")["convention"] is None


@pytest.mark.parametrize("text", ["1", "-3", "1.5", "-0.25", "1e5", "2.5e-07", "1e+300", "true", "false", ""])
def test_text_that_looks_like_a_number_or_boolean_stays_text(text):
    written = npss.signature(extra={"mine": text}, protocol=text)
    assert npss.parse_signature(written)["extra"] == {"mine": text}
    assert npss.parse_signature(written)["protocol"] == text
    assert '|mine:"' + text.replace("+", "%2B") + '"' in written


@pytest.mark.parametrize("value", [0, -1, 1.5, -0.25, 1e300, 5e-324, 2**70, True, False])
def test_numbers_and_booleans_are_bare(value):
    (read,) = npss.parse_signature(npss.signature(extra={"mine": value}))["extra"].values()
    assert (read, isinstance(read, bool)) == (value, isinstance(value, bool))
    assert '"' not in npss.signature(extra={"mine": value})


@pytest.mark.parametrize("text", ["a b", "x:y", "a|b", "50 %", "1+1", "%7C", ' "', "ü", "\n", " a", "a "])
def test_separators_in_text_are_escaped(text):
    written = npss.signature(extra={"mine": text})
    assert written.count("|") == 3
    assert written.count(":") == 3
    assert "+" not in written
    assert written.isprintable()
    assert npss.parse_signature(written)["extra"] == {"mine": text}


def test_equal_numbers_of_different_types_give_equal_signatures():
    assert npss.signature(fps=25.0) == npss.signature(fps=25) == npss.signature(fps=np.float32(25))
    assert npss.signature(frames=np.int64(3)) == npss.signature(frames=3)


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({"fps": float("nan")}, ValueError, "fps: expected a positive, finite number, got nan"),
        ({"fps": 0}, ValueError, "fps: expected a positive"),
        ({"fps": "25"}, TypeError, "fps: expected a positive number, got '25'"),
        ({"fps": None}, TypeError, "fps: expected a positive number, got None"),
        ({"frames": -1}, ValueError, "frames: expected a whole number, 0 or more, got -1"),
        ({"frames": 2.5}, TypeError, "frames: expected a whole number, 0 or more, got 2.5"),
        ({"frames": True}, TypeError, "frames: expected a whole number, 0 or more, got True"),
        ({"protocol": 8}, TypeError, "protocol: expected text, got 8"),
        ({"unwrap": "of"}, ValueError, "unwrap: expected one of off, target, seed, continuous, got 'of'"),
        ({"unwrap": False}, TypeError, "unwrap: expected one of off, target, seed, continuous, got False"),
        ({"convention": "mine"}, ValueError, "convention: expected one of"),
        ({"convention": ()}, ValueError, "convention: expected at least one"),
        ({"convention": 3}, TypeError, "convention: expected a sequence"),
        ({"metric": "mse"}, ValueError, "convention: mse has none; pass None"),
        ({"version": "one"}, TypeError, "version: expected a positive integer"),
        ({"version": 1.5}, TypeError, "version: expected a positive integer"),
        ({"metric": "NPSS|"}, ValueError, "metric: expected lower-case names"),
        ({"metric": 3}, TypeError, "metric: expected text"),
        ({"extra": {"späte": 1}}, ValueError, "extra: expected names of ASCII letters, .* got 'späte'"),
        ({"extra": {"": 1}}, ValueError, "extra: expected names of ASCII letters"),
        ({"extra": {"a:b": 1}}, ValueError, "extra: expected names of ASCII letters"),
        ({"extra": {"mine": None}}, TypeError, "mine: expected text, a number or a truth value"),
        ({"extra": {"mine": float("inf")}}, ValueError, "mine: expected a finite number, got inf"),
        ({"extra": [("mine", 1)]}, TypeError, "extra: expected a mapping"),
        ({"extra": {1: 1}}, TypeError, "extra: expected names, got 1"),
        ({"extra": {"frames": 1}}, TypeError, "extra: 'frames' is a known field: pass frames="),
        ({"extra": {"extra": 1}}, TypeError, "extra: 'extra' is the name of an argument"),
        ({"extra": {"convention": "paper"}}, TypeError, "extra: 'convention' is the name of an argument"),
    ],
)
def test_invalid_values(keywords, error, message):
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
        "npss|version:1|extra:1",
        "npss|version:1|mine:1|mine:1",
        "npss|version:1|unwrap:of",
        "npss|version:1|frames:2.5",
        "npss|version:1|fps:0",
        "npss|version:1|protocol:8",
        'npss|version:1|x:"unfinished',
        "npss|version:1||fps:25",
    ],
)
def test_invalid_signatures(text):
    with pytest.raises(ValueError, match=r"signature|convention|power"):
        npss.parse_signature(text)


def test_values_are_checked_in_parsed_signatures():
    with pytest.raises(
        ValueError, match=r"^signature: unwrap: expected one of .*, got 'of' in 'npss\|version:1\|unwrap:of'$"
    ):
        npss.parse_signature("npss|version:1|unwrap:of")


def test_several_unknown_fields_are_read():
    values = npss.parse_signature("npss|version:1|convention:paper|frames:9|a:1|z:two")
    assert values["frames"] == 9
    assert values["extra"] == {"a": 1, "z": "two"}
    with pytest.raises(ValueError, match="'a:2' is not a field 'name:value', or a duplicate"):
        npss.parse_signature("npss|version:1|a:1|a:2")


def test_only_text_is_parsed():
    with pytest.raises(TypeError, match="signature: expected text"):
        npss.parse_signature(None)


MOTIONS = np.random.default_rng(0).normal(size=(3, 8, 50, 3)).cumsum(axis=2)
CALLS = {
    "signature": npss.signature,
    "report": lambda **options: npss.report(*MOTIONS[:2], **options),
    "compare": lambda **options: npss.compare(*MOTIONS, **options),
    "leaderboard": lambda **options: npss.leaderboard("nowhere", **options),
    "spectra": lambda **options: npss.plot.spectra(*MOTIONS[:2], fps=25, **options),
    "errors": lambda **options: npss.plot.errors(MOTIONS[0], {"a": MOTIONS[1]}, fps=25, **options),
    "measure": lambda **options: measure(*MOTIONS[:2], **options),
}


@pytest.mark.parametrize("call", CALLS)
class TestUnknownNames:
    @pytest.mark.parametrize(
        ("name", "value", "nearest"),
        [("protocl", "srnn-8", "protocol"), ("Representation", "euler", "representation"), ("ekstra", {}, "extra")],
    )
    def test_the_nearest_is_named(self, call, name, value, nearest):
        message = f"^{name}: neither an argument nor a signature field; did you mean '{nearest}'\\?$"
        with pytest.raises(TypeError, match=message):
            CALLS[call](**{name: value})

    def test_no_similar_name(self, call):
        message = (
            r"^mydata: neither an argument nor a signature field; pass your own fields as extra=\{'mydata': \.\.\.\}$"
        )
        with pytest.raises(TypeError, match=message):
            CALLS[call](mydata="v2")

    @pytest.mark.parametrize("name", ["frames", "protocol", "unwrap", "draws", "metric", "version", "convention"])
    def test_taken_names(self, call, name):
        with pytest.raises(TypeError, match=rf"^extra: '{name}' is "):
            CALLS[call](extra={name: 1})


class TestNames:
    """A misspelt option must not change the signature instead of the score."""

    @pytest.mark.parametrize("call", ["report", "compare", "spectra", "signature"])
    def test_a_misspelt_convention(self, call):
        message = r"^conventon: neither an argument nor a signature field; did you mean 'convention'\?$"
        with pytest.raises(TypeError, match=message):
            CALLS[call](conventon="released")

    @pytest.mark.parametrize(
        ("call", "name", "nearest"),
        [("report", "feature_name", "feature_names"), ("compare", "atms", "at_ms"), ("spectra", "feture", "feature")]
        + [
            ("leaderboard", "publishd", "published"),
            ("errors", "leve", "level"),
            ("measure", "conventons", "conventions"),
        ],
    )
    def test_arguments_of_the_function_are_suggested(self, call, name, nearest):
        with pytest.raises(TypeError, match=f"did you mean '{nearest}'"):
            CALLS[call](**{name: 1})

    @pytest.mark.parametrize(
        ("call", "name"),
        [("report", "gt"), ("report", "feature_names"), ("compare", "pred_a"), ("leaderboard", "by")],
    )
    def test_fields_cannot_have_names_of_arguments(self, call, name):
        with pytest.raises(TypeError, match=f"extra: '{name}' is the name of an argument"):
            CALLS[call](extra={name: 1})

    @pytest.mark.parametrize(
        ("call", "name"),
        [
            ("report", "frames"),
            ("report", "version"),
            ("compare", "frames"),
            ("errors", "columns"),
            ("spectra", "frames"),
        ]
        + [("leaderboard", "unwrap"), ("leaderboard", "fps"), ("leaderboard", "metric"), ("measure", "unwrap")],
    )
    def test_filled_in_fields_cannot_be_passed(self, call, name):
        with pytest.raises(TypeError, match=f"^{name}: the signature states it anyway"):
            CALLS[call](**{name: 3})

    def test_custom_fields(self):
        for made in (CALLS["report"], CALLS["compare"]):
            assert made(extra={"mydata": "v2"}).signature.endswith("|mydata:v2")
        assert CALLS["measure"](extra={"mydata": "v2"})["signatures"]["paper"].endswith("|mydata:v2")

    def test_values_are_checked_before_the_computation(self):
        with pytest.raises(ValueError, match="unwrap: expected one of"):
            npss.report(np.zeros((2, 5, 1)), np.zeros((2, 5, 1)), unwrap="no")  # would have no score

    def test_unknown_fields_of_records_are_compared_as_text(self):
        one, other = (
            {"model": name, "action": "", **CALLS["measure"](extra={"data": data})} for name, data in ("a1", "b2")
        )
        assert len(npss.leaderboard([one, {**one, "model": "b"}]).tidy) == 2 * len(npss.CONVENTIONS)
        with pytest.raises(ValueError, match=r'different numbers.*data:"1" and .*data:"2"'):
            npss.leaderboard([one, other])


class TestTable:
    def test_the_order_is_that_of_printing(self):
        assert tuple(FIELDS)[: len(FIRST)] == FIRST
        assert list(FIELDS)[len(FIRST) :] == sorted(set(FIELDS) - set(FIRST))
        assert not {*FIELDS} & {*ARGUMENTS}

    def test_it_is_read_only(self):
        with pytest.raises(TypeError):
            FIELDS["mine"] = FIELDS["frames"]

    def test_it_is_the_table_of_the_documentation(self):
        page = (Path(__file__).parents[3] / "docs/signatures.md").read_text(encoding="utf-8")
        rows = re.findall(r"^\| `([a-z_]+)` \| (.*) \| (.*) \|$", page.partition("## Fields")[2], re.MULTILINE)
        assert rows == [(name, _may_hold(field), field.says) for name, field in FIELDS.items()]
        for name, field in FIELDS.items():
            for value, meaning in field.means.items():
                assert f"- `{name}:{value}`: {meaning}\n" in page


def _may_hold(field):
    values = ", ".join(f"`{value}`" for value in field.means)
    if field.kind == "one of":
        return values
    return field.kind + (f": {values}, ..." if values else "")


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

    def test_names_of_choices_and_frozen_named_conventions(self):
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
        assert "the square of the real part" in text
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
            ({"protocol": "random-256"}, "protocol must be srnn-8 or srnn-8-late, not random-256"),
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

    @pytest.mark.parametrize(
        ("protocol", "where"), [("srnn-8", "one frame later (srnn-8-late)."), ("srnn-8-late", "here.")]
    )
    def test_evidence(self, protocol, where):
        fields = PUBLISHED | {"protocol": protocol, "columns": "gt", "average": "at"}
        text = npss.explain(npss.signature(("paper", "released"), metric="npss+euler_error", **fields))
        evidence = "strong evidence, not fact: the first frame behind the paper's rows is unknown; its code cuts"
        assert f"comparable with tables 4 and 5 of the NPSS paper (Human3.6M): {evidence} {where}\n" in text
        assert f"Euler error: comparable with tables 6 and 7 of the NPSS paper (Human3.6M): {evidence} " in text
        assert ("the zero-velocity row of table 6, copied from" in text) == (protocol == "srnn-8-late")

    def test_a_field_unknown_to_the_tables(self):
        text = npss.explain(npss.signature("released", **PUBLISHED, extra={"subject": 9}))
        table = "tables 4 and 5 of the NPSS paper (Human3.6M)"
        assert f"may or may not be comparable with {table}; not stated: the meaning of subject." in text

    def test_a_window_of_table_5(self):
        assert "NPSS: comparable" in npss.explain(npss.signature("released", **PUBLISHED, window="1-2"))

    def test_unwrapping(self):
        assert "jumps of 2 pi removed: yes, over the scored frames only" in npss.explain(
            npss.signature(**{**PUBLISHED, "unwrap": "target"})
        )

    def test_an_incomplete_signature(self):
        text = npss.explain("npss|version:1|convention:released|frames:100")
        table = "tables 4 and 5 of the NPSS paper (Human3.6M)"
        assert f"may or may not be comparable with {table}; not stated: representation, fps, protocol, unwrap." in text

    def test_lafan1(self):
        fields = {
            "representation": "global-quaternions",
            "fps": 30,
            "frames": 45,
            "protocol": "lafan1",
            "unwrap": "off",
        }
        text = npss.explain(npss.signature("released", quaternions="continuous", **fields))
        assert "NPSS: comparable with the LaFAN1 in-betweening tables: fact: the benchmark's" in text
        assert "strong evidence" not in text
        assert "signs of quaternions: nearest to the frame before" in text

    @pytest.mark.parametrize("representation", ["global-quaternions", "quaternions", "quaternion"])
    def test_quaternions_without_a_rule_for_signs_are_not_comparable_with_lafan1(self, representation):
        fields = {"representation": representation, "fps": 30, "frames": 45, "protocol": "lafan1", "unwrap": "off"}
        text = npss.explain(npss.signature("released", **fields))
        assert "NPSS: comparable" not in text
        assert "not comparable" in text or "LaFAN1 in-betweening tables; not stated: quaternions" in text
        text = npss.explain(npss.signature("released", **fields, quaternions="w>=0"))
        assert "quaternions must be continuous, not w>=0" in text

    def test_continuous_angles_differ_from_the_paper(self):
        text = npss.explain(npss.signature("released", **{**PUBLISHED, "unwrap": "continuous"}))
        assert "yes, and jumps of pi at gimbal lock" in text
        assert "unwrap must be off, not continuous" in text

    def test_a_record_of_several_numbers(self):
        text = npss.explain(
            npss.signature(("paper", "released"), metric="npss+euler_error", columns="gt", average="at", **PUBLISHED)
        )
        assert "Euler error: comparable with tables 6 and 7" in text
        assert "NPSS released (only this one of the scores): comparable with tables 4 and 5" in text

    def test_only_npss_is_unwrapped(self):
        text = npss.explain(
            npss.signature(
                "released", metric="npss+euler_error", columns="gt", average="at", **{**PUBLISHED, "unwrap": "target"}
            )
        )
        assert "Euler error: comparable" in text
        assert "NPSS: not comparable" in text

    def test_custom_conventions_and_other_metrics(self):
        text = npss.explain(npss.signature(npss.Convention(bins="one-sided", distance="spectrum", weight="uniform")))
        assert "a custom convention" in text
        assert "only the T//2 + 1 bins" in text
        assert "No other fields." in text
        assert "true mean" not in npss.explain("mse|version:1")
        assert "MSE: the mean" in npss.explain("mse|version:1|frames:3")
        assert "fid: unknown metric, neither built in nor registered" in npss.explain("fid|version:1")
        assert "something: else" in npss.explain("mse|version:1|something:else")
