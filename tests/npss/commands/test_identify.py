"""Tests of the command ``npss identify``."""

import sys

import pytest

from command_line import run

MODULE = """\
import numpy as np

def npss(pred, target):
    first, second = (np.abs(np.fft.rfft(motion, axis=1)) ** 2 for motion in (pred, target))
    first, second = (power / power.sum(axis=1, keepdims=True) for power in (first, second))
    return np.abs(np.cumsum(first - second, axis=1)).sum(axis=1).mean()

def either(a, b):
    first, second = (np.fft.fft(motion, axis=1).real ** 2 for motion in (a, b))
    cdf, other = (np.cumsum(power / power.sum(axis=1, keepdims=True), axis=1) for power in (first, second))
    return np.average(np.abs(cdf - other).sum(axis=1), weights=first.sum(axis=1))

def of_frames(gt, pred):
    assert gt.shape[2:] == (5, 4)
    return either(gt.reshape(*gt.shape[:2], -1), pred.reshape(*gt.shape[:2], -1))

def loud(gt, pred):
    print("noise")
    return npss(pred, gt)

def exits(gt, pred):
    raise SystemExit(3)

def broken(gt, pred):
    return undefined

class Metrics:
    either = staticmethod(either)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    package = tmp_path / "evaluation_code"
    package.mkdir()
    (package / "metrics.py").write_text(MODULE, encoding="utf-8")
    (package / "quits.py").write_text("import sys\nsys.exit(3)\n", encoding="utf-8")
    (package / "fails.py").write_text("\n1 / 0\n", encoding="utf-8")
    (package / "mistyped.py").write_text("def (:\n", encoding="utf-8")
    (package / "needs.py").write_text("import no_such_package\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "evaluation_code"]:
        del sys.modules[name]


def test_functions_that_print_or_exit(capsys):
    status, out, err = run(capsys, "identify", "evaluation_code.metrics:loud")
    assert (status, "noise" in out, "noise" in err) == (0, False, True)
    status, _, err = run(capsys, "identify", "evaluation_code.metrics:exits")
    assert (status, "SystemExit: 3" in err) == (2, True)


def test_a_function(capsys):
    status, out, err = run(capsys, "identify", "evaluation_code.metrics:npss")
    assert (status, err) == (0, "")
    assert out.startswith(
        "It computes none of the named conventions; nearest: `paper`.\n"
        "What differs: bins: one-sided, none doubled (rfft); weights: none.\n"
    )
    assert 'npss.Convention(bins="one-sided", weight="uniform")' in out


def test_order(capsys):
    _, out, _ = run(capsys, "identify", "evaluation_code.metrics:either")
    assert out.startswith("The order of the arguments is unknown, and it decides; pass order= (--order)\n")
    status, out, _ = run(capsys, "identify", "evaluation_code.metrics:Metrics.either", "--order", "gt,pred")
    assert status == 0
    assert out.startswith("It computes `released`.\nWithout power: nan where a feature has no power.\n")


def test_frame(capsys):
    status, out, _ = run(capsys, "identify", "evaluation_code.metrics:of_frames", "--frame", "5", "4")
    assert status == 0
    assert out.startswith("It computes `released`.\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["evaluation_code.metrics"], "FUNCTION: expected package.module:function, got 'evaluation_code.metrics'"),
        (["evaluation_code/metrics.py:npss"], "FUNCTION: expected package.module:function, got "),
        (["evaluation_code.metrics:nothing"], "FUNCTION: evaluation_code.metrics has no 'nothing'"),
        (["no_such_module:npss"], "FUNCTION: there is no module 'no_such_module', installed or in the current folder"),
        (["evaluation_code.nothing:npss"], "FUNCTION: there is no module 'evaluation_code.nothing', "),
        (["evaluation_code.quits:npss"], "FUNCTION: evaluation_code.quits: SystemExit: 3 ("),
        (["evaluation_code.fails:npss"], "FUNCTION: evaluation_code.fails: ZeroDivisionError: division by zero ("),
        (["evaluation_code.mistyped:npss"], "FUNCTION: evaluation_code.mistyped: SyntaxError: "),
        (["evaluation_code.needs:npss"], "FUNCTION: evaluation_code.needs: No module named 'no_such_package' ("),
        (
            ["evaluation_code.metrics:broken"],
            "FUNCTION: broken runs with no shape of motion; arrays (N, T, D): NameErr",
        ),
        (["evaluation_code.metrics:npss", "--frame", "0"], "--frame: expected a positive integer, got 0"),
    ],
)
def test_errors(capsys, arguments, message):
    status, out, err = run(capsys, "identify", *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(f"npss: error: {message}")
    assert err.count("\n") == 1


def test_errors_name_the_line(capsys):
    _, _, err = run(capsys, "identify", "evaluation_code.fails:npss")
    assert err.endswith("fails.py, line 2)\n")
    _, _, err = run(capsys, "identify", "evaluation_code.metrics:broken")
    assert "metrics.py, line 25)" in err
