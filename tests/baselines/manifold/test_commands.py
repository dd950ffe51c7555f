"""Tests of ``npss-baselines manifold``: tables, pictures and commands."""

import io
import json
import re
import shutil

import matplotlib as mpl
import numpy as np
import pytest

import npss
from npss_baselines.__main__ import main
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.restore import RESTORATIONS
from npss_baselines.manifold.evaluation import measure, similarity, table
from npss_baselines.manifold.evaluation.pca_size import Restoration
from npss_baselines.manifold.evaluation.restoration import restoration
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.restorers.file import SHIPPED
from npss_baselines.manifold.show import drawing, figures
from untrained import manifold_of

pytestmark = pytest.mark.slow


class TestTable:
    def test_a_table_for_each_application(self, records):
        text = table.text(records)
        for application in (*RESTORATIONS, "interpolate", "sample", "filters"):
            assert f"\n{application}: " in f"\n{text}"
        assert "joint_error+bone_error+foot_speed+npss|version:1|convention:paper|frames:160|fps:30|" in text
        assert "model of manifold: untrained-0" in text
        repair = [r for r in records if r["application"] == "repair"]
        for record in repair:  # each method has its signature
            model = npss.parse_signature(record["signature"]).get("model")
            assert model is None or f": {model}\n" in table.text(repair) + "\n"

    def test_the_best_is_marked_but_not_the_input(self, records):
        repair = table.text([r for r in records if r["application"] == "repair"]).splitlines()
        repair = repair[: repair.index("", 3)]  # without the table of ratios
        assert sum(line.count("*") for line in repair) >= 4
        assert not any("*" in line for line in repair if line.startswith("input"))

    def test_markdown(self, records):
        assert "| method " in table.text([r for r in records if r["application"] == "repair"], markdown=True)

    def test_several_manifolds(self, motions):
        two = Testbed(motions, {"one": manifold_of(motions), "two": manifold_of(motions, 1)})
        methods = {r["method"] for r in restoration(two, "repair")}
        assert {"one", "two", "one, known kept", "two, known kept", "two, alternating", "pca", "restorer"} <= methods


class TestPictures:
    def test_each_motion_is_a_row(self, testbed):
        (axes,) = figures.restoration(testbed, "repair").axes
        names = [text.get_text().replace("\n", " ") for text in axes.texts]
        assert names[:6] == ["original", "input", "linear", "hermite", "gaussian", "restorer"]
        assert names[6:11] == [
            "manifold, alternating",
            *("pca-best", "manifold", "pca-best, rescaled", "manifold, rescaled"),
        ]
        assert [len(lines.get_segments()) for lines in axes.collections] == [12 * 19] * 13

    def test_bars(self):
        line = npss.signature(None, metric="map", source="cmu", matches="any", model="m")
        records = [
            {"application": "nearest", "method": method, "metric": "map", "value": v, "signature": line}
            for method, v in (("euclidean", 0.4), ("manifold", 0.6))
        ]
        (axes,) = figures.retrieval(records).axes
        assert [bar.get_width() for bar in axes.patches] == [0.4, 0.6]
        middles = [bar.get_y() + bar.get_height() / 2 for bar in axes.patches]
        assert axes.get_ylim() == pytest.approx((min(middles) - 1, max(middles) + 1))  # for any number of bars

    def test_unknown_clip(self, testbed, motions):
        assert figures.clip_named(motions, "synthetic/gait/3") == figures.clip_named(motions, "gait/3") == 3
        with pytest.raises(ValueError, match="CLIP: 0 of 8 clips have the name '99_01'; the first clips are gait/0"):
            figures.clip_named(motions, "99_01")


def test_pictures_do_not_depend_on_settings_or_names():
    name = r"a_b $x_1$ 5% ~ ^2 {c} \d"
    motion = np.random.default_rng(0).normal(size=(4, len(JOINTS.names), 3))
    with mpl.rc_context({"text.usetex": True}):
        for figure in (drawing.strips({name: motion}, name), drawing.bars({name: {name: 1.0}}, "what", name)):
            figure.savefig(written := io.StringIO(), format="svg")
            assert written.getvalue().count(name) >= 2


class TestCommands:
    @pytest.mark.parametrize("application", ["repair", "fill", "interpolate", "sample", "filters"])
    def test_numbers_and_a_picture(self, application, run, records, tmp_path, capsys):
        picture = tmp_path / "picture.svg"
        command = ["manifold", *(["measure"] if application != "filters" else []), application]
        assert main([*command, str(run), "--quick", "--format", "json", "-o", str(picture)]) == 0
        printed = json.loads(capsys.readouterr().out)
        expected = [r for r in records if r["application"] == application]
        assert [(r["method"], r["metric"]) for r in printed] == [(r["method"], r["metric"]) for r in expected]
        assert [r["value"] for r in printed] == pytest.approx([r["value"] for r in expected], rel=1e-4)
        assert picture.stat().st_size > 5000

    @pytest.mark.skipif(not SHIPPED.exists(), reason="the package has no restorer")
    def test_several_restorers(self, run, tmp_path, capsys):
        files = [shutil.copy(SHIPPED, tmp_path / name) for name in ("first.npz", "second.npz")]
        command = ["manifold", "measure", "inbetween", str(run), "--quick", "--format", "json", "--restorer"]
        assert main([*command, *map(str, files)]) == 0
        errors = {r["method"]: r["value"] for r in json.loads(capsys.readouterr().out) if r["metric"] == "lost_error"}
        assert errors["restorer, first"] == errors["restorer, second"] < errors["linear"]
        assert main([*command, str(files[0])]) == 0
        methods = {r["method"] for r in json.loads(capsys.readouterr().out)}
        assert "restorer" in methods
        assert not any(method.startswith("restorer,") for method in methods)

    def test_chosen_clip(self, run, tmp_path, capsys):
        options = [str(run), "--quick", "-o", str(tmp_path / "picture.svg")]
        assert main(["manifold", "measure", "fill", *options, "--clip", "gait/1"]) == 0
        assert "gait/1: gait; held out" in (tmp_path / "picture.svg").read_text(encoding="utf-8")
        assert main(["manifold", "measure", "fill", *options, "--clip", "gait/5"]) == 2  # not held out
        assert "CLIP: 0 of 2 clips have the name 'gait/5'" in capsys.readouterr().err
        assert main(["manifold", "measure", "interpolate", *options, "--clips", "gait/1", "gait/5"]) == 0
        assert main(["manifold", "filters", *options, "--units", "3", "5"]) == 0
        assert main(["manifold", "filters", *options, "--units", "99"]) == 2

    def test_distance(self, run, testbed, tmp_path, capsys):
        options = [str(run), "gait/0", "gait/5", "--quick", "-o", str(tmp_path / "pair.svg")]
        assert main(["manifold", "distance", *options, "--format", "json"]) == 0
        printed = json.loads(capsys.readouterr().out)
        expected = list(similarity.distance(testbed, 0, 5))
        assert [r["value"] for r in printed] == pytest.approx([r["value"] for r in expected], rel=1e-4)
        assert main(["manifold", "distance", *options, "--format", "table"]) == 0
        row = rf"manifold +g +{printed[0]['value']:.4f}\n"
        assert re.search(row, capsys.readouterr().out)
        assert "g by manifold" in (tmp_path / "pair.svg").read_text(encoding="utf-8")

    def test_nearest(self, run, testbed, tmp_path, capsys):
        picture = tmp_path / "near.svg"
        options = ["manifold", "measure", "nearest", str(run), "--quick", "--format", "json", "-o", str(picture)]
        assert main([*options, "--clip", "gait/4", "-n", "3"]) == 0
        printed = json.loads(capsys.readouterr().out)
        expected = [r["clip"] for r in similarity.ranking(testbed, 4, 3)]
        assert [r["clip"] for r in printed] == expected
        assert picture.stat().st_size > 5000

    def test_a_single_action_is_refused(self, run, capsys):
        assert main(["manifold", "measure", "nearest", str(run), "--quick"]) == 2
        assert "retrieval needs clips of at least two actions" in capsys.readouterr().err

    def test_several_runs_in_a_table(self, run, tmp_path, capsys, monkeypatch):
        monkeypatch.setattr(measure, "measure_all", lambda testbed: restoration(testbed, "repair"))
        other = tmp_path / "other"
        shutil.copytree(run, other)
        drawings = tmp_path / "pictures"
        options = ["--quick", "--format", "table", "--pictures", str(drawings)]
        assert main(["manifold", "table", str(run), str(other), *options]) == 0
        printed = capsys.readouterr().out
        assert "model of untrained: manifold-" in printed
        assert "model of other: manifold-" in printed
        drawn = {path.stem for path in drawings.iterdir()}
        assert drawn == {
            *RESTORATIONS,
            "interpolate",
            "sample",
            "filters",
            "nearest",
        }  # a single action: no retrieval
        assert main(["manifold", "table", str(run), str(run), "--quick"]) == 2
        assert "duplicate model 'untrained'" in capsys.readouterr().err

    def test_row_names_are_unique(self, run, tmp_path, monkeypatch):
        folders = [tmp_path / name for name in ("linear", "pca-best", "a/seed-0", "b/seed-0")]
        for copy in folders:
            shutil.copytree(run, copy)
        seen = []
        monkeypatch.setattr(measure, "measure_all", lambda testbed: seen.append(testbed) or [])
        monkeypatch.setattr(table, "text", lambda records, **_: "")
        assert main(["manifold", "table", *map(str, folders), "--quick", "--format", "table"]) == 0
        names = [f"{tmp_path.name}/linear", f"{tmp_path.name}/pca-best", "a/seed-0", "b/seed-0"]
        assert list(seen[0].manifolds) == names
        assert list(seen[0].projectors(Restoration("repair"))) == ["pca", "pca-best", *names]

    def test_missing_run(self, tmp_path, capsys):
        assert main(["manifold", "table", str(tmp_path)]) == 2
        assert "config.json" in capsys.readouterr().err

    def test_on_real_motion(self, run, cmu_root, tmp_path, capsys):
        """Go from raw files to numbers, with weights trained on generated walks."""
        options = [str(run), "--quick", "--cmu", str(cmu_root), "--cache", str(tmp_path), "--format", "json"]
        assert main(["manifold", "measure", "nearest", *options]) == 0
        printed = json.loads(capsys.readouterr().out)
        values = {(r["method"], r["metric"]): r["value"] for r in printed if r["application"] == "nearest"}
        assert 0 < values["chance", "map"] < values["extremes", "map"] <= 1
