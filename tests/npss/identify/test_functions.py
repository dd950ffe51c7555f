"""Tests of npss.identify: which functions it takes, what they return, and the order of their arguments."""

import functools

import numpy as np
import pytest

import npss
from nearest_versions import NAMED, RELEASED, combinations, distances_and_totals, function_of, score
from npss._identify.arguments import order_of

SWAPPED = "the prediction's total power (arguments swapped?)"


def released(gt, pred):
    return score(gt, pred, RELEASED)


def flat(motion):
    n, t, j, c = motion.shape
    return motion.reshape(n, t, j * c)


class TestShapes:
    @pytest.mark.parametrize("components", [3, 4, 6])
    def test_joints(self, components):
        def of_joints(gt, pred):
            assert gt.shape[3] == components
            return released(flat(gt), flat(pred))

        result = npss.identify(of_joints)
        assert result.convention == "released"
        assert "arrays (N, T, J, C)" in str(result)

    def test_transform_over_components(self):
        def over_components(gt, pred):
            powers = [flat(np.fft.fft(motion).real ** 2) for motion in (gt, pred)]
            totals = [power.sum(axis=1) for power in powers]
            first, second = (
                np.cumsum(power / total[:, None], axis=1) for power, total in zip(powers, totals, strict=True)
            )
            return np.average(np.abs(first - second).sum(axis=1), weights=totals[0])

        assert set(npss.identify(over_components).differences) == {"axis"}

    def test_one_sequence(self):
        def of_one(gt, pred):
            assert gt.ndim == 2
            return released(gt[None], pred[None])

        result = npss.identify(of_one)
        assert (result.convention, result.differences) == ("released", {})
        assert result.choices["aggregation"] == "not part of this function"
        assert "\nNot part of this function: aggregation.\n" in str(result)
        assert "arrays (T, D), one sequence at a time" in str(result)
        assert str(result).endswith("which the mean of these numbers is not.")

    def test_one_sequence_that_does_not_check(self):
        def of_one(gt, pred):
            first, second = (np.fft.fft(motion, axis=0).real ** 2 for motion in (gt, pred))
            distance = np.abs(np.cumsum(first / first.sum(0), 0) - np.cumsum(second / second.sum(0), 0)).sum(0)
            return np.average(distance, weights=first.sum(0))

        assert npss.identify(of_one).convention == "released"

    def test_transform_over_features_of_one_sequence(self):
        def of_one(gt, pred):
            first, second = (np.fft.fft(motion).real ** 2 for motion in (gt, pred))
            distance = np.abs(np.cumsum(first / first.sum(0), 0) - np.cumsum(second / second.sum(0), 0)).sum(0)
            return np.average(distance, weights=first.sum(0))

        assert npss.identify(of_one).differences == {"axis": "features for the transform, frames for all else"}

    def test_joints_of_one_sequence(self):
        def of_one(gt, pred):
            return released(flat(gt[None]), flat(pred[None]))

        result = npss.identify(of_one)
        assert result.convention == "released"
        assert "arrays (T, J, C), one sequence at a time" in str(result)

    @pytest.mark.parametrize("frame", [(22, 4), [5, 3, 3], 99, (7,), np.int64(10)])
    def test_a_frame_of_one_shape(self, frame):
        shape = (frame,) if isinstance(frame, int | np.integer) else tuple(frame)

        def of_frames(gt, pred):
            assert gt.shape[2:] == shape
            return released(gt.reshape(*gt.shape[:2], -1), pred.reshape(*gt.shape[:2], -1))

        assert npss.identify(of_frames, frame=frame).convention == "released"
        with pytest.raises(
            ValueError,
            match=r"^function: .* 15 to 100 frames; if it needs one shape of a frame, .* pass frame=\(22, 4\)$",
        ):
            npss.identify(of_frames)

    def test_a_usual_number_of_features_only(self):
        def of_twelve(gt, pred):
            assert gt.shape[2] == 12
            return released(gt, pred) / gt.shape[2]

        assert npss.identify(of_twelve).differences == {"factor": "divided by D"}

    def test_a_shape_that_it_refuses(self):
        def of_frames(gt, pred):
            assert gt.shape[2:] == (6,)
            return released(gt, pred)

        text = str(npss.identify(of_frames))  # which takes six components for six features, and joints for frames
        assert text.startswith("It computes no NPSS: ")
        assert "\nIt does not take arrays (N, T, D): AssertionError" in text
        assert text.endswith("pass frame=(22, 4).")

    @pytest.mark.parametrize(("frame", "error"), [(0, ValueError), ((), ValueError), (1, ValueError), ("9", TypeError)])
    def test_invalid_frames(self, frame, error):
        with pytest.raises(error, match=r"^frame: "):
            npss.identify(released, frame=frame)


class TestReturns:
    @pytest.mark.parametrize(
        "convert",
        [float, np.float64, np.array, lambda value: np.array([value]), lambda value: np.array([[value]]), complex],
    )
    def test_a_number(self, convert):
        assert npss.identify(lambda gt, pred: convert(released(gt, pred))).convention == "released"

    @pytest.mark.parametrize("kind", [np.array, list])
    def test_a_number_for_each_sequence(self, kind):
        result = npss.identify(
            lambda gt, pred: kind([released(g[None], p[None]) for g, p in zip(gt, pred, strict=True)])
        )
        assert (result.convention, result.differences) == ("released", {})
        assert result.choices["aggregation"] == "not part of this function"
        assert "returns a number for each sequence." in str(result)

    def test_a_part_for_each_sequence(self):
        def parts(gt, pred):
            distance, of_gt, _ = distances_and_totals(gt, pred, **RELEASED)
            return (distance * of_gt).sum(axis=1) / of_gt.sum()

        result = npss.identify(parts)
        assert result.convention == "released"
        assert "returns a part for each sequence, to be added up." in str(result)

    def test_distances(self):
        result = npss.identify(lambda gt, pred: distances_and_totals(gt, pred, **NAMED["paper"])[0])
        assert (result.convention, result.differences) == ("paper", {})
        assert {result.choices[axis] for axis in ("weight", "aggregation")} == {"not part of this function"}
        assert result.example[0] == pytest.approx(result.example[1], rel=1e-9)

    @pytest.mark.parametrize("normalised", [False, True])
    def test_distances_and_weights(self, normalised):
        def pair(gt, pred):
            distance, of_gt, _ = distances_and_totals(gt, pred, **RELEASED)
            return distance, of_gt / of_gt.sum() if normalised else of_gt

        result = npss.identify(pair)
        assert result.convention == "released"
        assert ("normalised in each call, so batches cannot be merged" in str(result)) == normalised

    def test_distances_and_swapped_weights_of_one_sequence(self):
        def pair(gt, pred):
            assert gt.ndim == 2
            distance, _, of_pred = distances_and_totals(gt[None], pred[None], **RELEASED)
            return distance[0], of_pred[0]

        assert npss.identify(pair).differences == {"weight": SWAPPED}

    def test_sums(self):
        def sums(gt, pred):
            distance, of_gt, _ = distances_and_totals(gt, pred, **RELEASED)
            return (distance * of_gt).sum(), of_gt.sum()

        assert npss.identify(sums).convention == "released"

    def test_a_number_and_more(self):
        assert npss.identify(lambda gt, pred: (released(gt, pred), gt, [0.0])).convention == "released"

    @pytest.mark.parametrize(
        ("value", "message"),
        [
            ({"npss": 1.0}, r"returns a dict \(npss\); pass a function that returns one of its values"),
            (None, "returns NoneType; expected a number, an array, or a tuple of them"),
            ("1", "returns str; expected"),
            ((), "returns NoneType; expected"),
            ((np.zeros(2), np.zeros(3)), "<lambda> returns arrays of other sizes than sequences or features"),
        ],
    )
    def test_other_values(self, value, message):
        with pytest.raises(TypeError, match=f"^function: .*{message}"):
            npss.identify(lambda gt, pred: value)


def rounded(values, digits):
    """Round to a number of binary digits: float32, float16 and bfloat16 have 24, 11 and 8."""
    fraction, exponent = np.frexp(values)
    return np.ldexp(np.round(fraction * 2.0**digits), exponent - digits)


class TestPrecision:
    @pytest.mark.parametrize("digits", [3, 5])
    def test_decimal_places(self, digits):
        result = npss.identify(lambda gt, pred: round(released(gt, pred), digits))
        assert result.nearest is None
        assert f"rounded to {digits} decimal places; pass a function that returns all digits" in str(result)

    def test_float32(self):
        def single(gt, pred):
            return np.float32(released(gt.astype(np.float32), pred.astype(np.float32)))

        assert npss.identify(single).convention == "released"

    @pytest.mark.parametrize("name", NAMED)
    @pytest.mark.parametrize("digits", [24, 11, 8])
    def test_coarse_floats(self, name, digits):
        function = function_of(NAMED[name])
        for finish in (rounded, lambda value, digits: value):
            result = npss.identify(
                lambda gt, pred, finish=finish: finish(function(rounded(gt, digits), rounded(pred, digits)), digits)
            )
            assert result.convention == name

    @pytest.mark.parametrize("power", ["real", "magnitude"])
    def test_coarse_functions_have_no_wrong_name(self, power):
        for choices in combinations(power=power, axis="time", factor="none", mean="kept"):
            function = function_of(choices)
            result = npss.identify(lambda gt, pred, function=function: rounded(function(gt, pred), 8))
            assert [result.convention] == ([name for name in NAMED if NAMED[name] == choices] or [None])

    def test_too_coarse_to_tell(self):
        function = function_of(
            {**RELEASED, "power": "amplitude", "bins": "one-sided", "distance": "spectrum", "mean": "removed"}
        )
        result = npss.identify(lambda gt, pred: rounded(function(rounded(gt, 8), rounded(pred, 8)), 8))
        assert (result.convention, result.call) == (None, None)
        assert result.differences["precision"].startswith("the function is too coarse to tell, or else bins: two-sided")

    def test_precise_functions_are_told_apart_precisely(self):
        result = npss.identify(lambda gt, pred: released(gt, pred) * (1 + 1e-5))
        assert result.convention is None

    def test_random_functions(self):
        random = np.random.default_rng(0)
        with pytest.raises(ValueError, match=r"^function: .* returns different values for equal motions: "):
            npss.identify(lambda gt, pred: released(gt, pred) + random.random())

    def test_slightly_random_functions_have_no_name(self):
        random = np.random.default_rng(0)
        result = npss.identify(lambda gt, pred: released(gt, pred) * (1 + 1e-3 * random.random()))
        assert result.convention is None


class TestOrder:
    @pytest.mark.parametrize(
        ("first", "second"),
        [
            ("gt", "pred"),
            ("target", "preds"),
            ("y_true", "y_pred"),
            ("gt_seq", "pred_seq"),
            ("target_gt", "target_pred"),
            ("groundTruth", "output"),
            ("reference", "x"),
            ("x", "y_hat"),
            ("real", "fake"),
            ("euler_gts", "euler_preds"),
            ("label", "input"),
            ("GT", "generated"),
        ],
    )
    def test_names(self, first, second):
        assert order_of(first, second) == "gt,pred"
        assert order_of(second, first) == "pred,gt"

    @pytest.mark.parametrize(("first", "second"), [("a", "b"), ("x", "y"), ("seq1", "seq2"), ("gt1", "gt2")])
    def test_names_that_say_nothing(self, first, second):
        assert order_of(first, second) is None

    def test_prediction_first(self):
        result = npss.identify(lambda pred, target: released(target, pred))
        assert (result.convention, result.order) == ("released", "pred,gt")
        assert "It takes (pred, gt), " in str(result)

    def test_prediction_first_with_its_own_weights(self):
        result = npss.identify(lambda pred, gt: released(pred, gt))
        assert (result.convention, result.differences) == (None, {"weight": SWAPPED})
        assert 'npss.score(pred, gt, convention="released")' in str(result)

    def test_keywords(self):
        def by_keyword(*, pred, gt, scale=1.0):
            return scale * released(gt, pred)

        assert npss.identify(by_keyword).convention == "released"

    @pytest.mark.parametrize("function", [lambda a, b: released(a, b), lambda *pair: released(*pair)])
    def test_unknown_order(self, function):
        result = npss.identify(function)
        assert (result.convention, result.nearest, result.order) == (None, "released", None)
        assert set(result.differences) == {"order"}
        first, second = result.readings
        assert (first.convention, first.order) == ("released", "gt,pred")
        assert (second.convention, second.order, second.differences) == (None, "pred,gt", {"weight": SWAPPED})
        assert str(first).splitlines()[0] in str(result)
        assert str(second).splitlines()[0] in str(result)
        assert npss.identify(function, order="gt,pred") == first
        assert npss.identify(function, order="pred,gt") == second

    def test_unknown_order_with_weights_of_the_second(self):
        result = npss.identify(lambda a, b: released(b, a))
        assert (result.convention, result.nearest) == (None, "released")
        assert [reading.convention for reading in result.readings] == [None, "released"]

    def test_order_makes_no_difference_without_weights(self):
        result = npss.identify(lambda a, b: score(a, b, NAMED["literal"]))
        assert (result.convention, result.order, result.readings) == ("literal", None, ())

    def test_what_is_passed_goes_before_names(self):
        result = npss.identify(lambda gt, pred: released(pred, gt), order="pred,gt")
        assert result.convention == "released"

    @pytest.mark.parametrize("order", ["gt, pred", "gt", ("gt", "pred")])
    def test_invalid_order(self, order):
        with pytest.raises((TypeError, ValueError), match=r"^order: expected one of gt,pred, pred,gt, got "):
            npss.identify(released, order=order)


class Exact:
    """A metric that keeps all motion."""

    def __init__(self):
        self.pairs = []

    def update(self, preds, target):
        self.pairs.append((preds, target))

    def compute(self):
        preds, target = (np.concatenate(motions) for motions in zip(*self.pairs, strict=True))
        return released(target, preds)


class Mean(Exact):
    def compute(self):
        return np.mean([released(target, preds) for preds, target in self.pairs])


class MeanBySize(Exact):
    def compute(self):
        sizes = [len(target) for _, target in self.pairs]
        return np.average([released(target, preds) for preds, target in self.pairs], weights=sizes)


class Last(Exact):
    def compute(self):
        preds, target = self.pairs[-1]
        return released(target, preds)


class LastOfPaper(Exact):
    def compute(self):
        preds, target = self.pairs[-1]
        return score(target, preds, NAMED["paper"])


class Sum(Exact):
    def compute(self):
        return np.sum([released(target, preds) for preds, target in self.pairs])


class TestClasses:
    @pytest.mark.parametrize("make", [Exact, Exact(), lambda: Exact(), functools.partial(Exact)])
    def test_whole_set(self, make):
        result = npss.identify(make)
        assert (result.convention, result.order) == ("released", "pred,gt")

    @pytest.mark.parametrize(
        ("kind", "nearest", "words"),
        [
            (Mean, "released", "per batch, then averaged"),
            (MeanBySize, "released", "per batch, then averaged by the size of batches"),
            (Last, "released", "over the last batch only"),
            (LastOfPaper, "paper", "over the last batch only"),
            (Sum, "released", "over batches in an unknown way"),
        ],
    )
    def test_batches(self, kind, nearest, words):
        result = npss.identify(kind)
        assert (result.convention, result.nearest) == (None, nearest)
        assert result.differences == {"aggregation": words}

    @pytest.mark.parametrize(
        ("combine", "words"),
        [
            (
                lambda scores: np.mean([np.mean(batch) for batch in scores]),
                "per sequence, averaged in each batch, then over batches",
            ),
            (lambda scores: np.mean(np.concatenate(scores)), "per sequence, then averaged"),
            (lambda scores: np.mean(scores[-1]), "per sequence, averaged over the last batch only"),
        ],
    )
    def test_batches_of_means_over_sequences(self, combine, words):
        """The mean of ratios in each batch is not the ratio of the batch."""

        class OfSequences(Exact):
            def compute(self):
                return combine(
                    [
                        np.array([released(t[None], p[None]) for p, t in zip(preds, target, strict=True)])
                        for preds, target in self.pairs
                    ]
                )

        assert npss.identify(OfSequences).differences == {"aggregation": words}

    def test_batches_of_means_over_features(self):
        class OfFeatures(Exact):
            def compute(self):
                return np.mean(
                    [np.mean([released(t[..., [d]], p[..., [d]]) for d in range(t.shape[2])]) for p, t in self.pairs]
                )

        words = "per feature, averaged in each batch, then over batches"
        assert npss.identify(OfFeatures).differences == {"aggregation": words}

    @pytest.mark.parametrize("kind", [Mean, MeanBySize, Last, LastOfPaper, Sum])
    def test_the_example_has_several_batches(self, kind):
        """In one batch, such a class computes the named convention."""
        result = npss.identify(kind)
        own, named = result.example
        assert own != pytest.approx(named, rel=1e-3)
        assert "\nOn one example (5 sequences in batches of 2 and 3, 20 frames of 12 features): " in str(result)

    def test_what_it_has_seen_does_not_count(self):
        class Resettable(Exact):
            def reset(self):
                self.pairs = []

        metric = Resettable()
        metric.update(np.ones((1, 3, 2)), np.ones((1, 3, 2)))
        assert npss.identify(metric).convention == "released"
        assert len(metric.pairs) == 1

    def test_arguments_of_the_constructor(self):
        class Sized(Exact):
            def __init__(self, size):
                super().__init__()

        with pytest.raises(ValueError, match=r"^function: .*Sized\(\) raises TypeError: .* pass a function that makes"):
            npss.identify(Sized)
        assert npss.identify(lambda: Sized(3)).convention == "released"

    def test_a_class_that_is_called(self):
        class Callable:
            def __call__(self, gt, pred):
                return released(gt, pred)

        assert npss.identify(Callable).convention == npss.identify(Callable()).convention == "released"


class TestErrors:
    @pytest.mark.parametrize("function", [3, "released", None, int])
    def test_no_function(self, function):
        with pytest.raises(TypeError, match=r"^function: "):
            npss.identify(function)

    def test_other_arguments(self):
        with pytest.raises(ValueError, match=r"^function: .* needs more than two motions \(fps\); pass a function of"):
            npss.identify(lambda gt, pred, fps: 0.0)
        with pytest.raises(ValueError, match=r"^function: expected a function of two motions, got "):
            npss.identify(lambda gt: 0.0)

    def test_other_arguments_with_defaults(self):
        def with_defaults(gt, pred, axis=1, *, eps=0.0):
            return released(gt, pred)

        assert npss.identify(with_defaults).convention == "released"

    def test_errors_of_the_function(self):
        def fails(gt, pred):
            raise KeyError(gt.ndim)

        with pytest.raises(
            ValueError, match=r"^function: .*fails runs with no shape of motion; arrays \(N, T, D\): KeyEr"
        ):
            npss.identify(fails)

    def test_functions_without_a_signature(self):
        assert str(npss.identify(np.hypot)).startswith("It computes no NPSS: ")

    def test_functions_that_refuse_what_is_unusual(self):
        def strict(gt, pred):
            if len(gt) > 100 or np.abs(gt).max() > 1e4 or not (gt - pred).any():
                raise ValueError
            return released(gt, pred)

        result = npss.identify(strict)
        assert result.differences == {"scale": "large motion gets another score: raises ValueError"}
        assert result.call is None

    def test_motion_may_be_overwritten(self):
        def overwrites(gt, pred):
            value = released(gt, pred)
            gt[:], pred[:] = 0.0, np.nan
            return value

        assert npss.identify(overwrites).convention == "released"


def test_functions_of_this_library():
    assert npss.identify(npss.score).convention == "paper"
    for name in npss.CONVENTIONS:
        result = npss.identify(functools.partial(npss.score, convention=name))
        assert (result.convention, result.custom) == (name, npss.CONVENTIONS[name])


def test_functions_without_a_signature_and_makers_of_something_else():
    with pytest.raises((TypeError, ValueError)):
        npss.identify(max)  # written in C: its parameters are unknown, and it takes no two motions
    with pytest.raises(TypeError, match=r"^function: .* returns 3, which has no update and compute"):
        npss.identify(lambda: 3)
