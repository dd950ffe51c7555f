"""The first two columns of rotation matrices: both layouts, Gram-Schmidt, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss.rotations import expmap_to_matrix, geodesic_angle, matrix_to_sixd, sixd_to_matrix
from rotation_strategies import both_precisions, converter, expmaps, sample

#: The six entries of a matrix, row and column, in the order of a layout.
ORDER = {
    "columns": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)],
    "rows": [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)],
}
every_layout = pytest.mark.parametrize("layout", ORDER)
finite = st.floats(-1e3, 1e3).map(lambda x: round(x, 3))


def gram_schmidt(first, second):
    """Return the matrix of two vectors, one projection after the other."""
    x = first / np.linalg.norm(first)
    y = second - (x @ second) * x
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


@pytest.mark.numeric
@every_layout
def test_entries_of_the_matrix(layout):
    R = sample("matrix", (50,))
    expected = np.stack([R[:, i, j] for i, j in ORDER[layout]], axis=-1)
    # Through a quaternion: twice the sum of two products of factors of at most 1, with about four roundings each.
    np.testing.assert_allclose(matrix_to_sixd(R, layout=layout), expected, rtol=0, atol=16 * np.finfo(float).eps / 2)


@pytest.mark.numeric
@every_layout
@given(st.lists(finite, min_size=6, max_size=6))
def test_any_two_vectors_against_gram_schmidt(layout, values):
    R = np.zeros((3, 2))
    for value, place in zip(values, ORDER[layout], strict=True):
        R[place] = value
    first, second = R.T
    lengths = np.linalg.norm(first) * np.linalg.norm(second)
    sine = np.linalg.norm(np.cross(first, second)) / lengths if lengths else 0
    if sine < 1e-9:
        return
    got = sixd_to_matrix(values, layout=layout)
    # The projection loses digits as the two vectors become parallel, the library's cross products nearly as many.
    np.testing.assert_allclose(got, gram_schmidt(first, second), rtol=0, atol=1e-14 / sine)


@pytest.mark.numeric
@every_layout
@both_precisions
@given(v=expmaps())
def test_every_form_and_back(layout, dtype, v):
    R = expmap_to_matrix(v.astype(dtype))
    sixd = matrix_to_sixd(R, layout=layout)
    for form in ("expmap", "quaternion", "euler"):
        back = converter(form, "sixd")(converter("sixd", form)(sixd, layout=layout), layout=layout)
        assert geodesic_angle(sixd_to_matrix(back, layout=layout), R).max() < 60 * np.finfo(dtype).eps


@pytest.mark.numeric
@pytest.mark.parametrize("sizes", [(5e-324, 1), (1e-310, 1e308), (1.7e308, 1.7e308), (1, 1e-200)])
def test_lengths_do_not_matter(sizes):
    given_ = np.array([0, 1, 0, -1, 0, 0]) * np.repeat(sizes, 3)
    np.testing.assert_array_equal(sixd_to_matrix(given_), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])


@pytest.mark.parametrize(("layout", "first"), [("columns", [0, 1, 2]), ("rows", [0, 2, 4])])
def test_a_zero_column(layout, first):
    values = np.ones((4, 5, 6))
    values[2, 3, first] = 0
    values[:2, :, first[0]] = values[2, :3, first[0]] = 3
    with pytest.raises(ValueError, match=r"^sixd: a zero column, not that of a rotation, at index \(2, 3\)$"):
        sixd_to_matrix(values, layout=layout)


@pytest.mark.parametrize("factor", [1, -1, 0.3, 1e-200, 1e200])
@both_precisions
def test_parallel_columns(factor, dtype):
    factor = np.clip(factor, -(2.0**100), 2.0**100) if dtype is np.float32 else factor
    values = np.concatenate([[0.1, 0.7, -0.3], np.multiply(factor, [0.1, 0.7, -0.3])]).astype(dtype)
    with pytest.raises(ValueError, match=r"^sixd: (two parallel columns|a zero column)"):
        sixd_to_matrix(values)


def test_layouts_that_are_none():
    with pytest.raises(ValueError, match=r"^layout: expected one of columns, rows, got 'row'"):
        sixd_to_matrix(np.ones(6), layout="row")
    with pytest.raises(TypeError, match=r"^layout: expected one of columns, rows, got 1"):
        matrix_to_sixd(np.eye(3), layout=1)
