"""What uses are worth: records against measures taken by hand, the table, the pictures, the commands."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch

import npss
from npss.gait import gait
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.clip_distances import clip_distances
from npss_baselines.manifold.applications.distance import g, g_of_poses
from npss_baselines.manifold.applications.restore import USES, Windows, corrupted, rescaled
from npss_baselines.manifold.evaluation import measure as evaluation
from npss_baselines.manifold.evaluation import pca_size as rivals
from npss_baselines.manifold.evaluation import table
from npss_baselines.manifold.evaluation.testbed import TAKEN, Bench, fingerprint
from npss_baselines.manifold.model import pca
from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig
from npss_baselines.manifold.model.projector import Manifold
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.normalization import normalization
from npss_baselines.manifold.motion.prepared import MotionSet, motion_set

RESTORED = ["input", "linear", "pca", "pca-best", "manifold", "pca-best, known kept", "manifold, known kept"]


@pytest.fixture(scope="module")
def motions():
    return motion_set(quick=True)  # 8 walks


def manifold_of(motions, seed=0):
    torch.manual_seed(seed)
    network = Autoencoder(AutoencoderConfig(widths=(12, 10), kernel=5)).eval()
    return Manifold(network, normalization(motions.windows, motions.mask, "kind"), f"untrained-{seed}")


@pytest.fixture(scope="module")
def bench(motions):
    return Bench(motions, {"manifold": manifold_of(motions)})


@pytest.fixture(scope="module")
def records(bench):
    return list(table.records_of(bench))


def value(records, use, method, metric):
    (found,) = [r["value"] for r in records if (r["use"], r["method"], r["metric"]) == (use, method, metric)]
    return found


class TestBench:
    @pytest.mark.parametrize("name", ["input", "linear", "pca", "pca-best", "extremes", "original", "pca, known kept"])
    def test_a_manifold_does_not_take_the_name_of_another_method(self, motions, name):
        with pytest.raises(ValueError, match=f"^manifolds: '{name}' could be taken for another method"):
            Bench(motions, {"manifold": manifold_of(motions), name: manifold_of(motions)})

    def test_every_method_that_is_no_manifold_is_known(self, bench, records):
        chosen = clip_distances(bench.motions, bench.manifolds, bench.rival, bench.normalization)
        methods = {record["method"] for record in records} | set(chosen)
        assert {method.partition(",")[0] for method in methods} - {"manifold"} <= set(TAKEN)

    def test_nobody_is_on_both_sides(self, bench):
        subjects = [{clip.subject for clip in part.clips} for part in (bench.training, bench.test)]
        assert subjects[1] == {"synthetic/0", "synthetic/1"}
        assert not subjects[0] & subjects[1]

    def test_rivals_are_fitted_to_training_windows_alone(self, bench):
        assert len(bench.rival.components) == len(bench.training.windows) - 1 < 400  # 40 x 10 numbers in the code
        assert bench.rival.project(bench.training.windows) == pytest.approx(bench.training.windows, abs=1e-4)
        assert np.abs(bench.rival.project(bench.test.windows) - bench.test.windows).max() > 0.01

    def test_the_best_size_is_the_best(self, bench):
        """Once more, by trying all sizes on the subjects that were put aside."""
        best = rivals.best_sizes(bench.training, bench.normalization, ["project", "repair"])
        assert set(best) == {"project", "repair", "repair, rescaled"}
        subjects = sorted({clip.subject for clip in bench.training.clips})
        aside = [subjects[i] for i in range(1, len(subjects), 3)]
        fitted = pca.fit(
            bench.training.only(exclude_subjects=aside).windows, bench.normalization, n_components=160 * 60
        )
        left_out = bench.training.only(subjects=aside)
        gt = local_positions(left_out.windows)
        sizes = [2**i for i in range(20) if 2**i < len(fitted.components)] + [rivals.ALL]
        assert len(sizes) > 4
        for use, size in best.items():
            lost = corrupted(use.partition(",")[0], Windows(left_out.windows, left_out.mask), bench.normalization.mean)
            seen = rescaled(lost, bench.normalization.mean) if use.endswith("rescaled") else lost.features
            errors = {}
            for tried in sizes:
                pred = local_positions(rivals.truncated(fitted, tried).project(seen))
                errors[tried] = np.linalg.norm(pred - gt, axis=-1)[left_out.mask].mean()
            assert errors.pop(size) < min(errors.values())

    def test_a_single_subject_leaves_nothing_to_choose_by(self, bench):
        one = bench.training.only(subjects=[bench.training.clips[0].subject])
        assert rivals.best_sizes(one, bench.normalization, ["project"]) == {}

    def test_nobody_is_held_out(self, motions):
        others = motions.only(exclude_subjects=["synthetic/0", "synthetic/1"])
        with pytest.raises(ValueError, match="there is no motion of those who are held out, cmu/02"):
            _ = Bench(others, {"manifold": manifold_of(motions)}).test

    def test_a_fingerprint_is_of_every_value(self, motions):
        changed = [each.copy() for each in motions.features]
        changed[-1][-1, -1] += 1e-6
        other = MotionSet(motions.clips, tuple(changed), motions.windows, motions.mask, motions.clip_of)
        assert fingerprint(motions) == fingerprint(motions) != fingerprint(other)


class TestRestoration:
    def test_every_use_method_and_metric(self, records):
        for use in USES:
            found = {(r["method"], r["metric"]) for r in records if r["use"] == use}
            methods = RESTORED
            if use == "project":
                methods = ["input", "pca", "pca-best", "manifold"]
            if use == "repair":
                methods = [*RESTORED, "pca-best, rescaled", "manifold, rescaled"]
            if use == "fill":
                methods = [method for method in RESTORED if method != "linear"]
            metrics = ["joint_error", "bone_error", "npss", *(["missing_joint_error"] if use == "fill" else [])]
            assert found == {(method, metric) for method in methods for metric in metrics}

    def test_against_the_measures(self, bench, records):
        left = bench.corrupted("repair")
        motion = bench.manifolds["manifold"].project(left.features)
        gt, pred = local_positions(bench.windows.features), local_positions(motion)
        assert value(records, "repair", "manifold", "joint_error") == pytest.approx(
            np.linalg.norm(pred - gt, axis=-1)[bench.windows.mask].mean()
        )
        sequences = [each.reshape(len(each), 160, 60) for each in (gt, pred)]
        assert value(records, "repair", "manifold", "npss") == pytest.approx(npss.score(*sequences))
        bone = measures.bone_error(pred, JOINTS, bench.windows.mask)
        assert value(records, "repair", "manifold", "bone_error") == bone

    def test_repair_of_what_is_rescaled(self, bench, records):
        """Twice as far from the mean, if half is lost; and known values put back into what comes of that."""
        left = bench.corrupted("repair")
        mean = bench.normalization.mean
        assert left.known.mean() == pytest.approx(0.5, abs=0.01)
        share = left.known.reshape(len(left.known), -1).mean(1)[:, np.newaxis, np.newaxis]
        motion = bench.manifolds["manifold"].project(mean + (left.features - mean) / share)
        kept = np.where(left.known, bench.windows.features, motion)
        gt, mask = local_positions(bench.windows.features), bench.windows.mask
        for method, pred in (("manifold, rescaled", motion), ("manifold, known kept", kept)):
            expected = np.linalg.norm(local_positions(pred) - gt, axis=-1)[mask].mean()
            assert value(records, "repair", method, "joint_error") == pytest.approx(expected)

    def test_the_missing_joints_are_the_hand(self, bench, records):
        hand = [JOINTS.names.index(name) for name in ("RightHand", "RightHandIndex")]
        motion = bench.rival.project(bench.corrupted("fill").features)
        errors = np.linalg.norm(local_positions(motion - bench.windows.features)[:, :, hand], axis=-1)
        assert value(records, "fill", "pca", "missing_joint_error") == pytest.approx(errors.mean())

    def test_nothing_is_lost_by_the_input_of_project(self, records):
        assert value(records, "project", "input", "joint_error") == 0
        assert value(records, "project", "input", "bone_error") < 1e-5

    def test_padding_is_not_measured(self, bench):
        mask = bench.test.mask.copy()
        mask[0, 100:] = False

        class Spoilt(Bench):
            def restored(self, use, left):
                return {"input": np.where(self.windows.mask[..., np.newaxis], left.features, 1e6)}

        part = Spoilt(bench.motions, bench.manifolds)
        part.__dict__["test"] = replace(bench.test, mask=mask)
        for one in evaluation.restoration(part, "project"):
            assert one["value"] < 1e-3

    def test_signatures_state_the_model_and_the_motion(self, bench, records):
        for record in records:
            stated = npss.parse_signature(record["signature"])
            assert stated["metric"] == record["metric"]
            assert stated["convention"] == ("paper" if record["metric"] == "npss" else None)
            assert stated["fps"] == 30
            assert (stated.get("model") == "untrained-0") == record["method"].startswith("manifold")
        of_motion = {npss.parse_signature(r["signature"])["motion"] for r in records if r["use"] in USES}
        assert of_motion == {fingerprint(bench.test)}

    def test_the_same_again(self, bench, records):
        again = list(table.records_of(Bench(bench.motions, bench.manifolds)))
        assert json.dumps(again) == json.dumps(records)


class TestOtherUses:
    def test_interpolation_is_of_different_clips(self, bench):
        first, second = evaluation.pairs(bench.test, 20, seed=0)
        whole = bench.test.windows.astype(np.float64)

        def clip_of(window):
            return int(bench.test.clip_of[np.flatnonzero((whole == window).all(axis=(1, 2)))[0]])

        assert all(clip_of(a) != clip_of(b) for a, b in zip(first, second, strict=True))

    def test_two_clips_of_ones_choice(self, bench):
        records = list(evaluation.interpolation(bench, (2, 5)))
        first, second = (evaluation.first_window(bench.motions, clip) for clip in (2, 5))
        assert np.array_equal(first[0], bench.motions.features[2][:160])
        blends = np.concatenate([(1 - share) * first + share * second for share in (0.25, 0.5, 0.75)])
        expected = evaluation.validity(blends)
        assert value(records, "interpolate", "linear", "bone_error") == pytest.approx(expected["bone_error"])
        assert value(records, "interpolate", "linear", "foot_speed") == pytest.approx(expected["foot_speed"])
        assert npss.parse_signature(records[0]["signature"])["clips"] == "gait/2 gait/5"

    def test_one_clip_is_not_enough(self, bench):
        one = bench.test.only(subjects=["synthetic/0"])
        with pytest.raises(ValueError, match="motions: to interpolate, it takes whole windows of two clips"):
            evaluation.pairs(one, 1, seed=0)

    def test_interpolation_and_samples_are_measured(self, records):
        found = {(r["use"], r["method"]) for r in records}
        assert {("interpolate", method) for method in ("input", "linear", "pca", "manifold")} <= found
        assert {("sample", f"manifold, {prior}") for prior in ("uniform", "range", "values")} <= found
        assert value(records, "interpolate", "input", "bone_error") < 1e-5

    def test_real_motion_moves_as_it_does(self, bench, records):
        windows = bench.training.windows.astype(np.float64)
        speeds = [
            30 * np.linalg.norm(window[t, 3 * j : 3 * j + 3] - window[t - 1, 3 * j : 3 * j + 3])
            for window in windows[:2]
            for t in range(1, 160)
            for j in range(20)
        ]
        two = evaluation.validity(windows[:2])
        assert two["joint_speed"] == pytest.approx(np.mean(speeds))
        assert value(records, "sample", "input", "joint_speed") == pytest.approx(two["joint_speed"], rel=0.5)

    def test_filters_are_counted(self, bench, records):
        codes = bench.manifolds["manifold"].encode(bench.test.windows)
        assert value(records, "filters", "manifold", "saturated") == pytest.approx((np.abs(codes) > 0.95).mean())


@pytest.fixture(scope="module")
def walks_and_runs(motions):
    """The same clips, said to be of CMU: five of them walk, two run, one does what nobody knows."""
    said = ["walk", "run/jog", "slow walk", "run", "wave", "walk", "walk", "walk"]
    clips = tuple(replace(c, source="cmu", description=d) for c, d in zip(motions.clips, said, strict=True))
    return MotionSet(clips, motions.features, motions.windows, motions.mask, motions.clip_of)


class TestNearness:
    def test_against_retrieval_by_hand(self, walks_and_runs, bench):
        of = Bench(walks_and_runs, bench.manifolds)
        of.__dict__["rival"] = bench.rival
        records = list(evaluation.nearness(of))
        manifold = bench.manifolds["manifold"]
        clips = [i for i in range(8) if i != 4]
        codes = [manifold.encode(walks_and_runs.features[i][np.newaxis])[0] for i in clips]
        label = ["walk", "run", "walk", "run", "walk", "walk", "walk"]
        precisions = []
        for query in range(7):
            order = sorted((i for i in range(7) if i != query), key=lambda i: g(codes[query], codes[i]))
            hits = [label[i] == label[query] for i in order]
            precisions.append(np.mean([sum(hits[: k + 1]) / (k + 1) for k in range(6) if hits[k]]))
        found = [
            r
            for r in records
            if (r["use"], r["method"], r["metric"]) == ("nearest", "manifold", "map")
            and npss.parse_signature(r["signature"])["matches"] == "any"
        ]
        assert [r["value"] for r in found] == pytest.approx([np.mean(precisions)])
        stated = npss.parse_signature(found[0]["signature"])
        assert (stated["clips"], stated["actions"], stated["unlabelled"], stated["queries"]) == (7, 2, 1, 7)
        assert "8 clips" not in table.text(records)
        assert "nearest: 7 clips of cmu, 2 actions; 7 queries, to be found: any" in table.text(records)

    def test_sources_whose_actions_nobody_knows_are_refused(self, motions, bench):
        clips = tuple(replace(c, source="mine" if i == 3 else "cmu") for i, c in enumerate(motions.clips))
        other = MotionSet(clips, motions.features, motions.windows, motions.mask, motions.clip_of)
        message = "motions: it is not known what actions are called in 'mine', only in cmu, cmu-styles, h36m, synthetic"
        with pytest.raises(ValueError, match=message):
            list(evaluation.nearness(Bench(other, bench.manifolds)))

    def test_one_action_alone_cannot_be_told_apart(self, records):
        assert not [r for r in records if r["use"] in ("distance", "nearest")]

    def test_distances_are_what_they_are_called(self, motions, bench):
        found = clip_distances(motions, bench.manifolds, bench.rival, bench.normalization)
        manifold = bench.manifolds["manifold"]
        codes = [manifold.encode(each[np.newaxis])[0] for each in motions.features]
        windows = motions.windows.reshape(len(motions.windows), -1).astype(np.float64)
        for a, b in ((0, 1), (5, 2)):
            assert found["manifold"][a, b] == pytest.approx(np.sqrt(g(codes[a], codes[b])))
            assert found["extremes"][a, b] == pytest.approx(np.sqrt(g(motions.features[a], motions.features[b])))
            closest = min(
                np.linalg.norm(x - y) for x in windows[motions.clip_of == a] for y in windows[motions.clip_of == b]
            )
            assert found["euclidean"][a, b] == pytest.approx(closest)
            before = [np.arctanh(np.clip(codes[i].astype(float), -0.999, 0.999)) for i in (a, b)]
            assert found["manifold, unsquashed"][a, b] == pytest.approx(np.sqrt(g(*before)))
        for distances in found.values():
            assert np.array_equal(distances, distances.T)
            assert not distances.diagonal().any()

    def test_ranking(self, bench, motions):
        ranked = [r for r in evaluation.ranking(bench, 3, 4) if r["method"] == "manifold"]
        manifold = bench.manifolds["manifold"]
        codes = [manifold.encode(each[np.newaxis])[0] for each in motions.features]
        far = {i: float(g(codes[3], codes[i])) for i in range(8) if i != 3}
        assert [r["index"] for r in ranked] == sorted(far, key=far.__getitem__)[:4]
        assert [r["value"] for r in ranked] == pytest.approx([far[r["index"]] for r in ranked])

    def test_a_pair(self, bench, motions):
        (first, second) = evaluation.distance(bench, 0, 1)
        codes = [bench.manifolds["manifold"].encode(motions.features[i][np.newaxis])[0] for i in (0, 1)]
        assert first["value"] == float(g(*codes))
        assert second["metric"] == "distance"


@pytest.fixture(scope="module")
def poses():
    return gait(3, 60, seed=0)


class TestGOfPoses:
    def test_a_perfect_prediction(self, bench, poses):
        assert list(g_of_poses(bench.manifolds["manifold"], poses, poses)) == [0, 0, 0]

    def test_symmetric_and_positive(self, bench, poses):
        manifold = bench.manifolds["manifold"]
        held = np.repeat(poses[:, :1], 60, axis=1)
        there, back = g_of_poses(manifold, poses, held), g_of_poses(manifold, held, poses)
        assert there == pytest.approx(back)
        assert (there > 0).all()

    def test_where_the_root_goes_does_not_matter(self, bench, poses):
        other = poses.copy()
        other[..., :6] = 0
        assert list(g_of_poses(bench.manifolds["manifold"], poses, other)) == [0, 0, 0]

    def test_shapes_differ(self, bench, poses):
        with pytest.raises(ValueError, match="pred: its shape"):
            g_of_poses(bench.manifolds["manifold"], poses, poses[:, 1:])
