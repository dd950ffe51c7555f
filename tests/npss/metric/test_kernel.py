"""The kernel against a slow definition, and the independence of a column's bits from everything around it."""

import itertools
import tracemalloc
from typing import get_args, get_type_hints

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
from npss._metric import kernel as _kernel
from npss._metric import power as _power
from npss._metric.convention import Convention

CHOICES = {field: get_args(kind) for field, kind in get_type_hints(Convention).items()}
ALL = [Convention(**dict(zip(CHOICES, values, strict=True))) for values in itertools.product(*CHOICES.values())]
SOME = [*npss.CONVENTIONS.values(), Convention(bins="one-sided", zero="empty")]
FRAMES = [*range(2, 41), 64, 97, 100, 101, 127, 128, *range(255, 261), 400, 401, 509, 1000]


@pytest.fixture(params=["matrices", "FFT"])
def way(request, monkeypatch):
    """Force each of the two transforms, for any T."""
    if request.param == "FFT":
        monkeypatch.setattr(_power, "_matrices", lambda n_frames, twins: None)
    else:
        monkeypatch.setattr(_power, "_TERMS", 10**6)


def motions(seed, *shape):
    """Two random walks with offsets, with features of different scales."""
    rng = np.random.default_rng(seed)
    walks = rng.normal(size=(2, *shape)).cumsum(axis=2) + rng.normal(size=(2, shape[0], 1, shape[2]))
    return walks * 10.0 ** rng.uniform(-3, 3, (2, shape[0], 1, shape[2]))


def statistics(gt, pred, convention):
    """Distance, weight and exponent of every column, ``(3, N, D)``."""
    out = np.full((3, *(gt[:, 0].shape if gt.ndim == 3 else (1, gt.shape[1]))), np.nan)
    for block in _kernel.blocks(gt):
        part = _kernel.tile(gt, pred, convention, block)
        here = out[:, part.sequences, part.features]
        assert np.isnan(here).all()
        here[:2] = part.distance, part.weight
        here[2] = 0 if part.exponent is None else part.exponent
    assert np.isfinite(out).all()
    return out


def slow_column(x, y, convention):
    """Distance and weight of one column, over all bins of the two-sided spectrum."""
    shares = []
    for column in (y, x):
        transform = np.fft.fft(column)
        power = transform.real**2 if convention.power == "real" else np.abs(transform) ** 2
        if convention.bins == "one-sided":
            power = power[: len(x) // 2 + 1]
        total = power.sum()
        share = power / total if total > 0 else np.zeros_like(power)
        if total == 0 and convention.zero == "dc":
            share[0] = 1.0
        shares.append(share.cumsum() if convention.distance == "cdf" else share)
    return np.abs(shares[0] - shares[1]).sum(), total if convention.weight == "power" else float(total > 0)


def slow(gt, pred, convention):
    """Distances and weights, ``(2, N, D)``."""
    out = np.empty((2, *gt[:, 0].shape))
    for i, j in np.ndindex(gt[:, 0].shape):
        out[:, i, j] = slow_column(gt[i, :, j], pred[i, :, j], convention)
    return out


def rounding(n_frames):
    """The tolerance between two computations of a distance.

    A value of a cumulative distribution is a sum of up to T rounded shares, whose errors add up to about sqrt(T) times
    the unit roundoff; transform, square and division add some more. Two distributions, T bins, two computations.
    """
    return 4 * n_frames * (np.sqrt(n_frames) + 16) * np.finfo(float).eps / 2


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", FRAMES)
def test_equals_the_slow_definition(n_frames):
    gt, pred = motions(n_frames, 3, n_frames, 4)
    gt[1, :, 1] = pred[0, :, 0] = gt[2, :, 2] = pred[2, :, 2] = 0.0
    pred[1, :, 3] = gt[0, :, 3] = 5.0
    for convention in ALL:
        distance, weight = slow(gt, pred, convention)
        expected = (distance * weight).sum() / weight.sum()
        assert abs(npss.score(gt, pred, convention=convention) - expected) <= rounding(n_frames)


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [2, 3, 4, 5, 30, 31, 100, 101, 256, 300, 500])
def test_both_transforms_agree(way, n_frames):
    gt, pred = motions(n_frames, 2, n_frames, 30)
    for convention in ALL:
        distance, weight = slow(gt, pred, convention)
        got = statistics(gt, pred, convention)
        np.testing.assert_allclose(got[0], distance, rtol=0, atol=rounding(n_frames))
        np.testing.assert_allclose(got[1], weight, rtol=rounding(n_frames))


@pytest.mark.numeric
@settings(max_examples=150)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 7),
    n_frames=st.sampled_from([2, 3, 4, 5, 8, 15, 30, 51, 97, 100, 101, 251, 300, 500]),
    d=st.one_of(st.integers(1, 5), st.integers(1, 120)),
    convention=st.sampled_from(SOME),
    data=st.data(),
)
def test_bits_of_a_column_depend_on_nothing_else(seed, n, n_frames, d, convention, data):
    gt, pred = motions(seed, n, n_frames, d)
    pred[0, :, 0] = 0.0
    whole = statistics(gt, pred, convention)
    rng = np.random.default_rng(seed)
    some, few = rng.permutation(n)[: rng.integers(1, n + 1)], rng.permutation(d)[: rng.integers(1, d + 1)]
    subset = np.ix_(some, range(n_frames), few)
    assert np.array_equal(statistics(gt[subset], pred[subset], convention), whole[:, some][:, :, few])
    assert np.array_equal(statistics(gt[0], pred[0], convention), whole[:, :1])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_kernel, "_BLOCK_COLUMNS", data.draw(st.integers(1, 200)))
        patch.setattr(_kernel, "_MEMORY", data.draw(st.sampled_from([1, 2**12, 2**15])))
        patch.setattr(_power, "_FFT", data.draw(st.sampled_from([1, 2**12])))
        assert np.array_equal(statistics(gt, pred, convention), whole)


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [2, 5, 100, 300])
@pytest.mark.parametrize("convention", SOME)
def test_bits_do_not_depend_on_the_layout(tmp_path, convention, n_frames):
    gt, pred = motions(0, 6, n_frames, 7)
    whole = statistics(gt, pred, convention)
    spaced = np.zeros((12, n_frames, 21))
    spaced[::-2, :, ::3] = gt
    np.save(tmp_path / "gt.npy", gt)
    layouts = [
        np.asfortranarray(gt),
        np.ascontiguousarray(gt.transpose(0, 2, 1)).transpose(0, 2, 1),
        np.ascontiguousarray(gt.transpose(1, 0, 2)).transpose(1, 0, 2),
        np.ascontiguousarray(gt[:, ::-1])[:, ::-1],
        spaced[::-2, :, ::3],
        np.load(tmp_path / "gt.npy", mmap_mode="r"),
        gt.astype(">f8"),
        gt.astype(np.longdouble),
    ]
    for layout in layouts:
        layout.flags.writeable = False
        assert np.array_equal(statistics(layout, pred, convention), whole)
        assert np.array_equal(layout, gt)


@pytest.mark.parametrize("dtype", ["f2", "f4", ">f4", "i1", "u1", "i2", "i8", "u8", "g"])
@pytest.mark.parametrize("n_frames", [4, 100, 300])
def test_bits_do_not_depend_on_the_type_that_holds_the_values(dtype, n_frames):
    gt, pred = np.random.default_rng(0).integers(0, 100, (2, 5, n_frames, 9)).astype(dtype)
    for convention in SOME:
        expected = statistics(gt.astype(float), pred.astype(float), convention)
        assert np.array_equal(statistics(gt, pred, convention), expected)
        assert np.array_equal(statistics(gt.astype(float), pred, convention), expected)


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [2, 5, 100, 300])
@pytest.mark.parametrize("convention", ALL)
def test_a_power_of_two_changes_no_bit_at_any_magnitude(convention, n_frames):
    gt, pred = motions(1, 2, n_frames, 3) / 1024
    distance, weight, _ = statistics(gt, pred, convention)
    for first, second in itertools.product((-900, -510, 0, 490, 1000), repeat=2):
        scaled, of, exponent = statistics(np.ldexp(gt, first), np.ldexp(pred, second), convention)
        assert np.array_equal(scaled, distance)
        if convention.weight == "power":
            mantissas, exponents = np.frexp(of)
            assert np.array_equal(mantissas, np.frexp(weight)[0])
            assert np.array_equal(exponents + exponent, np.frexp(weight)[1] + 2 * first)


@pytest.mark.numeric
@pytest.mark.parametrize("size", [1e308, 1e300, 1e155, 1e-155, 1e-300, 1e-307])
@pytest.mark.parametrize("n_frames", [100, 300])
def test_no_magnitude_is_out_of_range(size, n_frames):
    gt, pred = np.random.default_rng(0).uniform(-1, 1, (2, 4, n_frames, 5))
    expected = npss.score(gt, pred)
    assert npss.score(gt * size, pred) == pytest.approx(expected, rel=1e-12)
    assert npss.score(gt, pred * size) == pytest.approx(expected, rel=1e-12)
    assert npss.score(gt * size, pred * size, convention="released") == pytest.approx(
        npss.score(gt, pred, convention="released"), rel=1e-12
    )


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [6, 100, 300])
def test_power_that_cancels_up_to_a_tiny_remainder(n_frames):
    """An odd signal has no real power; the power of a tiny even remainder is found."""
    tiny = 1e-200
    odd = np.arange(1.0, n_frames) - n_frames / 2
    gt = np.concatenate([[tiny], odd])[:, np.newaxis]
    flat = np.eye(n_frames)[:, :1]
    distance, weight, exponent = statistics(gt, flat, Convention(power="real"))
    assert distance == pytest.approx(0, abs=1e-12)
    assert np.log2(weight) + exponent == pytest.approx(np.log2(n_frames) + 2 * np.log2(tiny))


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [2, 3, 100, 101, 300])
@pytest.mark.parametrize("convention", ALL)
def test_columns_without_power(convention, n_frames):
    gt, pred = motions(0, 1, n_frames, 4)
    gt[0, :, :2] = 0.0
    pred[0, :, ::2] = -0.0
    distance, weight, _ = statistics(gt, pred, convention)
    assert weight[0, :2].tolist() == [0, 0]
    assert (weight[0, 2:] > 0).all()
    assert distance[0, 0] == 0


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [2, 3, 30, 97, 100, 101, 256, 257, 400])
def test_constants_have_power_only_at_dc(n_frames):
    gt, pred = motions(0, 3, n_frames, 5)
    moving = (np.abs(np.fft.fft(gt, axis=1)) ** 2)[:, 1:].sum() / (np.abs(np.fft.fft(gt, axis=1)) ** 2).sum()
    for constant in (0.0, 1.0, -0.1, 1e200, np.pi):
        still = np.full_like(pred, constant)
        assert npss.score(gt, still) == pytest.approx(n_frames / 2 * moving, rel=1e-12)


@pytest.mark.parametrize("n_frames", [5, 100, 300])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_named(n_frames, bad):
    gt, pred = motions(0, 4, n_frames, 3)
    pred[2, 3, 1] = pred[3, 0, 0] = bad
    with pytest.raises(ValueError, match=rf"pred: {bad} at index \(2, 3, 1\); every value must be finite"):
        npss.score(gt, pred)
    gt[3, 4, 2] = bad
    with pytest.raises(ValueError, match=rf"gt: {bad} at index \(3, 4, 2\)"):
        npss.score(gt, pred)


@pytest.mark.skipif(np.finfo(np.longdouble).max <= np.finfo(float).max, reason="no wider type here")
def test_values_beyond_float64_are_refused():
    gt, pred = motions(0, 2, 10, 3).astype(np.longdouble)
    pred[1, 2, 0] = np.longdouble("1e400")
    with pytest.raises(ValueError, match=r"pred: inf at index \(1, 2, 0\) in float64"):
        npss.score(gt, pred)


@pytest.mark.parametrize("n_frames", FRAMES)
def test_products_are_small_enough_for_one_thread(n_frames, monkeypatch):
    def matmul(a, b, *, out):
        assert a.shape[-2] * a.shape[-1] * b.shape[-1] <= 2**18
        assert b.shape[-1] == out.shape[-1] == _power.COLUMNS
        return original(a, b, out=out)

    original = np.matmul
    monkeypatch.setattr(np, "matmul", matmul)
    _power._matrices.cache_clear()
    for convention in SOME:
        statistics(*motions(0, 2, n_frames, 60), convention)


@pytest.mark.numeric
def test_matrices_are_not_used_where_bits_would_depend_on_the_place(monkeypatch):
    def rounded_elsewhere(a, b, *, out):
        original(a, b, out=out)
        out[..., 40:] = np.nextafter(out[..., 40:], np.inf)

    original = np.matmul
    _power._matrices.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(np, "matmul", rounded_elsewhere)
        assert _power._matrices(100, twins=True) is None
    _power._matrices.cache_clear()
    assert _power._matrices(100, twins=True) is not None


def test_cached_matrices_cannot_be_written_to():
    for matrix in _power._matrices(100, twins=True):
        with pytest.raises(ValueError, match="read-only"):
            matrix[0, 0] = 0


def test_numpy_settings_are_unchanged():
    before = np.getbufsize(), np.geterr()
    npss.score(*motions(0, 3, 30, 4))
    assert (np.getbufsize(), np.geterr()) == before


def test_sizes_of_blocks_and_pieces(monkeypatch):
    def spectra(*arguments):
        calls.append(1)
        return original(*arguments)

    assert len(_kernel.blocks(np.broadcast_to(0.0, (400, 100, 99)))) == 4  # 105 sequences are 2**20 values
    assert len(_kernel.blocks(np.broadcast_to(0.0, (4000, 2, 99)))) == 13  # 330 are 2**15 columns
    calls, original = [], _kernel._spectra
    monkeypatch.setattr(_kernel, "_spectra", spectra)
    statistics(*motions(0, 30, 100, 99), Convention())
    assert len(calls) == 2 * 3  # 10 sequences are 2**18 values, including intermediate ones


def test_smooth_numbers():
    assert [n for n in range(1, 40) if not _power._is_smooth(n)] == [17, 19, 23, 29, 31, 34, 37, 38]


@pytest.mark.parametrize("shape", [(2000, 100, 99), (2000, 25, 99), (400, 400, 99), (20, 40, 99 * 100)])
def test_memory_does_not_grow_with_the_input(shape):
    gt = np.broadcast_to(motions(0, 1, *shape[1:])[0], shape)  # many sequences without memory
    pred = np.broadcast_to(motions(1, 1, *shape[1:])[0], shape)
    npss.score(gt[:1], pred[:1])
    for convention in ("paper", "released"):
        tracemalloc.start()
        npss.score(gt, pred, convention=convention)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 8 * 2**20
