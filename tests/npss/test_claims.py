"""Claims of signatures, checked by the arrays at hand: the protocol of the ground truth, the signs of quaternions."""

import numpy as np
import pytest

import npss
from npss.inbetweening import Global, measure
from npss.protocol import lafan1
from npss.rotations import continuous

RNG = np.random.default_rng(0)


def quaternions(n=6, frames=30, joints=22, seed=0):
    """Return smooth unit quaternions, continuous in time."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-1, 1, (n, 1, joints)) + 0.2 * rng.normal(size=(n, frames, joints)).cumsum(axis=1)
    axis = rng.normal(size=(n, 1, joints, 3))
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    q = np.concatenate([np.cos(angle / 2)[..., None], np.sin(angle / 2)[..., None] * axis], axis=-1)
    return continuous(q, axis=1)


GT, PRED, OTHER = (quaternions(seed=seed) for seed in range(3))
FIELDS = {"convention": "released", **lafan1.fields()}


def of_report(gt, pred, **fields):
    return npss.report(gt, pred, **fields).signature


def of_lengths(gt, pred, **fields):
    return npss.report(list(gt), list(pred), lengths=[30] * len(gt), **fields)[30].signature


def of_bound(gt, pred, **fields):
    return npss.report(gt, pred, normalize="bound", **fields).signature


def of_compare(gt, pred, **fields):
    return npss.compare(gt, pred, pred, **fields).signature


def of_compare_lengths(gt, pred, **fields):
    return npss.compare(list(gt), list(pred), list(pred), lengths=[30] * len(gt), **fields).signature


def of_samples(gt, pred, **fields):
    return npss.stochastic.report(gt, [pred, pred], **fields).signature


def of_record(gt, pred, *, convention, **fields):
    return npss.records.measure(gt, pred, conventions=[convention], **fields)["signature"]


WAYS = [of_report, of_lengths, of_bound, of_compare, of_compare_lengths, of_samples, of_record]


def fields_of(sign):
    """Return the fields of a published number, without those that a function fills in."""
    return {name: value for name, value in FIELDS.items() if sign is not of_record or name != "unwrap"}


@pytest.mark.parametrize("sign", WAYS)
class TestEveryNumber:
    def test_of_another_ground_truth_says_so(self, sign):
        fields = fields_of(sign)
        assert sign(GT, PRED, **fields).endswith("|verified:no")
        for changed in ({"protocol": "mine"}, {"protocol": None}):
            stated = {name: value for name, value in (fields | changed).items() if value is not None}
            assert "verified" not in sign(GT, PRED, **stated)

    def test_of_the_ground_truth_does_not(self, sign, monkeypatch):
        from npss.protocol import _claims, _verify

        seen = []

        def verify(gt, name, fps):
            seen.append((np.array(gt), name, fps))
            return _verify.Verification(protocol=name)

        monkeypatch.setattr(_claims, "verify", verify)
        fields = fields_of(sign)
        assert "verified" not in sign(GT, PRED, **fields)
        ((gt, name, fps),) = seen
        assert (name, fps) == ("lafan1", 30)
        np.testing.assert_array_equal(gt, GT.reshape(6, 30, 88))

    @pytest.mark.parametrize("signs", ["continuous", "w>=0"])
    def test_has_the_signs_that_it_states(self, sign, signs):
        motions = [GT, PRED]
        if signs == "w>=0":
            motions = [np.where(motion[..., :1] < 0, -motion, motion) for motion in motions]
        assert f"|quaternions:{signs}" in sign(*motions, convention="released", quaternions=signs)
        for place in range(2):
            flipped = [motion.copy() for motion in motions]
            flipped[place][4, 7:9, 3] *= -1
            name = r"(pred|pred_a|samples\[0\])" if place else "gt"
            with pytest.raises(ValueError, match=rf"^{name}: .* '{signs}', but 2 are not") as caught:
                sign(*flipped, convention="released", quaternions=signs)
            assert "quaternion (4, 7, 3)" in str(caught.value)
        with pytest.raises(ValueError, match=r"^gt: expected quaternions, whose signs are stated, got 6 features"):
            sign(*RNG.normal(size=(2, 6, 30, 6)), convention="released", quaternions=signs)


@pytest.mark.parametrize("signs", ["continuous", "w>=0"])
@pytest.mark.parametrize("others", [(0, 3), (3, 0), (0, 4), (3, 4), (5, 1)])
def test_signs_of_quaternions_among_other_features(signs, others):
    """Root positions before them or contact labels after them have no signs."""
    before, after = (RNG.normal(size=(2, 6, 30, n)) for n in others)
    gt, pred = (
        np.concatenate([start, np.where((q[..., :1] < 0) & (signs == "w>=0"), -q, q).reshape(6, 30, 88), end], axis=-1)
        for start, q, end in zip(before, (GT, PRED), after, strict=True)
    )
    assert f"|quaternions:{signs}" in of_report(gt, 0.9 * pred, quaternions=signs)
    flipped = pred.copy()
    flipped[4, 7:9, others[0] + 12 : others[0] + 16] *= -1
    with pytest.raises(ValueError, match=r"^pred: .* but 2 are not, the first at .* quaternion \(4, 7, 3\)"):
        of_report(gt, flipped, quaternions=signs)


def test_w_comes_first():
    gt, pred = (np.roll(np.where(q[..., :1] < 0, -q, q), -1, axis=-1) for q in (GT, PRED))
    with pytest.raises(ValueError, match="negate those with a negative w; they are taken as w, x, y, z"):
        of_report(gt, pred, quaternions="w>=0")


@pytest.mark.parametrize("n", [1, 3, 91])
def test_no_quaternions(n):
    with pytest.raises(ValueError, match=rf"^gt: expected quaternions, .* got {n} features, no four of unit length"):
        of_report(*RNG.normal(size=(2, 6, 30, n)), quaternions="continuous")


def test_rounding_does_not_flip_a_sign():
    """Two quaternions a full turn apart have a product of zero, but for rounding."""
    q = np.zeros((2, 4, 1, 4))
    q[:, ::2, 0, 0] = 1
    q[:, 1::2, 0, 1] = 1
    q[:, 1::2, 0, 0] = -1e-8
    assert "continuous" in of_report(q, q, quaternions="continuous")


class TestPublishedRows:
    def test_noise_does_not_stand_beside_them(self):
        """By a report, or by `measure`; both were stated to be of LaFAN1."""
        pytest.importorskip("pandas")
        report = npss.report(GT, PRED, **FIELDS)
        still = np.zeros((6, 30, 22, 3))
        record = measure(Global(GT, still), Global(PRED, still), unit="m", protocol=lafan1, model="mine")
        assert record["npss"]["released"] == pytest.approx(report.score)
        assert record["signatures"]["released"] == report.signature
        for source in ({"mine": report}, [record]):
            with pytest.raises(ValueError, match="verified must not be stated, but is no"):
                npss.leaderboard(source, published=True)
        assert "not comparable with the LaFAN1 in-betweening tables: the ground truth" in npss.explain(report.signature)

    def test_reports_say_why(self):
        report = npss.report(GT[:, :, :20], PRED[:, :, :20], **FIELDS)
        (line,) = (line for line in str(report).splitlines() if "protocol lafan1:" in line)
        assert line.startswith("  protocol lafan1: not its ground truth: 6 windows; lafan1 has 2232; 20 joints;")
        assert report.verification.findings
        assert npss.report(GT, PRED).verification is None
        assert "protocol" not in str(npss.report(GT, PRED))

    def test_other_features_are_not_of_the_protocol(self):
        report = npss.report(*RNG.normal(size=(2, 6, 30, 66)), protocol="lafan1")
        assert report.verification.findings[0].startswith("gt: expected global quaternions")
        assert report.signature.endswith("|verified:no")

    def test_other_representations_are_undecided(self):
        gt, *predictions = RNG.normal(size=(3, 6, 30, 22, 3))
        fields = {name: value for name, value in lafan1.fields("l2p").items() if name != "norm"}
        assert "verified" not in npss.compare(gt, *predictions, metric="l2p", **fields).signature
        times = {"metric": "position_error", "at_ms": 100}
        for how in ({"metric": "l2p"}, times):
            assert "verified" not in npss.compare(gt, *predictions, **how, fps=30, protocol="lafan1").signature
        report = npss.report(gt, predictions[0], representation="global-positions", protocol="lafan1")
        assert report.verification.undecided == ("its ground truth is known by global quaternions alone",)
        assert "verified" not in report.signature

    def test_one_sequence(self):
        assert npss.report(GT[0].reshape(30, 88), PRED[0].reshape(30, 88), protocol="lafan1").verification.findings[
            0
        ] == ("1 windows; lafan1 has 2232")


EULER = {"convention": "released", "representation": "euler", "fps": 25, "protocol": "srnn-8", "unwrap": "off"}


class TestHuman36M:
    @pytest.fixture
    def walking(self, h36m_root):
        clips = [
            np.loadtxt(h36m_root / f"dataset/S5/walking_{k}.txt", delimiter=",", dtype=np.float32)[::2] for k in (1, 2)
        ]
        windows = npss.protocol.srnn_windows([len(clip) for clip in clips])
        return npss.poses_to_euler(np.stack([clips[window.clip][window.target] for window in windows]))

    def test_real_windows(self, walking):
        pred = walking + RNG.normal(size=walking.shape)
        report = npss.report(walking, pred, **EULER)
        assert report.verification.ok
        assert "verified" not in report.signature
        pytest.importorskip("pandas")
        board = npss.leaderboard({"mine": {"walking": report}}, published=True)
        assert board.loc["VGRU-d (published)", ("walking", "NPSS released")] == 0.887
        late = npss.report(walking, pred, **EULER | {"protocol": "srnn-8-late"})
        assert late.verification.findings[0].endswith("it is walking on time (srnn-8)")
        assert late.signature.endswith("|verified:no")

    def test_other_motion_under_a_known_name(self):
        """It may be another action, of which no score is known, but not walking."""
        pytest.importorskip("pandas")
        report = npss.report(*RNG.normal(size=(2, 8, 100, 54)), **EULER)
        (undecided,) = report.verification.undecided
        assert undecided.endswith("as on none of walking, eating, smoking: another action, or other motion")
        assert "verified" not in report.signature
        assert npss.leaderboard({"mine": {"discussion": report}}, published=True).shape[0] > 1
        with pytest.raises(ValueError, match="verified must not be stated, but is no"):
            npss.leaderboard({"mine": {"walking": report}}, published=True)

    @pytest.mark.parametrize(("shape", "finding"), [((7, 100, 54), "7 windows"), ((8, 50, 54), "50 frames")])
    def test_shapes(self, shape, finding):
        report = npss.report(*RNG.normal(size=(2, *shape)), **EULER)
        assert report.verification.findings[0].startswith(f"{finding}; srnn-8 has ")
        assert report.signature.endswith("|verified:no")

    def test_other_representations_are_undecided(self):
        """In leaderboards, too: no checksum was taken that walking could differ from."""
        pytest.importorskip("pandas")
        fields = {"protocol": "srnn-8", "representation": "expmap"}
        report = npss.report(*RNG.normal(size=(2, 8, 100, 54)), **fields)
        assert report.verification.undecided
        assert "verified:no" not in npss.leaderboard({"mine": {"walking": report}}).to_text()
