"""Sample motion from random codes, and show the motion of a single hidden unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, Seed, generator, one_of, positive_integer, real_array, renamed
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.model.prior import fit_prior
from npss_baselines.manifold.motion.contacts import contacts_of, hold_feet
from npss_baselines.manifold.motion.smooth import smoothed

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch

__all__ = ["filter_motion", "motion_of", "sample_codes"]

#: Distributions of codes. ``local``: a Gaussian around each real code, fitted to it and its nearest neighbours; see
#: `npss_baselines.manifold.model.prior`. ``uniform``: each unit at each step uniformly from [-1, 1], the paper's prior.
#: ``range``: uniformly between the unit's minimum and maximum in real motion. ``values``: from the unit's values in
#: real motion. In the last three, units and steps are independent.
PRIORS = ("local", "uniform", "range", "values")


@renamed(rng="seed")
def sample_codes(codes: npt.ArrayLike, n: int, *, prior: str = "local", seed: Seed) -> Float64:
    """Draw random codes.

    Parameters
    ----------
    codes : (N, T', H) array_like
        Codes of real motion of the same length, for their shape and, except for ``'uniform'``, their values.
    n : int
        Number of codes to draw.
    prior : {'local', 'uniform', 'range', 'values'}, optional
        Distribution to draw from; see `PRIORS`.
    seed : int or numpy.random.Generator
        Source of randomness.

    Returns
    -------
    (n, T', H) ndarray of float64
        Codes, for `Projector.decode` or `motion_of`.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid; ``'local'`` needs five codes.

    Examples
    --------
    >>> import numpy as np
    >>> sample_codes(np.zeros((5, 20, 256)), 3, prior="uniform", seed=0).shape
    (3, 20, 256)
    """
    real = real_array("codes", codes)
    if real.ndim != 3 or 0 in real.shape:
        raise ValueError(f"codes: expected shape (N, T', H) = (motions, steps, units), got {real.shape}")
    one_of("prior", prior, PRIORS)
    shape = (positive_integer("n", n), *real.shape[1:])
    if prior == "local":
        return fit_prior(real).draw(n, seed=seed)
    rng = generator(seed)
    if prior == "values":
        rows = real.reshape(-1, real.shape[-1])
        return rows[rng.integers(len(rows), size=shape), np.arange(shape[-1])].astype(np.float64)
    low, high = (-1.0, 1.0) if prior == "uniform" else (real.min(axis=(0, 1)), real.max(axis=(0, 1)))
    return rng.uniform(low, high, shape)


def motion_of(projector: Projector, codes: npt.ArrayLike, n_frames: int) -> Float64:
    """Decode codes to possible motion: smooth, with the lengths of bones, and with standing feet in place.

    Parameters
    ----------
    projector : Projector
        The manifold.
    codes : (n, T', H) array_like
        Codes, such as those of `sample_codes`.
    n_frames : int
        Frames to decode.

    Returns
    -------
    (n, n_frames, F) ndarray of float64
        Motions of the joints of `npss_baselines.data.motion.JOINTS`.

    Raises
    ------
    TypeError, ValueError
        As `Projector.decode`.
    """
    decoded = smoothed(projector.decode(codes, n_frames))
    motion = with_lengths(decoded, np.zeros(decoded.shape, bool), JOINTS)
    return hold_feet(motion, contacts_of(motion, JOINTS), JOINTS)


def filter_motion(
    projector: Projector, code_shape: tuple[int, int], unit: int, n_frames: int, *, largest: float = 0.15
) -> Array:
    """Return the motion of a hidden unit: the decoded code in which only this unit is non-zero, at the middle step.

    Parameters
    ----------
    projector : Projector
        The manifold.
    code_shape : (int, int)
        Steps T' and units H of a code for `n_frames` frames.
    unit : int
        Index of the unit.
    n_frames : int
        Frames to decode.
    largest : float, optional
        Largest change of a feature from the motion of the zero code. The change is scaled to it, since a single unit
        moves little.

    Returns
    -------
    (T, F) ndarray
        Features of the frames that change by at least a tenth of the largest change.

    Raises
    ------
    ValueError
        If the unit does not exist, or changes nothing.
    """
    steps, units = code_shape
    if not 0 <= unit < units:
        raise ValueError(f"unit: expected a number from 0 to {units - 1}, got {unit}")
    codes = np.zeros((2, steps, units))
    codes[1, steps // 2, unit] = 0.5
    rest, excited = projector.decode(codes, n_frames)
    change = np.abs(excited - rest).max(axis=1)
    if not change.any():
        raise ValueError(f"unit: {unit} changes nothing")
    frames = np.flatnonzero(change >= change.max() / 10)
    motion: Array = (rest + (excited - rest) * (largest / change.max()))[frames[0] : frames[-1] + 1]
    return motion
