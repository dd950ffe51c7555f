"""The pages of `npss report` and `npss-baselines leaderboard --report`, from files."""

import base64
import json
import re
from html import unescape

import numpy as np
import pytest

import npss
from npss.commands import main

pytest.importorskip("pandas")
pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    from npss.gait import gait

    root = tmp_path_factory.mktemp("models")
    gt = gait(4, 50, seed=0)
    predictions = {
        "near": gt + 0.02 * np.random.default_rng(1).normal(size=gt.shape),
        "still": np.repeat(gt[:, :1], 50, axis=1),
    }
    for name, pred in predictions.items():
        arrays = {}
        for action in ("eating", "walking") if name == "near" else ("walking",):
            for i in range(len(gt)):
                arrays[f"expmap/gt/{action}_{i}"], arrays[f"expmap/preds/{action}_{i}"] = gt[i], pred[i]
        np.savez(root / f"{name}.npz", **arrays)
    return root


@pytest.fixture(scope="module")
def page(folder):
    path = folder / "out" / "report.html"
    path.parent.mkdir()
    assert main(["report", str(folder), "-o", str(path), "--by", "NPSS released"]) == 0
    return path.read_text(encoding="utf-8")


def test_prints_the_leaderboard_too(capsys, folder, tmp_path):
    assert main(["report", str(folder), "-o", str(tmp_path / "page.html"), "--format", "csv"]) == 0
    assert capsys.readouterr().out == npss.leaderboard(folder).to_csv() + "\n"


def test_has_the_tables_and_what_they_mean(page, folder):
    board = npss.leaderboard(folder, by="NPSS released")
    for table in re.findall(r"<table class=\"board\">.*?</table>", board.to_html(), flags=re.S):
        assert table in page
    for line in (*board.notes, *board.tidy["signature"]):
        assert line in unescape(page)


def test_says_what_each_score_is_made_of(page, folder):
    section = re.search(r'<section id="parts">.*?</section>', page, flags=re.S)[0]
    assert re.findall(r"<h3>([^<]*)</h3>", section) == ["eating", "walking"]
    board = npss.leaderboard(folder, by="NPSS released")
    *near, signature = re.findall(r"<li>([^<]*)</li>", section)[:2]
    assert near[0].startswith(f"near: NPSS {board.loc['near', ('eating', 'NPSS released')]:.4f}, form ")
    assert signature == npss.signature("released", representation="euler", frames=50, fps=25, unwrap="off")
    score = board.loc["still", ("walking", "NPSS released")]
    assert f"still: NPSS {score:.4f}, form 0.0000, share of DC +{score:.4f}; " in section


def test_lists_findings_of_each_prediction_and_once_of_the_ground_truth(page):
    section = re.search(r'<section id="diagnosis">.*?</section>', page, flags=re.S)[0]
    headings = re.findall(r"<h3>([^<]*)</h3>\s*<ul", section)
    expected = ["eating, ground truth", "eating, near", "walking, ground truth", "walking, near", "walking, still"]
    assert headings == expected
    assert unescape(page).count("4 constant predictions (of 4 sequences)") == 1


def test_has_four_pictures_an_action(page):
    captions = re.findall(r"<figure><h3>([^<]*)</h3>", page)
    assert captions == [
        f"{action}: {what}"
        for action in ("eating", "walking")
        for what in (
            "the first sequence",
            "Euler error over time",
            "where the score of near comes from",
            "the spectra behind it, near",
        )
    ]
    pictures = re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', page)
    assert len(pictures) == 8
    for picture in pictures:
        assert base64.b64decode(picture).startswith(b"<?xml")


def test_says_where_the_pictures_of_other_models_are(page):
    assert page.count("Of another model, a report on its file alone shows them.") == 1  # eating has one model


def test_has_every_model_moving(page):
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, flags=re.S)[1])
    labels = {clip["name"]: [motion["label"] for motion in clip["motions"]] for clip in data["clips"]}
    assert labels == {"eating": ["ground truth", "near"], "walking": ["ground truth", "near", "still"]}


def test_errors_are_one_line(capsys, tmp_path):
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "page.html")]) == 2
    assert "no results in it" in capsys.readouterr().err


def test_a_page_without_a_folder(capsys, folder, tmp_path):
    path = tmp_path / "nowhere" / "page.html"
    assert main(["report", str(folder), "-o", str(path)]) == 2
    assert capsys.readouterr() == ("", f"npss: error: {path}: no such folder: {path.parent}\n")


@pytest.mark.parametrize(("command", "options"), [(["report"], []), (["study", "page"], ["--action", "walking"])])
def test_a_page_never_replaces_its_inputs(capsys, folder, tmp_path, command, options):
    model = tmp_path / "model.npz"
    model.write_bytes((folder / "near.npz").read_bytes())
    (tmp_path / "page.html").symlink_to(model)
    for path in (model, tmp_path / "page.html"):
        assert main([*command, str(tmp_path), *options, "-o", str(path)]) == 2
        assert capsys.readouterr().err.startswith(f"npss: error: {path}: would overwrite an input")
    assert model.read_bytes() == (folder / "near.npz").read_bytes()
    assert main([*command, str(tmp_path), "-o", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"npss: error: {tmp_path}: expected a file to write, got a folder\n"


def test_nor_does_the_page_of_baselines(capsys, folder):
    from npss_baselines.__main__ import main as baselines

    path = folder / "near.npz"
    before = path.read_bytes()
    assert baselines(["leaderboard", "zero-velocity", str(path), "--synthetic", "--report", str(path)]) == 2
    assert "near.npz: would overwrite an input" in capsys.readouterr().err
    assert path.read_bytes() == before


@pytest.mark.parametrize(("n_frames", "pictures"), [(50, 2), (3, 1)])
def test_a_perfect_prediction_has_no_shares_and_a_short_one_no_strip(tmp_path, n_frames, pictures):
    gt = np.random.default_rng(0).normal(size=(2, n_frames, 99))
    names = [f"expmap/{kind}/walking_{i}" for kind in ("gt", "preds") for i in range(2)]
    np.savez(tmp_path / "perfect.npz", **dict(zip(names, [*gt, *gt], strict=True)))
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "page.html")]) == 0
    assert (tmp_path / "page.html").read_text(encoding="utf-8").count("<figure>") == pictures


def test_the_pictures_state_what_the_tables_state(folder, tmp_path):
    path = tmp_path / "page.html"
    command = ["report", str(folder), "-o", str(path), "--by", "NPSS released", "--protocol", "mine"]
    assert main(command) == 0
    page = path.read_text(encoding="utf-8")
    pictures = [
        base64.b64decode(picture).decode() for picture in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', page)
    ]
    stated = {npss.parse_signature(s)["protocol"] for s in npss.leaderboard(folder, protocol="mine").tidy["signature"]}
    assert stated == {"mine"}
    shown = [re.sub(r"\s", "", " ".join(re.findall(r"<!-- (.*?) -->", picture))) for picture in pictures]
    assert sum("protocol:mine" in text for text in shown) == 6  # all but the two film strips
    assert sum("convention:released" in text for text in shown) == 4


def test_of_baselines_and_files(capsys, tmp_path):
    from npss_baselines.__main__ import main as baselines

    path = tmp_path / "report.html"
    assert baselines(["leaderboard", "zero-velocity", "repeat-50", "--synthetic", "--report", str(path)]) == 0
    assert "repeat-50" in capsys.readouterr().out
    assert "<h1>2 models on gait</h1>" in path.read_text(encoding="utf-8")


def test_of_real_predictions(h36m_root, samples_root, tmp_path):
    from npss_baselines.__main__ import main as baselines

    path = tmp_path / "report.html"
    files = [str(samples_root / name) for name in ("wookay_walking_10000.h5", "wookay_eating_1000.h5")]
    command = ["leaderboard", "zero-velocity", "repeat-50", *files, "--h36m", str(h36m_root)]
    assert baselines([*command, "--actions", "walking", "eating", "--published", "--report", str(path)]) == 0
    page = unescape(path.read_text(encoding="utf-8"))
    assert "<h1>4 models on walking, eating</h1>" in page
    assert "VGRU-d (published)" in page
