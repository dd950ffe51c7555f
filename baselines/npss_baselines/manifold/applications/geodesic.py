"""The geodesic distance: the length of the shortest path between two motions along the manifold."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from npss.validation import Array, Float64, check_finite, positive_integer, real_array
from npss_baselines.manifold.model.projector import Manifold

__all__ = ["Geodesic", "geodesic", "geodesic_between"]

#: Pieces of a path, and iterations to shorten it.
PIECES, ITERATIONS = 8, 20


class Geodesic(NamedTuple):
    """A path along a manifold.

    Attributes
    ----------
    length : float
        The length of the path, in the unit of what the decoder returns.
    straight : float
        The length of the decoded line between the codes, from which the path began.
    codes : (pieces + 1, ...) ndarray of float64
        The codes of the points of the path, ends included.
    """

    length: float
    straight: float
    codes: Float64


def geodesic(
    decode: Callable[[Tensor], Tensor],
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    *,
    pieces: int = PIECES,
    iterations: int = ITERATIONS,
) -> Geodesic:
    r"""Find a shortest path between two codes, measured where they are decoded.

    The points of the path begin on the line between the codes. They move to minimise the energy of the decoded path,
    the sum of its squared pieces, whose minimum is a path of least length with pieces of equal length:

    .. math:: E(z) = \sum_i \lVert D(z_{i+1}) - D(z_i) \rVert_2^2

    Parameters
    ----------
    decode : callable
        The decoder D, differentiable, from codes ``(m, ...)`` to points ``(m, ...)``, as float64 tensors.
    first, second : (...) array_like
        The codes, of the same shape.
    pieces : int, optional
        Pieces of the path. A piece is straight, so that the length is at most that of the curve; the error falls with
        the square of their number.
    iterations : int, optional
        Largest number of iterations of L-BFGS.

    Returns
    -------
    Geodesic
        The path and its length, never longer than the decoded line.

    Raises
    ------
    TypeError, ValueError
        If the codes are invalid, their shapes differ, or a number is not positive.

    Notes
    -----
    A minimum may be local. The path need not lie on the manifold of motion that was seen, only on that of the decoder.

    References
    ----------
    G. Arvanitidis, L. K. Hansen and S. Hauberg, "Latent Space Oddity: on the Curvature of Deep Generative Models",
    ICLR 2018, for the metric of a decoder.

    Examples
    --------
    On a cylinder's surface, by angle and height, a quarter of a turn has the length of its arc, not of its chord:

    >>> def cylinder(z):
    ...     return torch.stack([z[:, 0].cos(), z[:, 0].sin(), z[:, 1]], dim=1)
    >>> path = geodesic(cylinder, [0.0, 0.0], [np.pi / 2, 0.0], pieces=32)
    >>> f"{path.length:.3f}, not {np.sqrt(2):.3f}"
    '1.571, not 1.414'
    """
    ends = [_code(name, code) for name, code in (("first", first), ("second", second))]
    if ends[0].shape != ends[1].shape:
        raise ValueError(f"second: shape {ends[1].shape} differs from shape {ends[0].shape} of first")
    start, end = map(torch.from_numpy, ends)
    shares = torch.linspace(0, 1, positive_integer("pieces", pieces) + 1, dtype=torch.float64)
    line = torch.stack([(1 - share) * start + share * end for share in shares])
    inner = line[1:-1].clone().requires_grad_()

    def steps() -> Tensor:
        points = decode(torch.cat([line[:1], inner, line[-1:]]))
        return (points[1:] - points[:-1]).flatten(1)

    straight = float(steps().detach().norm(dim=1).sum())
    length = straight
    if pieces > 1 and straight > 0:
        optimizer = torch.optim.LBFGS(
            [inner], max_iter=positive_integer("iterations", iterations), line_search_fn="strong_wolfe"
        )

        def energy() -> Tensor:
            optimizer.zero_grad()
            value = pieces * steps().square().sum() / straight**2
            value.backward()  # type: ignore[no-untyped-call]
            return value

        optimizer.step(energy)  # type: ignore[no-untyped-call]
        length = float(steps().detach().norm(dim=1).sum())
        if not length < straight:  # rounding, or no progress
            length, inner = straight, line[1:-1]
    codes: Float64 = torch.cat([line[:1], inner.detach(), line[-1:]]).numpy()
    return Geodesic(length, straight, codes)


def geodesic_between(
    manifold: Manifold,
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    *,
    pieces: int = PIECES,
    iterations: int = ITERATIONS,
) -> Geodesic:
    """Find a shortest path between two motions along a manifold.

    Parameters
    ----------
    manifold : Manifold
        The manifold.
    first, second : (T, F) array_like
        The motions, of the same length.
    pieces, iterations : int, optional
        As for `geodesic`.

    Returns
    -------
    Geodesic
        The path between their projections; lengths are in the unit of scaled features.

    Raises
    ------
    TypeError, ValueError
        As `geodesic`.
    """
    codes = [manifold.encode(np.asarray(motion)[np.newaxis])[0] for motion in (first, second)]
    parameter = next(manifold.network.parameters())

    def decode(points: Tensor) -> Tensor:
        return manifold.network.decode(points.to(parameter)).to(points)

    return geodesic(decode, *codes, pieces=pieces, iterations=iterations)


def _code(name: str, values: npt.ArrayLike) -> Float64:
    array: Array = real_array(name, values)
    check_finite(name, array)
    return array.astype(np.float64)
