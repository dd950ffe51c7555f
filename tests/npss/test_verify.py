"""Ground truth compared to that of a protocol: the six cases of in-betweening, and Human3.6M's windows."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lafan1 as oracle
import npss
from npss.inbetweening import Local, forward, transition, windows
from npss.protocol import Verification, lafan1, srnn_windows, verify
from npss.rotations import euler_to_quaternion
from npss.skeleton import Skeleton

PAGE = Path(__file__).parents[2] / "docs" / "in-betweening.md"
SKELETON = Skeleton(oracle.NAMES, oracle.PARENTS, oracle.OFFSETS)
LENGTHS = {"walking": (1500, 1261), "eating": (1638, 1166), "smoking": (1601, 1711)}


@pytest.fixture(scope="module")
def cut():
    """The test windows of three generated clips, 23 of them; the field's own are not to be had."""
    clips = [oracle.clip(seed, 386) for seed in (1, 2, 3)]
    return windows([Local(euler_to_quaternion(np.radians(angles), seq="ZYX"), root) for angles, root in clips])


def truth(cut, n, late=0):
    """Return the global quaternions of a transition, or of frames `late` frames later."""
    parts = transition(cut, n)
    joined = np.concatenate([part.quaternions for part in parts], axis=1)[:, 10 + late : 10 + late + n]
    return forward(Local(joined, np.zeros((*joined.shape[:2], 3))), SKELETON).quaternions


@pytest.fixture(scope="module")
def protocol(cut):
    """A protocol whose row of zero-velocity is computed by the oracle, and rounded to four digits as a paper does."""
    row = []
    for n in lafan1.transitions:
        flat = truth(cut, n).reshape(len(cut.root), n, 88)
        row.append(round(oracle.npss(flat, np.ones_like(flat)), 4))
    return replace(lafan1, name="generated", windows=len(cut.root), zero_velocity={"npss": tuple(row)})


def six_cases(cut, n):
    right = truth(cut, n)
    flipped = right.copy()
    places = np.random.default_rng(0).random(flipped.shape[:3]) < 0.01
    flipped[places] *= -1
    with_keys = np.concatenate([part.quaternions for part in transition(cut, n)], axis=1)[:, 9 : 9 + n + 2]
    return {
        "right": right,
        "one frame late": truth(cut, n, late=1),
        "key frames": forward(Local(with_keys, np.zeros((*with_keys.shape[:2], 3))), SKELETON).quaternions,
        "a window missing": right[1:],
        "a joint missing": right[:, :, :-1],
        "signs": flipped,
    }


@pytest.mark.parametrize("n", [30, 45])
def test_the_six_cases_are_told_apart(cut, protocol, n):
    cases = six_cases(cut, n)
    results = {name: verify(gt, protocol) for name, gt in cases.items()}
    assert results["right"].ok
    assert [name for name, result in results.items() if result.ok] == ["right"]
    assert not any(result.undecided for result in results.values())
    found = {name: " ".join(result.findings) for name, result in results.items()}
    assert found["one frame late"].startswith("zero-velocity scores")
    assert found["one frame late"].endswith("other windows, such as one frame early or late, or other motion")
    assert f"{n + 2} frames" in found["key frames"]
    assert f"are {n} frames scored with both key frames?" in found["key frames"]
    assert f"{len(cut.root) - 1} windows; generated has {len(cut.root)}" in found["a window missing"]
    assert "21 joints; generated has 22" in found["a joint missing"]
    assert "signs of quaternions flip" in found["signs"]
    assert len({result.findings for result in results.values()}) == 6


@pytest.mark.parametrize("n", [30, 45])
def test_the_checksum_alone_tells_them_apart(cut, protocol, n):
    """To the four digits of a published row, no two cases score the same; key frames at their own length."""
    scores = {}
    for name, gt in six_cases(cut, n).items():
        flat = gt.reshape(*gt.shape[:2], -1)
        scores[name] = f"{npss.score(flat, np.ones_like(flat), convention='released'):.4f}"
    assert len(set(scores.values())) == 6
    if n == 45 and PAGE.exists():
        assert f"| {' | '.join(scores.values())} |" in PAGE.read_text(encoding="utf-8")
    assert float(scores["right"]) == protocol.zero_velocity["npss"][lafan1.transitions.index(n)]


@pytest.mark.parametrize("layout", ["joints", "flat", "single precision"])
def test_layouts(cut, protocol, layout):
    gt = truth(cut, 30)
    gt = {"joints": gt, "flat": gt.reshape(len(gt), 30, 88), "single precision": gt.astype(np.float32)}[layout]
    assert verify(gt, protocol, fps=30).ok


def test_frame_rate_lengths_and_past(cut, protocol):
    gt = truth(cut, 30)
    assert verify(gt, protocol, fps=60).findings == ("60 frames per second; generated has 30",)
    assert verify(gt * 1.1, protocol).findings == ("not unit quaternions: their lengths are 1.1 to 1.1",)
    past = forward(transition(cut, 30).past, SKELETON).quaternions
    held = np.repeat(past[:, -1:], 30, axis=1)
    row = npss.inbetweening.l2q(gt, held, past=past[:, -1])
    own = replace(protocol, zero_velocity={**protocol.zero_velocity, "l2q": (0.1, 0.2, round(row, 2), 0.4)})
    assert verify(gt, own, past=past).ok
    assert verify(gt, protocol, past=past) == verify(gt, protocol)  # without a row of L2Q there is nothing to compare
    assert verify(gt, own, past=past.reshape(len(gt), 10, 88)).ok
    (finding,) = verify(gt, own, past=past[:, :-1]).findings
    assert finding.startswith("the L2Q of zero-velocity is ")
    with pytest.raises(ValueError, match=r"past: its shape .* is not that of frames before gt"):
        verify(gt, own, past=past[:5])


def test_too_few_digits_are_undecided(cut):
    """At 5 and 15 frames the published .0053 and .0522 decide nothing, unless they differ."""
    rows = lafan1.zero_velocity["npss"]
    for n, value in zip((5, 15), rows[:2], strict=True):
        gt = truth(cut, n)
        flat = gt.reshape(len(gt), n, 88)
        own = replace(lafan1, name="generated", windows=None)
        result = verify(gt, own)
        assert not result.ok
        score = npss.score(flat, np.ones_like(flat), convention="released")
        assert (len(result.findings), len(result.undecided)) == ((1, 0) if abs(score - value) > 5e-5 else (0, 1))
        own = replace(own, zero_velocity={"npss": (round(score, 4) if n == 5 else 1, round(score, 4), 1, 1)})
        coarse = 5e-5 / round(score, 4) > 5e-4
        result = verify(gt, own)
        assert bool(result.undecided) == coarse
        assert result.findings == ()


def test_published_rows_decide_from_30_frames(monkeypatch, cut):
    """With scores equal to the published ones, lengths 5 and 15 stay undecided; 30 and 45 decide."""
    from npss.protocol import _verify

    for n, value in zip(lafan1.transitions, lafan1.zero_velocity["npss"], strict=True):
        for score, agrees in ((value, True), (value + 4e-5, True), (value - 6e-5, False)):
            monkeypatch.setattr(_verify, "_constant_score", lambda truth, score=score: score)
            result = verify(truth(cut, n), replace(lafan1, name="generated", windows=len(cut.root)))
            assert result.ok == (agrees and n >= 30)
            assert bool(result.undecided) == (agrees and n < 30)
            assert bool(result.findings) == (not agrees)


def test_a_protocol_without_a_row(cut):
    result = verify(truth(cut, 5), replace(lafan1, name="mine", windows=None, zero_velocity={}))
    assert result.undecided == ("mine has no score of zero-velocity to compare with",)


def test_it_prints_a_line_for_each():
    result = Verification(protocol="lafan1", findings=("a",), undecided=("b",), agrees=("c",))
    assert str(result).splitlines() == ["protocol lafan1: not its ground truth", "  - a", "  - b", "  - agrees: c"]
    assert str(Verification(protocol="lafan1", undecided=("b",))).startswith("protocol lafan1: undecided")
    assert str(Verification(protocol="lafan1")) == "protocol lafan1: verified"
    assert result.as_dict() == {
        "protocol": "lafan1",
        "ok": False,
        "findings": ["a"],
        "undecided": ["b"],
        "agrees": ["c"],
    }


class TestHuman36M:
    @pytest.mark.parametrize("action", LENGTHS)
    @pytest.mark.parametrize("late", [False, True])
    def test_windows_on_time_and_late(self, h36m_root, action, late):
        gt, past = self.task(h36m_root, action, late)
        name, other = ("srnn-8-late", "srnn-8") if late else ("srnn-8", "srnn-8-late")
        for options in ({}, {"action": action}, {"past": past}, {"action": action, "past": past, "fps": 25}):
            result = verify(gt, name, **options)
            assert result.ok, str(result)
            (finding,) = verify(gt, other, **options).findings
            assert finding.endswith(f"it is {action} {'one frame late' if late else 'on time'} ({name})")
        # a past that is one frame early is found by the Euler error alone
        assert verify(gt, name, past=past[:, :-1]).findings
        wrong = "eating" if action == "walking" else "walking"
        (finding,) = verify(gt, name, action=wrong).findings
        assert f"it is {action} " in finding

    def task(self, root, action, late):
        clips = [
            np.loadtxt(root / f"dataset/S5/{action}_{k}.txt", delimiter=",", dtype=np.float32)[::2] for k in (1, 2)
        ]
        cut = srnn_windows([len(clip) for clip in clips], late=late)
        return (
            np.stack([clips[window.clip][window.target] for window in cut]),
            np.stack([clips[window.clip][window.seed_frames] for window in cut]),
        )

    def test_other_actions_are_undecided(self):
        gt = np.random.default_rng(0).normal(0, 0.1, (8, 100, 99))
        assert verify(gt, "srnn-8", action="posing").undecided == (
            "no score of zero-velocity on 'posing' to compare with; known: walking, eating, smoking",
        )
        with pytest.raises(ValueError, match=r"^past: expected exponential maps \(8, S, 99\), got shape \(8, 99\)"):
            verify(gt, "srnn-8", past=gt[:, 0])
        (finding,) = verify(gt, "srnn-8").findings
        assert finding.endswith("srnn-8 has 1.1413 on walking, 0.8677 on eating, 0.9427 on smoking")

    def test_shapes(self):
        gt = np.zeros((7, 99, 54))
        assert verify(gt, "srnn-8", fps=50).findings == (
            "7 windows; srnn-8 has 8",
            "99 frames; srnn-8 has 100",
            "54 columns; srnn-8 has 99",
            "50 frames per second; srnn-8 has 25",
        )


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: verify(np.ones((1, 5, 88)), "lafan2"),
            ValueError,
            "protocol: expected one of lafan1, srnn-8, srnn-8-late, got",
        ),
        (lambda: verify(np.ones((1, 5, 88)), 5), TypeError, "protocol: expected one of"),
        (lambda: verify(np.ones((1, 5, 88)), "lafan1", action="walking"), ValueError, "action: in-betweening has none"),
        (lambda: verify(np.ones((1, 5, 87)), "lafan1"), ValueError, r"gt: expected global quaternions \(N, T, J, 4\)"),
        (lambda: verify(np.full((1, 5, 88), np.nan), "lafan1"), ValueError, "gt: nan at index"),
        (lambda: verify(np.ones((8, 100)), "srnn-8"), ValueError, r"gt: expected exponential maps \(N, T, 99\)"),
        (lambda: verify(np.ones((1, 5, 88)), "lafan1", fps=0), ValueError, "fps: expected"),
    ],
)
def test_refuses(call, error, message):
    with pytest.raises(error, match=message):
        call()
