"""Retrieval: average precision by hand and by brute force, and the labels by which it is judged."""

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
    """Whether each clip that is ranked is right, nearest first: from the definition."""
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
    return sum(Fraction(found, rank) for found, rank in enumerate(right, 1)) / len(right) if right else None


clips = st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["s", "t", ""])), min_size=2, max_size=9)


class TestRetrieve:
    @given(clips, st.sampled_from(MATCHES), st.integers(0, 1000))
    def test_brute_force(self, clips, matches, seed):
        of, who = zip(*clips, strict=True)
        distances = np.random.default_rng(seed).integers(0, 6, (len(of), len(of)))  # with ties
        found = retrieve(distances, of, who, matches=matches)
        for query in range(len(of)):
            hits = ranking(query, distances, of, who, matches)
            if not any(hits):
                assert np.isnan([found.precision[query], found.nearest[query]]).all()
            else:
                assert found.precision[query] == pytest.approx(float(precision(hits)))
                assert found.nearest[query] == hits[0]

    def test_by_hand(self):
        # Query 0 is a walk of A's. In order of distance: B's walk, A's run, A's walk, C's run, C's walk.
        of = ["walk", "walk", "run", "walk", "run", "walk"]
        who = ["A", "B", "A", "A", "C", "C"]
        distances = np.abs(np.subtract.outer(np.arange(6.0), np.arange(6.0)))
        found = {matches: retrieve(distances, of, who, matches=matches) for matches in MATCHES}
        assert found["any"].precision[0] == pytest.approx((1 / 1 + 2 / 3 + 3 / 5) / 3)
        assert found["same subject"].precision[0] == pytest.approx(1 / 2)  # run, walk, run
        assert found["other subject"].precision[0] == pytest.approx((1 / 1 + 2 / 4) / 2)  # B, run, run, C
        assert [found[matches].nearest[0] for matches in MATCHES] == [1, 0, 1]
        assert np.isnan(found["same subject"].precision[1])  # B's only clip
        assert [found[matches].n_queries for matches in MATCHES] == [6, 2, 6]

    def test_an_action_of_one_subject_has_no_match_in_another(self):
        of, who = ["dance", "dance", "walk", "walk"], ["A", "A", "A", "B"]
        distances = np.random.default_rng(0).random((4, 4))
        assert list(np.isfinite(retrieve(distances, of, who, matches="other subject").precision)) == [0, 0, 1, 1]
        assert list(np.isfinite(retrieve(distances, of, who, matches="same subject").precision)) == [1, 1, 0, 0]

    def test_unknown_subjects_are_neither(self):
        found = [retrieve(np.zeros((2, 2)), ["a", "a"], ["", ""], matches=matches).n_queries for matches in MATCHES]
        assert found == [2, 0, 0]

    def test_means(self):
        found = retrieval.Retrieved(np.array([1, 0.5, np.nan, 0.2]), np.array([1, 0, np.nan, 0]))
        assert found.mean() == pytest.approx((1.7 / 3, 1 / 3))
        assert found.mean_of_labels(["a", "a", "a", "b"]) == pytest.approx((0.475, 0.25))

    @given(clips, st.integers(0, 1000))
    def test_the_scale_of_a_distance_does_not_matter(self, clips, seed):
        of, who = zip(*clips, strict=True)
        distances = np.random.default_rng(seed).random((len(of), len(of)))
        first, squared = retrieve(distances, of, who), retrieve(distances**2, of, who)
        assert np.array_equal(first.precision, squared.precision, equal_nan=True)

    @pytest.mark.parametrize(
        ("distances", "of", "who", "matches", "message"),
        [
            (np.zeros((2, 3)), "ab", "ab", "any", r"distances: expected shape \(N, N\) = \(2, 2\)"),
            (np.full((2, 2), np.nan), "ab", "ab", "any", "distances: a NaN"),
            (np.zeros((2, 2)), ["a", ""], "ab", "any", "labels: the clip at index 1 has none"),
            (np.zeros((2, 2)), "ab", "a", "any", "subjects: 1 of them for 2 labels"),
            (np.zeros((2, 2)), "ab", "ab", "all", "matches: expected one of any, same subject"),
        ],
    )
    def test_bad_input(self, distances, of, who, matches, message):
        with pytest.raises(ValueError, match=message):
            retrieve(distances, list(of), list(who), matches=matches)


class TestChance:
    @pytest.mark.parametrize("matches", MATCHES)
    def test_it_is_the_mean_over_all_orders(self, matches):
        of, who = ["a", "a", "a", "b", "b"], ["s", "s", "t", "t", ""]
        expected = chance(of, who, matches=matches)
        orders = [
            retrieve(np.tile(np.argsort(order), (5, 1)), of, who, matches=matches)
            for order in itertools.permutations(range(5))
        ]
        for name in ("precision", "nearest"):
            mean = np.mean([getattr(found, name) for found in orders], axis=0)
            assert getattr(expected, name) == pytest.approx(mean, nan_ok=True)

    def test_where_all_are_right(self):
        assert list(chance(["a", "a"], ["", ""]).precision) == [1, 1]


class TestAuc:
    @given(st.lists(st.sampled_from("ab"), min_size=3, max_size=7), st.integers(0, 1000))
    def test_all_pairs_of_pairs(self, of, seed):
        distances = np.random.default_rng(seed).integers(0, 5, (len(of), len(of)))
        distances = distances + distances.T
        pairs = list(itertools.combinations(range(len(of)), 2))
        same = [distances[a, b] for a, b in pairs if of[a] == of[b]]
        different = [distances[a, b] for a, b in pairs if of[a] != of[b]]
        if same and different:
            wins = [(near < far) + (near == far) / 2 for near in same for far in different]
            assert auc(distances, of) == pytest.approx(np.mean(wins))

    def test_no_two_are_the_same(self):
        assert np.isnan(auc(np.zeros((2, 2)), ["a", "b"]))


class TestDistances:
    @given(st.integers(1, 4), st.integers(0, 1000))
    def test_clips_are_as_close_as_their_closest_windows(self, n_clips, seed):
        rng = np.random.default_rng(seed)
        of = np.concatenate([np.arange(n_clips), rng.integers(0, n_clips, 4)])
        vectors = rng.normal(size=(len(of), 3))
        found = closest_windows(vectors, of, n_clips)
        for a, b in np.ndindex(n_clips, n_clips):
            pairs = [np.linalg.norm(x - y) for x in vectors[of == a] for y in vectors[of == b]]
            assert found[a, b] == pytest.approx(min(pairs))

    def test_a_clip_without_windows(self):
        with pytest.raises(ValueError, match="clip_of: not every clip of 3 has a window"):
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
    def test_what_comes_first(self, description, label):
        assert label_of(description) == label

    def test_only_what_cmu_says_is_read(self):
        said = {"cmu": "slow walk", "cmu-styles": "salsa", "h36m": "walkingdog"}
        assert [SOURCES[name].label(description) for name, description in said.items()] == [
            "walk",
            "salsa",
            "walkingdog",
        ]

    def test_every_label_is_there(self, cmu_root):
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
