"""Read and write the first two columns of rotation matrices, which a network can return without constraints ("6D")."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from npss.rotations._blocks import BadRotationError, Columns, require_finite
from npss.rotations._forms import Form, Quaternion
from npss.rotations._matrix import cross, dot, longest_quaternion, write_matrix
from npss.validation import one_of

#: The order of the six numbers: column by column, or row by row of the 3 x 2 matrix.
Layout = Literal["columns", "rows"]
COLUMNS: Layout = "columns"
#: Where the entries of the first column, then of the second, are found.
_PLACES = {"columns": ((0, 1, 2), (3, 4, 5)), "rows": ((0, 2, 4), (1, 3, 5))}


def sixd_form(layout: str) -> Form:
    """Return the form of a layout.

    Raises
    ------
    TypeError, ValueError
        If it is not a layout.
    """
    one_of("layout", layout, get_args(Layout))
    places = _PLACES[layout]

    def read(columns: Columns, given: np.dtype[Any]) -> Quaternion:
        require_finite(columns)
        first, second = (_unit(tuple(columns[i] for i in place)) for place in places)
        third = cross(first, second)
        sine = np.sqrt(dot(third, third))
        apart = sine > 16 * np.finfo(sine.dtype).eps  # below, the direction of the product is that of rounding errors
        if not apart.all():
            raise BadRotationError(int(np.argmin(apart)), "two parallel columns, not those of a rotation,")
        third = tuple(column / sine for column in third)
        second = cross(third, first)
        return longest_quaternion(tuple(column for row in zip(first, second, third, strict=True) for column in row))

    def write(quaternion: Quaternion, outputs: Columns) -> None:
        entries = {3 * i + j: outputs[place[i]] for j, place in enumerate(places) for i in range(3)}
        write_matrix(quaternion, tuple(entries.get(i, np.empty_like(outputs[0])) for i in range(9)))

    return Form((6,), read, write)


def _unit(vector: Columns) -> Columns:
    """Scale to unit length, first by the largest component, so that no square is out of range."""
    largest = np.maximum(np.maximum(np.abs(vector[0]), np.abs(vector[1])), np.abs(vector[2]))
    if not largest.all():
        raise BadRotationError(int(np.argmin(largest)), "a zero column, not that of a rotation,")
    exponent = -np.frexp(largest)[1]
    scaled = tuple(np.ldexp(column, exponent) for column in vector)
    length = np.sqrt(dot(scaled, scaled))
    return tuple(column / length for column in scaled)
