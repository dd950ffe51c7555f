"""Blocks: windows against plain loops, sums against definitions, and error rates by simulation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overlap
from npss import protocol
from npss._analysis.blocks import STATISTICS_VERSION, Blocks, read_groups, statistics_version
from npss.protocol import (
    TEST_LENGTHS,
    Window,
    chain_blocks,
    random_windows,
    srnn_windows,
    stretch_blocks,
    window_blocks,
)
from npss.ranking._submissions import known_blocks

LENGTHS = st.tuples(st.integers(167, 2000), st.integers(167, 2000))


def partition(labels):
    """Return which places have the same label, whatever it is; those of None are left out."""
    return {tuple(i for i, other in enumerate(labels) if other == label) for label in set(labels) - {None}}


def linked(windows):
    """Join windows that share a target frame, pair by pair, until nothing changes."""
    groups = [{i} for i in range(len(windows))]
    frames = [{(w.clip, frame) for frame in range(w.target.start, w.target.stop)} for w in windows]
    for i in range(len(windows)):
        for j in range(i):
            if frames[i] & frames[j]:
                both = next(g for g in groups if i in g) | next(g for g in groups if j in g)
                groups = [g for g in groups if not g & both] + [both]
    return {tuple(sorted(group)) for group in groups}


class TestWindows:
    @pytest.mark.parametrize(
        ("action", "blocks"), [("walking", 6), ("eating", 5), ("smoking", 6), ("walkingdog", 4), ("posing", 6)]
    )
    def test_the_eight_windows_are_fewer_blocks(self, action, blocks):
        for name in ("srnn-8", "srnn-8-late"):
            labels = window_blocks(name, TEST_LENGTHS[action])
            assert len(labels) == 8
            assert len(set(labels)) == blocks

    def test_the_pair_of_the_issue(self):
        labels = window_blocks("srnn-8", TEST_LENGTHS["walking"])  # starts 304 and 332 share 72 of 100 target frames
        starts = [window.start for window in srnn_windows(TEST_LENGTHS["walking"])]
        assert labels[starts.index(304)] == labels[starts.index(332)] == "clip 1, frames 354-481"

    @given(lengths=LENGTHS, n_target=st.integers(1, 100), late=st.booleans())
    def test_chains_join_windows_that_share_frames(self, lengths, n_target, late):
        windows = srnn_windows(lengths, n_target=n_target, late=late)
        assert partition(chain_blocks(windows)) == linked(windows)
        assert chain_blocks(windows) == window_blocks("srnn-8-late" if late else "srnn-8", lengths, n_target=n_target)

    @settings(max_examples=15)
    @given(lengths=LENGTHS, n_target=st.integers(20, 100))
    def test_stretches_hold_whole_targets(self, lengths, n_target):
        windows = random_windows(lengths, n_target=n_target)
        labels = stretch_blocks(windows, lengths)
        assert labels == window_blocks("random-256", lengths, n_target=n_target)
        for window, label in zip(windows, labels, strict=True):
            expected = None
            for first in range(0, lengths[window.clip] - 2 * n_target + 1, 2 * n_target):
                if first <= window.target.start and window.target.stop <= first + 2 * n_target:
                    expected = f"clip {window.clip}, frames {first}-{first + 2 * n_target - 1}"
            assert label == expected

    def test_the_rest_of_a_clip_is_no_block(self):
        windows = [Window(0, start, 50, 100) for start in (-50, 49, 50, 51, 150, 250, 349, 350, 351)]
        labels = stretch_blocks(windows, [599])
        first, second = "clip 0, frames 0-199", "clip 0, frames 200-399"
        assert labels == (first, first, first, None, second, second, None, None, None)
        assert stretch_blocks([Window(0, 350, 50, 100)], [600]) == ("clip 0, frames 400-599",)

    def test_chains_link_windows_that_do_not_share_frames_themselves(self):
        windows = [Window(0, start, 1, 100) for start in (0, 150, 75, 250, 400)] + [Window(1, 0, 1, 100)]
        a, b = "clip 0, frames 1-250", "clip 0, frames 251-350"
        assert chain_blocks(windows) == (a, a, a, b, "clip 0, frames 401-500", "clip 1, frames 1-100")

    def test_invalid_windows(self):
        for windows in ([3], [(0, 1, 2, 3)], [None]):
            with pytest.raises(TypeError, match=r"^windows: expected a Window, got .* at index 0"):
                chain_blocks(windows)
            with pytest.raises(TypeError, match=r"^windows: expected a Window, got .* at index 0"):
                stretch_blocks(windows, [500, 500])
        with pytest.raises(ValueError, match=r"^windows: .*clip=2.* at index 1 is not in clips of \[500, 500\] frames"):
            stretch_blocks([Window(0, 1, 50, 100), Window(2, 1, 50, 100)], [500, 500])
        with pytest.raises(ValueError, match=r"^windows: .* is not in clips"):
            stretch_blocks([Window(0, 400, 50, 100)], [500])
        with pytest.raises(ValueError, match=r"^windows: expected targets of equal length, got 25, 100 frames"):
            stretch_blocks([Window(0, 1, 50, 100), Window(0, 1, 50, 25)], [500])
        with pytest.raises(TypeError, match=r"^lengths: "):
            stretch_blocks([Window(0, 1, 50, 100)], [500.0])

    def test_invalid_protocols(self):
        with pytest.raises(ValueError, match=r"^protocol: expected one of srnn-8, srnn-8-late, random-256, got 'mine'"):
            window_blocks("mine", (1500, 1261))
        with pytest.raises(TypeError, match=r"^lengths: expected a positive integer, got None"):
            window_blocks("srnn-8", TEST_LENGTHS["waiting"])


class TestKnownBlocks:
    def test_of_clips_of_known_lengths(self):
        assert known_blocks("srnn-8", "walking", (8, 100, 99)) == window_blocks("srnn-8", (1500, 1261))
        assert known_blocks("random-256", "eating", (256, 25, 99)) == window_blocks(
            "random-256", (1638, 1166), n_target=25
        )

    @pytest.mark.parametrize(
        ("name", "action"), [("mine", "walking"), (None, "walking"), ("srnn-8", "waiting"), ("srnn-8", "gait")]
    )
    def test_where_starts_are_unknown_so_are_blocks(self, name, action):
        assert known_blocks(name, action, (8, 100, 99)) is None

    def test_other_windows(self):
        with pytest.raises(ValueError, match="walking: the protocol srnn-8 has 8 windows, got 5 sequences"):
            known_blocks("srnn-8", "walking", (5, 100, 99))


class TestSums:
    @given(
        labels=st.lists(st.sampled_from(["a", "b", "c", 1, 2, None]), min_size=1, max_size=30), seed=st.integers(0, 99)
    )
    def test_are_those_of_each_block(self, labels, seed):
        if set(labels) == {None}:
            labels[0] = "a"
        values = np.random.default_rng(seed).normal(size=(2, len(labels)))
        blocks = Blocks(read_groups("groups", labels, len(labels)), np.ones(len(labels)))
        order = [label for label in dict.fromkeys(labels) if label is not None]
        expected = [values[:, [i for i, other in enumerate(labels) if other == label]].sum(axis=1) for label in order]
        np.testing.assert_allclose(blocks.sums(values), np.transpose(expected), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(blocks.inside(values), np.sum(expected, axis=0), rtol=1e-12, atol=1e-12)
        assert (blocks.n, blocks.left_out, blocks.sequences) == (len(order), labels.count(None), len(labels))

    def test_without_labels_each_sequence_is_its_own(self):
        values = np.arange(3.0)
        blocks = Blocks(None, np.array([1.0, 0.0, 1.0]))
        assert blocks.sums(values) is values
        assert blocks.left_out == 0
        assert (blocks.n, len(blocks), str(blocks)) == (2, 3, "2 sequences, each its own block, assumed independent")

    def test_blocks_without_weight_do_not_count(self):
        blocks = Blocks(("a", "a", "b", None), np.array([0.0, 0.0, 1.0, 1.0]))
        assert (blocks.n, len(blocks), str(blocks)) == (1, 2, "1 block, 1 of 4 sequences in none")

    def test_many_blocks_take_little_memory(self):
        n = 200_000  # a table of sequences by blocks would take terabytes
        blocks = Blocks(tuple(range(n)), np.ones(n))
        np.testing.assert_array_equal(blocks.sums(np.arange(n)), np.arange(n))


def test_versions_of_statistics():
    assert statistics_version({}) == 1
    assert statistics_version({"statistics": STATISTICS_VERSION}) == STATISTICS_VERSION == 2
    for bad in (0, 3, True, "2", None, [2]):
        with pytest.raises(
            ValueError, match=r"^sequences: statistics: expected a version from 1 to 2, got .*newer npss"
        ):
            statistics_version({"statistics": bad})


# --- what they promise ------------------------------------------------------------------------------------------------

PHIS = (0.9, 0.98)


@pytest.fixture(scope="module")
def pairs():
    return overlap.generated_pairs(np.random.default_rng(1))


def slack(share, sets):
    """Four standard errors of a share."""
    return 4 * np.sqrt(share * (1 - share) / sets)


@pytest.mark.parametrize("phi", PHIS)
def test_equally_good_models_are_rarely_told_apart(pairs, phi):
    rng = np.random.default_rng(2)
    rejected, held = overlap.rates(overlap.cut(pairs, 13, rng, 20), phi, sets=400)
    assert rejected <= 0.065 + slack(0.065, 400)  # measured, of 10 000: .049 and .062
    assert held >= 0.89 - slack(0.89, 400)  # .94 and .92


@pytest.mark.parametrize("phi", PHIS)
def test_intervals_of_ten_blocks_hold_the_score(pairs, phi):
    _, held = overlap.rates(overlap.cut(pairs, 10, np.random.default_rng(3), 20), phi, sets=400)
    assert held >= 0.87 - slack(0.87, 400)  # .94 and .92


@pytest.mark.parametrize("phi", PHIS)
def test_windows_themselves_are_no_blocks(pairs, phi):
    """What was wrong: errors that are exchangeable were told apart in most cases, and intervals missed."""
    patterns = [overlap.pattern(pair, unit=lambda place, window: place) for pair in pairs[:10]]
    rejected, held = overlap.rates(patterns, phi, sets=20)
    assert rejected > 0.35
    assert held < 0.7


@pytest.mark.parametrize("phi", PHIS)
def test_the_eight_windows_in_chains_are_rarely_told_apart(pairs, phi):
    chained = [one for one in (overlap.pattern(pair, "srnn-8") for pair in pairs) if one.blocks.n >= 6]
    rejected, _ = overlap.rates(chained[:20], phi, sets=400)
    assert rejected <= 0.05 + slack(0.05, 400)


def test_of_real_windows(h36m_root):
    from npss_baselines.data.h36m_source import Human36M

    (task,) = Human36M().tasks(h36m_root, ["walking"], "random-256")
    assert task.groups == window_blocks("random-256", TEST_LENGTHS["walking"])
    assert str(Blocks(task.groups, np.ones(256))) == "13 blocks, 121 of 256 sequences in none"
    # The windows of a block are from one stretch of 200 frames: where labels are equal, so are frames that both hold.
    windows = protocol.random_windows(TEST_LENGTHS["walking"], n_target=100)
    frames = {}
    for window, target, label in zip(windows, task.target, task.groups, strict=True):
        for frame, pose in zip(range(window.target.start, window.target.stop), target, strict=True):
            if label is not None:
                known, first = frames.setdefault((window.clip, frame), (pose, label))
                assert first == label  # no frame is in two blocks
                np.testing.assert_array_equal(known, pose)
