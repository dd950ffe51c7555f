"""What a score is made of: against a slow definition, and the properties that follow from it."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import npss
from npss._metric import kernel as _kernel
from npss._metric import power as _power
from npss._metric.convention import CHOICES
from npss._metric.parts import Parts
from npss.predictors import periodic, repeat, zero_velocity
from strategies import pairs

ALL = [npss.Convention(**dict(zip(CHOICES, values, strict=True))) for values in itertools.product(*CHOICES.values())]
TWO_SIDED = [convention for convention in ALL if convention.bins == "two-sided"]
CUMULATIVE = [convention for convention in TWO_SIDED if convention.distance == "cdf"]
FRAMES = [2, 3, 4, 5, 8, 9, 30, 31, 97, 100, 101, 300]

#: Normalised spectra and their sums are rounded by some units of 1e-16 for each of T <= 300 bins.
ROUNDING = 1e-11


def close(one, other, atol=ROUNDING):
    np.testing.assert_allclose(one, other, rtol=0, atol=atol)


def normalised(column, convention):
    """Return the normalised spectrum of a column, its share outside DC, and its total power."""
    transform = np.fft.fft(column)
    power = np.array([(c.real if convention.power == "real" else abs(c)) ** 2 for c in transform])
    if convention.bins == "one-sided":
        power = power[: len(column) // 2 + 1]
    total = power.sum()
    if total > 0:
        return power / total, power[1:].sum() / total, total
    spectrum = np.zeros(len(power))
    spectrum[0] = convention.zero == "dc"
    return spectrum, 0.0, 0.0


def distance_of(first, second, convention):
    if convention.distance == "cdf":
        first, second = np.cumsum(first), np.cumsum(second)
    return np.abs(first - second).sum()


def slow(gt, pred, convention):
    """Return form, share, the floor by shares of DC and the score, from their definitions, bin by bin."""
    rows, weights = [], []
    for i, j in np.ndindex(gt[:, 0].shape):
        x, _, weight = normalised(gt[i, :, j], convention)
        if weight == 0:
            continue
        y, outside, total = normalised(pred[i, :, j], convention)
        distance = distance_of(x, y, convention)
        form = 0.0
        if total > 0 and outside > 1e-20:
            fitted = [x[0]] + [y[k] * (1 - x[0]) / outside for k in range(1, len(y))]
            form = distance_of(x, np.array(fitted), convention)
        floor = (len(gt[i]) / 2 if convention.distance == "cdf" else 2) * abs(y[0] - x[0])
        if total == 0 and convention.zero == "empty":
            floor = distance
        rows.append((form, distance - form, floor, distance))
        weights.append(weight if convention.weight == "power" else 1.0)
    return np.average(rows, axis=0, weights=weights)


def parts_of(gt, pred, convention):
    """Return the parts of a report, after checks that hold for all."""
    report = npss.report(gt, pred, convention=convention)
    parts = report.parts
    assert isinstance(parts, Parts)
    assert report.score == npss.score(gt, pred, convention=convention)
    assert abs(parts.form + parts.share - report.score) <= 2 * np.spacing(report.score)
    assert parts.form >= 0
    convention = npss.CONVENTIONS.get(convention, convention)
    if convention.bins == "two-sided":
        assert 0 <= parts.share_floor <= report.score + ROUNDING
        assert report.share_floor.shape == report.emd.shape
    else:
        assert parts.share_floor is report.share_floor is None
    if convention.distance == "spectrum" and convention.zero == "dc":
        assert parts.share >= -ROUNDING
    return parts


def tone(cycles, n_frames, *, mean=1.3, amplitude=0.4, phase=0.5):
    """Return a cosine, ``(1, T, 1)``."""
    return mean + amplitude * np.cos(2 * np.pi * cycles * np.arange(n_frames) / n_frames + phase)[np.newaxis, :, None]


def walks(n_frames, n=3, d=4, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(2, n, n_frames, d)).cumsum(axis=2) + rng.normal(size=(2, n, 1, d))


# --- the definition ---------------------------------------------------------------------------------------------------


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", FRAMES)
def test_equal_the_slow_definition(n_frames):
    gt, pred = walks(n_frames, seed=n_frames)
    gt[1, :, 1] = pred[0, :, 0] = gt[2, :, 2] = pred[2, :, 2] = 0.0
    pred[1, :, 3] = gt[0, :, 3] = 5.0
    for convention in ALL:
        form, share, floor, score = slow(gt, pred, convention)
        parts = parts_of(gt, pred, convention)
        close([parts.form, parts.share, parts.form + parts.share], [form, share, score], 1e-9)
        if convention.bins == "two-sided":
            close(parts.share_floor, floor)


@settings(max_examples=40)
@given(pair=pairs(min_t=2, max_t=16), convention=st.sampled_from(ALL))
def test_equal_the_slow_definition_of_any_motion(pair, convention):
    shares = [
        normalised(column, convention)[1] for x in pair for column in np.moveaxis(x, 1, 2).reshape(-1, x.shape[1])
    ]
    assume(all(share > 1e-6 or share < 1e-25 for share in shares))  # between, rounding of DC enters all other bins
    form, share, floor, score = slow(*pair, convention)
    parts = parts_of(*pair, convention)
    close([parts.form, parts.share, parts.form + parts.share], [form, share, score], 1e-9)
    if convention.bins == "two-sided":
        close(parts.share_floor, floor)


@pytest.mark.parametrize("way", ["matrices", "FFT"])
def test_both_transforms_agree(way, monkeypatch):
    gt, pred = walks(100)
    expected = npss.report(gt, pred)
    if way == "FFT":
        monkeypatch.setattr(_power, "_matrices", lambda n_frames, twins: None)
    got = npss.report(gt, pred)
    close(got.form, expected.form)
    close(got.share_floor, expected.share_floor)


@pytest.mark.parametrize("convention", ALL)
def test_the_parts_do_not_change_a_bit_of_the_distances(convention):
    gt, pred = walks(25, n=40, d=60)  # several pieces
    gt[0, :, 0] = pred[1, :, 1] = 0.0
    for block in _kernel.blocks(gt):
        plain, split = (_kernel.tile(gt, pred, convention, block, parts=parts) for parts in (False, True))
        assert plain.parts is None
        np.testing.assert_array_equal(split.distance, plain.distance)
        np.testing.assert_array_equal(split.weight, plain.weight)


def test_bits_of_a_column_depend_on_nothing_else():
    gt, pred = walks(31, n=30, d=70)
    whole = npss.report(gt, pred)
    for i, j in ((0, 0), (7, 69), (29, 35)):
        alone = npss.report(gt[i, :, [j]].T, pred[i, :, [j]].T)
        assert (whole.form[i, j], whole.share_floor[i, j]) == (alone.form[0, 0], alone.share_floor[0, 0])


@pytest.mark.parametrize("convention", npss.CONVENTIONS)
@pytest.mark.parametrize("scale", [2.0**-450, 2.0**-60, 2.0**450])
def test_units_do_not_matter(convention, scale):
    gt, pred = walks(50)
    expected = npss.report(gt, pred, convention=convention)
    for got in (npss.report(gt, scale * pred, convention=convention),
                npss.report(scale * gt, scale * pred, convention=convention)):  # fmt: skip
        close(got.form, expected.form)
        close(got.share_floor, expected.share_floor)


def test_small_motion_about_a_large_mean_keeps_its_digits():
    small = 1e-6
    gt, pred = (tone(k, 100, mean=1.0, amplitude=small) for k in (2, 3))
    outside = small**2 / 2  # of the power; 1 minus the share of DC would have four digits
    assert npss.report(gt, pred).parts.form == pytest.approx(outside / (1 + outside), rel=1e-8)


# --- what is share ----------------------------------------------------------------------------------------------------


def is_share(gt, pred, convention):
    parts = parts_of(gt, pred, convention)
    close(parts.form, 0.0)
    return parts


@settings(max_examples=30)
@given(seed=st.integers(0, 999), n_frames=st.integers(2, 60), convention=st.sampled_from(ALL))
def test_a_shift_of_the_mean_is_all_share_and_on_the_floor(seed, n_frames, convention):
    gt = walks(n_frames, seed=seed)[0]
    parts = is_share(gt, gt + np.random.default_rng(seed).normal(size=(3, 1, 4)), convention)
    if convention.bins == "two-sided":  # so no prediction with these shares can be better
        close(parts.share_floor, parts.share)


@pytest.mark.parametrize("convention", ALL)
@pytest.mark.parametrize("n_frames", [2, 9, 100])
def test_a_constant_on_either_side_is_all_share(convention, n_frames):
    gt, pred = walks(n_frames)
    constant = np.full_like(gt, 0.7) * np.arange(1, 5)
    for pair in ((gt, constant), (constant, pred), (constant, -2 * constant)):
        parts = is_share(*pair, convention)
        if convention in CUMULATIVE:
            close(parts.share_floor, parts.share)


@pytest.mark.parametrize("convention", ALL)
def test_zeros_are_all_share_and_on_the_floor(convention):
    gt = walks(50)[0]
    parts = is_share(gt, np.zeros_like(gt), convention)
    assert parts.form == 0
    if convention.bins == "two-sided":
        assert parts.share_floor == pytest.approx(npss.score(gt, np.zeros_like(gt), convention=convention), rel=1e-12)


@pytest.mark.parametrize("convention", npss.CONVENTIONS)
def test_a_prediction_that_moves_by_rounding_has_no_form(convention):
    gt = walks(100)[0]
    noise = np.random.default_rng(0).normal(size=gt.shape)
    assert npss.report(gt, 1 + 1e-11 * noise, convention=convention).parts.form == 0
    assert npss.report(gt, 1 + 1e-8 * noise, convention=convention).parts.form > 0.01


# --- what is form -----------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(
    n_frames=st.integers(5, 101),
    phase=st.floats(-1.4, 1.4),
    convention=st.sampled_from(ALL),
    data=st.data(),
)
def test_a_tone_of_another_frequency_is_all_form(n_frames, phase, convention, data):
    k, m = (data.draw(st.integers(1, (n_frames - 1) // 2)) for _ in range(2))
    parts = parts_of(tone(m, n_frames, phase=phase), tone(k, n_frames, phase=phase), convention)
    close(parts.share, 0.0)
    assert (parts.form > 1e-4) == (k != m)
    if convention.bins == "two-sided":
        close(parts.share_floor, 0.0)


@pytest.mark.parametrize("name", ["paper", "literal"])
def test_the_true_motion_played_later_or_backwards_has_neither(name):
    gt = walks(40)[0]
    for pred in (np.roll(gt, 7, axis=1), gt[:, ::-1], -3 * gt):
        parts = parts_of(gt, pred, name)
        close([*parts], 0.0)


# --- signs ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper", "released"])
def test_share_may_be_negative_and_the_text_says_so(name):
    # Too little power outside DC, and at too high a frequency: with more, more would be wrong.
    gt, pred = tone(1, 100, amplitude=1.0, phase=0.0), tone(45, 100, amplitude=0.98, phase=0.0)
    parts = parts_of(gt, pred, name)
    assert parts.share < 0 < parts.share_floor
    better = npss.report(gt, tone(45, 100, amplitude=1.0, phase=0.0), convention=name)
    assert better.score > npss.score(gt, pred, convention=name)
    close(better.score, parts.form)
    assert f"share of DC {parts.share:.4f} (the true shares would raise the score)" in str(parts)


@settings(max_examples=60)
@given(pair=pairs(), power=st.sampled_from(CHOICES["power"]), bins=st.sampled_from(CHOICES["bins"]))
def test_share_is_never_negative_without_cumulation(pair, power, bins):
    convention = npss.Convention(distance="spectrum", power=power, bins=bins)
    report = npss.report(*pair, convention=convention)
    assert (report.emd - report.form >= -ROUNDING).all()


@settings(max_examples=60)
@given(pair=pairs(), convention=st.sampled_from(TWO_SIDED))
def test_no_distance_is_below_its_floor(pair, convention):
    report = npss.report(*pair, convention=convention)
    assert (report.share_floor >= 0).all()
    assert (report.share_floor <= report.emd + ROUNDING).all()


# --- text and joints --------------------------------------------------------------------------------------------------


def test_text():
    assert (
        str(Parts(0.25, 1.5, 1.25))
        == "form 0.2500, share of DC +1.5000; no prediction with such shares scores below 1.2500"
    )
    assert str(Parts(0.25, 1.5, None)) == "form 0.2500, share of DC +1.5000"
    for nothing in (0.0, -0.0, -1e-17, 4e-5, -4e-5):
        assert str(Parts(0.25, nothing, None)) == "form 0.2500, share of DC +0.0000"
    negative = "form 0.2500, share of DC -0.1000 (the true shares would raise the score)"
    assert str(Parts(0.25, -0.1, None)) == negative


@pytest.mark.parametrize("convention", [*npss.CONVENTIONS, npss.Convention(bins="one-sided")])
def test_the_parts_of_joints_sum_to_those_of_the_score(convention):
    gt, pred = walks(30, d=5)
    report = npss.report(gt, pred, convention=convention, feature_names=["a.x", "b.x", "a.y", "c", "b.y"])
    joints = report.joint_parts
    assert list(joints) == list(report.joint_share)
    for joint, parts in joints.items():
        close((parts.form + parts.share) / report.score, report.joint_share[joint])
    for found, expected in zip(zip(*joints.values(), strict=True), report.parts, strict=True):
        if expected is None:
            assert set(found) == {None}
        else:
            close(sum(found), expected)


def test_arrays_are_read_only():
    report = npss.report(*walks(10))
    for array in (report.form, report.share_floor):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0


# --- real motion: the numbers of docs/conventions.md ------------------------------------------------------------------


def windows_of(root, action):
    from npss_baselines.data.h36m_source import Human36M  # needs torch

    (task,) = Human36M().tasks(root, [action])
    return npss.poses_to_euler(task.target), task


@pytest.mark.parametrize(
    ("action", "name", "form", "share", "floor"),
    [  # of the last 50 frames repeated: npss|version:1|representation:euler|frames:100|fps:25|protocol:srnn-8
        ("walking", "paper", 0.0846, 1.4223, 1.4899),
        ("walking", "released", 0.0548, 0.7735, 0.8218),
        ("walking", "literal", 0.4347, 0.1207, 0.2322),
        ("eating", "paper", 0.1115, 1.7021, 1.8030),
        ("eating", "released", 0.0760, 0.8720, 0.9440),
        ("eating", "literal", 0.4283, 0.1470, 0.3381),
        ("smoking", "paper", 0.1970, 3.7667, 3.9554),
        ("smoking", "released", 0.0813, 1.8199, 1.8978),
        ("smoking", "literal", 0.2744, 0.1943, 0.3651),
    ],
)
def test_parts_of_repeated_frames(h36m_root, action, name, form, share, floor):
    gt, task = windows_of(h36m_root, action)
    repeated, held = (npss.poses_to_euler(f(task.seed_frames, 100)) for f in (repeat, zero_velocity))
    report = npss.report(gt, repeated, convention=name)
    np.testing.assert_allclose(report.parts, (form, share, floor), rtol=0, atol=6e-5)
    held_parts = npss.report(gt, held, convention=name).parts
    close(held_parts, [0.0, *2 * [npss.score(gt, held, convention=name)]])  # as of any constant


@pytest.mark.parametrize(
    ("action", "name", "lowest", "highest", "share"),
    [
        ("walking", "paper", 1.157, 1.393, 0.933),
        ("walking", "released", 0.831, 1.054, 0.938),
        ("eating", "paper", 1.718, 1.834, 0.878),
        ("eating", "released", 0.765, 0.903, 0.886),
        ("smoking", "paper", 3.197, 3.307, 0.826),
        ("smoking", "released", 1.282, 1.454, 0.882),
    ],
)
def test_the_tempo_hardly_matters(h36m_root, action, name, lowest, highest, share):
    gt, task = windows_of(h36m_root, action)
    frames = np.concatenate([task.seed_frames[:, -1:], periodic(task.seed_frames, 300)], axis=1)
    motion = npss.unwrap(npss.poses_to_euler(frames))
    scores = []
    for tempo in (0.35, 0.5, 1, 2, 3):
        at = tempo * np.arange(1, 101)
        before = np.minimum(at.astype(int), 299)
        part = (at - before)[:, np.newaxis]
        played = (1 - part) * motion[:, before] + part * motion[:, before + 1]
        scores.append(npss.score(gt, played, convention=name))
    np.testing.assert_allclose([min(scores), max(scores)], [lowest, highest], rtol=0, atol=6e-4)
    report = npss.report(gt, npss.poses_to_euler(frames[:, 1:101]), convention=name)
    assert report.parts.share / report.score == pytest.approx(share, abs=6e-4)
