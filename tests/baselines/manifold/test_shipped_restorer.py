"""The restorer in the package: what it saw, and what it reaches on people that it did not see."""

import numpy as np
import pytest

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted, branch
from npss_baselines.manifold.applications.restore import Windows, corrupted
from npss_baselines.manifold.evaluation.lost import lost_error
from npss_baselines.manifold.motion.split import held_out_subjects, split, validation_subjects
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.file import SHIPPED, default, load
from npss_baselines.manifold.restorers.interpolation import Interpolation

pytestmark = pytest.mark.skipif(not SHIPPED.exists(), reason="the package has no restorer")


def test_it_saw_cmu_alone_and_no_held_out_person():
    seen = load(SHIPPED).seen
    assert set(seen["sources"]) <= {"cmu", "cmu-styles"}
    assert not {*held_out_subjects(), *validation_subjects()} & set(seen["subjects"])


def test_it_is_small_and_the_default():
    assert SHIPPED.stat().st_size < 5e6
    assert default().signature == load(SHIPPED).signature


def test_it_beats_simple_baselines_on_people_it_did_not_see(cmu_root):
    """A fast part of the table: every fourth window of CMU's held-out subjects."""
    from npss_baselines.manifold.motion.prepared import motion_set

    restorer = load(SHIPPED)
    test = split(motion_set({"cmu": cmu_root}, quick=True)).test
    if test is None:
        pytest.skip("the quick part of CMU has no held-out subject")
    windows = Windows(test.windows[::4].astype(float), test.mask[::4])
    simple = {
        "fill": Conditional(restorer.fill.pose),
        "repair": Interpolation("hermite"),
        "kinect": Interpolation("linear"),
    }
    for application, other in simple.items():
        left = corrupted(application, windows, restorer.keys.scaling.mean)
        first, second = (
            lost_error(windows.features, way.restore(left), left, windows.mask).error for way in (restorer, other)
        )
        assert first < second, application


@pytest.mark.parametrize("frames", [12, 60])
def test_an_arm_that_is_missing_for_a_while(frames, motions):
    """On generated walks, it is no worse than interpolation, and far better than the pose of each frame alone."""
    features = motions.windows[:4].astype(float)
    known = np.ones(features.shape, bool)
    arm = branch(JOINTS, "RightForeArm")
    known[:, 50 : 50 + frames, [3 * joint + axis for joint in arm for axis in range(3)]] = False
    left = Corrupted(np.where(known, features, np.nan), known)
    restorer, everywhere = load(SHIPPED), np.ones(features.shape[:2], bool)
    ways = {"restorer": restorer, "curve": Interpolation("hermite"), "pose": Conditional(restorer.fill.pose)}
    errors = {name: lost_error(features, way.restore(left), left, everywhere).error for name, way in ways.items()}
    assert errors["restorer"] <= 1.05 * errors["curve"]
    assert errors["restorer"] < 0.7 * errors["pose"]
