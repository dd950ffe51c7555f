"""Names of conversions, and hypothesis strategies for rotations."""

import numpy as np
import pytest
from hypothesis import strategies as st

from npss import rotations

#: Trailing axes of each form.
FORMS = {"expmap": (3,), "matrix": (3, 3), "quaternion": (4,), "sixd": (6,), "euler": (3,)}
#: Names of the functions' arguments.
ARGUMENTS = {"expmap": "v", "matrix": "R", "quaternion": "q", "sixd": "sixd", "euler": "angles"}
#: ``(source, target)`` of every conversion.
PAIRS = [(source, target) for source in FORMS for target in FORMS if source != target]

PROPER = ("XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ")
TAIT_BRYAN = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
LETTERS = [*PROPER, *TAIT_BRYAN, *map(str.lower, PROPER), *map(str.lower, TAIT_BRYAN)]

both_precisions = pytest.mark.parametrize("dtype", [np.float64, np.float32])


def is_proper(seq):
    return seq.upper() in PROPER


def around(difference):
    """Return the absolute difference of two angles, in [0, pi]."""
    return np.abs((difference + np.pi) % (2 * np.pi) - np.pi)


def converter(source, target):
    """Return the public function from one form to another."""
    return getattr(rotations, f"{source}_to_{target}")


def sample(form, leading, seed=0, dtype=np.float64):
    """Return random rotations in a form, with angles up to 6 for the exponential map."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(*leading, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    v = (axis * rng.uniform(0, 6, size=(*leading, 1))).astype(dtype)
    return v if form == "expmap" else converter("expmap", form)(v)


#: Angles where formulas break down, and distances from them.
_CORNERS = st.sampled_from([0.0, np.pi / 2, np.pi, 2 * np.pi])
_DISTANCES = st.sampled_from([0.0, 5e-324, 1e-300, 1e-160, 1e-17, 1e-16, 1e-12, 1e-8, 1e-7, 1e-4, 1e-2])


@st.composite
def angles(draw):
    """Draw angles in [-8, 8], often at or near corners."""
    if draw(st.booleans()):
        return draw(st.floats(-8, 8))
    sign = draw(st.sampled_from([-1.0, 1.0]))
    return sign * (draw(_CORNERS) + draw(st.sampled_from([-1.0, 1.0])) * draw(_DISTANCES))


@st.composite
def expmaps(draw, max_count=6):
    """Draw rotation vectors ``(n, 3)``: along coordinate axes, in their planes, and anywhere."""
    rows = []
    for _ in range(draw(st.integers(1, max_count))):
        axis = np.array(draw(st.tuples(*[st.sampled_from([0.0, 1.0, -1.0, 1e-9, 0.3, -0.7])] * 3)))
        length = np.linalg.norm(axis)
        rows.append(draw(angles()) * (axis / length if length else axis))
    return np.array(rows)


@st.composite
def euler_angles(draw, seq, max_count=6):
    """Draw Euler angles ``(n, 3)`` of a sequence, often at or near gimbal lock."""
    proper = seq[0] == seq[-1]
    rows = []
    for _ in range(draw(st.integers(1, max_count))):
        outer = draw(st.floats(-np.pi, np.pi)), draw(st.floats(-np.pi, np.pi))
        lock = draw(st.sampled_from([0.0, np.pi] if proper else [-np.pi / 2, np.pi / 2]))
        inwards = -1 if lock > 0 else 1
        near = lock + inwards * draw(_DISTANCES)
        anywhere = draw(st.floats(0, np.pi) if proper else st.floats(-np.pi / 2, np.pi / 2))
        rows.append((outer[0], draw(st.sampled_from([near, anywhere])), outer[1]))
    return np.array(rows)
