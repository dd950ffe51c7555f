"""Speed of 6D conversions, slerp, relative angles and forward kinematics, as ratios to scipy and RoMa.

    python -m pytest -s benchmarks/test_kinematics_speed.py

All contenders run on one thread, in turn, in one process; the best round counts. RoMa (torch) is left out where it is
not installed. It and scipy check less: neither refuses a matrix that is not a rotation.
"""

import importlib.util
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from npss.rotations import (
    expmap_to_quaternion,
    matrix_to_sixd,
    quaternion_to_matrix,
    relative_angle,
    sixd_to_matrix,
    slerp,
)
from npss.skeleton import H36M

COUNT = 100_000
FRAMES = COUNT // 32
ROUNDS = 7
#: Smallest ratios to scipy.
TARGETS = {"slerp": 1.0, "relative_angle": 1.0, "forward": 1.0}


def nanoseconds(calls):
    """Return the best time per rotation of each call."""
    best = dict.fromkeys(calls, np.inf)
    for _ in range(ROUNDS):
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            best[name] = min(best[name], (time.perf_counter() - start) / COUNT * 1e9)
    return best


def scipy_forward(local):
    """Compose rotations from the root to the leaves, one `Rotation` for all frames of a joint."""
    turned, positions = [], []
    for j, parent in enumerate(H36M.parents):
        here = Rotation.from_matrix(local[:, j])
        turned.append(here if parent < 0 else turned[parent] * here)
        offset = H36M.offsets[j].copy()
        positions.append(offset if parent < 0 else positions[parent] + turned[parent].apply(offset))
    return positions, [rotation.as_matrix() for rotation in turned]


@pytest.fixture(scope="module")
def times():
    rng = np.random.default_rng(0)
    q = expmap_to_quaternion(rng.normal(size=(COUNT + 1, 3)))
    R = quaternion_to_matrix(q[:COUNT])
    sixd = matrix_to_sixd(R)
    local = R.reshape(FRAMES, 32, 3, 3)
    chain = Slerp(np.arange(COUNT + 1), Rotation.from_quat(np.roll(q, -1, axis=-1)))
    middle = np.arange(COUNT) + 0.25
    first, second = (Rotation.from_quat(np.roll(x, -1, axis=-1)) for x in (q[:-1], q[1:]))
    calls = {
        ("slerp", "npss"): lambda: slerp(q[:-1], q[1:], 0.25),
        ("slerp", "scipy"): lambda: chain(middle).as_quat(),
        ("relative_angle", "npss"): lambda: relative_angle(q[:-1], q[1:], representation="quaternion"),
        ("relative_angle", "scipy"): lambda: (first.inv() * second).magnitude(),
        ("sixd_to_matrix", "npss"): lambda: sixd_to_matrix(sixd),
        ("forward", "npss"): lambda: H36M.forward(local),
        ("forward", "scipy"): lambda: scipy_forward(local),
    }
    if importlib.util.find_spec("roma"):
        import roma
        import torch

        torch.set_num_threads(1)
        p = torch.from_numpy(np.roll(q, -1, axis=-1))  # x, y, z, w
        columns = torch.from_numpy(R[..., :2].copy())
        where = torch.tensor([0.25], dtype=torch.float64)
        calls |= {
            ("slerp", "roma"): lambda: roma.unitquat_slerp(p[:-1], p[1:], where, shortest_arc=True),
            ("relative_angle", "roma"): lambda: roma.unitquat_geodesic_distance(p[:-1], p[1:]),
            ("sixd_to_matrix", "roma"): lambda: roma.special_gramschmidt(columns),
        }
    return nanoseconds(calls)


def test_table(times):
    print(f"\n\n{'ns per rotation':18}" + "".join(f"{name:>10}" for name in ("npss", "scipy", "roma")))
    for what in dict.fromkeys(what for what, _ in times):
        row = (times.get((what, name)) for name in ("npss", "scipy", "roma"))
        print(f"{what:18}" + "".join(f"{'-' if ns is None else format(ns, '.0f'):>10}" for ns in row))


@pytest.mark.parametrize("what", TARGETS)
def test_targets(times, what):
    assert times[what, "scipy"] / times[what, "npss"] >= TARGETS[what]
