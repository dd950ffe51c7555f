"""``npss.plot``: pictures show the computed numbers, state their meaning, and render without warnings."""

import inspect
import io
import re
import subprocess
import sys
from html import unescape
from xml.etree import ElementTree

import numpy as np
import pytest

import npss

pytest.importorskip("matplotlib")
import matplotlib as mpl
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.patches import StepPatch
from matplotlib.text import Text

import npss.plot
from npss._analysis.bootstrap import METHOD, RESAMPLES, bootstrap_interval
from npss.plot.style import label
from npss.skeleton import H36M, Skeleton, poses_to_positions
from pages import PROJECT, blocks

PAGE = PROJECT / "docs" / "pictures.md"
CONVENTIONS = {
    **npss.CONVENTIONS,
    "one-sided": npss.Convention(bins="one-sided"),
    "one-sided real spectrum": npss.Convention(bins="one-sided", distance="spectrum", power="real"),
    "one-sided empty": npss.Convention(bins="one-sided", zero="empty", weight="uniform"),
    "spectrum empty": npss.Convention(distance="spectrum", zero="empty", power="real"),
}


@pytest.fixture(scope="module")
def motion():
    gt, pred = np.random.default_rng(0).normal(size=(2, 6, 40, 5)).cumsum(axis=2)
    return gt + 3, pred + 4


def texts(figure):
    """What is written, long lines unbroken."""
    return [text.get_text().replace("\n    ", "") for text in figure.findobj(Text) if text.get_text()]


def shaded(axes):
    """The area that is shaded, and its steps."""
    (patch,) = (patch for patch in axes.findobj(StepPatch) if patch.get_fill())
    values, edges, baseline = patch.get_data()
    return float((np.abs(values - baseline) * np.diff(edges)).sum()), np.diff(edges)


class TestSpectra:
    @pytest.mark.parametrize("n_frames", [3, 40])
    @pytest.mark.parametrize("name", CONVENTIONS)
    def test_the_shaded_area_is_the_distance(self, motion, name, n_frames):
        gt, pred = (array[:, :n_frames] for array in motion)
        convention = CONVENTIONS[name]
        figure = npss.plot.spectra(gt, pred, fps=25, sequence=2, feature=3, convention=convention)
        emd = npss.score(gt[2, :, 3:4], pred[2, :, 3:4], convention=convention)
        area, widths = shaded(figure.axes[1])
        np.testing.assert_allclose(widths, 25 / n_frames)
        assert area / (25 / n_frames) == pytest.approx(emd, rel=1e-12)
        n_bins = n_frames if convention.bins == "two-sided" else n_frames // 2 + 1
        assert len(widths) == n_bins
        unit = " bins" if convention.distance == "cdf" else ""
        assert figure.axes[1].get_title(loc="left") == f"emd = {emd:.4g}{unit} = shaded area / {25 / n_frames:.4g} Hz"
        assert npss.signature(convention, frames=n_frames, fps=25) in texts(figure)
        assert len(figure.axes) == (2 if convention.distance == "cdf" else 3)

    def test_the_lines_are_the_normalised_spectra_and_their_sums(self, motion):
        gt, pred = motion
        figure = npss.plot.spectra(gt, pred, fps=20, feature=1)
        above, below = figure.axes
        spectra = [np.abs(np.fft.fft(array[0, :, 1])) ** 2 for array in motion]
        for line, spectrum, name in zip(above.get_lines(), spectra, ("ground truth", "prediction"), strict=True):
            share = spectrum / spectrum.sum()
            np.testing.assert_allclose(line.get_xdata(), np.arange(21) / 2)
            np.testing.assert_allclose(line.get_ydata(), share[:21], rtol=1e-9)
            assert line.get_label() == f"{name} (DC {100 * share[0]:.4g} %)"
        steps = [patch.get_data() for patch in below.findobj(StepPatch) if not patch.get_fill()]
        for step, spectrum in zip(steps, spectra, strict=True):
            np.testing.assert_allclose(step.values, np.cumsum(spectrum / spectrum.sum()), rtol=1e-9)
            np.testing.assert_allclose(step.edges, np.arange(41) / 2)

    def test_the_upper_half_of_two_sided_bins_is_called_negative(self, motion):
        axes = npss.plot.spectra(*motion, fps=20).axes[1]
        for place, tick in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
            frequency = float(tick.get_text().replace("−", "-"))
            assert place == pytest.approx(frequency if place < 10 else frequency + 20)
        assert min(float(label.get_text().replace("−", "-")) for label in axes.get_xticklabels()) < 0

    def test_the_zoom_shows_what_is_not_dc(self, motion):
        figure = npss.plot.spectra(*motion, fps=20, convention="literal")
        _, below, zoom = figure.axes
        assert shaded(zoom)[0] == shaded(below)[0]
        shares = [np.abs(np.fft.fft(array[0, :, 0])) ** 2 for array in motion]
        rest = np.maximum(*(share / share.sum() for share in shares))[1:21]
        left, right = zoom.get_xlim()
        assert left == pytest.approx(0.25)
        assert zoom.get_ylim() == pytest.approx((0, 1.1 * rest.max()))
        shown = rest[: round((right - left) / 0.5)]
        assert shown.sum() >= 0.99 * rest.sum() > shown[:-1].sum()

    def test_one_sequence_and_names(self, motion):
        gt, pred = (array[4] for array in motion)
        figure = npss.plot.spectra(gt, pred, fps=25, feature=4, names=("x", "y"), feature_names=list("abcde"))
        assert figure.axes[0].get_title(loc="left") == "e, sequence 0"
        assert [line.get_label().split()[0] for line in figure.axes[0].get_lines()] == ["x", "y"]

    @pytest.mark.parametrize(
        ("name", "scale"), [*((name, 1) for name in CONVENTIONS), ("paper", 1e-250), ("released", 1e250)]
    )
    def test_any_size_and_a_prediction_without_power(self, motion, name, scale):
        gt = motion[0] * scale
        pred = np.zeros_like(gt)
        figure = npss.plot.spectra(gt, pred, fps=40, convention=CONVENTIONS[name])
        emd = npss.score(gt[0, :, :1], pred[0, :, :1], convention=CONVENTIONS[name])
        assert shaded(figure.axes[1])[0] == pytest.approx(emd, rel=1e-12)

    def test_two_frames(self):
        figure = npss.plot.spectra([[1.0], [2.0]], [[1.0], [1.5]], fps=2)
        assert shaded(figure.axes[1])[0] == pytest.approx(npss.score([[1.0], [2.0]], [[1.0], [1.5]]))

    def test_two_constants_in_the_zoom(self):
        figure = npss.plot.spectra([[1.0]] * 4, [[2.0]] * 4, fps=1, convention="literal")
        assert figure.axes[2].get_ylim() == (0, 1)

    @pytest.mark.parametrize(
        ("options", "error", "message"),
        [
            ({"fps": 0}, ValueError, "fps: expected a positive"),
            ({"sequence": 6}, ValueError, "sequence: expected 0 to 5, got 6"),
            ({"sequence": -1}, ValueError, "sequence: expected 0 to 5, got -1"),
            ({"feature": 5}, ValueError, "feature: expected 0 to 4, got 5"),
            ({"feature": "hip"}, TypeError, "feature: expected an index, got 'hip'"),
            ({"feature": True}, TypeError, "feature: expected an index, got True"),
            ({"names": ("a",)}, ValueError, "names: expected two, for ground truth and prediction, got 1"),
            ({"names": "ab"}, TypeError, "names: expected a sequence of two names"),
            ({"feature_names": ["a"]}, ValueError, "feature_names: expected 5 names, one for each feature, got 1"),
            ({"convention": "papers"}, ValueError, "convention: expected one of"),
        ],
    )
    def test_invalid_options(self, motion, options, error, message):
        with pytest.raises(error, match=f"^{re.escape(message)}"):
            npss.plot.spectra(*motion, **{"fps": 25, **options})

    def test_bad_motion(self, motion):
        gt, pred = (array.copy() for array in motion)
        with pytest.raises(ValueError, match=r"^gt: a power spectrum needs at least two frames"):
            npss.plot.spectra(gt[:, :1], pred[:, :1], fps=25)
        with pytest.raises(ValueError, match=r"^pred: its shape"):
            npss.plot.spectra(gt, pred[:1], fps=25)
        pred[5, 3, 2] = np.nan
        with pytest.raises(ValueError, match=r"^pred: nan at index \(5, 3, 2\)"):
            npss.plot.spectra(gt, pred, fps=25)

    @pytest.mark.parametrize("values", [[0, 0, 0, 0], [0, 1, 0, -1]])
    def test_no_power_in_the_ground_truth(self, values):
        gt = np.array(values, float)[:, np.newaxis]
        with pytest.raises(ValueError, match=r"^gt: feature 0 of sequence 0 has no power"):
            npss.plot.spectra(gt, gt + 1, fps=25, convention="released")


@pytest.fixture(scope="module")
def report(motion):
    gt, pred = (array.copy() for array in motion)
    gt[..., 4] = pred[..., 4]
    return npss.report(gt, pred, fps=25, feature_names=("hip.x", "hip.y", "spine", "knee.x", "still.x"))


class TestContributions:
    def test_the_map_holds_the_shares(self, report):
        figure = npss.plot.contributions(report)
        heat, by_joint, by_sequence = figure.axes[:3]
        parts = report.weight * report.emd / (report.weight * report.emd).sum()
        expected = {"hip": parts[:, 0] + parts[:, 1], "spine": parts[:, 2], "knee": parts[:, 3]}
        joints = [label.get_text() for label in heat.get_yticklabels()]
        assert joints == sorted(expected, key=lambda joint: -expected[joint].sum())
        shares = np.asarray(heat.get_images()[0].get_array())
        np.testing.assert_allclose(shares, [expected[joint] for joint in joints], rtol=1e-12)
        assert shares.sum() == pytest.approx(1)
        widths = [bar.get_width() for bar in by_joint.patches]
        np.testing.assert_allclose(widths, shares.sum(axis=1))
        np.testing.assert_allclose(widths, [report.joint_share[joint] for joint in joints])
        np.testing.assert_allclose([bar.get_height() for bar in by_sequence.patches], shares.sum(axis=0))
        said = texts(figure)
        assert f"joints without a share: 1\n{report.signature}" in said
        assert f"NPSS {report.score:.4f}: shares of joints and sequences" in said
        printed = {text.get_position()[::-1]: text.get_text() for text in heat.texts}
        assert printed == {place: f"{100 * s:.1f} %" for place, s in np.ndenumerate(shares) if s >= 0.005}

    def test_many_sequences_are_not_printed(self):
        gt, pred = np.random.default_rng(1).normal(size=(2, 13, 10, 2))
        figure = npss.plot.contributions(npss.report(gt, pred))
        assert not figure.axes[0].texts
        assert figure.axes[0].get_images()[0].get_array().shape == (2, 13)

    def test_a_perfect_score_has_no_shares(self, motion):
        with pytest.raises(ValueError, match=r"^report: its score is 0"):
            npss.plot.contributions(npss.report(motion[0], motion[0]))


class TestErrors:
    def test_the_lines_are_the_curves_and_the_bands_their_intervals(self, motion):
        gt, pred = (np.concatenate([array, 2 * array]) for array in motion)
        preds = {"half": (gt + pred) / 2, "whole": pred}
        axes = npss.plot.errors(gt, preds, fps=20, level=0.8, seed=3).axes[0]
        times = np.arange(1, 41) * 50
        for line, band, (name, array) in zip(axes.get_lines(), axes.collections, preds.items(), strict=False):
            assert line.get_label() == name
            assert np.array_equal(line.get_xdata(), times)
            np.testing.assert_allclose(line.get_ydata(), npss.euler_error_curve(gt, array), rtol=1e-12)
            norms = np.linalg.norm(gt - array, axis=2)  # (N, T); everything moves
            low, high = bootstrap_interval(norms.T, np.ones(norms.T.shape), level=0.8, seed=3)
            corners = band.get_paths()[0].vertices
            for time, bottom, top in zip(times, low, high, strict=True):
                there = corners[corners[:, 0] == time, 1]
                assert (there.min(), there.max()) == pytest.approx((bottom, top), rel=1e-9)
        assert len(axes.collections) == 2

    def test_what_it_says(self, motion):
        gt, pred = (np.concatenate([array, 2 * array]) for array in motion)
        figure = npss.plot.errors(gt, {"model": pred}, fps=20)
        axes = figure.axes[0]
        assert axes.get_xlabel() == "time after the last seed frame (ms)"
        assert axes.get_ylabel() == "Euler error (rad)"
        marked = [line.get_xdata()[0] for line in axes.get_lines()[1:]]
        assert marked == list(npss.protocol.SLICES_MS)
        note = (
            f"mean of 12 sequences; bands: pointwise, 95 %, {METHOD}, {RESAMPLES} resamples, seed 0\n"
            "12 sequences, each its own block, assumed independent\n"
            "euler_error|version:1|frames:40|fps:20|average:at|columns:gt"
        )
        assert note in texts(figure)

    def test_times_beyond_the_end_are_not_marked(self, motion):
        axes = npss.plot.errors(motion[0][:, :9], {"model": motion[1][:, :9]}, fps=25).axes[0]
        assert [line.get_xdata()[0] for line in axes.get_lines()[1:]] == [80, 160, 320]

    def test_too_few_blocks_have_no_band(self, motion):
        rows = [0] * 9 + [1]  # most draws of blocks have no spread
        figure = npss.plot.errors(motion[0][rows], {"model": motion[1][rows]}, fps=25)
        assert not figure.axes[0].collections
        assert any("mean of 10 sequences; no band if the blocks do not bound it" in t for t in texts(figure))

    def test_few_blocks_have_their_range(self, motion):
        gt, pred = motion
        groups = ["a", "b", "a", "b", "c", None]
        figure = npss.plot.errors(gt, {"model": pred}, fps=20, groups=groups)
        (band,) = figure.axes[0].collections
        norms = np.linalg.norm(gt - pred, axis=2)
        means = np.stack([norms[[0, 2]].mean(axis=0), norms[[1, 3]].mean(axis=0), norms[4]])
        corners = band.get_paths()[0].vertices
        for time, of_blocks in zip(np.arange(1, 41) * 50, means.T, strict=True):
            there = corners[corners[:, 0] == time, 1]
            assert (there.min(), there.max()) == pytest.approx((of_blocks.min(), of_blocks.max()), rel=1e-9)
        note = (
            "mean of 6 sequences; bands: pointwise, range of 3 blocks, too few for an interval\n"
            "3 blocks, 1 of 6 sequences in none\n"
        )
        assert any(note in text for text in texts(figure))
        with pytest.raises(ValueError, match=r"^groups: expected 6 labels"):
            npss.plot.errors(gt, {"model": pred}, fps=20, groups=groups[1:])

    def test_more_models_than_colours(self, motion):
        preds = {str(i): motion[1] + i for i in range(12)}
        lines = npss.plot.errors(motion[0], preds, fps=25).axes[0].get_lines()[:12]
        assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == 12
        assert len({line.get_linestyle() for line in lines[:4]}) == 4

    @pytest.mark.parametrize(
        ("preds", "error", "message"),
        [
            ([], TypeError, "preds: expected a mapping of names to predictions, got list"),
            ({}, ValueError, "preds: no model to draw"),
            ({"short": np.zeros((6, 40, 4))}, ValueError, "pred: its shape (6, 40, 4) differs"),
            ({"text": "abc"}, TypeError, "pred: expected real numbers, got strings"),
        ],
    )
    def test_bad_predictions(self, motion, preds, error, message):
        with pytest.raises(error, match=f"^{re.escape(message)}") as raised:
            npss.plot.errors(motion[0], preds, fps=25)
        if preds:
            assert str(raised.value).endswith(f"; for {next(iter(preds))!r} of preds")

    def test_names_that_are_drawn_alike(self, motion):
        with pytest.raises(ValueError, match=r"^preds: two models are called 'a b'; for 'a  b' of preds"):
            npss.plot.errors(motion[0], {"a b": motion[1], "a  b": motion[1]}, fps=25)

    @pytest.mark.parametrize("options", [{"fps": -1}, {"fps": 25, "level": 1}])
    def test_bad_options(self, motion, options):
        with pytest.raises(ValueError, match=r"^(fps|level): expected"):
            npss.plot.errors(motion[0], {"model": motion[1]}, **options)


@pytest.fixture(scope="module")
def motions():
    first, second = np.random.default_rng(3).normal(size=(2, 20, 4, 3))
    return {"ground truth": first, "model": second[:10]}


class TestFilmStrip:
    CROSS = Skeleton(["root", "LeftHand", "RightHand", "head"], [-1, 0, 0, 0], np.array([[0, 0, 0], *np.eye(3)]))

    def bones(self, axes):
        """The drawn lines by colour."""
        (lines,) = (one for one in axes.collections if isinstance(one, LineCollection))
        return {to_hex(c): s for c, s in zip(lines.get_color(), lines.get_segments(), strict=True)}

    @pytest.mark.parametrize(
        ("options", "across", "upwards"),
        [
            ({"azimuth": 0}, [1, 0, 0], [0, 1, 0]),
            ({"azimuth": 90}, [0, 0, -1], [0, 1, 0]),
            ({"azimuth": -90}, [0, 0, 1], [0, 1, 0]),
            ({}, [0.5, 0, 3**0.5 / 2], [0, 1, 0]),
            ({"up": "z", "azimuth": 0}, [1, 0, 0], [0, 0, 1]),
            ({"up": "z", "azimuth": 90}, [0, 1, 0], [0, 0, 1]),
        ],
    )
    def test_bones_are_seen_from_their_side(self, motions, options, across, upwards):
        figure = npss.plot.film_strip(motions, fps=25, at_ms=(40, 400), skeleton=self.CROSS, **options)
        cells = np.reshape(figure.axes, (2, 2))
        for row, positions in zip(cells, motions.values(), strict=True):
            for axes, frame in zip(row, (0, 9), strict=True):
                place = (positions[frame] - positions[frame, 0]) @ np.transpose([across, upwards])
                for joint, colour in ((1, "#0072b2"), (2, "#d55e00"), (3, "#000000")):
                    np.testing.assert_allclose(self.bones(axes)[colour], [place[joint], [0, 0]], rtol=0, atol=1e-12)
                low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
                assert ((low < place) & (place < high)).all()
                assert axes.get_aspect() == 1

    @pytest.mark.parametrize(("azimuth", "order"), [(0, [3, 2, 1]), (180, [1, 2, 3])])
    def test_the_near_side_is_drawn_last(self, azimuth, order):
        positions = np.array([[[0, 0, 0], [0.1, 1, 3], [0.2, 1, 2], [0.3, 1, 1]]])
        figure = npss.plot.film_strip({"a": positions}, fps=25, at_ms=[40], skeleton=self.CROSS, azimuth=azimuth)
        (lines,) = figure.axes[0].collections
        assert [abs(round(10 * segment[0, 0])) for segment in lines.get_segments()] == order

    def test_what_it_says(self, motions):
        figure = npss.plot.film_strip(motions, fps=25, at_ms=(40, 400), skeleton=self.CROSS)
        assert [axes.get_title() for axes in figure.axes] == ["40 ms", "400 ms", "", ""]
        assert [axes.get_ylabel() for axes in figure.axes] == ["ground truth", "", "model", ""]
        note = "left side blue, right side orange; times after the last seed frame, 25 frames per second"
        assert note in texts(figure)

    def test_human36m_as_documented(self):
        still = poses_to_positions(np.zeros((100, 99)))
        figure = npss.plot.film_strip({"still": still}, fps=25, skeleton=H36M)
        assert [axes.get_title() for axes in figure.axes] == ["160 ms", "560 ms", "1000 ms", "2000 ms", "4000 ms"]
        (lines,) = figure.axes[0].collections
        assert len(lines.get_segments()) == len(H36M.bones)

    def test_all_joints_in_one_place(self):
        figure = npss.plot.film_strip({"dot": np.zeros((1, 4, 3))}, fps=25, at_ms=[40], skeleton=self.CROSS)
        assert figure.axes[0].get_xlim() == (-1, 1)

    @pytest.mark.parametrize(
        ("options", "error", "message"),
        [
            ({"motions": [1]}, TypeError, "motions: expected a mapping of names to positions, got list"),
            ({"motions": {}}, ValueError, "motions: no motion to draw"),
            (
                {"motions": {"a": np.zeros((9, 4))}},
                ValueError,
                "motions['a']: expected shape (T, J, 3) = (frames, 4, 3)",
            ),
            ({"motions": {"a": np.zeros((0, 4, 3))}}, ValueError, "motions['a']: expected shape (T, J, 3)"),
            ({"motions": {"a": np.full((9, 4, 3), np.inf)}}, ValueError, "motions['a']: inf at index (0, 0, 0)"),
            ({"at_ms": ()}, ValueError, "at_ms: no time to draw"),
            ({"at_ms": (440,)}, ValueError, "at_ms: 440 ms is out of range"),
            ({"at_ms": (50,)}, ValueError, "at_ms: 50 ms is not a whole number of frames"),
            ({"fps": 0}, ValueError, "fps: expected a positive"),
            ({"up": "x"}, ValueError, "up: expected one of y, z"),
            ({"azimuth": np.inf}, ValueError, "azimuth: expected an angle in degrees, got inf"),
            ({"azimuth": "left"}, ValueError, "azimuth: expected an angle in degrees, got 'left'"),
        ],
    )
    def test_bad_arguments(self, motions, options, error, message):
        given = {"motions": motions, "fps": 25, "at_ms": (40,), "skeleton": self.CROSS, **options}
        with pytest.raises(error, match=f"^{re.escape(message)}"):
            npss.plot.film_strip(given.pop("motions"), **given)


def record(distortion, strength, *, unit="rad", **npss_values):
    signatures = {name: f"npss|version:1|convention:{name}" for name in npss_values}
    return {
        "distortion": distortion,
        "strength": strength,
        "unit": unit,
        "euler_error": 7 * strength,
        "npss": npss_values,
        "signatures": {**signatures, "euler_error": "euler_error|version:1"},
    }


class TestSensitivity:
    ROWS = (
        record("still", 0.5, unit="", paper=3, released=1),
        record("noise", 0.2, paper=4, released=2),
        record("noise", 0.0, paper=0, released=0),
        record("shift", 0.5, unit="strides", paper=1, released=5),
        record("shift", 0.0, unit="strides", paper=0, released=0),
    )

    def test_a_panel_for_each_metric_and_distortion(self):
        figure = npss.plot.sensitivity(self.ROWS)
        panels = np.reshape(figure.axes, (3, 2))
        drawn = [[list(line.get_ydata()) for line in axes.get_lines()] for axes in panels.ravel()]
        still = [[3.5, 3.5], [3, 3], [1, 1]]
        curves = [[[0, 1.4], [0, 3.5]], [[0, 4], [0, 1]], [[0, 2], [0, 5]]]
        np.testing.assert_allclose(drawn, [[c, s] for row, s in zip(curves, still, strict=True) for c in row])
        assert list(panels[0, 1].get_lines()[0].get_xdata()) == [0.0, 0.5]
        assert [axes.get_title() for axes in panels[0]] == ["noise", "shift"]
        assert [axes.get_xlabel() for axes in panels[2]] == ["rad", "strides"]
        assert [axes.get_ylabel() for axes in panels[:, 0]] == ["Euler error (rad)", "NPSS paper", "NPSS released"]
        assert all(len({axes.get_ylim() for axes in row}) == 1 and row[0].get_ylim()[0] == 0 for row in panels)
        said = texts(figure)
        assert "still" in said
        assert "euler_error|version:1\nnpss|version:1|convention:paper\nnpss|version:1|convention:released" in said

    def test_without_a_yardstick(self):
        figure = npss.plot.sensitivity(self.ROWS[1:])
        assert figure.axes[0].get_legend() is None

    @pytest.mark.parametrize(
        ("rows", "error", "message"),
        [
            ([], ValueError, "rows: no records to draw"),
            (3, TypeError, "rows: expected a sequence of records"),
            ([3], TypeError, "rows: expected records, got 3 at index 0"),
            ([ROWS[0], {"unit": "rad"}], ValueError, "rows: the record at index 1 lacks distortion, strength, euler_"),
            ([ROWS[0], record("a", 1, paper=2)], ValueError, "rows: the conventions of the record at index 1 differ"),
            (ROWS[:1], ValueError, "rows: no distortion has several strengths"),
        ],
    )
    def test_bad_records(self, rows, error, message):
        with pytest.raises(error, match=f"^{re.escape(message)}"):
            npss.plot.sensitivity(rows)


class TestModels:
    def test_it_shows_the_numbers_of_the_leaderboard(self):
        board = ranked(convention="released")
        figure = npss.plot.models(board)
        assert [axes.get_title(loc="left") for axes in figure.axes] == ["walking", "eating"]
        assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["close", "far"]
        for axes, action in zip(figure.axes, ("walking", "eating"), strict=True):
            drawn = {tuple(line.get_xdata()): line for line in axes.get_lines()}
            rows = board.tidy[board.tidy["action"] == action]
            assert len(drawn) == 2 * len(rows)
            for row in rows.itertuples():
                assert (row.low, row.high) in drawn
                white = to_hex(drawn[(row.value,)].get_markerfacecolor()) == "#ffffff"
                assert white == row.worse
        assert board.tidy["worse"].any()
        written = "\n".join(texts(figure))
        assert "lower is better" in written
        assert "Intervals: 95 %" in written
        assert "Range: the lowest" in written
        assert "empty: significantly worse" in written
        for signature in set(board.tidy["signature"]):
            assert signature in written

    def test_published_rows_stand_beside(self):
        board = npss.leaderboard(
            [
                {
                    "model": "mine",
                    "action": "walking",
                    "npss": {"released": 0.9},
                    "signature": npss.signature(
                        "released", representation="euler", frames=100, fps=25, protocol="srnn-8", unwrap="off"
                    ),
                }
            ],
            published=True,
        )
        figure = npss.plot.models(board)
        assert "VGRU-d (published)" in texts(figure)
        assert {"yours", "published"} <= set(texts(figure))

    def test_what_is_refused(self):
        with pytest.raises(TypeError, match=r"^board: expected a leaderboard"):
            npss.plot.models({"a": 1})
        with pytest.raises(ValueError, match=r"^column: expected one of NPSS paper, got 'NPSS released'"):
            npss.plot.models(ranked(), column="NPSS released")


GT, PRED = np.random.default_rng(0).normal(size=(2, 5, 40, 3)).cumsum(axis=2)


def ranked(names=("close", "far"), **options):
    """A leaderboard of predictions on two actions, of twelve sequences each."""
    pytest.importorskip("pandas")
    rng = np.random.default_rng(0)
    gt = rng.normal(size=(12, 30, 3)).cumsum(axis=1)
    preds = {
        name: gt + size * rng.normal(size=gt.shape).cumsum(axis=1) for name, size in zip(names, (0.1, 2), strict=True)
    }
    reports = {
        name: {"walking": npss.report(gt, pred, **options), "eating": npss.report(gt[:4], pred[:4], **options)}
        for name, pred in preds.items()
    }
    return npss.leaderboard(reports)


PICTURES = {
    "spectra": lambda: npss.plot.spectra(GT, PRED, fps=25, convention="literal"),
    "contributions": lambda: npss.plot.contributions(npss.report(GT, PRED)),
    "errors": lambda: npss.plot.errors(GT, {"model": PRED}, fps=25),
    "models": lambda: npss.plot.models(ranked()),
    "film_strip": lambda: npss.plot.film_strip({"a": GT[:, :4]}, fps=25, at_ms=[40], skeleton=TestFilmStrip.CROSS),
    "sensitivity": lambda: npss.plot.sensitivity(TestSensitivity.ROWS),
}


def test_every_picture_is_here():
    assert tuple(PICTURES) == ("spectra", "contributions", "errors", "models", "film_strip", "sensitivity")
    assert sorted(PICTURES) == npss.plot.__all__


@pytest.mark.parametrize("name", PICTURES)
def test_renders_in_whole(name, tmp_path):
    settings = dict(mpl.rcParams)
    figure = PICTURES[name]()
    figure.savefig(tmp_path / "picture.svg")
    assert ElementTree.parse(tmp_path / "picture.svg").getroot().tag == "{http://www.w3.org/2000/svg}svg"
    figure.savefig(tmp_path / "picture.png", dpi=60)
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert dict(mpl.rcParams) == settings
    assert "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()
    note = figure.findobj(lambda artist: isinstance(artist, Text) and artist.get_text() == figure.get_supxlabel())[0]
    paper = figure.bbox.padded(2)
    assert paper.contains(*note.get_window_extent().min)
    assert paper.contains(*note.get_window_extent().max)
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert paper.contains(*box.min)
        assert paper.contains(*box.max)
        assert box.y0 >= note.get_window_extent().y1 - 2  # nothing lies over the footnote


def test_a_long_signature_takes_several_lines(motion):
    convention = npss.Convention(power="real", weight="uniform")
    stated = npss.report(
        *motion, convention=convention, fps=25, protocol="srnn-8", representation="euler", extra={"note": 30 * "a, "}
    )
    figure = npss.plot.contributions(stated)
    figure.savefig(io.BytesIO(), format="png", dpi=60)
    note = next(text for text in figure.findobj(Text) if text.get_text() == figure.get_supxlabel())
    assert note.get_window_extent().x1 < figure.bbox.x1
    assert note.get_text().count("\n") > 1
    assert f"joints without a share: 0\n{stated.signature}" in texts(figure)


#: What a user may have in a matplotlibrc.
SETTINGS = {
    "text.usetex": True,
    "axes.facecolor": "black",
    "font.size": 30,
    "lines.linewidth": 9,
    "axes.grid": True,
    "figure.constrained_layout.use": False,
    "savefig.dpi": 10,
    "savefig.bbox": "tight",
    "svg.fonttype": "none",
    "axes.formatter.use_mathtext": True,
    "path.sketch": (1, 100, 2),
}


def pixels(figure):
    figure.savefig(written := io.BytesIO(), format="png", dpi=50)
    return written.getvalue()


@pytest.mark.parametrize("name", PICTURES)
def test_user_settings_change_nothing(name):
    """Neither while it is made nor when it is written; with text.usetex, all of it would be given to LaTeX."""
    expected = pixels(PICTURES[name]())
    with mpl.rc_context(SETTINGS):
        figure = PICTURES[name]()
        assert pixels(figure) == expected
        assert dict(mpl.rcParams) == dict(mpl.rcParams) | SETTINGS


HOSTILE = r"a_b $x_1$ 5% ~ ^2 {c} \d & # \$"


def test_names_are_printed_unchanged(motion, motions):
    gt, pred = motion
    with mpl.rc_context({"text.usetex": True}):
        figures = [
            npss.plot.errors(gt, {HOSTILE: pred}, fps=25),
            npss.plot.spectra(gt, pred, fps=25, names=(HOSTILE, "b"), feature_names=[HOSTILE, *"bcde"]),
            npss.plot.contributions(npss.report(gt, pred, feature_names=[f"{HOSTILE}.x", *"bcde"])),
            npss.plot.models(ranked((HOSTILE, "b"))),
            npss.plot.film_strip({HOSTILE: motions["model"]}, fps=25, at_ms=(40,), skeleton=TestFilmStrip.CROSS),
            npss.plot.sensitivity([row | {"distortion": HOSTILE} for row in TestSensitivity.ROWS[-2:]]),
        ]
        for figure in figures:
            figure.savefig(written := io.StringIO(), format="svg")
            assert HOSTILE in unescape(written.getvalue())  # texts are paths, and stand beside them as comments


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        (f"{60 * 'a'}/seed-0", f"{20 * 'a'}…{12 * 'a'}/seed-0"),
        ("_hidden", "\N{ZERO WIDTH SPACE}_hidden"),
        ("a\nb\x1b", "a b"),
    ],
)
def test_what_a_label_says(name, shown):
    assert label(name) == shown


def test_a_model_has_a_name(motion):
    with pytest.raises(ValueError, match="the name of a model is empty: ' '; for ' ' of preds"):
        npss.plot.errors(motion[0], {" ": motion[1]}, fps=25)


@pytest.mark.parametrize("name", PICTURES)
def test_without_matplotlib_says_what_to_install(name, monkeypatch):
    monkeypatch.delitem(sys.modules, "npss.plot._figure", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(
        ImportError, match=r"^npss\.plot needs matplotlib; in the project's folder: pip install '\.\[plot\]'$"
    ):
        PICTURES[name]()


def test_importing_does_not_import_matplotlib():
    code = "import sys, npss.plot; assert not any(name.startswith('matplotlib') for name in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("name", npss.plot.__all__)
def test_is_documented_in_whole(name):
    text = inspect.getdoc(getattr(npss.plot, name))
    for section in ("Parameters", "Returns", "Raises", "Examples"):
        assert f"\n{section}\n---" in text, section


def luminance(colour):
    values = np.array(mpl.colors.to_rgb(colour))
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def test_text_can_be_read():
    """WCAG's contrast of 4.5 to white."""
    from npss.plot.style import GREY

    assert 1.05 / (luminance(GREY) + 0.05) >= 4.5


@pytest.mark.skipif(not PAGE.exists(), reason="the documentation is not beside the tests")
def test_the_program_of_the_page(tmp_path):
    (program,) = blocks(PAGE, "python")
    (tmp_path / "program.py").write_text(program, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", "program.py"], capture_output=True, encoding="utf-8", cwd=tmp_path, timeout=240
    )
    assert done.returncode == 0, done.stderr
    assert {file.stem for file in tmp_path.glob("*.svg")} == set(PICTURES)


def test_a_notebook_shows_a_figure():
    figure = PICTURES["spectra"]()
    assert figure._repr_png_().startswith(b"\x89PNG")
