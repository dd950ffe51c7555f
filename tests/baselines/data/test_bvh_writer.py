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


def test_channels_that_did_not_change_are_written_as_they_were_read(tmp_path):
    """An animator's curves keep their turns, and their jumps to other angles of the same rotation."""
    rows = [(350, 10, 20, 5), (351, 11, 20, 4), (352, 12, 20, 3), (-187, 167, 201, 362), (-186, 166, 202, 363)]
    text = turning([0] * len(rows)).splitlines()[:-5] + [" ".join(map(str, row)) for row in rows]
    motion = motion_of(tmp_path, "\n".join(text))
    assert [tuple(map(float, row.split())) for row in bvh_writer.text(motion).splitlines()[-5:]] == rows
    rotations = motion.rotations.copy()
    rotations[1:3, 0] = euler_to_matrix(np.radians([[-8, 11, 20], [-7, 12, 20]]), seq="ZXY")  # by one degree
    rotations[3:, 1] = euler_to_matrix(np.radians([[4, 0, 0], [5, 0, 0]]), seq="XYZ")
    written = bvh_writer.text(dataclasses.replace(motion, rotations=rotations)).splitlines()[-5:]
    expected = [rows[0], (352, 11, 20, 4), (353, 12, 20, 3), (*rows[3][:3], 4), (*rows[4][:3], 5)]
    np.testing.assert_allclose([list(map(float, row.split())) for row in written], expected, rtol=0, atol=2e-6)
    rotations[0, 0] = rotations[1, 0]
    rotations[1:3, 0] = motion.rotations[1:3, 0]
    first = bvh_writer.text(dataclasses.replace(motion, rotations=rotations)).splitlines()[-5]
    np.testing.assert_allclose(list(map(float, first.split())), [352, 11, 20, 5], rtol=0, atol=2e-6)


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
