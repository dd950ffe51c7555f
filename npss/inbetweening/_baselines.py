"""The two baselines of in-betweening tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from npss.inbetweening._motion import Local
from npss.inbetweening._windows import Transition
from npss.rotations import slerp

_LINEAR_ABOVE = 0.99  # the benchmark interpolates linearly where a dot product exceeds this


def zero_velocity(parts: Transition) -> Local:
    """Hold the last past frame.

    Parameters
    ----------
    parts : Transition
        The parts of windows, from `transition`.

    Returns
    -------
    Local
        The prediction, with the shapes of ``parts.truth``.

    Raises
    ------
    AttributeError
        If it is not a `Transition`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, transition, zero_velocity
    >>> root = np.arange(25.0)[:, np.newaxis] * [1, 0, 0]
    >>> parts = transition(Local(np.ones((1, 25, 22, 4)), root[np.newaxis]), 5)
    >>> zero_velocity(parts).root[0, :, 0].tolist()
    [9.0, 9.0, 9.0, 9.0, 9.0]
    """
    quaternions, root = parts.past
    return Local(
        np.repeat(quaternions[:, -1:], parts.n_frames, axis=1), np.repeat(root[:, -1:], parts.n_frames, axis=1)
    )


def interpolation(parts: Transition) -> Local:
    """Interpolate between the last past frame and the target: the root linearly, local rotations on the sphere.

    Parameters
    ----------
    parts : Transition
        The parts of windows, from `transition`.

    Returns
    -------
    Local
        The prediction, with the shapes of ``parts.truth``.

    Raises
    ------
    AttributeError
        If it is not a `Transition`.

    Notes
    -----
    Slerp along the shorter arc, linear where the dot product of two quaternions exceeds 0.99, normalised; weights in
    float32, as in the benchmark. Of n + 2 frames with both ends, the inner n are returned.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020, and its benchmark.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, interpolation, transition
    >>> root = np.arange(25.0)[:, np.newaxis] ** 2 * [1, 0, 0]
    >>> parts = transition(Local(np.ones((1, 25, 22, 4)), root[np.newaxis]), 5)
    >>> interpolation(parts).root[0, :, 0].round(3).tolist()  # from 81 to 225
    [105.0, 129.0, 153.0, 177.0, 201.0]
    """
    weights = np.linspace(0, 1, parts.n_frames + 2, dtype=np.float32)[1:-1].astype(np.float64)
    (first, start), (last, end) = parts.past, parts.future
    step = end[:, np.newaxis, 0] - start[:, np.newaxis, -1]
    root = start[:, np.newaxis, -1] + weights[:, np.newaxis] * step
    return Local(slerp(first[:, -1], last[:, 0], weights, axis=1, linear_above=_LINEAR_ABOVE), root)


#: The baselines by their names in tables.
BASELINES: Mapping[str, Callable[[Transition], Local]] = MappingProxyType(
    {"zero-velocity": zero_velocity, "interpolation": interpolation}
)
