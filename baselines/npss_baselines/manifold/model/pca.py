"""Principal components of windows: the linear baseline of the manifold."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, positive_integer
from npss_baselines.manifold.model.projector import mirrored, motions_of
from npss_baselines.manifold.motion.scaling import Scaling


@dataclass(frozen=True, eq=False)
class PCA:
    """Principal components as a `npss_baselines.manifold.model.projector.Projector`.

    The code of a motion has a row for each window of `window` frames; windows overlap by half, and overlapping
    reconstructions are averaged. Motion that does not fill a window is mirrored at its end, and cut again.

    Attributes
    ----------
    window : int
        Frames in a window; even.
    mean : (window * F,) ndarray
        Mean of the scaled windows.
    components : (k, window * F) ndarray
        Orthonormal components, largest variance first.
    scaling : Scaling
        Scaling of the features, which weights their errors.
    """

    window: int
    mean: Float64
    components: Float64
    scaling: Scaling

    @property
    def signature(self) -> str:
        """The identity of the components, to the bit."""
        arrays = (self.mean, self.components, self.scaling.mean, self.scaling.scale)
        digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()
        return f"pca-{len(self.components)}-{digest[:12]}"

    def encode(self, features: npt.ArrayLike) -> Array:
        """Return the code (n, W, k) of motions (n, T, F) with W windows, float64."""
        step, n_features = self.window // 2, len(self.scaling.mean)
        motions = mirrored(motions_of(features, n_features), step, least=self.window)
        scaled = self.scaling.normalize(motions)
        starts = range(0, scaled.shape[1] - step, step)
        windows = np.stack(
            [scaled[:, start : start + self.window].reshape(len(scaled), -1) for start in starts], axis=1
        )
        code: Array = (windows - self.mean) @ self.components.T
        return code

    def decode(self, code: npt.ArrayLike, n_frames: int) -> Array:
        """Return the motions (n, n_frames, F) of codes (n, W, k), float64.

        Raises
        ------
        TypeError, ValueError
            If the shape of the codes is wrong, or they have fewer frames.
        """
        step = self.window // 2
        rows = motions_of(code, len(self.components), name="code")
        available = (rows.shape[1] + 1) * step
        if positive_integer("n_frames", n_frames) > available:
            raise ValueError(f"n_frames: {rows.shape[1]} windows have {available} frames, got {n_frames}")
        windows = (rows @ self.components + self.mean).reshape(*rows.shape[:2], self.window, -1)
        total = np.zeros((len(rows), available, windows.shape[-1]))
        count = np.zeros((available, 1))
        for i in range(rows.shape[1]):
            total[:, i * step : i * step + self.window] += windows[:, i]
            count[i * step : i * step + self.window] += 1
        return self.scaling.unnormalize((total / count)[:, :n_frames])

    def project(self, features: npt.ArrayLike) -> Array:
        """Project motions (n, T, F): encode and decode them, in float64."""
        return self.decode(self.encode(features), np.shape(features)[1])


def fit_pca(windows: npt.ArrayLike, scaling: Scaling, *, n_components: int) -> PCA:
    """Fit principal components to windows.

    Parameters
    ----------
    windows : (n, T, F) array_like
        Features of motion; T is even. Mirrored padding of short clips counts, since windows are fitted whole.
    scaling : Scaling
        Scaling of the network to compare with.
    n_components : int
        Largest number of components; 20 x 256 gives codes of the network's size. At most the number of directions in
        which windows vary, itself at most n - 1.

    Returns
    -------
    PCA
        The components.

    Raises
    ------
    TypeError, ValueError
        If the windows are invalid or all equal, or the number is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> windows = rng.normal(size=(20, 2)) @ rng.normal(size=(2, 160 * 6))  # two directions
    >>> pca = fit_pca(windows.reshape(20, 160, 6), Scaling(np.zeros(6), np.ones(6)), n_components=5120)
    >>> len(pca.components)
    2
    """
    array = motions_of(windows, len(scaling.mean), name="windows")
    if array.shape[1] % 2:
        raise ValueError(f"windows: expected an even number of frames, got {array.shape[1]}")
    positive_integer("n_components", n_components)
    rows = scaling.normalize(array).reshape(len(array), -1)
    mean = rows.mean(axis=0)
    rows -= mean
    # Both Gram matrices have the same non-zero eigenvalues; decompose the smaller one.
    few = len(rows) < rows.shape[1]
    power, vectors = np.linalg.eigh(rows @ rows.T if few else rows.T @ rows)  # the largest last
    eps = np.finfo(np.float64).eps
    kept = power > eps * max(rows.shape) * max(power[-1], eps * len(rows) * (mean @ mean))  # the rest is rounding
    if not kept.any():
        raise ValueError("windows: all windows are equal")
    chosen = np.flatnonzero(kept)[::-1][:n_components]
    components = vectors[:, chosen].T
    if few:
        components = components @ rows / np.sqrt(power[chosen])[:, np.newaxis]
    return PCA(array.shape[1], mean, components, scaling)
