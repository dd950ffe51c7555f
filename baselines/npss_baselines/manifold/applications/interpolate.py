"""Between two motions: in the hidden space of a manifold, or by blending features."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, is_real, real_array
from npss_baselines.manifold.model.projector import Projector


def blend(first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Array:
    """Return (1 - share) first + share second: linear blending of motions, or of codes.

    Parameters
    ----------
    first, second : array_like
        Of the same shape.
    share : float
        Of the second, from 0 to 1.

    Raises
    ------
    TypeError, ValueError
        If the shapes differ, or the share is not as described.

    Examples
    --------
    >>> blend([0.0, 2.0], [4.0, 4.0], 0.25)
    array([1. , 2.5])
    """
    a, b = real_array("first", first), real_array("second", second)
    if a.shape != b.shape:
        raise ValueError(f"second: its shape {b.shape} differs from that of first, {a.shape}")
    if not is_real(share):
        raise TypeError(f"share: expected a number from 0 to 1, got {share!r}")
    if not 0 <= share <= 1:
        raise ValueError(f"share: expected a number from 0 to 1, got {share!r}")
    blended: Array = (1 - share) * a + share * b
    return blended


def interpolate(projector: Projector, first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Array:
    """Blend two motions in the hidden space.

    For a linear manifold, principal components, this is the projection of the linear blend, and nothing more.

    Parameters
    ----------
    projector : Projector
        The manifold.
    first, second : (n, T, F) array_like
        The motions.
    share : float
        Of the second, from 0 to 1; at 0 and 1 the result is the projection of the first and of the second.

    Returns
    -------
    (n, T, F) ndarray
        Motions.

    Raises
    ------
    TypeError, ValueError
        If the motions are not as described, their shapes differ, or the share is not from 0 to 1.
    """
    code = blend(projector.encode(first), projector.encode(second), share)
    return projector.decode(code, np.shape(first)[1])
