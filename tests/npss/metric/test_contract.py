"""The input contract, for every public function that takes motion."""

import warnings

import numpy as np
import pytest
from hypothesis import given

import npss
from refused import REFUSED_TYPES, REFUSED_VALUES, SHAPE
from strategies import pairs

FUNCTIONS = {
    **{f"score {name}": lambda g, p, name=name: npss.score(g, p, convention=name) for name in npss.CONVENTIONS},
    "score_windows": lambda g, p: npss.score_windows(g, p, fps=2, edges_ms=(0, 1000))["0-1"],
    "euler_error": lambda g, p: npss.euler_error(g, p, fps=2, at_ms=(1000,))[1000],
    "euler_error_curve": lambda g, p: float(npss.euler_error_curve(g, p).sum()),
    "mse": npss.mse,
    "position_error": lambda g, p: npss.position_error(g, p, fps=2, at_ms=(1000,))[1000],
    "position_error_curve": lambda g, p: float(npss.position_error_curve(g, p, align="root").sum()),
    "rotation_error": lambda g, p: npss.rotation_error(g, p, representation="expmap", fps=2, at_ms=(1000,))[1000],
    "spectrum_divergence": lambda g, p: npss.spectrum_divergence(g, p, spectra="sequence"),
    "report": lambda g, p: float(npss.report(g, p).emd.sum()),
    "diagnose": lambda g, p: float(sum(finding.count for finding in npss.diagnose(g, p))),
}


@pytest.fixture(params=FUNCTIONS)
def function(request):
    return FUNCTIONS[request.param]


@pytest.fixture
def motion():
    gt, pred = np.random.default_rng(5).normal(size=(2, *SHAPE)).cumsum(axis=2)
    return gt, pred


@pytest.mark.parametrize("kind", REFUSED_TYPES)
def test_refused_types(function, kind, motion):
    with pytest.raises(TypeError, match=r"^gt: "):
        function(REFUSED_TYPES[kind], motion[1])
    with pytest.raises(TypeError, match=r"^pred: "):
        function(motion[0], REFUSED_TYPES[kind])


@pytest.mark.parametrize("kind", REFUSED_VALUES)
def test_refused_shapes(function, kind, motion):
    bad, message = REFUSED_VALUES[kind]
    with pytest.raises(ValueError, match=f"^gt: {message}"):
        function(bad, motion[1])
    with pytest.raises(ValueError, match=f"^pred: {message}"):
        function(motion[0], bad)


@pytest.mark.parametrize("other", [(2, 4, 1), (1, 4, 3), (2, 1, 3), (4, 3), (2, 3, 4)])
def test_nothing_is_broadcast(function, other, motion):
    with pytest.raises(ValueError, match=r"^pred: its shape .* differs from that of gt"):
        function(motion[0], np.ones(other))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("index", [(0, 0, 0), (1, 1, 2), (1, 0, 1)])
def test_the_first_bad_value_is_named(function, bad, index, motion):
    for which, name in enumerate(("gt", "pred")):
        both = [array.copy() for array in motion]
        both[which][index] = bad
        both[which][1, 1, 2] = bad  # later, or the same
        place = str(index).replace("(", r"\(").replace(")", r"\)")
        with pytest.raises(ValueError, match=rf"^{name}: {bad} at index {place}"):
            function(*both)


def test_bad_values_of_one_sequence_have_two_indices(function, motion):
    gt, pred = (array[0] for array in motion)
    pred[1, 2] = np.nan
    with pytest.raises(ValueError, match=r"^pred: nan at index \(1, 2\)"):
        function(gt, pred)


@pytest.mark.parametrize("name", ["score paper", "score released", "score literal"])
def test_one_frame_has_no_spectrum(name):
    with pytest.raises(ValueError, match=r"^gt: one frame"):
        FUNCTIONS[name](np.ones((2, 1, 3)), np.ones((2, 1, 3)))


@pytest.mark.parametrize(
    "dtype", [np.float16, np.float32, np.int8, np.int64, np.uint8, np.longdouble, ">f8", ">f4", ">i2"]
)
def test_any_precision_scores_as_the_same_values_in_float64(function, dtype, motion):
    gt, pred = (np.round(8 * array + 20).astype(dtype) for array in motion)
    assert function(gt, pred) == function(gt.astype(np.float64), pred.astype(np.float64))


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_low_precision_is_computed_in_float64(function, dtype, motion):
    gt, pred = (array.astype(dtype) for array in motion)
    assert function(gt, pred) == function(gt.astype(np.float64), pred.astype(np.float64))


def layouts(array):
    yield "fortran", np.asfortranarray(array)
    yield "transposed", np.ascontiguousarray(array.transpose(2, 0, 1)).transpose(1, 2, 0)
    strided = np.zeros((2 * array.shape[0], array.shape[1], 3 * array.shape[2]))
    strided[::2, :, ::3] = array
    yield "strided", strided[::2, :, ::3]
    yield "reversed", array[::-1, ::-1, ::-1].copy()[::-1, ::-1, ::-1]
    read_only = array.copy()
    read_only.flags.writeable = False
    yield "read-only", read_only
    yield "lists", array.tolist()


def test_any_layout_scores_the_same(function, motion):
    gt, pred = motion
    expected = function(gt, pred)
    for (name, one), (_, two) in zip(layouts(gt), layouts(pred), strict=True):
        assert function(one, two) == expected, name
        assert function(one, pred) == expected, name


def test_memory_maps(function, motion, tmp_path):
    for name, array in zip(("gt", "pred"), motion, strict=True):
        np.save(tmp_path / f"{name}.npy", array)
    maps = [np.load(tmp_path / f"{name}.npy", mmap_mode="r") for name in ("gt", "pred")]
    assert function(*maps) == function(*motion)


@given(pair=pairs())
def test_inputs_are_never_written_and_nothing_warns(pair):
    gt, pred = pair
    copies = gt.copy(), pred.copy()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in npss.CONVENTIONS:
            npss.score(gt, pred, convention=name)
        npss.euler_error_curve(gt, pred, columns="all")
        npss.mse(gt, pred)
        npss.diagnose(gt, pred)
        str(npss.report(gt, pred))
        if len(gt) > 1:
            str(npss.compare(gt, pred, -pred))
    np.testing.assert_array_equal(gt, copies[0])
    np.testing.assert_array_equal(pred, copies[1])


def test_results_are_python_floats(function, motion):
    assert type(function(*motion)) is float


def test_inputs_are_positional_and_options_are_not(motion):
    with pytest.raises(TypeError):
        npss.score(*motion, "paper")


@pytest.mark.parametrize(
    ("convention", "error"), [("Paper", ValueError), ("", ValueError), (None, TypeError), (1, TypeError)]
)
def test_invalid_conventions(convention, error, motion):
    with pytest.raises(error, match="convention: expected one of paper, released, literal"):
        npss.score(*motion, convention=convention)


@pytest.mark.parametrize("fps", [0, -25, float("nan"), float("inf")])
def test_invalid_frame_rates(fps, motion):
    with pytest.raises(ValueError, match="fps: expected a positive"):
        npss.euler_error(*motion, fps=fps)
    with pytest.raises(ValueError, match="fps: expected a positive"):
        npss.score_windows(*motion, fps=fps)


@pytest.mark.parametrize("fps", ["25", None, True, 25j])
def test_frame_rates_of_another_type(fps, motion):
    with pytest.raises(TypeError, match="fps: expected a positive"):
        npss.euler_error(*motion, fps=fps)
