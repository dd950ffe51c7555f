"""Tests of retrieval, by hand and by brute force, and of labels."""

import csv
import itertools
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.data import SOURCES
from npss_baselines.data.cmu_labels import KEYWORDS, label_of
from npss_baselines.manifold.applications import retrieval
from npss_baselines.manifold.applications.retrieval import MATCHES, auc, chance, closest_windows, distances_of, retrieve


def ranking(query, distances, labels, subjects, matches):
    """Return whether each ranked clip is a match, nearest first, from the definition."""
    hits = []
    for _, clip in sorted((distances[query][clip], clip) for clip in range(len(labels))):
        same_label = labels[clip] == labels[query]
        unknown = "" in (subjects[clip], subjects[query])
        same_subject = subjects[clip] == subjects[query]
        if clip == query:
            continue
        if not same_label:
            hits.append(False)
        elif (
            matches == "any"
            or (matches == "same subject" and not unknown and same_subject)
            or (matches == "other subject" and not unknown and not same_subject)
        ):
            hits.append(True)
    return hits


def precision(hits):
    right = [rank for rank, hit in enumerate(hits, 1) if hit]
    return sum(Fraction(n_hits, rank) for n_hits, rank in enumerate(right, 1)) / len(right) if right else None


clips = st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["s", "t", ""])), min_size=2, max_size=9)


class TestRetrieve:
    @given(clips, st.sampled_from(MATCHES), st.integers(0, 1000))
    def test_brute_force(self, clips, matches, seed):
        labels, subjects = zip(*clips, strict=True)
        distances = np.random.default_rng(seed).integers(0, 6, (len(labels), len(labels)))  # with ties
        result = retrieve(distances, labels, subjects, matches=matches)
        for query in range(len(labels)):
            hits = ranking(query, distances, labels, subjects, matches)
            if not any(hits):
                assert np.isnan([result.precision[query], result.nearest[query]]).all()
            else:
                assert result.precision[query] == pytest.approx(float(precision(hits)))
                assert result.nearest[query] == hits[0]

    def test_by_hand(self):
        # Query 0 is a walk of A's. In order of distance: B's walk, A's run, A's walk, C's run, C's walk.
        labels = ["walk", "walk", "run", "walk", "run", "walk"]
        subjects = ["A", "B", "A", "A", "C", "C"]
        distances = np.abs(np.subtract.outer(np.arange(6.0), np.arange(6.0)))
        result = {matches: retrieve(distances, labels, subjects, matches=matches) for matches in MATCHES}
        assert result["any"].precision[0] == pytest.approx((1 / 1 + 2 / 3 + 3 / 5) / 3)
        assert result["same subject"].precision[0] == pytest.approx(1 / 2)  # run, walk, run
        assert result["other subject"].precision[0] == pytest.approx((1 / 1 + 2 / 4) / 2)  # B, run, run, C
        assert [result[matches].nearest[0] for matches in MATCHES] == [1, 0, 1]
        assert np.isnan(result["same subject"].precision[1])  # B's only clip
        assert [result[matches].n_queries for matches in MATCHES] == [6, 2, 6]

    def test_an_action_of_one_subject_has_no_match_in_another(self):
        labels, subjects = ["dance", "dance", "walk", "walk"], ["A", "A", "A", "B"]
        distances = np.random.default_rng(0).random((4, 4))
        assert list(np.isfinite(retrieve(distances, labels, subjects, matches="other subject").precision)) == [
            0,
            0,
            1,
            1,
        ]
        assert list(np.isfinite(retrieve(distances, labels, subjects, matches="same subject").precision)) == [
            1,
            1,
            0,
            0,
        ]

    def test_unknown_subjects_match_neither(self):
        result = [retrieve(np.zeros((2, 2)), ["a", "a"], ["", ""], matches=matches).n_queries for matches in MATCHES]
        assert result == [2, 0, 0]

    def test_means(self):
        result = retrieval.Retrieved(np.array([1, 0.5, np.nan, 0.2]), np.array([1, 0, np.nan, 0]))
        assert result.mean() == pytest.approx((1.7 / 3, 1 / 3))
        assert result.mean_of_labels(["a", "a", "a", "b"]) == pytest.approx((0.475, 0.25))

    @given(clips, st.integers(0, 1000))
    def test_the_scale_of_a_distance_does_not_matter(self, clips, seed):
        labels, subjects = zip(*clips, strict=True)
        distances = np.random.default_rng(seed).random((len(labels), len(labels)))
        first, squared = retrieve(distances, labels, subjects), retrieve(distances**2, labels, subjects)
        assert np.array_equal(first.precision, squared.precision, equal_nan=True)

    @pytest.mark.parametrize(
        ("distances", "labels", "subjects", "matches", "message"),
        [
            (np.zeros((2, 3)), "ab", "ab", "any", r"distances: expected shape \(N, N\) = \(2, 2\)"),
            (np.full((2, 2), np.nan), "ab", "ab", "any", "distances: NaN cannot"),
            (np.zeros((2, 2)), ["a", ""], "ab", "any", "labels: the clip at index 1 has no label"),
            (np.zeros((2, 2)), "ab", "a", "any", "subjects: 1 subjects for 2 labels"),
            (np.zeros((2, 2)), "ab", "ab", "all", "matches: expected one of any, same subject"),
        ],
    )
    def test_bad_input(self, distances, labels, subjects, matches, message):
        with pytest.raises(ValueError, match=message):
            retrieve(distances, list(labels), list(subjects), matches=matches)


class TestChance:
    @pytest.mark.parametrize("matches", MATCHES)
    def test_chance_is_the_average_over_all_orders(self, matches):
        labels, subjects = ["a", "a", "a", "b", "b"], ["s", "s", "t", "t", ""]
        expected = chance(labels, subjects, matches=matches)
        orders = [
            retrieve(np.tile(np.argsort(order), (5, 1)), labels, subjects, matches=matches)
            for order in itertools.permutations(range(5))
        ]
        for name in ("precision", "nearest"):
            mean = np.mean([getattr(result, name) for result in orders], axis=0)
            assert getattr(expected, name) == pytest.approx(mean, nan_ok=True)

    def test_all_clips_match(self):
        assert list(chance(["a", "a"], ["", ""]).precision) == [1, 1]


class TestAuc:
    @given(st.lists(st.sampled_from("ab"), min_size=3, max_size=7), st.integers(0, 1000))
    def test_brute_force_over_pairs(self, labels, seed):
        distances = np.random.default_rng(seed).integers(0, 5, (len(labels), len(labels)))
        distances = distances + distances.T
        pairs = list(itertools.combinations(range(len(labels)), 2))
        same = [distances[a, b] for a, b in pairs if labels[a] == labels[b]]
        different = [distances[a, b] for a, b in pairs if labels[a] != labels[b]]
        if same and different:
            wins = [(near < far) + (near == far) / 2 for near in same for far in different]
            assert auc(distances, labels) == pytest.approx(np.mean(wins))

    def test_no_equal_labels(self):
        assert np.isnan(auc(np.zeros((2, 2)), ["a", "b"]))


class TestDistances:
    @given(st.integers(1, 4), st.integers(0, 1000))
    def test_closest_windows(self, n_clips, seed):
        rng = np.random.default_rng(seed)
        labels = np.concatenate([np.arange(n_clips), rng.integers(0, n_clips, 4)])
        vectors = rng.normal(size=(len(labels), 3))
        result = closest_windows(vectors, labels, n_clips)
        for a, b in np.ndindex(n_clips, n_clips):
            pairs = [np.linalg.norm(x - y) for x in vectors[labels == a] for y in vectors[labels == b]]
            assert result[a, b] == pytest.approx(min(pairs))

    def test_a_clip_without_windows(self):
        with pytest.raises(ValueError, match="clip_of: not all of 3 clips have a window"):
            closest_windows([[0.0], [1.0]], [0, 2], 3)

    def test_euclidean(self):
        vectors = np.random.default_rng(0).normal(size=(5, 4))
        for a, b in np.ndindex(5, 5):
            assert distances_of(vectors)[a, b] == pytest.approx(np.linalg.norm(vectors[a] - vectors[b]))


class TestLabels:
    @pytest.mark.parametrize(
        ("description", "label"),
        [
            ("walk", "walk"),
            ("run/jog", "run"),
            ("walk/stride", "walk"),
            ("slow walk", "walk"),
            ("navigate - walk forward, backward, sideways", "walk"),
            ("jump, balance", "jump"),
            ("playground - forward jumps, turn around", "jump"),
            ("playground - climb, jump down, dangle, legs push off against", "climb"),
            ("climb 3 steps", "climb"),
            ("jumping jacks, side twists, squats, jog", "jumping jacks"),
            ("dance - small jetes, pirouette", "dance"),
            ("basketball - dribble, shoot", "basketball"),
            ("soccer - kick ball", "soccer"),
            ("unscrew bottlecap, drink soda", "drink"),
            ("sit on high stool, stand up", "sit"),
            ("boxing", "punch"),
            ("Walk", "walk"),
            ("visit the site", ""),
            ("", ""),
        ],
    )
    def test_first_word_counts(self, description, label):
        assert label_of(description) == label

    def test_labels_of_other_sources(self):
        descriptions = {"cmu": "slow walk", "cmu-styles": "salsa", "h36m": "walkingdog"}
        assert [SOURCES[name].label(description) for name, description in descriptions.items()] == [
            "walk",
            "salsa",
            "walkingdog",
        ]

    def test_all_labels_occur(self, cmu_root):
        with (cmu_root / "clips.csv").open(encoding="utf-8") as file:
            counts = Counter(label_of(row["description"]) for row in csv.DictReader(file))
        assert set(counts) == {*KEYWORDS, ""}
        assert {label: counts[label] for label in ("walk", "run", "dance", "climb", "")} == {
            "walk": 34,
            "run": 12,
            "dance": 19,
            "climb": 14,
            "": 4,
        }
