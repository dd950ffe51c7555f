"""Motion out of nothing: codes drawn at random, and the motion that excites a single hidden unit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, Seed, generator, one_of, positive_integer, real_array, renamed
from npss_baselines.manifold.model.projector import Projector

#: What codes are drawn from. ``uniform``: each unit at each step uniformly from [-1, 1], the prior that the paper
#: names. ``range``: uniformly between the least and the greatest value that the unit takes in real motion. ``values``:
#: from the values that it takes. In all three, units and steps know nothing of each other.
PRIORS = ("uniform", "range", "values")


@renamed(rng="seed")
def sample_codes(codes: npt.ArrayLike, n: int, *, prior: str = "uniform", seed: Seed) -> Float64:
    """Draw codes.

    Parameters
    ----------
    codes : (N, T', H) array_like
        Those of real motion, of the same length: their shape, and for the other priors than the first, their values.
    n : int
        How many to draw.
    prior : {'uniform', 'range', 'values'}, optional
        What from; see `PRIORS`.
    seed : int or numpy.random.Generator
        Where randomness comes from.

    Returns
    -------
    (n, T', H) ndarray of float64
        Codes, for `Projector.decode`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.

    Examples
    --------
    >>> import numpy as np
    >>> sample_codes(np.zeros((5, 20, 256)), 3, seed=0).shape
    (3, 20, 256)
    """
    real = real_array("codes", codes)
    if real.ndim != 3 or 0 in real.shape:
        raise ValueError(f"codes: expected shape (N, T', H) = (motions, steps, units), got {real.shape}")
    one_of("prior", prior, PRIORS)
    shape = (positive_integer("n", n), *real.shape[1:])
    rng = generator(seed)
    if prior == "values":
        rows = real.reshape(-1, real.shape[-1])
        return rows[rng.integers(len(rows), size=shape), np.arange(shape[-1])].astype(np.float64)
    low, high = (-1.0, 1.0) if prior == "uniform" else (real.min(axis=(0, 1)), real.max(axis=(0, 1)))
    return rng.uniform(low, high, shape)


def filter_motion(
    projector: Projector, code_shape: tuple[int, int], unit: int, n_frames: int, *, largest: float = 0.15
) -> Array:
    """Return the motion that excites a hidden unit: what the inverse makes of it alone, in the middle of the time.

    Parameters
    ----------
    projector : Projector
        The manifold.
    code_shape : (int, int)
        Steps T' and units H of its codes for so many frames.
    unit : int
        Which.
    n_frames : int
        Frames to decode.
    largest : float, optional
        One unit alone moves little: what it adds to the motion of a code of zeros is scaled until the largest change of
        a feature is this.

    Returns
    -------
    (T, F) ndarray
        Features of the frames that it changes, by a tenth of the largest change or more.

    Raises
    ------
    ValueError
        If there is no such unit, or it changes nothing.
    """
    steps, units = code_shape
    if not 0 <= unit < units:
        raise ValueError(f"unit: expected one of 0 to {units - 1}, got {unit}")
    codes = np.zeros((2, steps, units))
    codes[1, steps // 2, unit] = 0.5
    rest, excited = projector.decode(codes, n_frames)
    change = np.abs(excited - rest).max(axis=1)
    if not change.any():
        raise ValueError(f"unit: {unit} changes nothing")
    frames = np.flatnonzero(change >= change.max() / 10)
    motion: Array = (rest + (excited - rest) * (largest / change.max()))[frames[0] : frames[-1] + 1]
    return motion
