"""Clips of one's own: what is missing is found and restored, and all else returns exactly."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from dialects import CHAINS, swaying, walking, with_z_up
from npss_baselines.data.mapping import guess
from npss_baselines.data.motion import JOINTS, NAMES
from npss_baselines.data.upright import up_of, with_own_up, with_y_up
from npss_baselines.manifold import fill, inbetween, insert, interpolate, nearest, project, repair, sample
from npss_baselines.manifold.applications.corrupt import branch
from npss_baselines.manifold.clips.comparison import restoration_error
from npss_baselines.manifold.clips.filling import filled, last_known
from npss_baselines.manifold.clips.finding import find, leaps
from npss_baselines.manifold.clips.gap import Gap, lost_in
from npss_baselines.manifold.clips.lost import without_channels, without_places
from npss_baselines.manifold.clips.restoring import closed, known_features
from npss_baselines.manifold.clips.search import features_of
from npss_baselines.manifold.model.gaussian import fit_gaussian
from npss_baselines.manifold.motion.features import to_positions
from npss_baselines.manifold.motion.own_clip import body_height
from npss_baselines.manifold.motion.runs import runs
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.show.side_by_side import Shown, picture

DIALECTS = sorted(CHAINS)


def index_of(motion, common):
    return motion.skeleton.names.index(guess(motion.skeleton).joints[common])


def common_places(motion):
    return guess(motion.skeleton).positions(motion.positions(), motion.skeleton)


def turned(motion, joint, rng, size=0.7):
    """Return the clip with a joint turned otherwise in each frame."""
    rotations = motion.rotations.copy()
    turns = Rotation.from_rotvec(size * rng.normal(size=(len(rotations), 3))).as_matrix()
    rotations[:, joint] = rotations[:, joint] @ turns
    return replace(motion, rotations=rotations)


def lengths(motion):
    places = motion.positions()
    parents = [max(parent, 0) for parent in motion.skeleton.parents]
    return np.linalg.norm(places - places[:, parents], axis=-1)


@pytest.fixture(scope="module")
def restorer():
    """Return the Gaussian of the poses of one walker."""
    windows = features_of(walking("cmu", 200, seed=5))[np.newaxis]
    mask = np.ones(windows.shape[:2], bool)
    return Conditional(fit_gaussian(windows, mask, fit_scaling(windows, mask, "kind"), span=1))


@pytest.fixture(autouse=True)
def _no_restorer(monkeypatch):
    """Interpolate in time, whether or not the package has a restorer."""
    monkeypatch.setattr("npss_baselines.manifold.clips.repair.default", lambda: Interpolation("hermite"))


class TestLost:
    @pytest.mark.parametrize("missing", [["RightHand"], ["LeftUpLeg"], ["Neck"], ["Spine1", "RightLeg"], ["Hips"]])
    @pytest.mark.parametrize("name", DIALECTS)
    def test_joints_turn_freely_that_move_no_place_that_is_seen(self, name, missing):
        """Turn each joint of the skeleton, and see which common joints move."""
        motion, rng = swaying(name, fps=30.0, seconds=0.1), np.random.default_rng(0)
        mapping = guess(motion.skeleton)
        asked = np.zeros((len(motion.rotations), 20), bool)
        asked[:, [NAMES.index(joint) for joint in missing]] = True
        lost = without_places(asked, motion.skeleton, mapping)
        expected = {joint for top in missing for joint in branch(JOINTS, top)}
        assert set(np.flatnonzero(lost.places.all(axis=0))) == expected
        assert set(np.flatnonzero(lost.places.any(axis=0))) == expected
        before = common_places(motion)
        for joint in range(len(motion.skeleton.names)):
            after = common_places(turned(motion, joint, rng))
            moved = set(np.flatnonzero(np.abs(after - before).max(axis=(0, 2)) > 1e-6))
            free = bool(lost.rotations[:, joint].all())
            assert free == bool(lost.rotations[:, joint].any())
            if moved:
                assert free == (moved <= expected)
        carried = set(mapping.joints.values())
        for joint, own in enumerate(motion.skeleton.names):
            if missing != ["Hips"] and own not in carried and joint not in motion.skeleton.parents:
                assert not lost.rotations[:, joint].any()  # the last joint of a finger keeps its rotation
        if missing == ["Hips"]:
            assert lost.rotations.all()
            assert lost.translations.all()

    @pytest.mark.parametrize("name", DIALECTS)
    def test_a_joint_without_rotation_takes_the_places_that_it_moves(self, name):
        motion, rng = swaying(name, fps=30.0, seconds=0.1), np.random.default_rng(1)
        before = common_places(motion)
        for joint in range(len(motion.skeleton.names)):
            absent = np.zeros(motion.rotations.shape[:2], bool)
            absent[1, joint] = True
            lost = without_channels(absent, absent & False, motion.skeleton, guess(motion.skeleton))
            after = common_places(turned(motion, joint, rng))
            moved = np.abs(after - before).max(axis=(0, 2)) > 1e-6
            np.testing.assert_array_equal(lost.places[1], moved)
            assert not lost.places[[0, 2]].any()
            np.testing.assert_array_equal(lost.rotations, absent)

    @given(st.lists(st.booleans(), min_size=1, max_size=40), st.sampled_from([24.0, 25.0, 30.0, 60.0, 100.0, 120.0]))
    @settings(max_examples=40, deadline=None)
    def test_a_feature_is_known_if_a_frame_nearby_is(self, missing, fps):
        mask = np.repeat(np.array(missing)[:, np.newaxis], 20, axis=1)
        n = int((len(missing) - 1) * 30 / fps) + 1
        known = known_features(mask, fps, n)
        near = max(0.5 / fps, 0.5 / 30) + 1e-9
        expected = [any(abs(i / 30 - t / fps) <= near and not lost for t, lost in enumerate(missing)) for i in range(n)]
        np.testing.assert_array_equal(known, np.repeat(np.array(expected)[:, np.newaxis], 63, axis=1))

    def test_the_path_ends_where_it_should(self, motions):
        """After a gap, world positions are those before restoration, whatever the velocities in the gap."""
        before = motions.features[0][:120].astype(np.float64)
        rng = np.random.default_rng(0)
        known = np.ones(before.shape, bool)
        known[20:45, -3:] = known[70:71, -3:] = known[110:, -3:] = False
        after = np.where(known, before, before + 0.1 * rng.normal(size=before.shape))
        path = closed(after, before, known)
        np.testing.assert_array_equal(path[known], before[known])
        outside = known[:, -1].copy()
        outside[[44, 70]] = True  # the last frames of gaps
        outside[110:] = True  # without an end, the path is that before
        right, wrong = to_positions(before), to_positions(after)
        np.testing.assert_allclose(to_positions(path)[outside], right[outside], rtol=0, atol=1e-9)
        assert np.abs(wrong - right)[outside].max() > 0.01


class TestFilled:
    def test_steady_rotation_goes_on(self):
        motion = walking("lafan1", 40)
        joint, t = index_of(motion, "LeftArm"), np.arange(40)
        rotations = motion.rotations.copy()
        rotations[:, joint] = Rotation.from_rotvec(np.outer(0.05 * t, [0, 0.6, 0.8])).as_matrix()
        truth = replace(motion, rotations=rotations)
        gap = Gap(motion.skeleton.names[joint], "rotation", 15, 23, "given")
        lost = lost_in([gap], truth, guess(motion.skeleton))
        broken = rotations.copy()
        broken[15:23, joint] = np.eye(3)
        result = filled(replace(motion, rotations=broken), lost)
        np.testing.assert_allclose(result.rotations, rotations, rtol=0, atol=2e-3)
        np.testing.assert_array_equal(result.rotations[:15], rotations[:15])

    def test_a_joint_without_known_frames_rests(self):
        motion = walking("lafan1", 10)
        name = motion.skeleton.names[index_of(motion, "LeftArm")]
        lost = lost_in([Gap(name, "rotation", 0, 10, "given")], motion, guess(motion.skeleton))
        result = filled(motion, lost)
        np.testing.assert_allclose(result.rotations[:, index_of(motion, "LeftArm")], np.tile(np.eye(3), (10, 1, 1)))

    def test_last_known(self):
        values = np.array([[np.nan], [1], [np.nan], [2]])[..., np.newaxis]
        assert last_known(values).ravel().tolist() == [1, 1, 1, 2]
        assert last_known(values * np.nan).ravel().tolist() == [0] * 4
        assert last_known(np.full((1, 1, 3, 3), np.nan)).tolist() == [[np.eye(3).tolist()]]


class TestFind:
    @given(st.sampled_from(DIALECTS), st.sampled_from([24.0, 30.0, 60.0, 120.0]))
    @settings(max_examples=8, deadline=None)
    def test_nothing_is_found_in_whole_motion(self, name, fps):
        assert find(swaying(name, fps=fps)) == []
        assert find(walking(name, 60, fps=fps)) == []

    @pytest.mark.parametrize("fps", [30.0, 120.0])
    def test_a_held_joint(self, fps):
        motion = swaying("lafan1", fps=fps)
        joint, start, n = index_of(motion, "RightForeArm"), round(0.5 * fps), round(0.3 * fps)
        rotations = motion.rotations.copy()
        rotations[start : start + n, joint] = rotations[start, joint]
        # The first of the equal frames is not missing.
        (gap,) = find(replace(motion, rotations=rotations))
        assert gap == Gap("RightForeArm", "rotation", start + 1, start + n, "held")
        rotations[start + round(0.09 * fps) :, joint] = motion.rotations[start + round(0.09 * fps) :, joint]
        assert find(replace(motion, rotations=rotations)) == []

    @pytest.mark.parametrize("fps", [30.0, 120.0])
    @pytest.mark.parametrize(("start", "end"), [(0.5, 1.0), (0.0, 0.5), (1.5, 2.0)])
    def test_a_joint_that_leaps_into_its_hold_was_lost_before(self, fps, start, end):
        """A tracker that loses a joint writes zeros: the first frame is no more true than the others."""
        motion = swaying("lafan1", fps=fps)
        joint, first, last = index_of(motion, "RightArm"), round(start * fps), round(end * fps)
        tilted = Rotation.from_rotvec([0, 0, 1.2]).as_matrix()
        rotations = motion.rotations.copy()
        rotations[:, joint] = rotations[:, joint] @ tilted
        rotations[first:last, joint] = np.eye(3)
        assert find(replace(motion, rotations=rotations)) == [Gap("RightArm", "rotation", first, last, "held")]
        hand = index_of(motion, "RightHand")  # does not leap, but is lost together with the arm
        rotations[first:last, hand] = rotations[first, hand]
        lost = find(replace(motion, rotations=rotations))
        assert {(gap.joint, gap.start) for gap in lost} == {("RightArm", first), ("RightHand", first)}

    def test_keys_that_are_held_are_kept(self):
        """In stepped motion, every key leaps into its hold."""
        motion = walking("lafan1", 60)
        frames = np.arange(60) // 15 * 15
        stepped = replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])
        assert {gap.start % 15 for gap in find(stepped)} <= {1}

    @pytest.mark.parametrize("fps", [30.0, 120.0])
    def test_a_figure_that_leaps_and_stays(self, fps):
        motion = walking("lafan1", round(3 * fps), fps=fps)
        assert leaps(motion) == []
        frames = np.delete(np.arange(round(3 * fps)), slice(round(fps), round(1.7 * fps)))
        cut = replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])
        assert leaps(cut) == [round(fps)]
        assert leaps(cut, [Gap("Hips", "place", round(fps), round(fps) + 3, "given")]) == []

    def test_joints_that_are_held_on_purpose(self):
        """Knees that an animator holds at their limit for a moment are told apart by time, or by name."""
        motion = walking("lafan1", 120, fps=60.0)
        knee, hand = (index_of(motion, name) for name in ("LeftLeg", "RightForeArm"))
        rotations = motion.rotations.copy()
        rotations[20:28, knee] = rotations[20, knee]
        rotations[60:90, hand] = rotations[60, hand]
        clip = replace(motion, rotations=rotations)
        assert [gap.joint for gap in repair(clip).gaps] == ["RightForeArm", "LeftLeg"]
        for options in ({"shortest": 0.25}, {"only": ["RightForeArm"]}):
            assert [gap.joint for gap in repair(clip, **options).gaps] == ["RightForeArm"]
        with pytest.raises(ValueError, match=r"^only: 'left_foot' is not one of .*; did you mean LeftFoot\?$"):
            repair(clip, only=["left_foot"])
        with pytest.raises(ValueError, match=r"^shortest: "):
            repair(clip, shortest=0)
        for options in ({"shortest": 0.25}, {"only": ["Head"]}):
            with pytest.raises(ValueError, match=r"^only, shortest: choose from what is found"):
                repair(clip, missing=["Head"], end=9, **options)

    def test_joints_that_never_move_and_a_figure_at_rest_are_not_held(self):
        motion = swaying("mixamo", fps=30.0)
        rotations = motion.rotations.copy()
        rotations[:, index_of(motion, "Head")] = np.eye(3)
        translations = motion.translations.copy()
        for values in (rotations, translations):
            values[:8], values[-8:] = values[8], values[-9]
        assert find(replace(motion, rotations=rotations, translations=translations)) == []

    def test_a_figure_that_freezes_is_held(self):
        motion = walking("lafan1", 60)
        rotations, translations = motion.rotations.copy(), motion.translations.copy()
        for values in (rotations, translations):
            values[20:30] = values[20]
        gaps = find(replace(motion, rotations=rotations, translations=translations))
        assert {(gap.start, gap.end, gap.why) for gap in gaps} == {(21, 30, "held")}
        assert Gap("Hips", "translation", 21, 30, "held") in gaps

    @pytest.mark.parametrize("n", [1, 3])
    @pytest.mark.parametrize("fps", [30.0, 120.0])
    def test_a_joint_that_jumps(self, fps, n):
        motion = swaying("lafan1", fps=fps)
        joint, start = index_of(motion, "LeftForeArm"), round(fps)
        rotations = motion.rotations.copy()
        away = Rotation.from_rotvec([0, 0, np.radians(50)]).as_matrix()
        rotations[start : start + n, joint] = rotations[start : start + n, joint] @ away
        assert find(replace(motion, rotations=rotations)) == [Gap("LeftForeArm", "rotation", start, start + n, "jump")]
        rotations[start:, joint] = motion.rotations[start:, joint] @ away  # it does not come back
        assert find(replace(motion, rotations=rotations)) == []

    def test_a_root_that_jumps(self):
        motion = walking("lafan1", 60)
        translations = motion.translations.copy()
        translations[20:22, 0] += [30, 0, 0]
        assert find(replace(motion, translations=translations)) == [Gap("Hips", "translation", 20, 22, "jump")]

    def test_values_that_are_no_numbers(self):
        motion = walking("lafan1", 60)
        rotations, translations = motion.rotations.copy(), motion.translations.copy()
        rotations[5:9, index_of(motion, "LeftArm")] = np.nan
        translations[:3, 0] = np.nan
        gaps = find(replace(motion, rotations=rotations, translations=translations))
        assert gaps == [
            Gap("Hips", "translation", 0, 3, "not a number"),
            Gap("LeftArm", "rotation", 5, 9, "not a number"),
        ]

    def test_short_clips(self):
        assert find(walking("lafan1", 2)) == []

    def test_runs(self):
        assert runs(np.array([True, False, True, True])) == [(0, 1), (2, 4)]


class TestRepair:
    @pytest.mark.parametrize("name", DIALECTS)
    def test_what_is_not_missing_returns_exactly(self, name):
        motion = walking(name, 80)
        outcome = repair(motion, missing=["RightForeArm"], start=30, end=42)
        lost = lost_in(outcome.gaps, motion, outcome.mapping)
        assert lost.rotations.any()
        np.testing.assert_array_equal(outcome.motion.rotations[~lost.rotations], motion.rotations[~lost.rotations])
        np.testing.assert_array_equal(outcome.motion.translations, motion.translations)
        assert outcome.motion.channels == motion.channels
        assert outcome.motion.fps == motion.fps
        np.testing.assert_allclose(lengths(outcome.motion), lengths(motion), rtol=1e-9)
        held = motion.rotations.copy()
        held[30:42] = np.where(lost.rotations[30:42, :, np.newaxis, np.newaxis], held[29], held[30:42])
        before = restoration_error(replace(motion, rotations=held), motion, outcome)
        after = restoration_error(outcome.motion, motion, outcome)
        assert after < before / 2
        assert outcome.error.max() < 1e-9  # a limb reaches everything

    def test_damage_is_found_and_repaired(self):
        truth = walking("mixamo", 120, fps=60.0)
        joint = index_of(truth, "LeftLeg")
        rotations = truth.rotations.copy()
        rotations[40:52, joint] = rotations[39, joint]
        rotations[80:82, joint] = rotations[80:82, joint] @ Rotation.from_rotvec([0.9, 0, 0]).as_matrix()
        rotations[100:104, index_of(truth, "RightArm")] = np.nan
        damaged = replace(truth, rotations=rotations)
        outcome = repair(damaged)
        assert [(gap.start, gap.end, gap.why) for gap in outcome.gaps] == [
            *[(100, 104, "not a number")],
            *[(40, 52, "held"), (80, 82, "jump")],
        ]
        after, before = (restoration_error(motion, truth, outcome) for motion in (outcome.motion, damaged))
        assert after < before / 3
        # The elbow's own rotation is known, though its place is not.
        elbow = index_of(truth, "RightForeArm")
        np.testing.assert_array_equal(outcome.motion.rotations[:, elbow], truth.rotations[:, elbow])

    def test_a_whole_clip_returns_as_it_is(self):
        motion = walking("lafan1", 40)
        outcome = repair(motion)
        assert outcome.gaps == ()
        assert not outcome.error.any()
        np.testing.assert_array_equal(outcome.motion.rotations, motion.rotations)
        np.testing.assert_array_equal(outcome.motion.translations, motion.translations)

    def test_z_up(self):
        motion = walking("xsens", 60)
        tilted = with_z_up(motion)
        assert up_of(tilted, guess(motion.skeleton)) == "z"
        assert up_of(motion, guess(motion.skeleton)) == "y"
        np.testing.assert_array_equal(with_own_up(with_y_up(tilted, "z"), "z").rotations, tilted.rotations)
        options = {"missing": ["LeftUpLeg"], "start": 20, "end": 30}
        outcome, other = repair(motion, **options), repair(tilted, **options)
        assert (outcome.up, other.up) == ("y", "z")
        np.testing.assert_allclose(with_z_up(outcome.motion).rotations, other.motion.rotations, rtol=0, atol=1e-9)
        with pytest.raises(ValueError, match=r"^up: expected"):
            repair(motion, **options, up="x")

    def test_a_finger_is_interpolated(self):
        motion = swaying("mixamo", fps=30.0)
        joint = motion.skeleton.names.index("mixamorig:LeftHandThumb1")
        rotations = motion.rotations.copy()
        rotations[20:24, joint] = np.nan
        outcome = repair(replace(motion, rotations=rotations))
        np.testing.assert_allclose(outcome.motion.rotations, motion.rotations, rtol=0, atol=0.01)

    def test_invalid_arguments(self):
        motion = walking("lafan1", 40)
        with pytest.raises(ValueError, match=r"^missing: 'Tail' is not one of the joints Hips \(Hips\), "):
            repair(motion, missing=["Tail"])
        with pytest.raises(TypeError, match=r"^missing: expected names of joints, got 3"):
            repair(motion, missing=[3])
        with pytest.raises(TypeError, match=r"^missing: "):
            repair(motion, missing="Head")
        with pytest.raises(ValueError, match=r"^start: expected frames from 0 to 40, .*; got 30 to 30"):
            repair(motion, missing=["Head"], start=30, end=30)
        with pytest.raises(TypeError, match=r"^end: expected a frame of the file, got 1.5"):
            repair(motion, missing=["Head"], end=1.5)
        with pytest.raises(ValueError, match=r"^missing: Head: missing in all frames, so there is nothing"):
            repair(motion, missing=["Head"])


class TestFill:
    @pytest.mark.parametrize("name", ["mixamo", "bandai", "xsens", "rokoko"])
    def test_a_joint_is_filled_from_the_others(self, name, restorer):
        """The walk is the same on every skeleton, up to the length of bones that differ."""
        motion = walking(name, 80, seed=5)
        outcome = fill(motion, "RightHand", restorer=restorer)
        lost = lost_in(outcome.gaps, motion, outcome.mapping)
        assert lost.places[:, NAMES.index("RightHand")].all()
        np.testing.assert_array_equal(outcome.motion.rotations[~lost.rotations], motion.rotations[~lost.rotations])
        resting = filled(motion, lost)
        after, before = (restoration_error(clip, motion, outcome) for clip in (outcome.motion, resting))
        assert after < before / 2
        assert outcome.way == restorer.signature

    def test_names_of_the_file(self, restorer):
        motion = walking("mixamo", 40)
        by_file, by_common = (
            fill(motion, joint, restorer=restorer, end=10) for joint in ("mixamorig:RightHand", "RightHand")
        )
        assert by_file.gaps == by_common.gaps == (Gap("mixamorig:RightHand", "place", 0, 10, "given"),)

    def test_nothing_known(self, restorer):
        with pytest.raises(ValueError, match=r"^missing: nothing of the clip is known"):
            fill(walking("lafan1", 40), "Hips", restorer=restorer)


class TestInbetween:
    @pytest.mark.parametrize("fps", [24.0, 30.0, 120.0])
    def test_keys_return_exactly(self, fps):
        motion = walking("lafan1", round(2 * fps) + 1, fps=fps)
        every = round(fps / 6)
        outcome = inbetween(motion, every=every)
        for name in ("rotations", "translations"):
            np.testing.assert_array_equal(getattr(outcome.motion, name)[::every], getattr(motion, name)[::every])
        frames = np.arange(len(motion.rotations)) // every * every
        stepped = replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])
        after, before = (restoration_error(clip, motion, outcome) for clip in (outcome.motion, stepped))
        assert after < before / 3
        np.testing.assert_allclose(lengths(outcome.motion), lengths(motion), rtol=1e-9)
        by_number = inbetween(stepped, keys=range(0, len(frames), every))
        found = inbetween(stepped)
        assert found.gaps == by_number.gaps == outcome.gaps
        np.testing.assert_array_equal(found.motion.rotations, outcome.motion.rotations)

    def test_the_figure_stays_after_the_last_key(self):
        motion = walking("lafan1", 40)
        outcome = inbetween(motion, keys=[5, 20])
        np.testing.assert_allclose(outcome.motion.root[20:], np.tile(motion.root[20], (20, 1)), rtol=0, atol=1e-9)
        np.testing.assert_allclose(outcome.motion.root[:5], np.tile(motion.root[5], (5, 1)), rtol=0, atol=1e-9)

    def test_invalid_keys(self):
        motion = walking("lafan1", 40)
        with pytest.raises(ValueError, match=r"^keys: no frame is held"):
            inbetween(motion)
        with pytest.raises(ValueError, match=r"^keys: the clip has the frames 0 to 39, not 40"):
            inbetween(motion, keys=[0, 40])
        with pytest.raises(TypeError, match=r"^keys: expected frames, got 1.5"):
            inbetween(motion, keys=[0, 1.5])
        with pytest.raises(ValueError, match=r"^keys: expected at least two"):
            inbetween(motion, keys=[3])
        with pytest.raises(ValueError, match=r"^every: give either"):
            inbetween(motion, keys=[3], every=4)
        with pytest.raises(ValueError, match=r"^every: "):
            inbetween(motion, every=0)


class TestInsert:
    def test_frames_that_were_deleted(self):
        motion = walking("lafan1", 90)
        frames = np.r_[:30, 40:90]
        cut = replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])
        longer = insert(cut, 30, 10)
        assert len(longer.rotations) == 90
        np.testing.assert_array_equal(longer.rotations[30:40], np.repeat(motion.rotations[29:30], 10, axis=0))
        outcome = repair(longer, missing=["Hips"], start=30, end=40)
        outside = np.r_[:30, 40:90]
        np.testing.assert_array_equal(outcome.motion.rotations[outside], motion.rotations[outside])
        after, before = (restoration_error(clip, motion, outcome) for clip in (outcome.motion, longer))
        assert after < before / 2

    @pytest.mark.parametrize(
        ("at", "count", "error", "message"),
        [
            (0, 3, ValueError, "^at: expected a frame from 1 to 19, got 0"),
            (20, 3, ValueError, "^at: expected"),
            (1.5, 3, TypeError, "^at: expected a frame of the file, got 1.5"),
            (3, 0, ValueError, "^insert: "),
        ],
    )
    def test_invalid_places(self, at, count, error, message):
        with pytest.raises(error, match=message):
            insert(walking("lafan1", 20), at, count)


class TestInterpolate:
    def test_shares_of_nothing_and_of_all(self):
        first, second = walking("mixamo", 60), walking("lafan1", 101, fps=50.0, seed=1)
        nothing = interpolate(first, second, 0)
        np.testing.assert_allclose(nothing.motion.rotations, first.rotations, rtol=0, atol=1e-9)
        np.testing.assert_allclose(nothing.motion.translations, first.translations, rtol=0, atol=1e-7)
        everything = interpolate(first, second, 1)
        assert len(everything.motion.rotations) == 61  # two seconds
        assert everything.motion.fps == 30
        made = [NAMES.index(f"{side}HandIndex") for side in ("Left", "Right")]
        got, asked = (features_of(clip)[:, :60].reshape(-1, 20, 3) for clip in (everything.motion, second))
        difference = np.delete(np.linalg.norm(got - asked, axis=-1), made, axis=1)
        # The skeletons' hips and spines differ, and are not bent to reach everything.
        assert difference.mean() < 0.02
        np.testing.assert_allclose(lengths(everything.motion), np.tile(lengths(first)[0], (61, 1)), rtol=1e-6)

    def test_half(self):
        first, second = walking("xsens", 61), walking("xsens", 91, seed=1)
        outcome = interpolate(first, second, 0.5)
        assert len(outcome.motion.rotations) == 76
        assert outcome.way == "slerp"
        np.testing.assert_allclose(outcome.motion.root[0, [0, 2]], first.root[0, [0, 2]], rtol=0, atol=1e-9)

    def test_in_hidden_space(self):
        class Halved:
            signature = "halved"

            def encode(self, features):
                return np.asarray(features)[:, ::1] / 2

            def decode(self, code, n_frames):
                return 2 * code[:, :n_frames]

        first, second = walking("xsens", 61), walking("bandai", 91, seed=1)
        hidden = interpolate(first, second, 0.3, manifold=Halved())
        assert hidden.way == "halved"
        bones = lengths(hidden.motion)
        np.testing.assert_allclose(bones, np.tile(lengths(first)[0], (len(bones), 1)), rtol=1e-6)

    def test_invalid_shares(self):
        motion = walking("lafan1", 20)
        with pytest.raises(ValueError, match=r"^share: expected a number from 0 to 1, got 2"):
            interpolate(motion, motion, 2)


class TestNearest:
    def test_the_same_walk_on_another_skeleton_is_nearest(self):
        clips = {f"{name}/{seed}": walking(name, 90, seed=seed) for name in ("mixamo", "xsens") for seed in range(3)}
        clips["fast"] = walking("bandai", 360, fps=120.0, seed=1)
        clips["upright"] = with_z_up(walking("lafan1", 90, seed=1))
        ranked = nearest(walking("rokoko", 90, seed=1), clips.items())
        assert {name for name, _ in ranked[:3]} >= {"mixamo/1", "xsens/1", "upright"} - {"fast"}
        distances = [distance for _, distance in ranked]
        assert distances == sorted(distances)
        assert len(ranked) == len(clips)

    def test_equation_4(self):
        clips = [walking("mixamo", 40, seed=seed) for seed in range(3)]
        first, *others = [features_of(clip) for clip in clips]
        deviation = np.concatenate([first, *others]).std(axis=0)
        places = np.concatenate([first, *others])[:, :60]
        scale = np.concatenate([np.full(60, np.sqrt(((places - places.mean(axis=0)) ** 2).mean())), deviation[60:]])
        expected = sorted(
            (
                sum(
                    ((getattr(first, m)(axis=0) - getattr(other, m)(axis=0)) ** 2 / scale**2).sum()
                    for m in ("max", "min")
                ),
                str(number),
            )
            for number, other in enumerate(others)
        )
        ranked = nearest(clips[0], [("0", clips[1]), ("1", clips[2])])
        assert [name for name, _ in ranked] == [name for _, name in expected]
        assert [distance for _, distance in ranked] == pytest.approx([distance for distance, _ in expected])

    def test_by_a_manifold(self):
        class Heights:
            def encode(self, features):
                return np.asarray(features)[..., 1:2]

        low, high = walking("mixamo", 40, seed=0), walking("mixamo", 40, seed=1)
        heights = [features_of(clip)[:, 1] for clip in (low, high)]
        g = np.ptp([h.max() for h in heights]) ** 2 + np.ptp([h.min() for h in heights]) ** 2
        assert nearest(low, [("high", high)], manifold=Heights()) == [("high", pytest.approx(g))]

    def test_invalid_clips(self):
        motion = walking("lafan1", 20)
        with pytest.raises(ValueError, match=r"^others: expected at least one clip"):
            nearest(motion, [])
        lying = replace(motion, rotations=np.tile(np.eye(3), (20, len(motion.channels), 1, 1)))
        lying.rotations[:, 0] = Rotation.from_rotvec([0, 0, np.pi / 2]).as_matrix()
        with pytest.raises(ValueError, match=r"^lying: positions: no facing direction at frame 0"):
            nearest(motion, [("lying", lying)])
        left_out = []
        ranked = nearest(motion, [("lying", lying), ("self", motion)], skip=lambda *why: left_out.append(why))
        assert ranked == [("self", 0)]
        assert [(name, str(error)[:30]) for name, error in left_out] == [("lying", "positions: no facing direction")]


class TestManifold:
    def test_a_projection_that_changes_nothing(self):
        class Identity:
            signature = "identity"

            def project(self, features):
                return features

        motion = with_z_up(walking("bandai", 60, fps=60.0))
        outcome = project(motion, Identity())
        np.testing.assert_allclose(outcome.motion.rotations, motion.rotations, rtol=0, atol=1e-9)
        assert outcome.way == "identity"

    def test_samples(self, testbed, motions):
        (manifold,) = testbed.manifolds.values()
        outcome = sample(manifold, n_frames=50, real=motions.windows[:5, :50], seed=3)
        assert len(outcome.motion.rotations) == 50
        assert outcome.way.startswith("local of ")
        expected = 170 * np.linalg.norm(JOINTS.offsets[1:], axis=-1)
        np.testing.assert_allclose(lengths(outcome.motion)[:, 1:20], np.tile(expected, (50, 1)), rtol=1e-6)
        again = sample(manifold, n_frames=50, real=motions.windows[:5, :50], seed=3)
        np.testing.assert_array_equal(again.motion.rotations, outcome.motion.rotations)
        with pytest.raises(ValueError, match=r"^real: expected more than 4 motions, got 2"):
            sample(manifold, n_frames=50, real=motions.windows[:2, :50])
        assert sample(manifold).way.startswith("uniform of ")
        assert guess(outcome.motion.skeleton).joints == {name: name for name in NAMES}
        assert body_height(common_places(outcome.motion)) == pytest.approx(170)


class TestShown:
    @pytest.mark.parametrize(
        ("spans", "inside"), [([(0.5, 1.0), (1.5, 1.6)], 8), ([(1.0, 1.1)], 3), ([(0.0, 2.0)], 12), ([], 3)]
    )
    def test_most_figures_are_taken_from_the_stretches_to_look_at(self, spans, inside):
        pytest.importorskip("matplotlib")
        clip = walking("lafan1", 60)
        drawn = picture({"clip": Shown(clip, guess(clip.skeleton), "y")}, spans=spans)
        times = [float(text.get_text()) for text in drawn.axes[0].texts if text.get_text() != "clip"]
        assert len(times) == len(set(times)) == 12
        assert times == sorted(times)
        looked_at = spans or [(0.5, 1.0), (1.5, 1.6)]
        assert sum(any(start - 1e-9 <= time < end for start, end in looked_at) for time in times) == inside
