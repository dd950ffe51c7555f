"""Tables of the reference numbers: cells against records, published numbers beside them, and pictures."""

import csv
import io
import re

import numpy as np
import pytest

from npss import published
from npss.predictors import repeat
from npss_baselines.reproduction import pictures, tables
from npss_baselines.reproduction.plan import read_plan
from npss_baselines.reproduction.results import Results
from reproduced import record


def cells(table, name):
    """Return the cells of the rows of a model."""
    names = [row[0] for row in table.rows]
    first = names.index(name)
    rows = [table.rows[first]]
    for row in table.rows[first + 1 :]:
        if row[0]:
            break
        rows.append(row)
    return [dict(zip(table.header, row, strict=True)) for row in rows]


def test_best_numbers(of_plan):
    fitted = record("ridge", "fitted", 0, repeat)
    results = Results(read_plan(), [*of_plan, fitted])
    table = tables.best(results, "walking")
    assert table.header == ["number", "to beat", "ridge"]
    least = [".887", ".117", ".170", ".359", ".270", ".470", ".640", ".720", "1.026", "1.231"]  # Tables 4 to 7
    ours = [results.of("walking")["ridge"].number("npss", "released", at).value for at in ("", *tables.WINDOWS)]
    errors = fitted["measured"][0]["euler_error"]
    still = results.of("walking")["zero-velocity"].number
    for i, (row, number) in enumerate(zip(table.rows, [*ours, *errors.values()], strict=True)):
        bound = float(least[i])
        if i > 3:
            bound = min(bound, still("euler_error", "", row[0].split()[-2]).value)
        assert float(row[1]) == pytest.approx(bound, abs=5.1e-4)
        assert float(row[2].strip("*")) == pytest.approx(number, abs=5.1e-4)
        assert row[2].startswith("**") == (number < bound)
    assert {row[2].startswith("**") for row in table.rows} == {True, False}
    assert tables.best(Results(read_plan(), of_plan), "walking").rows == []


def test_without_published_numbers_there_is_nothing_to_beat():
    results = Results(read_plan(), [record("ridge", "fitted", 0, repeat, action="gait")])
    assert tables.all_tables(results)["best-gait"].rows == []


def test_records(results):
    table = tables.records(results)
    counts = {row[0]: row[2:] for row in table.rows}
    assert table.header == ["model", "recipe", *results.actions]
    assert counts["vgru-d"][0] == "3 of 3"
    assert counts["periodic"][0] == "0 of 1"
    assert [*counts] == [name for name in results.plan.rows if any(counts.get(name, ()))]


def test_table_4(results):
    table = tables.table_4(results, "walking")
    assert [row[0] for row in table.rows[:3]] == ["zero-velocity", "repeat-50", "vgru-d"]  # untrained ones on top
    (row,) = cells(table, "vgru-d")
    number = results.of("walking")["vgru-d"].number("npss", "released")
    value, seeds, low, high, draws = map(float, re.findall(r"[\d.]+", row["`released`"]))
    assert (value, seeds, draws) == pytest.approx((number.value, number.over_seeds, number.over_draws), abs=5.1e-4)
    assert low <= value <= high
    assert row["published"] == ".887"
    assert cells(table, "zero-velocity")[0]["published"] == ""
    assert cells(table, "gru-d")[0] == dict.fromkeys(table.header, "") | {
        "model": "gru-d",
        "recipe": "ours",
        "published": ".931",
    }
    (line,) = (note for note in table.notes if note.startswith("Not yet measured: "))
    assert re.search(r"[:;] running-average-2, [^;]*\(seed 0\)", line)
    assert re.search(r"[:;] [^;]*gru-d, vgru-ac, [^;]*\(seed 0, 1, 2\)", line)
    assert "zero-velocity" not in line
    assert "`npss|version:1|convention:paper|representation:euler|frames:100|fps:25|protocol:srnn-8" in table.markdown()


def test_table_5(results):
    first, second, third = cells(tables.table_5(results, "walking"), "vgru-d")
    assert [first["0-1 s"], first["1-2 s"], first["2-4 s"]] == [".117", ".179", ".359"]
    assert tuple(row["NPSS"] for row in (first, second, third)) == ("published", "`released`", "`paper`")
    value = results.of("walking")["vgru-d"].number("npss", "paper", "1-2").value
    assert float(re.match(r"[\d.]+", third["1-2 s"])[0]) == pytest.approx(value, abs=5.1e-4)
    unwrapped = tables.table_5(results, "walking", unwrap="target")
    assert [row["NPSS"] for row in cells(unwrapped, "vgru-d")] == ["`released`", "`paper`"]


def test_euler_tables(results):
    theirs, ours = cells(tables.euler_table(results, "walking", "table-7", (80, 1000)), "vgru-d")
    assert (theirs["80 ms"], theirs["1000 ms"]) == ("1.108", "1.28")
    value = results.of("walking")["vgru-d"].number("euler_error", at="1000").value
    assert float(re.match(r"[\d.]+", ours["1000 ms"])[0]) == pytest.approx(value, abs=5.1e-4)
    table_6 = tables.euler_table(results, "walking", "table-6", tables.SHORT_MS)
    assert [row["400 ms"] for row in cells(table_6, "vgru-r1-all")] == [".72"]
    assert "vgru-d" not in [row[0] for row in table_6.rows]


def test_parts_of_the_score(results):
    (row,) = cells(tables.parts(results, "walking"), "vgru-d")
    number = results.of("walking")["vgru-d"].number("npss", "released")
    assert float(row["`released`: form"]) + float(row["`released`: share"]) == pytest.approx(number.value, abs=1.1e-3)
    assert float(row["`paper`: share floor"]) > 0
    assert cells(tables.parts(results, "walking"), "zero-velocity")[0]["speed"] == ".00"


def test_ablation_is_beside_the_whole_model(of_plan):
    part = [{**record, "row": "no-top-rnn"} for record in of_plan if record["row"] == "vgru-d"][:1]
    results = Results(read_plan(), [*of_plan, *part])
    (row,) = cells(tables.ablation(results), "no-top-rnn")
    found = results.of("walking")
    numbers = [found[name].number("npss", "released").value for name in ("no-top-rnn", "vgru-d")]
    assert row["minus vgru-d"] == f"{numbers[0] - numbers[1]:+.3f}".replace("0.", ".", 1)
    assert cells(tables.ablation(results), "zero-velocity")[0]["minus vgru-d"] == ""


def test_published_and_measured(results):
    (row,) = cells(tables.reproduces(results), "vgru-d")
    value = results.of("walking")["vgru-d"].number("npss", "released").value
    assert row["`released`, published"] == ".887"
    assert tables.reproduces(results).rows[-1][5] == f"{100 * (value / 0.887 - 1):+.0f} %"


def test_ranks_and_disagreements(results):
    table = tables.rankings(results, "walking")
    scores = {name: found.number("npss", "paper").value for name, found in results.of("walking").items()}
    order = sorted(scores, key=scores.get)
    assert {row[0]: int(row[4]) for row in table.rows} == {name: 1 + order.index(name) for name in order}
    assert table.header[4] == "`paper`"
    differences = tables.disagreements(results, "walking")
    sums = {
        name: sum(found.number("euler_error", at=str(time)).value for time in (80, 160, 320, 400, 560, 1000))
        for name, found in results.of("walking").items()
    }
    names = list(scores)
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    differ = sum((scores[a] - scores[b]) * (sums[a] - sums[b]) < 0 for a, b in pairs)
    assert differences.rows[0][0] == "Euler error"
    assert differences.rows[0][differences.header.index("`paper`")] == f"{differ} of {len(pairs)}"


def test_table_2_has_the_ranks_of_the_paper(results):
    table = tables.table_2(results, "walking")
    assert table.rows[0] == ["vgru-d", "3", "1"]  # of six models, of which one has a record
    assert sorted(row[2] for row in table.rows) == [*"123456"]
    assert table.notes[1] == "Not yet ranked here: gru-d, vgru-ac, vgru-r1, mbr-long, mbr-unsup have no record."
    assert tables.table_2(results, "posing").rows == []


def test_pairs_in_the_same_order():
    ranks = {"a": "1", "b": "2", "c": "3"}
    assert tables._in_order(ranks, {"a": "1", "b": "3", "c": "2"}) == "2 of 3"
    assert tables._in_order(ranks, {"a": "1", "b": "1", "c": "3"}) == "2 of 3"  # a tie is no order


def test_spreads_and_differences_that_round_to_nothing_say_so(of_plan):
    twice = [{**one, "seed": seed} for one in of_plan if one["row"] == "zero-velocity" for seed in (0, 1)]
    (cell, *_) = tables.table_4(Results(read_plan(), twice), "walking").rows[0][3:]
    assert " ±<.001" in cell
    assert tables._per_cent(-0.001) == tables._per_cent(0.001) == "0 %"
    assert tables._per_cent(-0.03) == "-3 %"


def test_table_1():
    rows = {row[0]: row[1:] for row in tables.table_1(Results(read_plan(), [])).rows}
    assert rows["erd"] == ["14,842,054", "14,842,054", "+0"]
    assert rows["gru-d"] == ["2,735,670", "2,721,846", "-13,824"]


def test_every_number_is_in_the_csv(results):
    rows = list(csv.DictReader(io.StringIO(tables.numbers(results))))
    of_records = {row["metric"] for row in rows}
    assert of_records == {"npss", "euler_error", "npss_form", "npss_share", "npss_share_floor", "speed_ratio"}
    parts = [row for row in rows if row["metric"] in ("npss_form", "npss_share") and row["convention"] == "paper"]
    found = results.of("walking")["vgru-d"]
    of_row = [row for row in parts if row["row"] == "vgru-d" and "srnn-8|unwrap:off" in row["signature"]]
    assert sum(float(row["value"]) for row in of_row) == pytest.approx(found.number("npss", "paper").value, rel=1e-5)
    (speed,) = {
        row["signature"]
        for row in rows
        if row["metric"] == "speed_ratio" and row["row"] == "repeat-50" and "srnn-8|unwrap:off" in row["signature"]
    }
    assert speed.startswith("speed_ratio|version:1|representation:euler|frames:100|fps:25|")
    assert "|start:25" in speed
    rows = [row for row in rows if row["metric"] in ("npss", "euler_error")]
    numbers = [number for found in results.all() for number in found.numbers()]
    assert len(rows) == len(numbers) == 3 * 3 * (3 + 9 + 6)
    for row, number in zip(rows, numbers, strict=True):
        assert float(row["value"]) == pytest.approx(number.value, rel=1e-5)
        assert row["signature"] == number.signature
        assert row["low"] == "" or float(row["low"]) <= float(row["high"])
    several = [row for row in rows if row["row"] == "vgru-d"]
    assert {row["seeds"] for row in several} == {"3"}
    assert all(row["std_over_seeds"] for row in several)


def test_package_data_has_the_form_of_the_published_table(results):
    rows = list(csv.DictReader(io.StringIO(tables.package_data(results))))
    assert {"model", "action", "metric", "convention", "at", "frames", "value", "table"} <= set(rows[0])
    assert {row["convention"] for row in rows} == {"paper", "released", ""}
    assert {(row["metric"], row["table"]) for row in rows} == {
        ("npss", "4"),
        ("npss", "5"),
        ("euler_error", "7"),
    }
    assert len(rows) == 3 * (2 * 4 + 6)


def test_a_page_is_filled(results):
    number = results.of("walking")["repeat-50"].number("npss", "paper", "0-1").value
    short = f"{number:.3f}".removeprefix("0")
    assert tables.filled("a {{ repeat-50 walking paper 0-1 }} b", results) == f"a {short} b"
    error = results.of("walking", "random-256")["repeat-50"].number("euler_error", at="80").value
    filled = tables.filled("{{ repeat-50 walking 80 random-256 }}", results)
    assert float(filled) == pytest.approx(error, abs=5.1e-4)
    assert tables.filled("{{ table-4-walking }}", results) == tables.table_4(results, "walking").markdown()
    with pytest.raises(ValueError, match="template: no table 'table-9'"):
        tables.filled("{{ table-9 }}", results)
    with pytest.raises(ValueError, match=r"template: no record for \{\{ periodic walking paper \}\}"):
        tables.filled("{{ periodic walking paper }}", results)


def test_tables_are_written(results, tmp_path):
    tables.write(results, tmp_path / "tables")
    written = {path.name for path in (tmp_path / "tables").iterdir()}
    assert {"table-1.md", "table-4-walking.md", "table-7-walking.md", "ablation.md", "numbers.csv"} <= written
    text = (tmp_path / "tables" / "table-4-walking.md").read_text(encoding="utf-8")
    assert text.startswith("# Table 4, walking: NPSS over four seconds\n\n| model")


def test_published_names_exist():
    known = {record["model"] for record in published.records()}
    assert set(tables.PUBLISHED.values()) <= known
    assert set(tables.PUBLISHED) <= set(read_plan().rows)


def test_pictures(results):
    pytest.importorskip("matplotlib")
    (axes,) = pictures.models(results).axes
    drawn = [line.get_xdata() for line in axes.get_lines()]
    value = results.of("walking")["vgru-d"].number("npss", "released").value
    assert any(np.allclose(x, value) for x in drawn)
    assert any(np.allclose(x, 0.887) for x in drawn)
    (axes,) = pictures.amplitudes(results).axes
    labels = [line.get_label() for line in axes.get_lines()]
    assert labels == ["ground truth", "repeat-50", "vgru-d"]  # zero-velocity does not move
    truth = results.of("walking")["vgru-d"].record["amplitude"]["truth"]
    hertz, heights = axes.get_lines()[0].get_data()
    assert heights[0] == pytest.approx(np.hypot(truth[1], truth[2]), rel=1e-9)
    assert hertz[0] == pytest.approx(0.375)
