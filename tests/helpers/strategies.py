"""Hypothesis strategies for motion."""

import numpy as np
from hypothesis import strategies as st


@st.composite
def pairs(draw, max_n=4, min_t=2, max_t=24, max_d=4, special=True):
    """Draw ground truth and prediction, ``(N, T, D)``: drifting noise, some features constant or zero."""
    shape = (
        draw(st.integers(1, max_n)),
        draw(st.integers(min_t, max_t)),
        draw(st.integers(1, max_d)),
    )
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    both = []
    for _ in range(2):
        motion = rng.normal(size=shape).cumsum(axis=1) + rng.normal(size=(shape[0], 1, shape[2]))
        motion *= 10.0 ** rng.integers(-3, 4, size=(1, 1, shape[2]))
        if special:
            constant = rng.random((shape[0], 1, shape[2])) < draw(st.sampled_from([0.0, 0.3]))
            zero = rng.random((shape[0], 1, shape[2])) < draw(st.sampled_from([0.0, 0.3]))
            motion = np.where(constant, motion[:, :1], motion)
            motion = np.where(zero, 0.0, motion)
        both.append(motion)
    both[0][0, :, 0] = rng.normal(size=shape[1])  # the ground truth always has power
    return both[0], both[1]
