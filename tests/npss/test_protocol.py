"""Windows, times and normalisation, against their definitions and against Human3.6M."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss import protocol
from npss.protocol import (
    COLUMNS,
    SLICES_MS,
    TEST_SUBJECT,
    TRAIN_SUBJECTS,
    frames_to_ms,
    ms_to_frames,
    normalization,
    random_windows,
    srnn_windows,
)

LENGTHS = st.tuples(st.integers(167, 5000), st.integers(167, 5000))
# Lengths of clips of Human3.6M's test subject at 25 frames per second, and known starts of its windows.
KNOWN = {
    "walking": ((1500, 1261), [1087, 955, 1145, 332, 660, 304, 201, 54]),
    "eating": ((1638, 1166), [1426, 374, 1087, 156, 1329, 955, 1145, 332]),
    "smoking": ((1601, 1711), [1426, 1398, 1087, 1180, 1329, 955, 1145, 332]),
}


class TestConstants:
    def test_actions(self):
        assert len(set(protocol.ACTIONS)) == 15
        assert list(protocol.ACTIONS) == sorted(protocol.ACTIONS)

    def test_columns(self):
        text = "0-9, 12-15, 21-24, 27-30, 36-47, 51-57, 60-62, 75-81, 84-86"
        ends = [[int(end) for end in part.split("-")] for part in text.split(", ")]
        assert list(COLUMNS) == [column for first, last in ends for column in range(first, last + 1)]
        assert len(COLUMNS) == 54

    def test_lengths_of_the_test_clips(self):
        assert tuple(protocol.TEST_LENGTHS) == protocol.ACTIONS
        assert {action: protocol.TEST_LENGTHS[action] for action in KNOWN} == {
            action: lengths for action, (lengths, _) in KNOWN.items()
        }
        assert sum(length is None for pair in protocol.TEST_LENGTHS.values() for length in pair) == 6
        with pytest.raises(TypeError):
            protocol.TEST_LENGTHS["walking"] = (1500, 1500)

    def test_the_test_subject_is_not_a_training_subject(self):
        assert TEST_SUBJECT not in TRAIN_SUBJECTS


class TestWindows:
    @pytest.mark.parametrize("action", KNOWN)
    def test_known_starts(self, action):
        lengths, starts = KNOWN[action]
        windows = srnn_windows(lengths)
        assert [window.start for window in windows] == starts
        assert [window.clip for window in windows] == [0, 1] * 4

    @given(LENGTHS, st.integers(1, 50), st.integers(1, 100))
    def test_late_windows_are_one_frame_later(self, lengths, n_seed, n_target):
        windows = srnn_windows(lengths, n_seed=n_seed, n_target=n_target)
        late = srnn_windows(lengths, n_seed=n_seed, n_target=n_target, late=True)
        assert late == tuple(window._replace(start=window.start + 1) for window in windows)
        assert all(window.target.stop <= lengths[window.clip] for window in late)

    def test_late_windows_reach_the_last_frame(self):
        """The last draw leaves one frame of the clip unused; late windows use exactly that frame."""
        stops = {window.target.stop for window in srnn_windows((167, 167), late=True)}
        assert stops == {167}

    def test_late_is_true_or_false(self):
        with pytest.raises(TypeError, match="late: expected True or False, got 1"):
            srnn_windows((1500, 1261), late=1)

    def test_slices(self):
        window = srnn_windows((1500, 1261))[0]
        assert window.seed_frames == slice(1087, 1137)
        assert window.target == slice(1137, 1237)

    def test_the_first_random_windows_hold_the_eight(self):
        """The generator and the range of its draws are the same."""
        starts = [window.start for window in random_windows((1500, 1261), n_seed=50)]
        assert starts[:8] == KNOWN["walking"][1]

    @given(LENGTHS)
    def test_random_windows_by_the_definition(self, lengths):
        generator = np.random.RandomState(1234567890)
        for i, window in enumerate(random_windows(lengths)):
            boundary = generator.randint(16, lengths[i % 2] - 150) + 50
            assert window.clip == i % 2
            assert (window.seed_frames.start, window.seed_frames.stop) == (boundary - 10, boundary)
            assert (window.target.start, window.target.stop) == (boundary, boundary + 25)
        assert i == 255

    @given(LENGTHS, st.integers(1, 50), st.integers(1, 100))
    def test_the_boundaries_do_not_depend_on_numbers_of_frames(self, lengths, n_seed, n_target):
        for draw in (srnn_windows, random_windows):
            windows = draw(lengths, n_seed=n_seed, n_target=n_target)
            assert [window.seed_frames.stop for window in windows] == [
                window.seed_frames.stop for window in draw(lengths)
            ]

    @given(LENGTHS, st.integers(1, 50), st.integers(1, 100))
    def test_windows_alternate_and_lie_within_their_clips(self, lengths, n_seed, n_target):
        eight = srnn_windows(lengths, n_seed=n_seed, n_target=n_target)
        many = random_windows(lengths, n_seed=n_seed, n_target=n_target)
        for windows, count in ((eight, 8), (many, 256)):
            assert [window.clip for window in windows] == [0, 1] * (count // 2)
            for window in windows:
                assert 16 <= window.seed_frames.start < window.seed_frames.stop == window.target.start
                assert window.target.stop <= lengths[window.clip]
                assert window.seed_frames.stop - window.seed_frames.start == window.n_seed
                assert window.target.stop - window.target.start == window.n_target
        assert eight == srnn_windows(list(lengths), n_seed=n_seed, n_target=n_target)

    def test_the_global_generator_is_unchanged(self):
        np.random.seed(0)  # noqa: NPY002
        before = np.random.get_state()[1].copy()  # noqa: NPY002
        srnn_windows((1500, 1261))
        assert np.array_equal(before, np.random.get_state()[1])  # noqa: NPY002

    @pytest.mark.parametrize("draw", [srnn_windows, random_windows])
    @pytest.mark.parametrize(
        ("error", "lengths", "message"),
        [
            (ValueError, (1500,), "lengths: expected those of the two clips of an action, got 1 lengths"),
            (ValueError, (1500, 1500, 1500), "lengths: expected those of the two clips of an action, got 3 lengths"),
            (ValueError, (1500, 0), "lengths: expected a positive integer, got 0"),
            (ValueError, (1500, 166), "lengths: clip 1 has 166 frames; windows of 150 frames need at least 167"),
            (ValueError, (12, 1500), "lengths: clip 0 has 12 frames"),
            (TypeError, (1500, 1261.0), "lengths: expected a positive integer, got 1261.0"),
            (TypeError, 1500, "lengths: expected a sequence of numbers, got 1500"),
        ],
    )
    def test_bad_lengths(self, draw, error, lengths, message):
        options = {"n_seed": 50, "n_target": 100}
        with pytest.raises(error, match=message):
            draw(lengths, **options)

    def test_the_shortest_clips(self):
        assert {window.start for window in srnn_windows((167, 167))} == {16}
        assert {window.target.stop for window in random_windows((167, 167), n_target=100)} == {166}

    @pytest.mark.parametrize("draw", [srnn_windows, random_windows])
    @pytest.mark.parametrize("name", ["n_seed", "n_target"])
    @pytest.mark.parametrize(
        ("error", "value"), [(ValueError, 0), (ValueError, -1), (TypeError, 2.5), (TypeError, True)]
    )
    def test_bad_numbers_of_frames(self, draw, name, error, value):
        with pytest.raises(error, match=f"^{name}: expected a positive integer"):
            draw((1500, 1261), **{name: value})

    @pytest.mark.parametrize(("name", "limit"), [("n_seed", 50), ("n_target", 100)])
    def test_the_most_frames_of_random_windows(self, name, limit):
        random_windows((1500, 1261), **{name: limit})
        with pytest.raises(ValueError, match=f"{name}: expected at most {limit} frames, got {limit + 1}"):
            random_windows((1500, 1261), **{name: limit + 1})


class TestTimes:
    def test_the_times_of_the_field(self):
        assert ms_to_frames((*SLICES_MS, 2000, 4000)) == [1, 3, 7, 9, 13, 24, 49, 99]
        assert frames_to_ms([1, 3, 7, 9, 13, 24, 49, 99]) == [*SLICES_MS, 2000, 4000]

    def test_they_index_a_curve(self):
        assert np.arange(25)[ms_to_frames(SLICES_MS)].tolist() == [1, 3, 7, 9, 13, 24]

    @given(
        st.lists(st.integers(0, 10**6), max_size=5),
        st.one_of(st.integers(1, 1000), st.sampled_from([23.976, 29.97, 59.94, 119.88, 30000 / 1001, 0.1])),
    )
    def test_round_trip(self, frames, fps):
        assert ms_to_frames(frames_to_ms(frames, fps=fps), fps=fps) == frames

    @given(st.integers(1, 10**6), st.sampled_from([1, 2, 4, 5, 8, 10, 20, 25, 40, 50, 100, 125, 200, 250, 500, 1000]))
    def test_whole_milliseconds_are_ints(self, count, fps):
        (time,) = frames_to_ms([count - 1], fps=fps)
        assert isinstance(time, int)
        assert time == count * 1000 // fps

    def test_numpy_numbers(self):
        assert ms_to_frames(np.array([80, 160]), fps=np.float32(25)) == [1, 3]
        assert frames_to_ms(np.array([1, 3]), fps=np.int64(25)) == [80, 160]

    @given(st.integers(1, 10**6), st.integers(1, 240))
    def test_errors_name_the_nearest_times(self, time, fps):
        frames, rest = divmod(time * fps, 1000)
        if rest == 0:
            assert ms_to_frames([time], fps=fps) == [frames - 1]
            return
        with pytest.raises(
            ValueError, match=f"at_ms: {time:g} ms is not a whole number of frames".replace("+", r"\+")
        ) as e:
            ms_to_frames([time], fps=fps)
        nearest = str(e.value).partition("nearest: ")[2].removesuffix(" ms").split(" and ")
        expected = sorted({max(frames, 1), frames + 1})
        assert [float(t) for t in nearest] == pytest.approx([count * 1000 / fps for count in expected], rel=1e-9)

    @pytest.mark.parametrize(
        ("error", "at_ms", "message"),
        [
            (ValueError, [100], "at_ms: 100 ms is not a whole .* 25 frames per second; nearest: 80 and 120 ms"),
            (ValueError, [80, 0], "at_ms: 0 ms is out of range .* nearest: 40 ms"),
            (ValueError, [-80], "at_ms: -80 ms is out of range .* nearest: 40 ms"),
            (ValueError, [10], "at_ms: 10 ms is not a whole .* nearest: 40 ms"),
            (ValueError, [float("nan")], "at_ms: nan ms .* is not a frame"),
            (ValueError, [float("inf")], "at_ms: inf ms .* is not a frame"),
            (TypeError, ["80"], "at_ms: expected a time in ms, got '80'"),
            (TypeError, [True], "at_ms: expected a time in ms, got True"),
            (TypeError, 80, "at_ms: expected a sequence of numbers, got 80"),
        ],
    )
    def test_bad_times(self, error, at_ms, message):
        with pytest.raises(error, match=message):
            ms_to_frames(at_ms)

    @pytest.mark.parametrize(
        ("error", "frames", "message"),
        [
            (ValueError, [1, -1], "frames: expected indices of predicted frames, 0 or more, got -1"),
            (TypeError, [1.0], "frames: expected indices of predicted frames, got 1.0"),
            (TypeError, [False], "frames: expected indices of predicted frames, got False"),
            (TypeError, 3, "frames: expected a sequence of numbers, got 3"),
        ],
    )
    def test_bad_frames(self, error, frames, message):
        with pytest.raises(error, match=message):
            frames_to_ms(frames)

    @pytest.mark.parametrize("convert", [ms_to_frames, frames_to_ms])
    @pytest.mark.parametrize(("error", "fps"), [(ValueError, 0), (ValueError, float("inf")), (TypeError, "25")])
    def test_bad_rates(self, convert, error, fps):
        with pytest.raises(error, match=r"^fps: expected a positive"):
            convert([80], fps=fps)


def poses(seed=0, lengths=(30, 20, 1), dtype=np.float64):
    """Clips of five columns; the second and the fourth are constant."""
    rng = np.random.default_rng(seed)
    clips = [rng.normal(size=(length, 5)) * [1, 0, 1e-3, 0, 1e3] + [5, 7, 0, 0, 1e4] for length in lengths]
    return [clip.astype(dtype) for clip in clips]


class TestNormalization:
    def test_the_definition(self):
        clips = poses()
        stacked = np.concatenate(clips)
        fitted = normalization(clips)
        assert fitted.columns == (0, 2, 4)
        np.testing.assert_allclose(fitted.mean, stacked.mean(axis=0), rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(fitted.std[[0, 2, 4]], stacked.std(axis=0)[[0, 2, 4]], rtol=1e-13)
        assert fitted.std[[1, 3]].tolist() == [1, 1]

    @given(st.integers(0, 1000), st.lists(st.integers(1, 30), min_size=2, max_size=5))
    def test_the_split_into_clips_does_not_matter(self, seed, lengths):
        clips = poses(seed, lengths)
        one, many = normalization([np.concatenate(clips)]), normalization(iter(clips))
        np.testing.assert_allclose(one.mean, many.mean, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(one.std, many.std, rtol=1e-10)

    @given(st.integers(0, 1000))
    def test_normalized_clips_have_mean_0_and_deviation_1(self, seed):
        clips = poses(seed)
        fitted = normalization(clips)
        values = np.concatenate([fitted.normalize(clip) for clip in clips])
        assert values.shape == (51, 3)
        np.testing.assert_allclose(values.mean(axis=0), 0, rtol=0, atol=1e-11)
        np.testing.assert_allclose(values.std(axis=0), 1, rtol=1e-11)

    @given(st.integers(0, 1000), st.sampled_from([(), (4,), (2, 3), (0,)]))
    def test_round_trip(self, seed, shape):
        fitted = normalization(poses())
        rng = np.random.default_rng(seed)
        given_poses = rng.normal(size=(*shape, 5)) * 1e3
        back = fitted.unnormalize(fitted.normalize(given_poses))
        assert back.shape == given_poses.shape
        np.testing.assert_allclose(back[..., [0, 2, 4]], given_poses[..., [0, 2, 4]], rtol=1e-12, atol=1e-9)
        assert (back[..., [1, 3]] == fitted.mean[[1, 3]]).all()

    @pytest.mark.parametrize(
        ("dtype", "result"),
        [(np.float32, np.float32), (">f4", np.float32), (np.float64, np.float64), (np.float16, np.float64)]
        + [(np.longdouble, np.float64), (np.int32, np.float64), (np.uint8, np.float64)],
    )
    def test_precision(self, dtype, result):
        clips = [np.arange(10).reshape(5, 2).astype(dtype)]
        fitted = normalization(clips)
        assert fitted.mean.dtype == fitted.std.dtype == np.float64
        assert fitted.mean.tolist() == [4, 5]
        assert fitted.normalize(clips[0]).dtype == result
        assert fitted.unnormalize(fitted.normalize(clips[0]).astype(dtype)).dtype == result

    def test_float32_is_accumulated_in_float64(self):
        """In float32, a constant column far from zero would seem to vary, and one that hardly varies would be lost."""
        clip = np.full((100_000, 2), 1000.1, np.float32)
        step = 8 * np.spacing(clip[0, 0])
        clip[::2, 1] += step
        fitted = normalization([clip[:60_000], clip[60_000:]])
        assert fitted.columns == (1,)
        assert fitted.mean[0] == pytest.approx(float(clip[0, 0]), rel=1e-14)
        assert fitted.std[1] == pytest.approx(step / 2, rel=1e-9)

    def test_the_threshold_is_on_the_deviation(self):
        fitted = normalization([np.array([[-1.0], [1.0]]) * [0.999e-4, 1.001e-4]])
        assert fitted.columns == (1,)
        assert fitted.std == pytest.approx([1, 1.001e-4])

    def test_a_column_at_the_threshold_is_kept(self):
        """Only columns below it are dropped; kept columns are not divided by 1."""
        fitted = normalization([np.array([[-1e-4], [1e-4]])])
        assert fitted.columns == (0,)
        assert fitted.std.tolist() == [1e-4]

    def test_inputs_are_unchanged_and_statistics_read_only(self):
        clips = poses()
        copies = [clip.copy() for clip in clips]
        fitted = normalization(clips)
        fitted.normalize(clips[0])[...] = 0
        assert all(np.array_equal(a, b) for a, b in zip(clips, copies, strict=True))
        with pytest.raises(ValueError, match="read-only"):
            fitted.mean[0] = 0
        with pytest.raises(dataclasses.FrozenInstanceError):
            fitted.columns = ()

    @pytest.mark.parametrize(
        ("error", "clips", "message"),
        [
            (ValueError, [], "clips: expected at least one clip"),
            (ValueError, [np.zeros(3)], r"clips\[0\]: expected shape \(T, D\).* got \(3,\)"),
            (ValueError, [np.zeros((1, 2, 3))], r"clips\[0\]: expected shape \(T, D\)"),
            (ValueError, [np.eye(2), np.zeros((0, 2))], r"clips\[1\]: expected shape \(T, D\).* got \(0, 2\)"),
            (ValueError, [np.eye(2), np.eye(3)], r"clips\[1\]: expected shape \(..., 2\), got \(3, 3\)"),
            (ValueError, [np.eye(2), [[0, np.nan]]], r"clips\[1\]: nan at index \(0, 1\)"),
            (ValueError, [np.ones((4, 2))], "clips: no column has a standard deviation"),
            (ValueError, [[[0, 1e200], [1, -1e200]]], "clips: the standard deviation of column 1 is beyond float64"),
            (TypeError, [[["a", "b"]]], r"clips\[0\]: expected real numbers, got strings"),
            (TypeError, 3, "clips: expected a sequence of numbers, got 3"),
        ],
    )
    def test_bad_clips(self, error, clips, message):
        with pytest.raises(error, match=message):
            normalization(clips)

    @pytest.mark.parametrize(("method", "name", "width"), [("normalize", "poses", 5), ("unnormalize", "values", 3)])
    def test_bad_poses(self, method, name, width):
        convert = getattr(normalization(poses()), method)
        for wrong in (np.zeros(width + 1), np.float64(3), np.zeros((width, 2))):
            with pytest.raises(ValueError, match=rf"{name}: expected shape \(..., {width}\)"):
                convert(wrong)
        with pytest.raises(ValueError, match=rf"{name}: inf at index \(1, 2\)"):
            convert(np.where(np.arange(2 * width).reshape(2, width) == width + 2, np.inf, 0.0))
        with pytest.raises(TypeError, match=f"{name}: expected real numbers, got complex"):
            convert(np.zeros(width, complex))


class TestHuman36M:
    @pytest.mark.parametrize(
        ("action", "subjects"),
        [("walking", TRAIN_SUBJECTS), ("eating", TRAIN_SUBJECTS), ("smoking", (1, 6, 8, 11))],
    )
    def test_54_columns_vary(self, h36m_root, action, subjects):
        from npss_baselines.data import h36m

        clips = h36m.training_clips(h36m.open_root(h36m_root), [action], subjects=subjects)
        assert len(clips) == 2 * len(subjects)
        fitted = normalization(clips.values())
        assert fitted.columns == COLUMNS
        stacked = np.concatenate(list(clips.values())).astype(np.float64)
        np.testing.assert_allclose(fitted.mean, stacked.mean(axis=0), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(fitted.std[list(COLUMNS)], stacked.std(axis=0)[list(COLUMNS)], rtol=1e-9)

    @pytest.mark.parametrize("action", KNOWN)
    def test_lengths(self, h36m_root, action):
        from npss_baselines.data import h36m

        data = h36m.open_root(h36m_root)
        lengths = tuple(len(h36m.load(data, TEST_SUBJECT, action, clip, fps=25)) for clip in (1, 2))
        assert lengths == KNOWN[action][0]
