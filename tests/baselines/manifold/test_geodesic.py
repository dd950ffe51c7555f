"""Tests of geodesics, on surfaces whose shortest paths are known."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from npss_baselines.manifold.applications.geodesic import geodesic, geodesic_between


def sphere(z):
    """Decode longitude and latitude."""
    return torch.stack([z[:, 0].cos() * z[:, 1].cos(), z[:, 0].sin() * z[:, 1].cos(), z[:, 1].sin()], dim=1)


def arc(a, b):
    first, second = sphere(torch.tensor([a, b], dtype=torch.float64))
    return float(torch.arccos((first @ second).clamp(-1, 1)))


@pytest.mark.numeric
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10)
def test_on_a_linear_manifold_it_is_the_euclidean_distance(seed):
    rng = np.random.default_rng(seed)
    matrix = torch.from_numpy(rng.normal(size=(5, 7)))
    first, second = rng.normal(size=(2, 5))
    path = geodesic(lambda z: z @ matrix, first, second)
    expected = np.linalg.norm((second - first) @ matrix.numpy())
    assert path.length == pytest.approx(expected, rel=1e-9)
    assert path.straight == pytest.approx(expected, rel=1e-9)


@pytest.mark.numeric
@pytest.mark.parametrize(("a", "b"), [((0, 1.0), (2.0, 1.0)), ((0.3, -0.7), (1.9, 0.9)), ((0, 1.2), (3.0, 1.2))])
def test_on_a_sphere_it_is_the_arc_of_a_great_circle(a, b):
    """Chords of n equal pieces of an arc are together shorter by a share of (angle / n)^2 / 24."""
    expected = arc(a, b)
    path = geodesic(sphere, a, b, pieces=16, iterations=200)
    shorter = 1 - (expected / 16) ** 2 / 24
    assert path.length == pytest.approx(expected * shorter, rel=1e-4)
    assert path.straight > path.length * 1.01  # the line in longitude and latitude is no great circle
    np.testing.assert_array_equal(path.codes[[0, -1]], [a, b])
    steps = np.linalg.norm(np.diff(sphere(torch.from_numpy(path.codes)).numpy(), axis=0), axis=1)
    assert np.ptp(steps) < 0.01 * steps.mean()  # pieces of equal length


@pytest.mark.numeric
def test_symmetric_and_zero_from_a_point_to_itself():
    a, b = (0.2, 0.9), (1.4, 1.1)
    there, back = geodesic(sphere, a, b, iterations=200), geodesic(sphere, b, a, iterations=200)
    assert there.length == pytest.approx(back.length, rel=1e-4)
    assert geodesic(sphere, a, a).length == 0


def test_a_path_is_never_longer_than_the_line():
    path = geodesic(sphere, (0, 1.0), (2.0, 1.0), iterations=1)
    assert path.length <= path.straight
    assert geodesic(sphere, (0, 0), (1.0, 0), pieces=1).length == pytest.approx(2 * np.sin(0.5))


@pytest.mark.numeric
def test_of_motions(testbed):
    manifold = testbed.manifolds["manifold"]
    first, second = testbed.test.windows[[0, -1]]
    path = geodesic_between(manifold, first, second, pieces=4, iterations=5)
    ends = manifold.scaling.normalize(manifold.project(np.stack([first, second])))
    assert path.codes.shape == (5, 40, 10)
    assert np.linalg.norm(ends[1] - ends[0]) * (1 - 1e-5) <= path.length <= path.straight


@pytest.mark.parametrize(
    ("first", "second", "options", "error", "message"),
    [
        ([0.0, 0.0], [1.0], {}, ValueError, r"second: shape \(1,\) differs from shape \(2,\) of first"),
        ([0.0, np.nan], [1.0, 0.0], {}, ValueError, "first: nan at index"),
        (["a"], [1.0], {}, TypeError, "first: "),
        ([0.0, 0.0], [1.0, 0.0], {"pieces": 0}, ValueError, "pieces: "),
        ([0.0, 0.0], [1.0, 0.0], {"iterations": 0}, ValueError, "iterations: "),
    ],
)
def test_refused(first, second, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        geodesic(sphere, first, second, **options)
