"""Interpolate two motions, in the hidden space of a manifold or by blending features."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss.validation import Array, is_real, real_array

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch

__all__ = ["blend", "interpolate"]


def blend(first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Array:
    """Blend motions or codes linearly: (1 - share) first + share second.

    Parameters
    ----------
    first, second : array_like
        Arrays of the same shape.
    share : float
        Share of the second, from 0 to 1.

    Returns
    -------
    ndarray
        The blend, of the same shape.

    Raises
    ------
    TypeError, ValueError
        If the shapes differ, or the share is invalid.

    Examples
    --------
    >>> blend([0.0, 2.0], [4.0, 4.0], 0.25)
    array([1. , 2.5])
    """
    a, b = real_array("first", first), real_array("second", second)
    if a.shape != b.shape:
        raise ValueError(f"second: shape {b.shape} differs from shape {a.shape} of first")
    if not is_real(share):
        raise TypeError(f"share: expected a number from 0 to 1, got {share!r}")
    if not 0 <= share <= 1:
        raise ValueError(f"share: expected a number from 0 to 1, got {share!r}")
    blended: Array = (1 - share) * a + share * b
    return blended


def interpolate(projector: Projector, first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Array:
    """Blend two motions in the hidden space.

    For a linear manifold such as principal components, the result is only the projection of the linear blend.

    Parameters
    ----------
    projector : Projector
        The manifold.
    first, second : (n, T, F) array_like
        The motions.
    share : float
        Share of the second, from 0 to 1; 0 and 1 give the projections of the first and of the second.

    Returns
    -------
    (n, T, F) ndarray
        The blended motions.

    Raises
    ------
    TypeError, ValueError
        If the motions are invalid, their shapes differ, or the share is not from 0 to 1.
    """
    code = blend(projector.encode(first), projector.encode(second), share)
    return projector.decode(code, np.shape(first)[1])
