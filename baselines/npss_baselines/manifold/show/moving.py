"""Interpolations as moving figures, side by side."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Float64
from npss_baselines.manifold.applications.interpolate import interpolate
from npss_baselines.manifold.model.projector import Projector
from npss_baselines.manifold.motion.features import to_positions

__all__ = ["moving_interpolations"]

#: The height of a figure, in millimetres.
HEIGHT = 1700.0


def moving_interpolations(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    share: float = 0.5,
    *,
    projector: Projector | None = None,
    names: tuple[str, str] = ("first", "second"),
) -> dict[str, Float64]:
    """Return two motions, and interpolations between them, for a page of moving skeletons.

    Parameters
    ----------
    first, second : (T, F) array_like
        Features of the motions, of the joints of `npss_baselines.data.motion.JOINTS`.
    share : float, optional
        Share of the second, from 0 to 1.
    projector : Projector, optional
        A manifold, to interpolate in its hidden space, too: as decoded, and made possible.
    names : (str, str), optional
        The labels of the motions.

    Returns
    -------
    dict of str to (T, 20, 3) ndarray
        World positions in millimetres by label: the first motion, ``linear``, ``slerp`` with lengths and contacts (the
        default of `interpolate`), ``manifold`` and ``manifold, possible`` if there is one, and the second motion.

    Raises
    ------
    TypeError, ValueError
        As `interpolate`.

    Examples
    --------
    >>> from npss_baselines.data.synthetic import synthetic_clips
    >>> from npss_baselines.data.synthetic_jump import jump_clip
    >>> from npss_baselines.manifold.motion.dataset import prepare
    >>> walk, jump = prepare([next(synthetic_clips(1, 160, seed=0)), jump_clip(160)]).windows
    >>> list(moving_interpolations(walk, jump, names=("walk", "jump")))
    ['walk', 'linear, 0.5', 'slerp, possible, 0.5', 'jump']
    """
    one, other = (np.asarray(motion, np.float64)[np.newaxis] for motion in (first, second))
    features = {
        names[0]: one,
        f"linear, {share:g}": interpolate(None, one, other, share, way="linear", constrained=False),
    }
    features[f"slerp, possible, {share:g}"] = interpolate(None, one, other, share)
    if projector is not None:
        for variant, constrained in (("", False), (", possible", True)):
            blended = interpolate(projector, one, other, share, way="manifold", constrained=constrained)
            features[f"manifold{variant}, {share:g}"] = blended
    features[names[1]] = other
    return {name: HEIGHT * to_positions(motion[0].astype(np.float64)) for name, motion in features.items()}
