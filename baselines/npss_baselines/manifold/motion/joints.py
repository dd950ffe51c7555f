"""Checks of joint positions and joint names, for error messages."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Float64, check_finite, real_array


def positions_of(positions: npt.ArrayLike, skeleton: Skeleton) -> Float64:
    """Read positions (..., T, J, 3) of the joints of a skeleton, as float64."""
    array = real_array("positions", positions)
    if array.ndim < 3 or array.shape[-2:] != (len(skeleton.names), 3) or 0 in array.shape:
        raise ValueError(f"positions: expected shape (..., T, {len(skeleton.names)}, 3), got {array.shape}")
    check_finite("positions", array)
    return array.astype(np.float64)


def joint_named(name: str, skeleton: Skeleton, joint: str) -> int:
    """Return the index of a joint; `name` is the argument's, for the error message."""
    if joint not in skeleton.names:
        raise ValueError(f"{name}: the skeleton has no joint {joint!r}; it has {', '.join(skeleton.names)}")
    return skeleton.names.index(joint)


def first_frame(where: npt.NDArray[np.bool_]) -> int | tuple[int, ...]:
    """Return the index of the first true frame; for a single motion, as a number."""
    index = tuple(int(i) for i in np.argwhere(where)[0])
    return index[0] if len(index) == 1 else index
