"""Tests of generated jumps."""

import numpy as np
import pytest

from npss_baselines.data.motion import JOINTS, NAMES
from npss_baselines.data.synthetic_jump import AIR, CROUCH, GRAVITY, RISE, jump_clip


def test_bones_and_ground():
    positions = jump_clip(200).positions
    for child, parent in JOINTS.bones:
        length = np.linalg.norm(positions[:, child] - positions[:, parent], axis=-1)
        np.testing.assert_allclose(length, np.linalg.norm(JOINTS.offsets[child]), atol=1e-12)
    balls = positions[:, [NAMES.index("LeftToeBase"), NAMES.index("RightToeBase")]]
    np.testing.assert_allclose(balls[..., ::2], np.broadcast_to(balls[0, :, ::2], (200, 2, 2)), atol=1e-12)
    time = np.arange(200) / 30 % (CROUCH + AIR + RISE)
    flying = (time > CROUCH) & (time < CROUCH + AIR)
    assert np.abs(balls[~flying][..., 1]).max() < 1e-12
    assert (balls[flying][..., 1] > 0).all()


def test_flight_is_a_parabola():
    clip = jump_clip(3000, fps=1000)
    root = clip.positions[:, 0, 1]
    inside = slice(int(1000 * CROUCH) + 5, int(1000 * (CROUCH + AIR)) - 5)
    np.testing.assert_allclose(np.diff(root, 2)[inside] * 1000**2, -GRAVITY, rtol=1e-6)


def test_refused():
    with pytest.raises(ValueError, match=r"^n_frames: "):
        jump_clip(0)
    with pytest.raises(ValueError, match=r"^fps: "):
        jump_clip(10, fps=0.0)
