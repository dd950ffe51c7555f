"""The error of rotations: the angle between predicted and true orientations of joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.joints import joint_pair
from npss._metric.times import Average, check_average, errors_at, frames_at
from npss.rotations._angle import Representation, angle_between, rotation_form
from npss.rotations._euler import H36M
from npss.rotations._sixd import COLUMNS, Layout
from npss.validation import Float64, one_of

#: The unit of angles.
Unit = Literal["rad", "deg"]


def rotation_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    representation: Representation,
    unit: Unit = "rad",
    fps: float = 25,
    at_ms: Sequence[float] = (80, 160, 320, 400, 560, 1000),
    average: Average = "at",
    joints: Sequence[int] | None = None,
    seq: str = H36M,
    layout: Layout = COLUMNS,
) -> dict[float, float]:
    """Return the mean angle between predicted and true rotations of joints at given times.

    Parameters
    ----------
    gt, pred : (N, T, J, n), (N, T, n J) or (T, n J) array_like
        Rotations of J joints, local or global; for matrices ``(N, T, J, 3, 3)``, or flattened.
    representation : {'expmap', 'matrix', 'quaternion', 'sixd', 'euler'}
        The representation of both.
    unit : {'rad', 'deg'}, optional
        Radians or degrees.
    fps, at_ms, average
        As for `position_error`.
    joints : sequence of int, optional
        Indices of the joints to average (default: all).
    seq : str, optional
        The sequence of Euler angles, as in `npss.rotations.expmap_to_euler`.
    layout : {'columns', 'rows'}, optional
        The layout of 6D columns, as in `npss.rotations.sixd_to_matrix`.

    Returns
    -------
    dict of float to float
        The error at each time in `unit`; whole numbers of milliseconds are ints.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If a shape is wrong or differs, a value is not finite or not a rotation, an option is invalid, or a time is not
        that of a frame. The message then names the nearest times.

    See Also
    --------
    npss.rotations.relative_angle : the angle of each joint.

    Notes
    -----
    Sign it with ``npss.signature(None, metric="rotation_error", average=..., extra={"unit": ...})``. With
    ``average="sum"``, it is the joint angle difference of AMASS's tables (Aksan et al., ICCV 2019).

    References
    ----------
    D. Q. Huynh, "Metrics for 3D Rotations: Comparison and Analysis", JMIV 2009, distance 6. E. Aksan, M. Kaufmann,
    O. Hilliges, "Structured Prediction Helps 3D Human Motion Modelling", ICCV 2019.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.zeros((1, 25, 3))  # one joint
    >>> pred = gt + np.linspace(0, np.pi / 2, 25)[:, np.newaxis] * [0, 0, 1]
    >>> errors = npss.rotation_error(gt, pred, representation="expmap", unit="deg", at_ms=[1000])
    >>> round(errors[1000], 9)
    90.0
    """
    one_of("unit", unit, get_args(Unit))
    check_average(average)
    errors = sequence_rotation_errors(
        gt, pred, representation=representation, joints=joints, seq=seq, layout=layout
    ).mean(axis=0)
    if unit == "deg":
        errors = np.degrees(errors)
    return errors_at(errors, frames_at(at_ms, fps, len(errors)), average)


def sequence_rotation_errors(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    representation: Representation,
    joints: Sequence[int] | None = None,
    seq: str = H36M,
    layout: Layout = COLUMNS,
) -> Float64:
    """Return the error of every frame of every sequence in radians, ``(N, T)``."""
    form = rotation_form(representation, seq=seq, layout=layout)
    truth, prediction = joint_pair(gt, pred, form.shape, joints)
    errors: Float64 = angle_between(truth, prediction, form, ("gt", "pred"), np.dtype(np.float64)).mean(axis=-1)
    return errors
