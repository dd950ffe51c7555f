"""Retrieval of clips of the same action by a distance, leave-one-out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Float64, one_of

__all__ = ["Retrieved", "auc", "chance", "closest_windows", "distances_between", "distances_of", "retrieve"]

#: Clips with the query's label to find. Other clips with its label are removed from the ranking; all clips with other
#: labels stay.
MATCHES = ("any", "same subject", "other subject")


@dataclass(frozen=True)
class Retrieved:
    """The results of retrieval.

    Attributes
    ----------
    precision : (N,) ndarray of float64
        Average precision of each clip as the query: the share of matches among all clips ranked as high or higher,
        averaged over the matches. NaN for queries without a match.
    nearest : (N,) ndarray of float64
        1 if the nearest clip is a match, 0 if not, NaN for queries without a match.
    """

    precision: Float64
    nearest: Float64

    @property
    def n_queries(self) -> int:
        """Number of queries with a match."""
        return int(np.isfinite(self.precision).sum())

    def mean(self) -> tuple[float, float]:
        """Return mean average precision and nearest-neighbour accuracy, averaged over queries."""
        return float(np.nanmean(self.precision)), float(np.nanmean(self.nearest))

    def mean_of_labels(self, labels: Sequence[str]) -> tuple[float, float]:
        """Return the same, averaged over the queries of each label and then over labels, which weigh equally."""
        names = np.asarray(labels)
        has_match = np.isfinite(self.precision)
        groups = [has_match & (names == label) for label in dict.fromkeys(names[has_match])]
        means = [[values[group].mean() for group in groups] for values in (self.precision, self.nearest)]
        return float(np.mean(means[0])), float(np.mean(means[1]))


def retrieve(
    distances: npt.ArrayLike, labels: Sequence[str], subjects: Sequence[str], *, matches: str = "any"
) -> Retrieved:
    """Rank the other clips by their distance from each clip.

    Parameters
    ----------
    distances : (N, N) array_like
        Distances from each query (row) to each clip (column). Of equal ones, the clip with the lower index is first.
    labels : sequence of str
        The action of each clip; not empty.
    subjects : sequence of str
        The subject of each clip; empty where unknown. A clip of an unknown subject matches neither the same subject nor
        another.
    matches : {'any', 'same subject', 'other subject'}, optional
        Clips to find; see `MATCHES`.

    Returns
    -------
    Retrieved
        The average precision of each query, and whether the nearest clip is a match.

    Raises
    ------
    ValueError
        If `distances` is not (N, N), holds NaN, a label is empty, or `matches` is unknown.

    Examples
    --------
    Three walks, and a run between the second and the third:

    >>> place = np.array([0.0, 1.0, 3.0, 2.0])
    >>> distances = abs(place[:, np.newaxis] - place)
    >>> result = retrieve(distances, ["walk", "walk", "walk", "run"], ["a", "a", "b", "b"])
    >>> result.precision.round(3)
    array([0.833, 0.833, 0.583,   nan])
    >>> retrieve(distances, ["walk", "walk", "walk", "run"], ["a", "a", "b", "b"], matches="other subject").nearest
    array([ 0.,  0.,  0., nan])
    """
    pairwise = np.asarray(distances)
    right, ranked = _pairs(labels, subjects, matches)
    if pairwise.shape != right.shape:
        raise ValueError(
            f"distances: expected shape (N, N) = {right.shape} for {len(labels)} labels, got {pairwise.shape}"
        )
    if np.isnan(pairwise).any():
        raise ValueError("distances: NaN cannot be ranked")
    precision, nearest = np.full((2, len(pairwise)), np.nan)
    for query in np.flatnonzero(right.any(axis=1)):
        others = np.flatnonzero(ranked[query])
        hits = right[query, others[np.argsort(pairwise[query, others], kind="stable")]]
        precision[query] = (np.cumsum(hits) / np.arange(1, len(hits) + 1))[hits].mean()
        nearest[query] = hits[0]
    return Retrieved(precision, nearest)


def chance(labels: Sequence[str], subjects: Sequence[str], *, matches: str = "any") -> Retrieved:
    """Return the expected result of `retrieve` for a random order, of each query.

    Parameters
    ----------
    labels, subjects, matches
        As for `retrieve`.

    Returns
    -------
    Retrieved
        The expected results.

    Notes
    -----
    With R matches among N ranked clips, a match has each rank k with equal probability. Of the k - 1 clips before it, a
    share b = (R - 1) / (N - 1) matches on average. The precision at k is (1 + b (k - 1)) / k, and its average over
    ranks is b + (1 - b) H / N, where H is the N-th harmonic number. The nearest clip is a match with probability R / N.

    Examples
    --------
    >>> chance(["a", "a", "b"], ["", "", ""]).precision  # the match is first or second
    array([0.75, 0.75,  nan])
    """
    right, ranked = _pairs(labels, subjects, matches)
    precision, nearest = np.full((2, len(right)), np.nan)
    for query in np.flatnonzero(right.any(axis=1)):
        n_right, n = int(right[query].sum()), int(ranked[query].sum())
        before = (n_right - 1) / (n - 1) if n > 1 else 0.0
        precision[query] = before + (1 - before) * (1 / np.arange(1, n + 1)).mean()
        nearest[query] = n_right / n
    return Retrieved(precision, nearest)


def auc(distances: npt.ArrayLike, labels: Sequence[str]) -> float:
    """Compute how often two clips with the same label are closer than two with different labels.

    Parameters
    ----------
    distances : (N, N) array_like
        Symmetric distances.
    labels : sequence of str
        The action of each clip; at least two actions.

    Returns
    -------
    float
        The area under the ROC curve, from 0 to 1; equal distances count half. 0.5 is chance. NaN if no two labels are
        equal.

    Examples
    --------
    >>> auc([[0, 1, 5], [1, 0, 1], [5, 1, 0]], ["walk", "walk", "run"])  # 1 against 5 and 1
    0.75
    """
    names = np.asarray(labels)
    first, second = np.triu_indices(len(names), 1)
    alike = names[first] == names[second]
    if not alike.any():
        return float("nan")
    lengths = np.asarray(distances)[first, second]
    apart = np.sort(lengths[~alike])
    not_further = [np.searchsorted(apart, lengths[alike], side) for side in ("left", "right")]
    return float(1 - np.mean(not_further) / len(apart))


def closest_windows(vectors: npt.ArrayLike, clip_of: npt.ArrayLike, n_clips: int) -> Float64:
    """Compute the distances of clips: those of their two closest windows.

    Parameters
    ----------
    vectors : (n, D) array_like
        A vector for each window, compared by Euclidean distance.
    clip_of : (n,) array_like of int
        The clip of each window, from 0 to N - 1; every clip has at least one window.
    n_clips : int
        Number of clips, N.

    Returns
    -------
    (N, N) ndarray of float64
        Symmetric distances, zero on the diagonal.

    Raises
    ------
    ValueError
        If a clip has no window.

    Examples
    --------
    >>> closest_windows([[0.0], [5.0], [7.0]], [0, 0, 1], 2)
    array([[0., 2.],
           [2., 0.]])
    """
    clips = np.asarray(clip_of)
    by_window = distances_of(vectors)
    smallest = np.full((n_clips, n_clips), np.inf)
    np.minimum.at(smallest, (clips[:, np.newaxis], clips), by_window)
    if np.isinf(smallest).any():
        raise ValueError(f"clip_of: not all of {n_clips} clips have a window")
    return smallest


def distances_of(vectors: npt.ArrayLike) -> Float64:
    """Compute the Euclidean distances between all pairs of vectors.

    Parameters
    ----------
    vectors : (n, D) array_like
        The vectors.

    Returns
    -------
    (n, n) ndarray of float64
        Symmetric distances, zero on the diagonal.
    """
    rows = np.asarray(vectors, np.float64)
    rows = rows - rows.mean(axis=0)  # for less cancellation
    # Vectors are long: a matrix product is much faster than differences.
    products = rows @ rows.T
    power = np.diag(products)
    squares = np.maximum(power[:, np.newaxis] + power - (products + products.T), 0)
    np.fill_diagonal(squares, 0)
    distances: Float64 = np.sqrt(squares)
    return distances


def distances_between(first: npt.ArrayLike, second: npt.ArrayLike) -> Float64:
    """Compute the Euclidean distances between the vectors of two sets.

    Parameters
    ----------
    first, second : (n, D), (m, D) array_like
        The vectors.

    Returns
    -------
    (n, m) ndarray of float64
        The distances.
    """
    a, b = (np.asarray(vectors, np.float64) for vectors in (first, second))
    centre = a.mean(axis=0)  # for less cancellation
    a, b = a - centre, b - centre
    squares = np.square(a).sum(axis=1)[:, np.newaxis] + np.square(b).sum(axis=1) - 2 * (a @ b.T)
    distances: Float64 = np.sqrt(np.maximum(squares, 0))
    return distances


def _pairs(
    labels: Sequence[str], subjects: Sequence[str], matches: str
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return the matches of each query (row) among clips (columns), and the ranked clips."""
    one_of("matches", matches, MATCHES)
    names, who = np.asarray(labels), np.asarray(subjects)
    if names.ndim != 1 or names.shape != who.shape:
        raise ValueError(f"subjects: {len(who)} subjects for {len(names)} labels")
    if (names == "").any():
        raise ValueError(f"labels: the clip at index {int((names == '').argmax())} has no label; remove it")
    alike = names[:, np.newaxis] == names
    named = (who != "")[:, np.newaxis] & (who != "")
    same = who[:, np.newaxis] == who
    selected = {"any": np.ones_like(alike), "same subject": named & same, "other subject": named & ~same}[matches]
    right = alike & selected & ~np.eye(len(names), dtype=bool)
    return right, right | ~alike
