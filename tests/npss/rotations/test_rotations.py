"""The contract of npss.rotations: every conversion in any shape, strides and precision."""

import tracemalloc
from functools import partial
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss import rotations
from npss.rotations import expmap_to_euler, expmap_to_matrix, geodesic_angle
from rotation_strategies import ARGUMENTS, FORMS, LETTERS, PAIRS, both_precisions, converter, expmaps, sample

every_pair = pytest.mark.parametrize(("source", "target"), PAIRS)
every_form = pytest.mark.parametrize("form", FORMS)


def same_bits(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def test_public_names():
    assert rotations.__all__ == sorted(
        [f"{a}_to_{b}" for a, b in PAIRS]
        + ["continuous", "continuous_euler", "geodesic_angle", "relative_angle", "slerp"]
    )


@every_pair
@pytest.mark.parametrize("leading", [(), (1,), (5,), (2, 3), (2, 1, 3), (0,), (2, 0), (0, 4)])
@both_precisions
def test_shape_and_dtype(source, target, leading, dtype):
    given_ = sample(source, leading, dtype=dtype)
    got = converter(source, target)(given_)
    assert given_.shape == leading + FORMS[source]
    assert got.shape == leading + FORMS[target]
    assert got.dtype == dtype
    assert got.flags.c_contiguous
    assert got.flags.owndata
    assert np.isfinite(got).all()


# Rotations in small integers, exact in every dtype.
EXACT = {
    "expmap": [[0, 1, 0], [2, 0, 1], [1, 1, 2]],
    "matrix": [[[0, 0, 1], [1, 0, 0], [0, 1, 0]], np.eye(3), [[0, 1, 0], [0, 0, 1], [1, 0, 0]]],
    "quaternion": [[1, 0, 1, 0], [0, 2, 0, 1], [1, 1, 2, 4]],
    "sixd": [[0, 1, 0, 0, 0, 1], [2, 1, 0, 0, 1, 3], [1, 1, 2, 1, 0, 0]],
    "euler": [[0, 1, 0], [2, 0, 1], [1, 1, 2]],
}
DTYPES = ["i1", "u1", "i4", ">i4", "i8", "f2", ">f2", "f4", ">f4", "f8", ">f8", "g"]


@every_pair
@pytest.mark.parametrize("leading", [(), (1,), (1, 1), (0,), (3,)])
def test_every_dtype_in_every_shape(source, target, leading):
    """A row of native floats is the reference for rotations alone, in a row, and cast."""
    calls = [converter(source, target)]
    if (source, target) == ("expmap", "euler"):
        calls.append(partial(expmap_to_euler, legacy=True))
    count = int(np.prod(leading))
    for call, dtype in product(calls, DTYPES):
        exact = np.array(EXACT[source], np.float32 if dtype in ("f4", ">f4") else np.float64)
        values = exact[:count].reshape(leading + FORMS[source]).astype(dtype)
        expected = call(exact)[:count].reshape(leading + FORMS[target])
        for same in (values, np.repeat(values, 2, axis=-1)[..., ::2]):
            for _ in range(2):  # uninitialised memory may be right by chance
                assert same_bits(call(same), expected)


@pytest.mark.numeric
@every_pair
def test_leading_axes_do_not_matter(source, target):
    flat = sample(source, (24,))
    deep = flat.reshape(2, 3, 4, *FORMS[source])
    convert = converter(source, target)
    assert same_bits(convert(deep).reshape(24, *FORMS[target]), convert(flat))
    assert same_bits(convert(flat[7]), convert(flat)[7])


@pytest.mark.numeric
@every_pair
@both_precisions
def test_place_in_the_array_does_not_matter(source, target, dtype):
    """The bits do not depend on the block, the vector register or its remainder."""
    given_ = sample(source, (40_003,), dtype=dtype)
    if source == "expmap":
        given_[::7] *= 3  # float32 uses another method above 8 rad
        given_[5::1000] = 0
    convert = converter(source, target)
    whole = convert(given_)
    for start, stop in [(0, 1), (1, 4), (8189, 8197), (16383, 16385), (16380, 33001), (39_990, 40_003)]:
        assert same_bits(convert(given_[start:stop]), whole[start:stop])
    order = np.random.default_rng(1).permutation(len(given_))
    assert same_bits(convert(given_[order]), whole[order])


@pytest.mark.numeric
@every_pair
@both_precisions
def test_strides_do_not_matter(source, target, dtype):
    core = FORMS[source]
    given_ = sample(source, (6, 8), dtype=dtype)
    convert = converter(source, target)
    expected = convert(given_)
    wide = np.full((6, 16, *(2 * n for n in core)), np.nan, dtype)
    strided = wide[:, ::2][(..., *(slice(None, None, 2) for _ in core))]
    strided[:] = given_
    unaligned = np.zeros(given_.nbytes + 1, np.uint8)[1:].view(dtype).reshape(given_.shape)
    unaligned[:] = given_
    swapped = given_.astype(given_.dtype.newbyteorder())
    for same in (strided, np.asfortranarray(given_), given_[::-1, ::-1][::-1, ::-1], unaligned, swapped):
        assert same_bits(convert(same), expected)
    assert same_bits(convert(np.moveaxis(given_, 0, 1)), np.ascontiguousarray(np.moveaxis(expected, 0, 1)))
    assert same_bits(convert(np.broadcast_to(given_[0], given_.shape)), convert(np.stack([given_[0]] * 6)))


@every_pair
def test_inputs_are_not_written(source, target):
    given_ = sample(source, (10,))
    before = given_.copy()
    given_.flags.writeable = False
    got = converter(source, target)(given_)
    assert same_bits(given_, before)
    assert not np.shares_memory(got, given_)
    got[...] = 0  # the result is the caller's


@every_pair
def test_other_precisions_are_computed_in_float64(source, target):
    convert = converter(source, target)
    whole = {
        "matrix": np.stack([np.eye(3), np.diag([1, -1, -1])]),
        "sixd": np.array([[1.0, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, 1]]),
    }.get(source, np.eye(3, FORMS[source][0]))
    expected = convert(whole)
    for dtype in (np.int8, np.int64, np.uint16 if whole.min() == 0 else np.int16, np.float16, np.longdouble):
        assert same_bits(convert(whole.astype(dtype)), expected)
    assert same_bits(convert(whole.astype(int).tolist()), expected)


@every_pair
def test_the_callers_error_settings_do_not_matter(source, target):
    given_ = sample(source, (5,))
    tiny = given_ * (1e-310 if source in ("expmap", "euler") else 1)
    with np.errstate(all="raise"):
        assert np.isfinite(converter(source, target)(np.concatenate([given_, tiny]))).all()


# ---- errors


def call_with(form):
    """Return every function that takes a form, with the name of the argument."""
    calls = [(converter(a, b), ARGUMENTS[a]) for a, b in PAIRS if a == form]
    if form == "matrix":
        good = np.broadcast_to(np.eye(3), (2, 3, 4, 3, 3))
        calls.append((lambda R: geodesic_angle(R, good), "a"))
        calls.append((lambda R: geodesic_angle(good, R), "b"))
    if form == "expmap":
        calls.append((lambda v: expmap_to_euler(v, legacy=True), "v"))
        calls.append((lambda v: expmap_to_euler(v, seq="zxz"), "v"))
    return calls


@every_form
@pytest.mark.parametrize("shape", [(), (2,), (3, 2), (5,), (9,), (3, 4, 2), (3, 5, 5)])
def test_wrong_shape(form, shape):
    expected = ", ".join(map(str, FORMS[form]))
    for call, name in call_with(form):
        with pytest.raises(ValueError, match=rf"^{name}: expected shape \(\.\.\., {expected}\), got ") as error:
            call(np.zeros(shape))
        assert str(error.value).endswith(f"got {shape}")


@every_form
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@both_precisions
def test_not_finite(form, bad, dtype):
    values = sample(form, (2, 3, 4), dtype=dtype)
    where = (1, 2, 0, *(n - 1 for n in FORMS[form]))
    values[where] = bad
    values[1, 2, 1] = np.nan
    for call, name in call_with(form):
        with pytest.raises(ValueError, match=f"^{name}: ") as error:
            call(values)
        assert f"{bad} at index {where};" in str(error.value)
        assert error.value.__context__ is None


@every_form
def test_not_finite_in_a_later_block(form):
    values = sample(form, (30_000,))
    where = (25_000, *(0 for _ in FORMS[form]))
    values[where] = np.nan
    for call, _ in call_with(form)[:3]:
        with pytest.raises(ValueError, match="nan") as error:
            call(values)
        assert f"at index {where};" in str(error.value)


@every_form
@pytest.mark.parametrize(
    ("dtype", "what"), [(bool, "booleans"), (complex, "complex"), (object, "objects"), (str, "strings")]
)
def test_not_real_numbers(form, dtype, what):
    for call, name in call_with(form):
        with pytest.raises(TypeError, match=f"^{name}: .*{what}"):
            call(np.zeros(FORMS[form]).astype(dtype))
        with pytest.raises(TypeError, match=f"^{name}: masked"):
            call(np.ma.zeros(FORMS[form]))


@every_form
def test_extended_precision_beyond_float64(form):
    if np.finfo(np.longdouble).max == np.finfo(np.float64).max:
        pytest.skip("this machine has no extended precision")
    for call, name in call_with(form):
        with pytest.raises(ValueError, match=f"^{name}: inf"):
            call(np.full(FORMS[form], np.longdouble("1e4000")))


@pytest.mark.parametrize("size", [2.0**52, 1e16, 1e30, 1e300])
def test_angle_too_large(size):
    v = np.zeros((20_000, 3))
    v[[17_000, 18_000], 1] = size
    for call, _ in call_with("expmap"):
        with pytest.raises(ValueError, match=r"^v: an angle of 2\*\*52 rad or more at index \(17000,\)$"):
            call(v)
        if size < 1e38:
            with pytest.raises(ValueError, match=r"^v: an angle of 2\*\*52 rad or more at index \(17000,\)$"):
                call(v.astype(np.float32))


def test_largest_angles_are_accepted():
    for dtype in (np.float64, np.float32):
        assert np.isfinite(expmap_to_matrix(np.array([2.0**51, 2.0**51, 0], dtype))).all()


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.float16, np.int64])
def test_zero_quaternion(dtype):
    q = np.ones((3, 4, 4), dtype)
    q[1, 2] = q[2, 0] = 0
    for call, _ in call_with("quaternion"):
        with pytest.raises(ValueError, match=r"^q: a zero quaternion, .* at index \(1, 2\)$"):
            call(q)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-6), (np.float32, 1e-4), (np.float16, 1e-2)])
def test_matrix_near_a_rotation(dtype, tolerance):
    for off, accepted in ((tolerance / 4, True), (tolerance * 4, False)):
        R = np.broadcast_to(np.eye(3), (2, 3, 4, 3, 3)).astype(dtype)
        R[1, 0, 2, 0, 1] = R[1, 1, 0, 2, 2] = off
        R[1, 1, 0, 2, 2] += 1
        for call, name in call_with("matrix"):
            if accepted:
                assert np.isfinite(call(R)).all()
            else:
                with pytest.raises(ValueError, match=rf"^{name}: not a rotation matrix .*\(1, 0, 2\)$"):
                    call(R)


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.ones((3, 3)), 2 * np.eye(3), np.full((3, 3), 1e300)])
def test_matrix_far_from_a_rotation(bad):
    for call, name in call_with("matrix"):
        with pytest.raises(ValueError, match=rf"^{name}: not a rotation matrix .* at index \(\)$"):
            call(bad)


def test_reflection():
    R = np.broadcast_to(np.eye(3), (2, 3, 4, 3, 3)).copy()
    R[0, 1, 2] = np.diag([1, -1, 1])
    for call, name in call_with("matrix"):
        with pytest.raises(ValueError, match=rf"^{name}: a reflection.* at index \(0, 1, 2\)$"):
            call(R)


@pytest.mark.parametrize("seq", ["", "XY", "XXY", "XYy", "Xyz", "ABC", "XYZX", "H36M", "xyz "])
def test_invalid_sequences(seq):
    for source, target in PAIRS:
        if "euler" in (source, target):
            with pytest.raises(ValueError, match=r"^seq: expected one of h36m, "):
                converter(source, target)(sample(source, (2,)), seq=seq)


@pytest.mark.parametrize("seq", [None, 3, ("X", "Y", "Z")])
def test_sequences_that_are_not_strings(seq):
    with pytest.raises(TypeError, match=r"^seq: "):
        expmap_to_euler([0, 0, 1], seq=seq)


@pytest.mark.parametrize("seq", LETTERS)
def test_legacy_supports_one_convention(seq):
    with pytest.raises(ValueError, match=r"^legacy: .*h36m"):
        expmap_to_euler([0, 0, 1], seq=seq, legacy=True)


def test_geodesic_angle_does_not_broadcast():
    with pytest.raises(ValueError, match=r"^b: its shape \(3, 3\) differs from that of a, \(2, 3, 3\)"):
        geodesic_angle(np.stack([np.eye(3)] * 2), np.eye(3))


# ---- properties of rotations


@pytest.mark.numeric
@given(v=expmaps())
@both_precisions
def test_round_trips(dtype, v):
    """Conversion to each form and back gives the same rotation."""
    R = expmap_to_matrix(v.astype(dtype))
    eps = np.finfo(dtype).eps
    for source, target in PAIRS:
        first = R if source == "matrix" else converter("matrix", source)(R)
        back = converter(target, source)(converter(source, target)(first))
        again = back if source == "matrix" else converter(source, "matrix")(back)
        assert geodesic_angle(again, R).max() < 60 * eps


@pytest.mark.numeric
@given(v=expmaps(), seq=st.sampled_from(LETTERS))
def test_round_trips_through_every_sequence(v, seq):
    R = expmap_to_matrix(v)
    for source in ("expmap", "matrix", "quaternion"):
        first = R if source == "matrix" else converter("matrix", source)(R)
        back = converter("euler", source)(converter(source, "euler")(first, seq=seq), seq=seq)
        again = back if source == "matrix" else converter(source, "matrix")(back)
        assert geodesic_angle(again, R).max() < 1e-14


@pytest.mark.numeric
@given(v=expmaps())
@both_precisions
def test_matrices_are_rotations(dtype, v):
    R = expmap_to_matrix(v.astype(dtype)).astype(np.float64)
    eps = np.finfo(dtype).eps
    assert np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max() < 8 * eps
    assert np.abs(np.linalg.det(R) - 1).max() < 8 * eps


@pytest.mark.numeric
@given(v=expmaps())
def test_the_negative_vector_is_the_inverse(v):
    product = expmap_to_matrix(v) @ expmap_to_matrix(-v)
    assert np.abs(product - np.eye(3)).max() < 1e-14
    assert same_bits(expmap_to_matrix(-v), np.ascontiguousarray(np.swapaxes(expmap_to_matrix(v), -1, -2)))


@pytest.mark.numeric
@given(v=expmaps())
@both_precisions
def test_the_axis_is_fixed_and_the_trace_is_right(dtype, v):
    v = v.astype(dtype)
    R = expmap_to_matrix(v).astype(np.float64)
    v = v.astype(np.float64)
    angle = np.linalg.norm(v, axis=-1)
    tolerance = 40 * np.finfo(dtype).eps
    assert np.abs((R @ v[..., np.newaxis])[..., 0] - v).max() < tolerance
    assert np.abs(np.trace(R, axis1=-1, axis2=-2) - 1 - 2 * np.cos(angle)).max() < tolerance


@pytest.mark.numeric
@given(v=expmaps())
@both_precisions
def test_the_representative_is_canonical(dtype, v):
    """Quaternions have w >= 0, rotation vectors a length of at most pi; ties go to the first positive component."""
    v = v.astype(dtype)
    q = rotations.expmap_to_quaternion(v)
    assert (q[..., 0] >= 0).all()
    for row in q:
        assert row[np.flatnonzero(row)[0]] > 0
        assert not np.signbit(row[row == 0]).any()
    short = rotations.quaternion_to_expmap(q)
    assert (np.linalg.norm(short.astype(np.float64), axis=-1) <= np.pi * (1 + 4 * np.finfo(dtype).eps)).all()


@pytest.mark.numeric
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.8, 0), (0, 0.6, -0.8)])
def test_half_turns_have_a_canonical_axis(axis):
    axis = np.array(axis)
    half_turn = 2 * np.outer(axis, axis) - np.eye(3)
    for v in (rotations.matrix_to_expmap(half_turn), rotations.quaternion_to_expmap([0, *-axis])):
        np.testing.assert_allclose(v, np.pi * axis, rtol=0, atol=1e-14)
    np.testing.assert_allclose(rotations.matrix_to_quaternion(half_turn), [0, *axis], rtol=0, atol=4e-15)


@pytest.mark.numeric
@given(v=expmaps(), power=st.integers(-1000, 1000), sign=st.sampled_from([-1.0, 1.0]))
def test_the_length_of_a_quaternion_does_not_matter(v, power, sign):
    q = rotations.expmap_to_quaternion(v)
    q[np.abs(q) < 1e-5] = 0  # would be lost as subnormal numbers
    scaled = sign * np.ldexp(q, power)
    for target in ("expmap", "matrix", "euler"):
        convert = converter("quaternion", target)
        assert np.array_equal(convert(scaled), convert(q))


@pytest.mark.numeric
def test_extreme_quaternions():
    for size in (5e-324, 1e-310, 1.7e308):
        np.testing.assert_allclose(rotations.quaternion_to_expmap([size, 0, 0, size]), [0, 0, np.pi / 2])


@pytest.mark.numeric
@given(v=expmaps(max_count=3), w=expmaps(max_count=3))
def test_geodesic_angle_is_a_metric(v, w):
    n = min(len(v), len(w))
    a, b = expmap_to_matrix(v[:n]), expmap_to_matrix(w[:n])
    angle = geodesic_angle(a, b)
    assert angle.shape == (n,)
    assert ((angle >= 0) & (angle <= np.pi)).all()
    assert np.array_equal(geodesic_angle(a, a), np.zeros(n))
    assert np.abs(geodesic_angle(b, a) - angle).max() < 1e-14
    assert np.abs(geodesic_angle(a @ b, b @ b) - angle).max() < 2e-14  # moves with both


def test_geodesic_angle_dtype_and_scalar():
    a, b = expmap_to_matrix(np.array([[0, 0, 1], [0, 0, 1.5]], np.float32))
    assert geodesic_angle(a, b).dtype == np.float32
    assert geodesic_angle(a, b.astype(float)).dtype == np.float64
    assert geodesic_angle(a, b).shape == ()
    assert geodesic_angle(np.empty((0, 3, 3)), np.empty((0, 3, 3))).shape == (0,)


def test_memory_does_not_grow():
    v = sample("expmap", (300_000,))
    for call in (expmap_to_euler, lambda v: expmap_to_euler(v, legacy=True), expmap_to_matrix):
        tracemalloc.start()
        try:
            out = call(v)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak - out.nbytes < 4e6
