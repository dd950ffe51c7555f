"""Written BVH files: they open again with the same motion, and refuse what their channels cannot say."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bvh_files import generated
from npss.rotations import euler_to_matrix
from npss_baselines.data import bvh, bvh_writer


def motion_of(tmp_path, text):
    path = tmp_path / "motion.bvh"
    path.write_text(text, encoding="utf-8")
    return bvh.read(path)


@given(seed=st.integers(0, 2**32 - 1), plain=st.booleans())
def test_what_is_read_is_written(tmp_path_factory, seed, plain):
    folder = tmp_path_factory.mktemp("bvh")
    motion = motion_of(folder, generated(seed, plain=plain)[0])
    bvh_writer.write(folder / "copy.bvh", motion)
    copy = bvh.read(folder / "copy.bvh")
    assert copy.channels == motion.channels
    assert copy.fps == pytest.approx(motion.fps, rel=1e-6)
    assert sorted(copy.skeleton.names) == sorted(motion.skeleton.names)
    # Six decimal places of degrees, and of offsets added along each chain.
    places = [copy.skeleton.names.index(name) for name in motion.skeleton.names]
    np.testing.assert_allclose(copy.positions()[:, places], motion.positions(), rtol=0, atol=1e-5)
    np.testing.assert_allclose(copy.rotations[:, places], motion.rotations, rtol=0, atol=1e-6)


def turning(degrees, order="ZXY"):
    """A motion of two joints: the root turns, and the knee bends about x only."""
    knee = "CHANNELS 1 Xrotation"
    lines = ["HIERARCHY", "ROOT hip", "{", "OFFSET 0 1 0", f"CHANNELS 3 {' '.join(f'{a}rotation' for a in order)}"]
    lines += ["JOINT knee", "{", "OFFSET 0 -1 0", knee, "End Site", "{", "OFFSET 0 -1 0", "}", "}", "}", "MOTION"]
    lines += [f"Frames: {len(degrees)}", "Frame Time: .04", *(f"{d} 0 0 10" for d in degrees)]
    return "\n".join(lines)


def test_angles_are_continuous(tmp_path):
    motion = motion_of(tmp_path, turning([170, 178, 186, 194]))
    rows = bvh_writer.text(motion).splitlines()[-4:]
    assert [float(row.split()[0]) for row in rows] == [170, 178, 186, 194]


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        (
            "rotations",
            lambda values: values.__setitem__((1, 1), euler_to_matrix([0, 0.1, 0], seq="XYZ")),
            "^knee: it turns by 5.7",
        ),
        ("translations", lambda values: values.__setitem__((1, 1, 2), 0.5), "^knee: it moves by 0.5 along an axis"),
        ("rotations", lambda values: values.__setitem__((1, 0, 0, 0), np.nan), "^rotations: .*nan"),
    ],
)
def test_what_channels_cannot_say_is_refused(tmp_path, field, change, message):
    motion = motion_of(tmp_path, turning([0, 1]))
    values = getattr(motion, field).copy()
    change(values)
    with pytest.raises(ValueError, match=message):
        bvh_writer.text(dataclasses.replace(motion, **{field: values}))
