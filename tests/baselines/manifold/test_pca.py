"""Tests of principal components, against numpy's singular vectors and by properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.manifold.model.pca import fit_pca
from npss_baselines.manifold.motion.scaling import Scaling

pytestmark = pytest.mark.numeric

PLAIN = Scaling(np.zeros(6), np.ones(6))
SCALED = Scaling(np.array([1.0, -2, 0, 3, 0, 5]), np.array([1.0, 2, 0.5, 4, 1, 0.1]))


def windows(n, rank, n_frames=8, seed=0):
    rng = np.random.default_rng(seed)
    mixed = rng.normal(size=(n, rank)) @ rng.normal(size=(rank, n_frames * 6)) + rng.normal(size=n_frames * 6)
    return mixed.reshape(n, n_frames, 6)


@pytest.mark.parametrize("n", [20, 200])  # fewer and more windows than values in one
@pytest.mark.parametrize("statistics", [PLAIN, SCALED])
def test_components_are_the_right_singular_vectors(n, statistics):
    motions = windows(n, 48)
    fitted = fit_pca(motions, statistics, n_components=12)
    rows = ((motions - statistics.mean) / statistics.scale).reshape(n, -1)
    _, _, expected = np.linalg.svd(rows - rows.mean(0), full_matrices=False)
    np.testing.assert_allclose(np.abs(fitted.components @ expected[:12].T), np.eye(12), rtol=0, atol=1e-9)
    np.testing.assert_allclose(fitted.components @ fitted.components.T, np.eye(12), rtol=0, atol=1e-12)
    centred = rows - rows.mean(0)
    projected = (centred @ expected[:12].T @ expected[:12] + rows.mean(0)).reshape(motions.shape)
    np.testing.assert_allclose(
        fitted.project(motions), projected * statistics.scale + statistics.mean, rtol=0, atol=1e-9
    )


@pytest.mark.parametrize(
    ("n", "rank", "n_components", "expected"), [(20, 5, 5120, 5), (20, 48, 5120, 19), (99, 48, 48, 48)]
)
def test_number_of_components(n, rank, n_components, expected):
    motions = windows(n, rank)
    fitted = fit_pca(motions.astype(np.float64), PLAIN, n_components=n_components)
    assert fitted.components.shape == (expected, 48)
    np.testing.assert_allclose(
        fitted.project(motions), motions, rtol=0, atol=1e-9
    )  # fitted windows are on the manifold


def test_more_components_reconstruct_better_and_projection_is_idempotent():
    motions, others = windows(60, 48), windows(9, 48, seed=1)
    errors = []
    for k in (1, 5, 20, 48):
        fitted = fit_pca(motions, SCALED, n_components=k)
        projected = fitted.project(others)
        errors.append(np.square((projected - others) / SCALED.scale).mean())
        np.testing.assert_allclose(fitted.project(projected), projected, rtol=0, atol=1e-9)
        assert fitted.encode(others).shape == (9, 1, k)
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 100 * errors[-1]


@given(st.integers(1, 45))
def test_any_length(n_frames):
    """Windows overlap by half and are averaged; short motion is mirrored."""
    fitted = fit_pca(windows(30, 48), SCALED, n_components=7)
    motions = windows(2, 6, n_frames, seed=2)
    projected = fitted.project(motions)
    assert projected.shape == motions.shape
    length = max(8, -(-n_frames // 4) * 4)
    padded = np.pad(motions, ((0, 0), (0, length - n_frames), (0, 0)), mode="reflect")
    total, count = np.zeros_like(padded), np.zeros((length, 1))
    for start in range(0, length - 7, 4):
        total[:, start : start + 8] += fitted.project(padded[:, start : start + 8])
        count[start : start + 8] += 1
    assert fitted.encode(motions).shape == (2, length // 4 - 1, 7)
    np.testing.assert_allclose(projected, (total / count)[:, :n_frames], rtol=0, atol=1e-9)


def test_signature_depends_on_all_numbers():
    fitted = fit_pca(windows(30, 48), SCALED, n_components=7)
    assert fitted.signature == fit_pca(windows(30, 48), SCALED, n_components=7).signature
    assert fitted.signature.startswith("pca-7-")
    others = (
        fit_pca(windows(30, 48), PLAIN, n_components=7),
        fit_pca(windows(31, 48), SCALED, n_components=7),
        fit_pca(windows(30, 48), SCALED, n_components=6),
    )
    assert len({fitted.signature, *(other.signature for other in others)}) == 4


def test_bad_input():
    motions = windows(4, 3)
    for wrong, message in (
        (motions[0], r"windows: expected shape \(n, T, 6\), got \(8, 6\)"),
        (motions[:, :7], "windows: expected an even number of frames, got 7"),
        (motions[..., :5], r"windows: expected shape \(n, T, 6\)"),
        (np.repeat(motions[:1], 3, axis=0), "windows: all windows are equal"),
        (motions[:1], "windows: all windows are equal"),
        (motions * np.nan, "windows: nan at index"),
    ):
        with pytest.raises(ValueError, match=f"^{message}"):
            fit_pca(wrong, PLAIN, n_components=2)
    with pytest.raises(ValueError, match=r"^n_components: expected a positive integer"):
        fit_pca(motions, PLAIN, n_components=0)
    fitted = fit_pca(motions, PLAIN, n_components=2)
    with pytest.raises(ValueError, match=r"^features: expected shape \(n, T, 6\)"):
        fitted.project(motions[0])
    with pytest.raises(ValueError, match=r"^code: expected shape \(n, T, 2\)"):
        fitted.decode(np.zeros((1, 1, 3)), 8)
    with pytest.raises(ValueError, match=r"^n_frames: 1 windows have 8 frames"):
        fitted.decode(np.zeros((1, 1, 2)), 9)
