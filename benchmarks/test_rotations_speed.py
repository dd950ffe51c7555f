"""Speed of the conversions to Euler angles, as ratios to other implementations.

    python -m pytest -s benchmarks/test_rotations_speed.py

All contenders run on one thread, in turn, in one process; the best round counts. The targets hold where numpy uses
vector units of 512 bits. Where it falls back to the C library, arc tangents are computed one by one, and only memory
improves over scipy: set NPSS_BENCHMARK_REPORT=1 to print only the table.
"""

import os
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from npss import poses_to_euler
from npss.rotations import expmap_to_euler, expmap_to_matrix, matrix_to_euler

COUNT = 1_000_000
FRAMES = 32_256  # of 31 joints: about `COUNT` rotations
LOOP_COUNT = 2_000
ROUNDS = 7

#: Smallest ratios to the loop, to scipy in double and to scipy in single precision, by name.
TARGETS = {
    "expmap_to_euler float64": (200, 1.5, None),
    "expmap_to_euler float32": (200, None, 5),
    "poses_to_euler float64": (200, 1.5, None),
    "poses_to_euler float32": (200, 1.5, None),
}


def loop(v):
    """Convert one rotation at a time with 3 x 3 matrices, as released code of the field does."""
    out = np.empty(v.shape)
    for n, row in enumerate(v):
        angle = np.linalg.norm(row)
        x, y, z = row / (angle + np.finfo(np.float32).eps)
        K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K.dot(K)
        middle = -np.arcsin(R[0, 2])
        cosine = np.cos(middle)
        out[n, 0] = np.arctan2(R[1, 2] / cosine, R[2, 2] / cosine)
        out[n, 1] = middle
        out[n, 2] = np.arctan2(R[0, 1] / cosine, R[0, 0] / cosine)
    return out


def scipy_euler(v):
    return -Rotation.from_rotvec(v).as_euler("XYZ")


def nanoseconds(calls):
    """Return the best time per rotation of each call; `calls` maps a name to (call, rotations)."""
    best = dict.fromkeys(calls, np.inf)
    for _ in range(ROUNDS):
        for name, (call, count) in calls.items():
            start = time.perf_counter()
            call()
            best[name] = min(best[name], (time.perf_counter() - start) / count * 1e9)
    return best


@pytest.fixture(scope="module")
def times():
    rng = np.random.default_rng(0)
    v = rng.normal(size=(COUNT, 3))
    poses = rng.normal(size=(FRAMES, 99))
    single, single_poses = v.astype(np.float32), poses.astype(np.float32)
    R = expmap_to_matrix(v)
    joints = FRAMES * 31
    return nanoseconds(
        {
            "loop": (lambda: loop(v[:LOOP_COUNT]), LOOP_COUNT),
            "scipy float64": (lambda: scipy_euler(v), COUNT),
            "scipy float32": (lambda: scipy_euler(single), COUNT),
            "expmap_to_euler float64": (lambda: expmap_to_euler(v), COUNT),
            "expmap_to_euler float32": (lambda: expmap_to_euler(single), COUNT),
            "expmap_to_euler legacy": (lambda: expmap_to_euler(v, legacy=True), COUNT),
            "poses_to_euler float64": (lambda: poses_to_euler(poses), joints),
            "poses_to_euler float32": (lambda: poses_to_euler(single_poses), joints),
            "expmap_to_matrix float64": (lambda: expmap_to_matrix(v), COUNT),
            "matrix_to_euler float64": (lambda: matrix_to_euler(R), COUNT),
        }
    )


def test_table(times):
    print(f"\n\n{'':26}{'ns':>8}{'x loop':>10}{'x scipy64':>11}{'x scipy32':>11}")
    for name, ns in times.items():
        ratios = [times[base] / ns for base in ("loop", "scipy float64", "scipy float32")]
        print(f"{name:26}{ns:8.0f}{ratios[0]:10.0f}{ratios[1]:11.2f}{ratios[2]:11.2f}")


@pytest.mark.skipif(bool(os.environ.get("NPSS_BENCHMARK_REPORT")), reason="table only")
@pytest.mark.parametrize("name", TARGETS)
def test_targets(times, name):
    for base, least in zip(("loop", "scipy float64", "scipy float32"), TARGETS[name], strict=True):
        if least is not None:
            assert times[base] / times[name] >= least
