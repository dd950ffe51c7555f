"""The published tables as records: shape, spot values, and comparable signatures."""

import csv
from collections import Counter
from importlib.resources import files

import pytest

import npss
from npss import published

H36M = "Gopalakrishnan et al. 2019"
LAFAN1 = ("Harvey et al. 2020", "Oreshkin et al. 2022", "Qin et al. 2022")
ACTIONS = ("walking", "eating", "smoking", "discussion")
LONG_TERM = {"VGRU-r1 (SA)", "MBR-unsup (SA)", "MBR-long", "VGRU-ac", "GRU-d", "VGRU-d"}  # of table 4
OLD = {"ERD", "LSTM-3LR", "SRNN"}  # only in table 7, without 400 ms
SHORT_TERM = {"zero-velocity", "MBR-unsup (MA)", "MBR-sup (MA)", "VGRU-r1 (MA)"}  # of table 6


@pytest.fixture(scope="module")
def rows():
    with files("npss").joinpath("published.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def h36m():
    return {(record["model"], record["action"]): record for record in published.records(H36M)}


def test_number_of_cells(rows):
    cells = Counter(row["table"] for row in rows)
    numbered = {name: cells.pop(name) for name in "4567"}
    assert numbered == {"4": 6 * 4, "5": 6 * 4 * 3, "6": 4 * 4 * 4, "7": 4 * (6 * 6 + 3 * 5)}
    assert sum(cells.values()) == 3 * (4 + 4 + 3 + 4 + 4)  # L2Q, L2P and NPSS of in-betweening
    assert all(cells)


def test_every_cell_is_in_one_record(rows):
    values = Counter(float(row["value"]) for row in rows)
    cells = Counter()
    for record in published.records():
        cells.update(record.get("npss", {}).values())
        cells.update(record.get("npss_windows", {}).get("released", {}).values())
        cells.update(record.get("euler_error", {}).values())
        cells.update(record.get("metrics", {}).values())
        assert {float(text) for text in record.get("printed", {}).values()} <= set(cells)
    assert cells == values


def test_models_and_actions(h36m):
    assert set(h36m) == {(model, action) for model in LONG_TERM | OLD | SHORT_TERM for action in ACTIONS}


def test_the_long_term_models_have_tables_4_5_and_7(h36m):
    for model in LONG_TERM:
        for action in ACTIONS:
            record = h36m[model, action]
            assert record["source"] == f"{H36M}, Tables 4, 5, 7"
            assert list(record["npss"]) == list(record["npss_windows"]) == ["released"]
            assert list(record["npss_windows"]["released"]) == ["0-1", "1-2", "2-4"]
            assert list(record["euler_error"]) == ["80", "160", "320", "400", "560", "1000"]


def test_unpublished_cells_are_absent(h36m):
    for action in ACTIONS:
        for model in OLD:
            assert list(h36m[model, action]["euler_error"]) == ["80", "160", "320", "560", "1000"]
            assert h36m[model, action]["source"] == f"{H36M}, Table 7"
        for model in SHORT_TERM:
            assert list(h36m[model, action]["euler_error"]) == ["80", "160", "320", "400"]
            assert h36m[model, action]["source"] == f"{H36M}, Table 6"
        for model in OLD | SHORT_TERM:
            assert h36m[model, action].keys().isdisjoint(("npss", "npss_windows"))


@pytest.mark.parametrize(
    ("model", "action", "number", "at", "value"),
    [
        ("VGRU-d", "walking", "npss", None, 0.887),
        ("VGRU-r1 (SA)", "discussion", "npss", None, 4.884),
        ("MBR-long", "smoking", "npss", None, 4.741),
        ("VGRU-r1 (SA)", "discussion", "npss_windows", "2-4", 2.72),
        ("MBR-unsup (SA)", "eating", "npss_windows", "1-2", 0.178),
        ("VGRU-d", "walking", "npss_windows", "0-1", 0.117),
        ("zero-velocity", "walking", "euler_error", "400", 1.15),
        ("VGRU-r1 (MA)", "discussion", "euler_error", "160", 0.82),
        ("VGRU-r1 (SA)", "discussion", "euler_error", "160", 0.909),
        ("SRNN", "smoking", "euler_error", "1000", 3.23),
        ("GRU-d", "walking", "euler_error", "80", 1.311),
        ("VGRU-d", "discussion", "euler_error", "1000", 2.318),
    ],
)
def test_spot_values(h36m, model, action, number, at, value):
    found = h36m[model, action][number]
    if number == "npss_windows":
        found = found["released"]
    assert found["released" if at is None else at] == value


def test_the_reference_predictor_reproduces_its_published_row(h36m, h36m_root):
    from npss.predictors import PREDICTORS
    from npss_baselines.commands.evaluate import evaluate
    from npss_baselines.data.h36m_source import Human36M

    for task in Human36M().tasks(h36m_root, ["walking", "eating"]):
        measured = evaluate("zero-velocity", PREDICTORS["zero-velocity"], task)
        row = h36m["zero-velocity", task.action]
        assert measured["signatures"]["euler_error"] == row["signatures"]["euler_error"]
        for time, value in row["euler_error"].items():
            assert measured["euler_error"][time] == pytest.approx(value, abs=0.005)


def test_windows_and_whole_match(h36m):
    """Windows have fewer bins, so their sum is below the whole; rows of a wrong model violate this."""
    for model in LONG_TERM:
        for action in ACTIONS:
            record = h36m[model, action]
            assert sum(record["npss_windows"]["released"].values()) < record["npss"]["released"]


def test_lafan1():
    records = [record for record in published.records() if record["action"].startswith("in-betweening, ")]
    rows = {}
    for record in records:
        values = npss.parse_signature(record["signature"])
        assert (values["representation"], values["fps"]) == ("global-quaternions", 30)
        assert "NPSS: comparable with the LaFAN1" in npss.explain(record["signature"])
        assert record["action"] == f"in-betweening, {values['frames']} frames"
        assert "euler_error" not in record
        assert {name: float(text) for name, text in record["printed"].items()} == {
            "NPSS": record["npss"]["released"],
            **record["metrics"],
        }
        numbers = tuple(record["printed"][name] for name in ("L2Q", "L2P", "NPSS"))
        rows.setdefault((record["model"], record["source"]), {})[values["frames"]] = numbers
    assert rows == {
        ("zero-velocity", f"{LAFAN1[0]}, the benchmark"): {
            5: ("0.56", "1.52", "0.0053"),
            15: ("1.10", "3.69", "0.0522"),
            30: ("1.51", "6.60", "0.2318"),
            45: ("1.81", "9.33", "0.4918"),
        },
        ("interpolation", f"{LAFAN1[0]}, the benchmark and the benchmark's tests"): {
            5: ("0.22", "0.373", "0.0023"),
            15: ("0.62", "1.25", "0.0391"),
            30: ("0.98", "2.32", "0.2013"),
            45: ("1.25", "3.45", "0.4493"),
        },
        ("Delta-interpolator", f"{LAFAN1[1]}, the authors' notebook (mean of 8 seeds)"): {
            5: ("0.1138", "0.1290", "0.0014"),
            15: ("0.3175", "0.4670", "0.0217"),
            30: ("0.5723", "0.9954", "0.1217"),
        },
        ("two-stage transformer", f"{LAFAN1[2]}, the authors' repository"): {
            5: ("0.0994", "0.1049", "0.0011"),
            15: ("0.2839", "0.3943", "0.0188"),
            30: ("0.5446", "0.8948", "0.1124"),
            45: ("0.8727", "1.6777", "0.3217"),
        },
        ("context transformer", f"{LAFAN1[2]}, the authors' repository"): {
            5: ("0.1325", "0.1717", "0.0015"),
            15: ("0.3287", "0.4923", "0.0212"),
            30: ("0.5991", "1.0663", "0.1238"),
            45: ("0.9170", "1.9972", "0.3369"),
        },
    }


def test_signatures_of_the_tables():
    for record in published.records():
        expected = ({"released"} if "npss" in record else set()) | set(record.get("metrics", {}))
        assert set(record["signatures"]) == expected | ({"euler_error"} if "euler_error" in record else set())
        for text in (record["signature"], *record["signatures"].values()):
            assert npss.signature(**npss.parse_signature(text)) == text
        for name, text in record["signatures"].items():
            subject = {"euler_error": "Euler error", "released": "NPSS"}.get(name, name)
            assert f"{subject}: comparable with" in npss.explain(text)
        whole = npss.explain(record["signature"])
        assert whole.count(": comparable with") == len(record["signatures"]) - len(record.get("metrics", {}))


def test_records_have_the_format_of_evaluate(h36m):
    from npss.predictors import PREDICTORS
    from npss_baselines.commands.evaluate import evaluate
    from npss_baselines.data.synthetic import synthetic_task

    measured = evaluate("zero-velocity", PREDICTORS["zero-velocity"], synthetic_task(2))
    assert [*measured, "source", "published"] == list(h36m["VGRU-d", "walking"])
    for record in published.records():
        assert record["published"] is True
        order = [*measured, "metrics", "source", "published", "printed"]
        assert list(record) == sorted(record, key=order.index)


def test_by_source():
    everything = published.records()
    parts = [published.records(source) for source in (H36M, *LAFAN1)]
    assert [record for part in parts for record in part] == everything
    assert [len(part) for part in parts] == [13 * 4, 8, 3, 8]
    with pytest.raises(ValueError, match=r"source: expected one of Gopalakrishnan et al. 2019, .*got 'NPSS'"):
        published.records("NPSS")
    with pytest.raises(TypeError, match="source: expected one of"):
        published.records(4)


def test_by_protocol():
    """The paper's rows may use either protocol, except the one copied from another paper."""
    early, late, lafan1 = (published.records(protocol=name) for name in ("srnn-8", "srnn-8-late", "lafan1"))
    assert early + lafan1 == published.records()
    assert all(npss.parse_signature(record["signature"])["protocol"] == "srnn-8-late" for record in late)
    numbers = ("model", "action", "npss", "npss_windows", "euler_error", "source")
    kept = [record for record in early if record["model"] != "zero-velocity"]
    assert [[one.get(n) for n in numbers] for one in late] == [[one.get(n) for n in numbers] for one in kept]
    for record in late:
        for name, text in record["signatures"].items():
            assert text == early[0]["signatures"][name].replace("srnn-8", "srnn-8-late")
            assert ": comparable with tables" in npss.explain(text)
    with pytest.raises(ValueError, match="protocol: expected one of srnn-8, srnn-8-late, lafan1, got 'random-256'"):
        published.records(protocol="random-256")
    with pytest.raises(ValueError, match=r"protocol: Qin et al\. 2022 has no rows for srnn-8"):
        published.records("Qin et al. 2022", protocol="srnn-8")


@pytest.mark.parametrize("protocol", ["srnn-8", "srnn-8-late"])
def test_they_are_comparable_with_both_protocols(protocol):
    own = {**next(iter(published.records(protocol=protocol))), "model": "mine", "source": ""}
    board = npss.leaderboard([own], published=True)
    assert {"mine", "VGRU-d (published)"} <= set(board.index)
    assert all(protocol in npss.parse_signature(text)["protocol"] for text in board.tidy["signature"])
    assert len({npss.parse_signature(text)["protocol"] for text in board.tidy["signature"]}) == 1


def test_they_form_a_leaderboard():
    board = npss.leaderboard(published.records())
    assert board.tidy["rank"].isna().all()
    assert board.loc["VGRU-d (published)", ("eating", "NPSS released")] == 0.846
    assert board.loc["interpolation (published)", ("in-betweening, 30 frames", "NPSS released")] == 0.2013


class TestReference:
    def test_signatures_state_what_was_measured(self):
        for record in published.reference():
            assert record["reference"] is True
            assert set(record["npss"]) == {"paper", "released"}
            assert list(record["euler_error"]) == ["80", "160", "320", "400", "560", "1000"]
            assert all(list(windows) == ["0-1", "1-2", "2-4"] for windows in record["npss_windows"].values())
            for name in ("paper", "released", "euler_error"):
                text = record["signatures"][name]
                assert npss.signature(**npss.parse_signature(text)) == text
                assert npss.parse_signature(text)["protocol"] == "srnn-8"

    def test_the_untrained_rows(self):
        rows = {(record["model"], record["action"]): record for record in published.reference()}
        assert rows["zero-velocity", "walking"]["npss"] == pytest.approx({"paper": 2.334, "released": 1.141}, abs=5e-4)
        assert rows["repeat-50", "eating"]["npss"] == pytest.approx({"paper": 1.81, "released": 0.95}, abs=5e-3)
        assert rows["zero-velocity", "smoking"]["euler_error"]["1000"] == pytest.approx(1.694, abs=5e-4)

    def test_seeds_and_draws(self, monkeypatch):
        """A row of several seeds states their spread; its signature states draws."""
        lines = [
            "table,model,recipe,action,metric,convention,at,frames,value,seeds,spread,draws",
            "4,m,ours,walking,npss,paper,,100,1.5,3,0.25,30",
            "5,m,ours,walking,npss,paper,0-1,100,0.5,3,0.125,30",
            "7,m,ours,walking,euler_error,,80,100,0.75,3,0.5,30",
        ]
        monkeypatch.setattr(published, "_rows", lambda name: list(csv.DictReader(lines)))
        (record,) = published.reference()
        assert (record["seeds"], record["draws"], record["recipe"]) == (3, 30, "ours")
        assert record["spread"] == {
            "npss": {"paper": 0.25},
            "npss_windows": {"paper": {"0-1": 0.125}},
            "euler_error": {"80": 0.5},
        }
        assert record["signatures"]["paper"].endswith("|unwrap:off|draws:30")
        assert "|draws:30" in record["signatures"]["euler_error"]
