"""The discrete cosine transform of short motions, as a matrix."""

from __future__ import annotations

import numpy as np

from npss.validation import Float64


def cosines(n_frames: int, n: int) -> Float64:
    """Return the first `n` functions (n, n_frames) of the orthonormal discrete cosine transform (type II).

    Examples
    --------
    >>> import numpy as np
    >>> basis = cosines(8, 3)
    >>> bool(np.allclose(basis @ basis.T, np.eye(3)))
    True
    """
    frequency, frame = np.arange(n)[:, np.newaxis], np.arange(n_frames)
    basis: Float64 = np.sqrt(2 / n_frames) * np.cos(np.pi * frequency * (2 * frame + 1) / (2 * n_frames))
    basis[0] /= np.sqrt(2)
    return basis
