"""The shared docstrings of the conversions: parameters, results and errors of each representation."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Described:
    """The description of a representation."""

    argument: str
    given: str
    refused: str
    returned: str


EXPMAP = Described(
    argument="v",
    given="""\
v : (..., 3) array_like
    Rotation vectors: axis times angle in radians. Any angle below 2**52.""",
    refused="an angle is too large",
    returned="""\
(..., 3) ndarray
    Rotation vectors in radians, of length in [0, pi]; at pi, where v and -v are the same rotation, the first nonzero
    component is positive.""",
)
MATRIX = Described(
    argument="R",
    given="""\
R : (..., 3, 3) array_like
    Rotation matrices. Entries of ``R @ R.T`` must be within 1e-6 of the identity in double precision (and for
    integers), 1e-4 in single and 1e-2 in half precision, and the determinant must be positive.""",
    refused="a matrix is not a rotation",
    returned="""\
(..., 3, 3) ndarray
    Matrices R that rotate column vectors, ``R @ x``.""",
)
QUATERNION = Described(
    argument="q",
    given="""\
q : (..., 4) array_like
    Quaternions in the order w, x, y, z, of any nonzero length; q and -q are the same rotation.""",
    refused="a quaternion is zero",
    returned="""\
(..., 4) ndarray
    Unit quaternions in the order w, x, y, z, with w >= 0; if w is 0, the first nonzero component is positive.""",
)
EULER = Described(
    argument="angles",
    given="""\
angles : (..., 3) array_like
    Angles in radians, in the order of the letters; any finite value.""",
    refused="",
    returned="""\
(..., 3) ndarray
    Angles in radians in the order of the letters; the outer ones in [-pi, pi], the middle one in [-pi/2, pi/2], or in
    [0, pi] if the first letter is also the last. At gimbal lock the third is zero.""",
)
SIXD = Described(
    argument="sixd",
    given="""\
sixd : (..., 6) array_like
    The first two columns of rotation matrices, of any nonzero length and angle, as a network returns them: the second
    is made perpendicular to the first (Gram-Schmidt).""",
    refused="a column is zero or parallel to the other",
    returned="""\
(..., 6) ndarray
    The first two columns of the rotation matrices.""",
)
_LAYOUT = """
layout : {'columns', 'rows'}, optional
    ``'columns'``: one column after the other, R00 R10 R20 R01 R11 R21. ``'rows'``: interleaved, the rows of the 3 x 2
    matrix, R00 R01 R10 R11 R20 R21."""
_SEQ = """
seq : str
    As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic."""
_CONTINUOUS = """

See Also
--------
continuous : remove sign flips between frames, before scoring."""


def conversion(source: Described, target: Described) -> Callable[[Function], Function]:
    """Replace ``{contract}`` in the docstring of a conversion by its parameters, results and errors."""
    options = [(EULER, "seq", _SEQ, "not a sequence"), (SIXD, "layout", _LAYOUT, "neither of the two")]
    options = [option for option in options if option[0] in (source, target)]
    bad_options = "".join(f", or `{name}` is {bad}" for _, name, _, bad in options)
    not_text = "".join(f", or `{name}` is not a string" for _, name, _, _ in options)
    see_also = _CONTINUOUS if target is QUATERNION else ""
    bad_rotation = f", or {source.refused}" if source.refused else ""
    contract = f"""\
Parameters
----------
{source.given}{"".join(text for _, _, text, _ in options)}

Returns
-------
{target.returned}
    float32 for float32, float64 otherwise.

Raises
------
TypeError
    If `{source.argument}` is not an array of real numbers{not_text}.
ValueError
    If the shape is wrong, a value is not finite{bad_rotation} (the message names the first
    index){bad_options}.{see_also}"""

    def write(function: Function) -> Function:
        if function.__doc__ is not None:  # `python -OO` removes docstrings
            function.__doc__ = inspect.cleandoc(function.__doc__).replace("{contract}", contract)
        return function

    return write
