"""Whether a distance finds clips of the same action: leave one out, ranked by distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Float64, one_of

#: Which clips of the query's label are to be found. The others of its label are taken out of the ranking; all clips of
#: other labels stay in it.
MATCHES = ("any", "same subject", "other subject")


@dataclass(frozen=True)
class Retrieved:
    """How well clips of an action are found.

    Attributes
    ----------
    precision : (N,) ndarray of float64
        Of each clip as the query, the average precision: the mean, over the clips that are to be found, of the share of
        such clips among all that are ranked no worse. NaN where there is nothing to be found.
    nearest : (N,) ndarray of float64
        1 if the nearest clip is one to be found, 0 if not, and NaN likewise.
    """

    precision: Float64
    nearest: Float64

    @property
    def n_queries(self) -> int:
        """How many clips there is something to be found for."""
        return int(np.isfinite(self.precision).sum())

    def mean(self) -> tuple[float, float]:
        """Return mean average precision and nearest-neighbour accuracy, each the mean over queries."""
        return float(np.nanmean(self.precision)), float(np.nanmean(self.nearest))

    def mean_of_labels(self, labels: Sequence[str]) -> tuple[float, float]:
        """Return the same as the mean over labels of the mean over the queries of each: frequent ones weigh no more."""
        names = np.asarray(labels)
        asked = np.isfinite(self.precision)
        chosen = [asked & (names == label) for label in dict.fromkeys(names[asked])]
        means = [[values[queries].mean() for queries in chosen] for values in (self.precision, self.nearest)]
        return float(np.mean(means[0])), float(np.mean(means[1]))


def retrieve(
    distances: npt.ArrayLike, labels: Sequence[str], subjects: Sequence[str], *, matches: str = "any"
) -> Retrieved:
    """Take each clip in turn as the query and rank the others by their distance from it.

    Parameters
    ----------
    distances : (N, N) array_like
        From each query (row) to each clip (column); of equals, the clip with the lower index comes first.
    labels : sequence of str
        The action of each clip; none is empty.
    subjects : sequence of str
        Who moves; empty where that is not known: then a pair is neither of the same subject nor of another.
    matches : {'any', 'same subject', 'other subject'}, optional
        Which clips of the query's label are to be found; see `MATCHES`.

    Returns
    -------
    Retrieved
        The average precision of each query, and whether the nearest clip is right.

    Raises
    ------
    ValueError
        If `distances` is not (N, N), holds NaN, a label is empty, or `matches` is none of these.

    Examples
    --------
    Three walks, and a run between the second and the third:

    >>> place = np.array([0.0, 1.0, 3.0, 2.0])
    >>> distances = abs(place[:, np.newaxis] - place)
    >>> found = retrieve(distances, ["walk", "walk", "walk", "run"], ["a", "a", "b", "b"])
    >>> found.precision.round(3)
    array([0.833, 0.833, 0.583,   nan])
    >>> retrieve(distances, ["walk", "walk", "walk", "run"], ["a", "a", "b", "b"], matches="other subject").nearest
    array([ 0.,  0.,  0., nan])
    """
    far = np.asarray(distances)
    right, ranked = _pairs(labels, subjects, matches)
    if far.shape != right.shape:
        raise ValueError(f"distances: expected shape (N, N) = {right.shape} for so many labels, got {far.shape}")
    if np.isnan(far).any():
        raise ValueError("distances: a NaN has no place in a ranking")
    precision, nearest = np.full((2, len(far)), np.nan)
    for query in np.flatnonzero(right.any(axis=1)):
        others = np.flatnonzero(ranked[query])
        hits = right[query, others[np.argsort(far[query, others], kind="stable")]]
        precision[query] = (np.cumsum(hits) / np.arange(1, len(hits) + 1))[hits].mean()
        nearest[query] = hits[0]
    return Retrieved(precision, nearest)


def chance(labels: Sequence[str], subjects: Sequence[str], *, matches: str = "any") -> Retrieved:
    """Return what a random order finds on average: as `retrieve`, the expectation for each query.

    Notes
    -----
    With R of N ranked clips to be found, one of them is at each rank k as likely as at any other; of the k - 1 before
    it the share b = (R - 1) / (N - 1) is right on average. So the precision there is (1 + b (k - 1)) / k, and its mean
    over ranks b + (1 - b) H / N, where H is the N-th harmonic number. The nearest is right with probability R / N.

    Examples
    --------
    >>> chance(["a", "a", "b"], ["", "", ""]).precision  # found first or second
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
    """Compute how often a pair of clips of the same label is closer than a pair of different labels.

    Parameters
    ----------
    distances : (N, N) array_like
        Symmetric.
    labels : sequence of str
        The action of each clip; there are two or more.

    Returns
    -------
    float
        From 0 to 1: the area under the ROC curve, where equal distances count half. 0.5 is chance. NaN if no two labels
        are the same.

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
    far = np.asarray(distances)[first, second]
    apart = np.sort(far[~alike])
    not_further = [np.searchsorted(apart, far[alike], side) for side in ("left", "right")]
    return float(1 - np.mean(not_further) / len(apart))


def closest_windows(vectors: npt.ArrayLike, clip_of: npt.ArrayLike, n_clips: int) -> Float64:
    """Compute distances of clips from those of their windows: the smallest over all pairs.

    Parameters
    ----------
    vectors : (n, D) array_like
        What windows are compared by, in Euclidean distance.
    clip_of : (n,) array_like of int
        The clip, from 0 to N - 1, that each window is from; every clip has one.
    n_clips : int
        N.

    Returns
    -------
    (N, N) ndarray of float64
        Symmetric, zero on the diagonal.

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
        raise ValueError(f"clip_of: not every clip of {n_clips} has a window")
    return smallest


def distances_of(vectors: npt.ArrayLike) -> Float64:
    """Compute Euclidean distances between all pairs of vectors ``(n, D)``: ``(n, n)``, symmetric, 0 on the diagonal."""
    rows = np.asarray(vectors, np.float64)
    rows = rows - rows.mean(axis=0)  # less to cancel
    # Vectors are long: a matrix product is many times faster than differences.
    products = rows @ rows.T
    power = np.diag(products)
    squares = np.maximum(power[:, np.newaxis] + power - (products + products.T), 0)
    np.fill_diagonal(squares, 0)
    distances: Float64 = np.sqrt(squares)
    return distances


def _pairs(
    labels: Sequence[str], subjects: Sequence[str], matches: str
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return which clips (columns) each query (row) is to find, and among which."""
    one_of("matches", matches, MATCHES)
    names, who = np.asarray(labels), np.asarray(subjects)
    if names.ndim != 1 or names.shape != who.shape:
        raise ValueError(f"subjects: {len(who)} of them for {len(names)} labels")
    if (names == "").any():
        raise ValueError(f"labels: the clip at index {int((names == '').argmax())} has none; leave it out")
    alike = names[:, np.newaxis] == names
    named = (who != "")[:, np.newaxis] & (who != "")
    same = who[:, np.newaxis] == who
    wanted = {"any": np.ones_like(alike), "same subject": named & same, "other subject": named & ~same}[matches]
    right = alike & wanted & ~np.eye(len(names), dtype=bool)
    return right, right | ~alike
