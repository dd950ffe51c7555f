"""``npss-baselines evaluate``, on generated motion and on Human3.6M."""

import json

import numpy as np
import pytest

import npss
from npss.predictors import PREDICTORS
from npss_baselines.__main__ import main
from npss_baselines.commands import evaluate
from npss_baselines.data import h36m
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.synthetic import synthetic_task


def run(capsys, *arguments):
    try:
        status = main(["evaluate", *map(str, arguments)])
    except SystemExit as end:
        status = end.code
    captured = capsys.readouterr()
    return status, captured.out, captured.err


@pytest.fixture(autouse=True)
def no_environment(monkeypatch, request):
    """The default of --h36m is read when the parser is built; the tests set it."""
    monkeypatch.delenv("NPSS_H36M", raising=False)


CONTEXT = {"representation": "euler", "frames": 100, "fps": 25, "protocol": "synthetic-64", "unwrap": "off"}


class TestSynthetic:
    def test_records(self, capsys):
        status, out, err = run(capsys, "--synthetic", "zero-velocity")
        assert (status, err) == (0, "")
        (record,) = json.loads(out)
        assert list(record) == ["model", "action", "euler_error", "npss", "npss_windows", "signature", "signatures"]
        assert list(record["euler_error"]) == ["80", "160", "320", "400", "560", "1000"]
        assert list(record["npss"]) == ["paper", "released", "literal"]
        task = synthetic_task()
        gt = npss.poses_to_euler(task.target)
        pred = np.broadcast_to(npss.poses_to_euler(task.seed_frames[:, -1:]), gt.shape)
        for name in npss.CONVENTIONS:
            assert record["npss"][name] == npss.score(gt, pred, convention=name)
            assert record["npss_windows"][name] == npss.score_windows(gt, pred, fps=25, convention=name)
        assert record["euler_error"] == {str(t): e for t, e in npss.euler_error(gt, pred).items()}
        assert record["signatures"] == {
            **{name: npss.signature(name, **CONTEXT) for name in npss.CONVENTIONS},
            "euler_error": npss.signature(None, metric="euler_error", columns="gt", average="at", **CONTEXT),
        }
        assert npss.parse_signature(record["signature"]) == {
            "metric": "npss+euler_error",
            "version": 1,
            "convention": ("paper", "released", "literal"),
            **CONTEXT,
            "average": "at",
            "columns": "gt",
        }

    def test_all_models_without_a_name(self, capsys):
        records = json.loads(run(capsys, "--synthetic")[1])
        assert [record["model"] for record in records] == list(PREDICTORS)

    def test_is_always_the_same(self, capsys):
        assert run(capsys, "--synthetic") == run(capsys, "--synthetic")

    def test_its_sequences_are_independent(self):
        record = evaluate.evaluate("zero-velocity", PREDICTORS["zero-velocity"], synthetic_task(4), sequences=True)
        assert record["sequences"]["groups"] == [0, 1, 2, 3]

    def test_no_trivial_predictor_is_perfect_or_absurd(self):
        task = synthetic_task()
        for name, predictor in PREDICTORS.items():
            record = evaluate.evaluate(name, predictor, task)
            assert 0.05 < record["npss"]["paper"] < 10
            assert 0.05 < record["euler_error"]["400"] < 3

    def test_table_marks_the_best(self, capsys):
        _, out, _ = run(capsys, "--synthetic", "--format", "table")
        rows = [line for line in out.splitlines() if line.split(" ")[0] in PREDICTORS]
        assert len(rows) == len(PREDICTORS)
        columns = np.array([line.split()[1:] for line in rows])
        for column in columns.T:
            marked = [cell for cell in column if cell.endswith("*")]
            assert marked
            assert min(float(cell.rstrip("*")) for cell in column) == float(marked[0][:-1])
        assert [float(cell.rstrip("*")) for cell in columns[:, 0]] == sorted(
            float(cell.rstrip("*")) for cell in columns[:, 0]
        )
        assert "npss|version:1|convention:literal|representation:euler|frames:100" in out
        assert "euler_error|version:1|" in out

    def test_numbers_are_rounded_not_truncated(self):
        record = json.loads(json.dumps(evaluate.evaluate("m", PREDICTORS["repeat-50"], synthetic_task())))
        record["npss"]["paper"], record["euler_error"]["80"] = 12.34567, 1234567.0
        row = next(line for line in evaluate.summary([record]).splitlines() if line.startswith("m "))
        assert row.split()[1] == "12.3457*"
        assert "1234567.000*" in row

    def test_markdown(self, capsys):
        _, out, _ = run(capsys, "--synthetic", "--format", "markdown")
        assert out.startswith("### gait")
        assert "| zero-velocity " in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give --h36m DIR (the folder"),
        (("--synthetic", "--actions", "walking"), "--actions: expected one of gait, got 'walking'"),
        (("--synthetic", "zero-speed"), "'zero-speed' is neither one of zero-velocity"),
        (("--h36m", "nowhere"), "nowhere"),
    ],
)
def test_errors_are_one_line_with_status_2(capsys, arguments, message):
    status, out, err = run(capsys, *arguments)
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


# Checked values: from several independent programs, printed to these digits.
PAPER_RELEASED_LITERAL = {
    ("walking", "zero-velocity"): ("2.3341", "1.1413", "0.6119"),
    ("walking", "repeat-50"): ("1.5069", "0.8283", "0.5553"),
    ("eating", "zero-velocity"): ("2.5167", "0.8677", "0.5740"),
    ("eating", "repeat-50"): ("1.8136", "0.9481", "0.5753"),
    ("smoking", "zero-velocity"): ("2.9405", "0.9427", "0.3883"),
    ("smoking", "repeat-50"): ("3.9637", "1.9012", "0.4687"),
}
WINDOWS = {
    ("walking", "released"): ("0.142", "0.181", "0.479"),
    ("eating", "released"): ("0.085", "0.083", "0.277"),
    ("smoking", "released"): ("0.051", "0.027", "0.706"),
    ("walking", "paper"): ("0.367", "0.433", "1.044"),
    ("eating", "paper"): ("0.225", "0.307", "0.728"),
    ("smoking", "paper"): ("0.154", "0.107", "1.076"),
}
EULER = {
    "walking": ("0.394", "0.678", "0.986", "1.152", "1.351", "1.315"),
    "eating": ("0.271", "0.479", "0.727", "0.863", "1.038", "1.375"),
    "smoking": ("0.258", "0.483", "0.970", "0.949", "1.023", "1.694"),
}
# One frame later; from an independent program.
LATE = {"walking": "1.1864", "eating": "0.8887", "smoking": "0.9438"}
# Of predictors by period: NPSS `released` and `paper`, and the Euler error; of `periodic` on the eight windows, from an
# independent program.
PERIODIC = {
    ("srnn-8", "walking", "periodic"): ("0.831", "1.185", "0.247 0.427 0.666 0.720 0.737 0.730"),
    ("srnn-8", "eating", "periodic"): ("0.765", "1.718", "0.359 0.678 1.078 1.167 1.267 1.307"),
    ("srnn-8", "smoking", "periodic"): ("1.423", "3.272", "0.460 0.872 1.190 1.223 1.159 1.873"),
    ("srnn-8", "walking", "gated-periodic"): ("0.716", "1.069", "0.207 0.327 0.535 0.598 0.627 0.670"),
    ("srnn-8", "eating", "gated-periodic"): ("0.829", "2.126", "0.257 0.432 0.683 0.799 0.926 1.149"),
    ("srnn-8", "smoking", "gated-periodic"): ("0.925", "2.879", "0.303 0.572 1.009 0.992 1.050 1.710"),
    ("random-256", "walking", "zero-velocity"): ("1.503", "3.479", "0.426 0.777 1.235 1.345 1.500 1.552"),
    ("random-256", "eating", "zero-velocity"): ("1.064", "2.475", "0.300 0.591 0.938 1.067 1.206 1.533"),
    ("random-256", "smoking", "zero-velocity"): ("1.021", "2.871", "0.338 0.561 0.945 1.075 1.279 1.707"),
    ("random-256", "walking", "periodic"): ("1.368", "2.119", "0.413 0.726 0.975 1.026 1.086 1.129"),
    ("random-256", "eating", "periodic"): ("1.115", "2.129", "0.442 0.816 1.204 1.279 1.344 1.526"),
    ("random-256", "smoking", "periodic"): ("1.244", "2.699", "0.564 0.922 1.366 1.473 1.575 1.781"),
    ("random-256", "walking", "gated-periodic"): ("1.122", "2.315", "0.313 0.541 0.767 0.818 0.929 1.045"),
    ("random-256", "eating", "gated-periodic"): ("0.998", "2.174", "0.316 0.603 0.943 0.995 1.122 1.416"),
    ("random-256", "smoking", "gated-periodic"): ("0.981", "2.630", "0.352 0.577 1.060 1.184 1.366 1.624"),
}
UNWRAPPED = {"off": ("2.940", "0.943"), "target": ("2.417", "0.763"), "seed": ("2.081", "0.653")}


@pytest.fixture(scope="module")
def records(h36m_root):
    return {
        (task.action, name): evaluate.evaluate(name, PREDICTORS[name], task)
        for task in Human36M().tasks(h36m_root, ("walking", "eating", "smoking"))
        for name in PREDICTORS
    }


class TestHuman36M:
    @pytest.mark.parametrize("case", PAPER_RELEASED_LITERAL)
    def test_npss(self, records, case):
        printed = tuple(f"{records[case]['npss'][name]:.4f}" for name in ("paper", "released", "literal"))
        assert printed == PAPER_RELEASED_LITERAL[case]

    @pytest.mark.parametrize("case", WINDOWS)
    def test_windows(self, records, case):
        action, convention = case
        windows = records[action, "zero-velocity"]["npss_windows"][convention]
        assert tuple(f"{value:.3f}" for value in windows.values()) == WINDOWS[case]

    @pytest.mark.parametrize("action", EULER)
    def test_euler_error_of_zero_velocity(self, records, action):
        errors = records[action, "zero-velocity"]["euler_error"]
        assert tuple(f"{error:.3f}" for error in errors.values()) == EULER[action]

    @pytest.mark.parametrize(("windows", "action"), [*dict.fromkeys(case[:2] for case in PERIODIC)])
    def test_periodic(self, h36m_root, windows, action):
        (task,) = Human36M().tasks(h36m_root, (action,), windows)
        for name in (name for *case, name in PERIODIC if case == [windows, action]):
            record = evaluate.evaluate(name, PREDICTORS[name], task)
            errors = " ".join(f"{error:.3f}" for error in record["euler_error"].values())
            printed = f"{record['npss']['released']:.3f}", f"{record['npss']['paper']:.3f}", errors
            assert printed == PERIODIC[windows, action, name]
            assert record["signature"].endswith(f"|protocol:{windows}|unwrap:off|average:at|columns:gt")

    def test_constant_predictions_are_equal_to_all_digits(self, records):
        for action in EULER:
            scores = [records[action, name]["npss"]["paper"] for name in ("zero-velocity", "running-average-4")]
            assert scores[0] == pytest.approx(scores[1], rel=1e-12)

    @pytest.mark.parametrize("action", LATE)
    def test_one_frame_later(self, capsys, h36m_root, action):
        options = ("--h36m", h36m_root, "--actions", action, "--windows", "srnn-8-late", "--format", "json")
        _, out, _ = run(capsys, "zero-velocity", *options)
        (record,) = json.loads(out)
        assert f"{record['npss']['released']:.4f}" == LATE[action]
        assert "|protocol:srnn-8-late|" in record["signatures"]["released"]
        assert "strong evidence, not fact" in npss.explain(record["signatures"]["released"])

    def test_a_truncated_clip(self, capsys, h36m_root, tmp_path):
        """walking_1 without its last 1000 rows has other windows, and would score 2.739 under the same signature."""
        (tmp_path / "dataset/S5").mkdir(parents=True)
        for clip in (1, 2):
            lines = (h36m_root / f"dataset/S5/walking_{clip}.txt").read_text(encoding="utf-8").splitlines(keepends=True)
            text = "".join(lines[:-1000] if clip == 1 else lines)
            (tmp_path / f"dataset/S5/walking_{clip}.txt").write_text(text, encoding="utf-8")
        for windows in h36m.WINDOWS:
            options = ("--h36m", tmp_path, "--actions", "walking", "--windows", windows)
            status, out, error = run(capsys, "zero-velocity", *options)
            assert (status, out) == (2, "")
            assert "walking_1.txt: 1000 frames at 25 frames per second, expected 1500" in error

    @pytest.mark.parametrize("unwrapped", UNWRAPPED)
    def test_unwrapping_changes_smoking(self, h36m_root, unwrapped):
        (task,) = Human36M().tasks(h36m_root, ("smoking",))
        record = evaluate.evaluate("zero-velocity", PREDICTORS["zero-velocity"], task, unwrapped=unwrapped)
        assert tuple(f"{record['npss'][name]:.3f}" for name in ("paper", "released")) == UNWRAPPED[unwrapped]
        assert f"unwrap:{unwrapped}" in record["signatures"]["paper"]
        assert "unwrap:off" in record["signatures"]["euler_error"]

    @pytest.mark.parametrize("unwrapped", ["target", "seed"])
    def test_unwrapping_does_not_change_walking_and_eating(self, h36m_root, records, unwrapped):
        for task in Human36M().tasks(h36m_root, ("walking", "eating")):
            record = evaluate.evaluate("zero-velocity", PREDICTORS["zero-velocity"], task, unwrapped=unwrapped)
            assert record["npss"]["paper"] == pytest.approx(records[task.action, "zero-velocity"]["npss"]["paper"])

    def test_dc_is_nearly_all_of_the_weight(self, h36m_root):
        for task in Human36M().tasks(h36m_root, ("walking", "eating", "smoking")):
            transform = np.fft.fft(npss.poses_to_euler(task.target), axis=1)
            for power in (np.square(np.abs(transform)), np.square(transform.real)):
                assert 0.94 < power[:, 0].sum() / power.sum() < 0.985

    def test_the_command_on_real_motion(self, capsys, h36m_root, records):
        status, out, _ = run(
            capsys, "zero-velocity", "repeat-50", "--h36m", h36m_root, "--actions", "walking", "--format", "json"
        )
        assert status == 0
        assert json.loads(out) == [records["walking", name] for name in ("zero-velocity", "repeat-50")]

    def test_a_cache_changes_nothing(self, capsys, h36m_root, records, tmp_path):
        arguments = ("repeat-50", "--h36m", h36m_root, "--actions", "eating", "--cache", tmp_path / "cache")
        for _ in range(2):
            assert json.loads(run(capsys, *arguments)[1]) == [records["eating", "repeat-50"]]
        assert len(list((tmp_path / "cache").iterdir())) == 2

    @pytest.mark.parametrize(("windows", "blocks", "left_out"), [("srnn-8", 6, 0), ("random-256", 13, 121)])
    def test_records_hold_the_blocks_of_windows(self, h36m_root, windows, blocks, left_out):
        (task,) = Human36M().tasks(h36m_root, ["walking"], windows)
        record = evaluate.evaluate("zero-velocity", PREDICTORS["zero-velocity"], task, sequences=True)
        groups = json.loads(json.dumps(record))["sequences"]["groups"]
        assert len(set(groups) - {None}) == blocks
        assert groups.count(None) == left_out

    def test_256_windows(self, capsys, h36m_root):
        _, out, _ = run(capsys, "zero-velocity", "--h36m", h36m_root, "--actions", "walking", "--windows", "random-256")
        (record,) = json.loads(out)
        assert "protocol:random-256" in record["signature"]
        assert 1.5 < record["npss"]["paper"] < 3.5


@pytest.mark.parametrize(
    ("file", "action"), [("wookay_walking_10000.h5", "walking"), ("wookay_eating_1000.h5", "eating")]
)
def test_error_curves_stored_by_another_project(capsys, samples_root, file, action):
    pytest.importorskip("h5py")
    from npss.commands import main as npss_main

    assert npss_main(["score", str(samples_root / file), "--format", "json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert record["action"] == action
    assert record["stored_curve_difference"] < 1e-6
