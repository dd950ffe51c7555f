"""Tests of the evaluation: records against direct measurements, and the table."""

import json
from dataclasses import replace

import numpy as np
import pytest

import npss
from npss.gait import gait
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.clip_distances import clip_distances
from npss_baselines.manifold.applications.distance import g, g_of_poses
from npss_baselines.manifold.applications.geodesic import geodesic_between
from npss_baselines.manifold.applications.interpolate import interpolate, slerp
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.restore import RESTORATIONS, Windows, corrupted, rescaled
from npss_baselines.manifold.evaluation import pca_size, restoration, similarity, synthesis, table
from npss_baselines.manifold.evaluation.pca_size import Restoration
from npss_baselines.manifold.evaluation.testbed import RESERVED, Testbed, fingerprint
from npss_baselines.manifold.model.pca import fit_pca
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.restorers.simple_baselines import names_for
from untrained import manifold_of


def value(records, application, method, metric):
    (value,) = [
        r["value"] for r in records if (r["application"], r["method"], r["metric"]) == (application, method, metric)
    ]
    return value


class TestTestbed:
    @pytest.mark.parametrize("name", ["input", "linear", "pca", "pca-best", "extremes", "original", "pca, known kept"])
    def test_reserved_names(self, motions, name):
        with pytest.raises(ValueError, match=f"^manifolds: invalid name '{name}'"):
            Testbed(motions, {"manifold": manifold_of(motions), name: manifold_of(motions)})

    def test_all_other_methods_are_reserved(self, testbed, records):
        chosen = clip_distances(testbed.motions, testbed.manifolds, testbed.pca, testbed.scaling)
        methods = {Method.parse(record["method"]) for record in records} | set(chosen)
        assert {method.name for method in methods} - {"manifold"} <= set(RESERVED)

    def test_subjects_are_in_one_set(self, testbed):
        subjects = [{clip.subject for clip in part.clips} for part in (testbed.training, testbed.test)]
        assert subjects[1] == {"synthetic/0", "synthetic/1"}
        assert not subjects[0] & subjects[1]

    def test_baselines_are_fitted_to_training_windows_only(self, testbed):
        assert len(testbed.pca.components) == len(testbed.training.windows) - 1 < 400  # 40 x 10 numbers in the code
        assert testbed.pca.project(testbed.training.windows) == pytest.approx(testbed.training.windows, abs=1e-4)
        assert np.abs(testbed.pca.project(testbed.test.windows) - testbed.test.windows).max() > 0.01

    def test_best_size(self, testbed):
        """Compare with a search over all sizes on the subjects set aside."""
        best = pca_size.best_sizes(testbed.training, testbed.scaling, ["project", "repair"])
        repaired = Restoration("repair", rescaled=True)
        assert set(best) == {Restoration("project"), Restoration("repair"), repaired}
        subjects = sorted({clip.subject for clip in testbed.training.clips})
        aside = [subjects[i] for i in range(1, len(subjects), 3)]
        fitted = fit_pca(testbed.training.only(exclude_subjects=aside).windows, testbed.scaling, n_components=160 * 60)
        left_out = testbed.training.only(subjects=aside)
        gt = local_positions(left_out.windows)
        sizes = [2**i for i in range(20) if 2**i < len(fitted.components)] + [pca_size.ALL]
        assert len(sizes) > 4
        for way, size in best.items():
            lost = corrupted(way.application, Windows(left_out.windows, left_out.mask), testbed.scaling.mean)
            seen = rescaled(lost, testbed.scaling.mean) if way.rescaled else lost.features
            errors = {}
            for tried in sizes:
                pred = local_positions(pca_size.truncated(fitted, tried).project(seen))
                errors[tried] = np.linalg.norm(pred - gt, axis=-1)[left_out.mask].mean()
            assert errors.pop(size) < min(errors.values())

    def test_a_single_subject_has_no_best_size(self, testbed):
        single = testbed.training.only(subjects=[testbed.training.clips[0].subject])
        assert pca_size.best_sizes(single, testbed.scaling, ["project"]) == {}

    def test_no_held_out_subject(self, motions):
        others = motions.only(exclude_subjects=["synthetic/0", "synthetic/1"])
        with pytest.raises(ValueError, match="no motion of the held-out subjects cmu/02"):
            _ = Testbed(others, {"manifold": manifold_of(motions)}).test

    def test_fingerprint_depends_on_every_value(self, motions):
        changed = [each.copy() for each in motions.features]
        changed[-1][-1, -1] += 1e-6
        other = MotionSet(motions.clips, tuple(changed), motions.windows, motions.mask, motions.clip_of)
        assert fingerprint(motions) == fingerprint(motions) != fingerprint(other)


class TestRestoration:
    def test_every_application_method_and_metric(self, testbed, records):
        for application in RESTORATIONS:
            results = {(r["method"], r["metric"]) for r in records if r["application"] == application}
            methods = ["input", "pca", "pca-best", "manifold"]
            metrics = ["joint_error", "bone_error", "npss", "foot_speed"]
            if application != "project":
                ways = names_for(testbed.corrupted(application))
                methods += ["pca-best, known kept", "manifold, known kept", "manifold, alternating", "restorer", *ways]
                metrics += ["lost_error", "ratio"]
            if application == "repair":
                methods += ["pca-best, rescaled", "manifold, rescaled"]
            expected = {(method, metric) for method in methods for metric in metrics}
            assert results == expected | {("original", "foot_speed")}

    def test_the_ratio_is_to_the_best_simple_baseline(self, testbed, records):
        for application in ("repair", "kinect", "inbetween"):
            ways = names_for(testbed.corrupted(application))
            errors = {way: value(records, application, way, "lost_error") for way in ways}
            best = min(errors, key=errors.__getitem__)
            ratios = [r for r in records if (r["application"], r["metric"]) == (application, "ratio")]
            assert {npss.parse_signature(r["signature"])["extra"]["reference"] for r in ratios} == {best}
            assert {r["subject"] for r in ratios} == {"all", "synthetic/0", "synthetic/1"}
            for record in ratios:
                if record["subject"] == "all":
                    lost = value(records, application, record["method"], "lost_error")
                    assert record["value"] == pytest.approx(lost / errors[best])
                    assert record["low"] <= record["value"] <= record["high"]
                    assert record["clips"] == 2

    def test_lost_joints_are_those_of_which_a_coordinate_was_lost(self, testbed, records):
        left, mask = testbed.corrupted("repair"), testbed.windows.mask
        motion = testbed.restorers(left)[Method("gaussian")].restore(left)
        distances = []
        for i, t, j in np.ndindex(*mask.shape, 20):
            columns = slice(3 * j, 3 * j + 3)
            if mask[i, t] and not left.known[i, t, columns].all():
                distances.append(np.linalg.norm(motion[i, t, columns] - testbed.windows.features[i, t, columns]))
        assert value(records, "repair", "gaussian", "lost_error") == pytest.approx(np.mean(distances))

    def test_against_the_measures(self, testbed, records):
        left = testbed.corrupted("repair")
        motion = testbed.manifolds["manifold"].project(left.features)
        gt, pred = local_positions(testbed.windows.features), local_positions(motion)
        assert value(records, "repair", "manifold", "joint_error") == pytest.approx(
            np.linalg.norm(pred - gt, axis=-1)[testbed.windows.mask].mean()
        )
        sequences = [each.reshape(len(each), 160, 60) for each in (gt, pred)]
        assert value(records, "repair", "manifold", "npss") == pytest.approx(npss.score(*sequences))
        bone = measures.bone_error(pred, JOINTS, testbed.windows.mask)
        assert value(records, "repair", "manifold", "bone_error") == bone

    def test_rescaled_repair(self, testbed, records):
        """Double deviations from the mean if half is lost, then put known values back."""
        left = testbed.corrupted("repair")
        mean = testbed.scaling.mean
        assert left.known.mean() == pytest.approx(0.5, abs=0.01)
        share = left.known.reshape(len(left.known), -1).mean(1)[:, np.newaxis, np.newaxis]
        motion = testbed.manifolds["manifold"].project(mean + (left.features - mean) / share)
        kept = np.where(left.known, testbed.windows.features, motion)
        gt, mask = local_positions(testbed.windows.features), testbed.windows.mask
        for method, pred in (("manifold, rescaled", motion), ("manifold, known kept", kept)):
            expected = np.linalg.norm(local_positions(pred) - gt, axis=-1)[mask].mean()
            assert value(records, "repair", method, "joint_error") == pytest.approx(expected)

    def test_the_missing_joints_are_the_hand(self, testbed, records):
        hand = [JOINTS.names.index(name) for name in ("RightHand", "RightHandIndex")]
        motion = testbed.pca.project(testbed.corrupted("fill").features)
        errors = np.linalg.norm(local_positions(motion - testbed.windows.features)[:, :, hand], axis=-1)
        assert value(records, "fill", "pca", "lost_error") == pytest.approx(errors.mean())

    def test_input_of_project_has_no_error(self, records):
        assert value(records, "project", "input", "joint_error") == 0
        assert value(records, "project", "input", "bone_error") < 1e-5

    def test_padding_is_not_measured(self, testbed):
        mask = testbed.test.mask.copy()
        mask[0, 100:] = False

        class Spoilt(Testbed):
            def restored(self, application, left):
                return {Method("input"): np.where(self.windows.mask[..., np.newaxis], left.features, 1e6)}

        part = Spoilt(testbed.motions, testbed.manifolds)
        part.__dict__["test"] = replace(testbed.test, mask=mask)
        for record in restoration.restoration(part, "project"):
            assert record["value"] < (10 if record["metric"] == "foot_speed" else 1e-3)

    def test_signatures_state_the_model_and_the_motion(self, testbed, records):
        for record in records:
            fields = npss.parse_signature(record["signature"])
            assert fields["metric"] == record["metric"]
            assert fields["convention"] == ("paper" if record["metric"] == "npss" else None)
            assert fields["fps"] == 30
            assert str(fields.get("model")).startswith("untrained-0") == record["method"].startswith("manifold")
        of_motion = {
            npss.parse_signature(r["signature"])["motion"] for r in records if r["application"] in RESTORATIONS
        }
        assert of_motion == {fingerprint(testbed.test)}

    def test_reproducible(self, testbed, records):
        fresh = Testbed(testbed.motions, testbed.manifolds)
        again = [*restoration.restoration(fresh, "fill"), *synthesis.sampling(fresh)]
        assert json.dumps(again) == json.dumps([r for r in records if r["application"] in ("fill", "sample")])


class TestSynthesis:
    def test_interpolation_is_between_different_clips(self, testbed):
        first, second = synthesis.pairs(testbed.test, 20, seed=0)
        whole = testbed.test.windows.astype(np.float64)

        def clip_of(window):
            return int(testbed.test.clip_of[np.flatnonzero((whole == window).all(axis=(1, 2)))[0]])

        assert all(clip_of(a) != clip_of(b) for a, b in zip(first, second, strict=True))

    def test_two_chosen_clips(self, testbed):
        records = list(synthesis.interpolation(testbed, (2, 5)))
        first, second = (synthesis.first_window(testbed.motions, clip) for clip in (2, 5))
        assert np.array_equal(first[0], testbed.motions.features[2][:160])
        blends = np.concatenate([(1 - share) * first + share * second for share in (0.25, 0.5, 0.75)])
        expected = synthesis.validity(blends)
        assert value(records, "interpolate", "linear", "bone_error") == pytest.approx(expected["bone_error"])
        assert value(records, "interpolate", "linear", "foot_speed") == pytest.approx(expected["foot_speed"])
        for method, options in {
            "slerp, possible": {},
            "linear, possible": {"way": "linear"},
            "manifold": {"way": "manifold", "constrained": False},
            "manifold, possible": {"way": "manifold"},
        }.items():
            manifold = testbed.manifolds["manifold"]
            made = [interpolate(manifold, first, second, share, **options) for share in (0.25, 0.5, 0.75)]
            expected = synthesis.validity(np.concatenate(made))
            assert value(records, "interpolate", method, "jerk") == pytest.approx(expected["jerk"])
        assert not [record for record in records if "low" in record]  # a pair has no interval
        assert npss.parse_signature(records[0]["signature"])["clips"] == "gait/2 gait/5"

    def test_interpolations_are_compared_with_the_default(self, testbed, records):
        of_pairs = [record for record in records if record["application"] == "interpolate"]
        assert {r["method"] for r in of_pairs if "low" not in r} == {"input", "slerp, possible"}
        assert {r["against"] for r in of_pairs if "low" in r} == {"slerp, possible"}
        for record in of_pairs:
            if "low" in record:
                difference = record["value"] - value(records, "interpolate", "slerp, possible", record["metric"])
                assert record["low"] - 1e-12 <= difference <= record["high"] + 1e-12
        text = table.text(of_pairs)
        assert "in parentheses: 95 % interval of the difference from slerp, possible" in text

    def test_npss_of_an_interpolation_counts_both_by_their_shares(self, testbed, records):
        first, second = synthesis.pairs(testbed.test, synthesis.PAIRS, seed=0)
        total = np.zeros(2)
        for share in synthesis.SHARES:
            pred = slerp(first, second, share)[..., :60]
            for part, gt in ((1 - share, first[..., :60]), (share, second[..., :60])):
                scored = npss.report(gt, pred)
                total += part * np.array([(scored.weight * scored.emd).sum(), scored.weight.sum()])
        assert value(records, "interpolate", "slerp", "npss") == pytest.approx(total[0] / total[1])

    def test_jerk(self):
        """A figure that moves along x by t^3 has a constant third difference of 6."""
        motion = np.zeros((1, 50, 63))
        motion[0, :, -2] = 1e-4 * np.diff(np.arange(-1.0, 50) ** 3)
        assert synthesis.validity(motion)["jerk"] == pytest.approx(6e-4 * 30**3)
        assert synthesis.validity(motion)["snaps"] == 0
        motion[0, 25, :3] += 1  # a jump of one joint in a frame: four third differences, of 1, 3, 3 and 1
        assert synthesis.validity(motion)["snaps"] == pytest.approx(4 / (20 * 47))

    def test_one_clip_is_not_enough(self, testbed):
        single = testbed.test.only(subjects=["synthetic/0"])
        with pytest.raises(ValueError, match="motions: interpolation needs whole windows of at least two clips"):
            synthesis.pairs(single, 1, seed=0)

    def test_interpolation_and_samples_are_measured(self, records):
        results = {(r["application"], r["method"]) for r in records}
        assert {("interpolate", method) for method in ("input", "linear", "pca", "manifold")} <= results
        assert {("sample", f"manifold, {prior}") for prior in ("local", "uniform", "range", "values")} <= results
        assert value(records, "sample", "manifold, local, possible", "bone_error") < 1e-9
        for metric in ("precision", "recall"):
            assert value(records, "sample", "manifold, uniform", metric) == 0
            assert 0 <= value(records, "sample", "input", metric) <= 1
        assert value(records, "sample", "input", "nearest_npss") < value(
            records, "sample", "manifold, uniform", "nearest_npss"
        )
        assert value(records, "interpolate", "input", "bone_error") < 1e-5

    def test_measures_of_real_motion(self, testbed, records):
        windows = testbed.training.windows.astype(np.float64)
        speeds = [
            30 * np.linalg.norm(window[t, 3 * j : 3 * j + 3] - window[t - 1, 3 * j : 3 * j + 3])
            for window in windows[:2]
            for t in range(1, 160)
            for j in range(20)
        ]
        two = synthesis.validity(windows[:2])
        assert two["joint_speed"] == pytest.approx(np.mean(speeds))
        assert value(records, "sample", "input", "joint_speed") == pytest.approx(two["joint_speed"], rel=0.5)

    def test_filters(self, testbed, records):
        codes = testbed.manifolds["manifold"].encode(testbed.test.windows)
        assert value(records, "filters", "manifold", "saturated") == pytest.approx((np.abs(codes) > 0.95).mean())


@pytest.fixture(scope="module")
def walks_and_runs(motions):
    """Return the clips as CMU's: five walks, two runs, one without a label."""
    descriptions = ["walk", "run/jog", "slow walk", "run", "wave", "walk", "walk", "walk"]
    clips = tuple(replace(c, source="cmu", description=d) for c, d in zip(motions.clips, descriptions, strict=True))
    return MotionSet(clips, motions.features, motions.windows, motions.mask, motions.clip_of)


class TestNearness:
    def test_against_retrieval_by_hand(self, walks_and_runs, testbed):
        own = Testbed(walks_and_runs, testbed.manifolds)
        own.__dict__["pca"] = testbed.pca
        records = list(similarity.nearness(own))
        manifold = testbed.manifolds["manifold"]
        clips = [i for i in range(8) if i != 4]
        codes = [manifold.encode(walks_and_runs.features[i][np.newaxis])[0] for i in clips]
        label = ["walk", "run", "walk", "run", "walk", "walk", "walk"]
        precisions = []
        for query in range(7):
            order = sorted((i for i in range(7) if i != query), key=lambda i: g(codes[query], codes[i]))
            hits = [label[i] == label[query] for i in order]
            precisions.append(np.mean([sum(hits[: k + 1]) / (k + 1) for k in range(6) if hits[k]]))
        results = [
            r
            for r in records
            if (r["application"], r["method"], r["metric"]) == ("nearest", "manifold", "map")
            and npss.parse_signature(r["signature"])["matches"] == "any"
        ]
        assert [r["value"] for r in results] == pytest.approx([np.mean(precisions)])
        fields = npss.parse_signature(results[0]["signature"])
        assert (fields["clips"], fields["actions"], fields["unlabelled"], fields["queries"]) == (7, 2, 1, 7)
        assert "8 clips" not in table.text(records)
        assert "nearest: 7 clips of cmu, 2 actions; 7 queries, matches: any" in table.text(records)

    def test_sources_without_known_actions_are_refused(self, motions, testbed):
        clips = tuple(replace(c, source="mine" if i == 3 else "cmu") for i, c in enumerate(motions.clips))
        other = MotionSet(clips, motions.features, motions.windows, motions.mask, motions.clip_of)
        known = "cmu, cmu-styles, h36m, bvh, synthetic"
        with pytest.raises(
            ValueError, match=f"motions: unknown action names of source 'mine'; they are known for {known}"
        ):
            list(similarity.nearness(Testbed(other, testbed.manifolds)))

    def test_a_single_action_has_no_records(self, records):
        assert not [r for r in records if r["application"] in ("distance", "nearest")]

    def test_distances_by_name(self, motions, testbed):
        by_method = clip_distances(motions, testbed.manifolds, testbed.pca, testbed.scaling)
        results = {str(method): distances for method, distances in by_method.items()}
        manifold = testbed.manifolds["manifold"]
        codes = [manifold.encode(each[np.newaxis])[0] for each in motions.features]
        windows = motions.windows.reshape(len(motions.windows), -1).astype(np.float64)
        for a, b in ((0, 1), (5, 2)):
            assert results["manifold"][a, b] == pytest.approx(np.sqrt(g(codes[a], codes[b])))
            assert results["extremes"][a, b] == pytest.approx(np.sqrt(g(motions.features[a], motions.features[b])))
            closest = min(
                np.linalg.norm(x - y) for x in windows[motions.clip_of == a] for y in windows[motions.clip_of == b]
            )
            assert results["euclidean"][a, b] == pytest.approx(closest)
            before = [np.arctanh(np.clip(codes[i].astype(float), -0.999, 0.999)) for i in (a, b)]
            assert results["manifold, unsquashed"][a, b] == pytest.approx(np.sqrt(g(*before)))
        for distances in results.values():
            assert np.array_equal(distances, distances.T)
            assert not distances.diagonal().any()

    def test_ranking(self, testbed, motions):
        ranked = [r for r in similarity.ranking(testbed, 3, 4) if r["method"] == "manifold"]
        manifold = testbed.manifolds["manifold"]
        codes = [manifold.encode(features[np.newaxis])[0] for features in motions.features]
        distances = {i: float(g(codes[3], codes[i])) for i in range(8) if i != 3}
        assert [r["index"] for r in ranked] == sorted(distances, key=distances.__getitem__)[:4]
        assert [r["value"] for r in ranked] == pytest.approx([distances[r["index"]] for r in ranked])

    def test_a_pair(self, testbed, motions):
        by_metric = {record["metric"]: record["value"] for record in similarity.distance(testbed, 0, 1)}
        manifold = testbed.manifolds["manifold"]
        codes = [manifold.encode(motions.features[i][np.newaxis])[0] for i in (0, 1)]
        assert by_metric["g"] == float(g(*codes))
        path = geodesic_between(manifold, *(motions.windows[motions.clip_of == i][0] for i in (0, 1)))
        assert by_metric["geodesic"] == path.length
        assert list(by_metric) == ["g", "geodesic", "distance"]


@pytest.fixture(scope="module")
def poses():
    return gait(3, 60, seed=0)


class TestGOfPoses:
    def test_a_perfect_prediction(self, testbed, poses):
        assert list(g_of_poses(testbed.manifolds["manifold"], poses, poses)) == [0, 0, 0]

    def test_symmetric_and_positive(self, testbed, poses):
        manifold = testbed.manifolds["manifold"]
        held = np.repeat(poses[:, :1], 60, axis=1)
        forward, back = g_of_poses(manifold, poses, held), g_of_poses(manifold, held, poses)
        assert forward == pytest.approx(back)
        assert (forward > 0).all()

    def test_root_motion_does_not_matter(self, testbed, poses):
        other = poses.copy()
        other[..., :6] = 0
        assert list(g_of_poses(testbed.manifolds["manifold"], poses, other)) == [0, 0, 0]

    def test_shapes_differ(self, testbed, poses):
        with pytest.raises(ValueError, match="pred: its shape"):
            g_of_poses(testbed.manifolds["manifold"], poses, poses[:, 1:])
