"""Corrupt motion: random zeros, a simulated depth camera, missing joints, stepped keys.

The input is features of windows, ``(n, T, 3 J + 3)``: positions of J joints in the character's frame, the turn, and two
velocities. A lost value becomes the average over training frames, which scaling maps to zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import (
    Array,
    Float64,
    Seed,
    check_finite,
    generator,
    is_real,
    positive_integer,
    real_array,
    renamed,
)
from npss_baselines.data.motion import JOINTS

__all__ = ["Corrupted", "branch", "kinect", "missing", "stepped_keys", "structured", "zeros"]

#: Share of values that `zeros` loses, and frames between the keys of `stepped_keys`, as in the paper.
LOST, EVERY = 0.5, 15
#: Noise of the simulated camera: standard deviations per frame of coordinates and the root's position, in body heights,
#: and of the facing direction, in radians.
JITTER, TURN_JITTER = 0.01, 0.02
#: Probability per frame that a joint drops out, and average number of frames until it is seen again.
DROP, SPELL = 0.02, 8
#: Share of the window in which one limb is occluded.
OCCLUDED = 0.4
_LIMBS = ("LeftForeArm", "RightForeArm", "LeftLeg", "RightLeg")
#: What `structured` draws: the probability of a lost value, frames from one key to the next, and frames of a span. A
#: limb is missing throughout in half of its windows, and two limbs are in a third.
_LOST, _KEYS, _SPANS = (0.05, 0.7), (3, 25), (5, 60)
_ENDS = ("LeftHand", "RightHand", "LeftFoot", "RightFoot")


@dataclass(frozen=True)
class Corrupted:
    """Corrupted windows.

    Attributes
    ----------
    features : (n, T, F) ndarray of float64
        The corrupted features.
    known : (n, T, F) ndarray of bool
        True for values that were seen, if with noise; False for lost ones.
    noise : float or (F,) ndarray of float64
        The standard deviation of the error of known values; 0 where they are exact.
    """

    features: Float64
    known: npt.NDArray[np.bool_]
    noise: float | Float64 = 0.0

    @property
    def exact(self) -> npt.NDArray[np.bool_]:
        """True for values that were seen without noise ``(n, T, F)``."""
        exact: npt.NDArray[np.bool_] = self.known & (np.asarray(self.noise) == 0)
        return exact


@renamed(rng="seed")
def zeros(features: npt.ArrayLike, mean: npt.ArrayLike, *, lost: float = LOST, seed: Seed) -> Corrupted:
    """Lose each value independently with the same probability.

    Parameters
    ----------
    features : (n, T, F) array_like
        Windows.
    mean : (F,) array_like
        Replacement of lost values: the average of each feature over training frames. The paper equivalently sets values
        to zero after subtracting the mean.
    lost : float, optional
        The probability, from 0 to 1.
    seed : int or numpy.random.Generator
        Source of randomness.

    Returns
    -------
    Corrupted
        The corrupted windows.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> import numpy as np
    >>> corrupted = zeros(np.ones((1, 2, 3)), [5, 5, 5], seed=0)
    >>> corrupted.features[0]
    array([[1., 5., 5.],
           [5., 1., 1.]])
    """
    windows = _windows(features)
    if not (is_real(lost) and 0 <= lost <= 1):
        raise ValueError(f"lost: expected a probability, got {lost!r}")
    known = generator(seed).random(windows.shape) >= lost
    return Corrupted(np.where(known, windows, _mean(mean, windows)), known)


def missing(features: npt.ArrayLike, mean: npt.ArrayLike, *, joints: Sequence[int]) -> Corrupted:
    """Lose joints in all frames.

    Parameters
    ----------
    features, mean
        As for `zeros`.
    joints : sequence of int
        Indices of the joints; see `branch`.

    Returns
    -------
    Corrupted
        The corrupted windows.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> import numpy as np
    >>> missing(np.ones((1, 1, 9)), np.zeros(9), joints=[1]).features
    array([[[1., 1., 1., 0., 0., 0., 1., 1., 1.]]])
    """
    windows = _windows(features)
    known = np.ones(windows.shape, bool)
    known[..., _columns(joints, windows)] = False
    return Corrupted(np.where(known, windows, _mean(mean, windows)), known)


def stepped_keys(features: npt.ArrayLike, *, every: int = EVERY) -> Corrupted:
    """Keep every n-th frame, from the first on, and hold it until the next: stepped keys.

    Parameters
    ----------
    features : (n, T, F) array_like
        Windows.
    every : int, optional
        Frames from one key to the next.

    Returns
    -------
    Corrupted
        The corrupted windows; only keys are known.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> import numpy as np
    >>> stepped_keys(np.arange(6.0).reshape(1, 6, 1), every=3).features.ravel()
    array([0., 0., 0., 3., 3., 3.])
    """
    windows, every = _windows(features), positive_integer("every", every)
    frames = np.arange(windows.shape[1])
    known = np.broadcast_to((frames % every == 0)[:, np.newaxis], windows.shape)
    return Corrupted(windows[:, frames - frames % every], known)


@renamed(rng="seed")
def kinect(features: npt.ArrayLike, skeleton: Skeleton, *, seed: Seed) -> Corrupted:
    """Simulate a depth camera: jitter, joints that drop out, and an occluded limb.

    No camera was used, and nothing is fitted to one.

    - Jitter: independent Gaussian noise in each frame, of `JITTER` body heights on every coordinate and on the root's
      position (whose differences change the velocities), and of `TURN_JITTER` radians on the facing direction.
    - Drop-outs: each joint except the root is lost with probability `DROP` a frame, for a geometrically distributed
      time of `SPELL` frames on average, and stays where it was last seen.
    - Occlusion: a random arm or leg, from elbow or knee on, is hidden for `OCCLUDED` of the window, at a random time,
      and stays where it was last seen (or is next seen, if the window begins with the occlusion).

    Parameters
    ----------
    features : (n, T, F) array_like
        Windows.
    skeleton : npss.skeleton.Skeleton
        The skeleton of the first columns.
    seed : int or numpy.random.Generator
        Source of randomness.

    Returns
    -------
    Corrupted
        The corrupted windows; seen values, with jitter, are known.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    windows = _windows(features)
    n, n_frames, n_features = windows.shape
    n_joints = len(skeleton.names)
    if n_features != 3 * n_joints + 3:
        raise ValueError(f"features: expected {3 * n_joints + 3} for {n_joints} joints, got {n_features}")
    root = skeleton.parents.index(-1)
    rng = generator(seed)

    seen = np.ones((n, n_frames, n_joints), bool)
    ends = np.zeros((n, n_joints))  # of the current drop-out
    for t in range(n_frames):
        begins = (rng.random((n, n_joints)) < DROP) & (ends <= t)
        ends = np.where(begins, t + rng.geometric(1 / SPELL, (n, n_joints)), ends)
        seen[:, t] = ends <= t
    seen[..., root] = True
    limbs = [branch(skeleton, limb) for limb in _LIMBS]
    length = round(OCCLUDED * n_frames)
    for window in seen:
        start = rng.integers(n_frames - length + 1)
        window[start : start + length, limbs[rng.integers(len(limbs))]] = False

    noisy = windows.copy()
    positions = noisy[..., :-3].reshape(n, n_frames, n_joints, 3)
    positions += JITTER * rng.standard_normal(positions.shape)
    positions[..., root, ::2] = 0  # the root defines the character's frame
    place = rng.standard_normal((n, n_frames + 1, 3)) * (TURN_JITTER, JITTER, JITTER)
    noisy[..., -3:] += np.diff(place, axis=1)

    positions[...] = np.take_along_axis(positions, _last_seen(seen)[..., np.newaxis], axis=1)
    known = np.concatenate([np.repeat(seen, 3, axis=-1), np.ones((n, n_frames, 3), bool)], axis=-1)
    return Corrupted(noisy, known, camera_noise(n_joints, root))


@renamed(rng="seed")
def structured(features: npt.ArrayLike, mean: npt.ArrayLike, skeleton: Skeleton, *, seed: Seed) -> Corrupted:
    """Corrupt each window in one of the ways that applications meet, to train on.

    With equal probability, a window

    - loses values independently, with a probability between .05 and .7;
    - loses one or two limbs, from wrist, elbow, ankle or knee on, throughout or for a span of 5 to 60 frames;
    - loses all frames but each k-th, with k between 3 and 25;
    - loses all values in one to three spans of 5 to 60 frames;
    - is seen by the camera of `kinect`, whose lost joints are held.

    Parameters
    ----------
    features, mean
        As for `zeros`.
    skeleton : npss.skeleton.Skeleton
        The skeleton of the first columns.
    seed : int or numpy.random.Generator
        Source of randomness.

    Returns
    -------
    Corrupted
        The corrupted windows. `noise` is 0, though values of the camera are noisy.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> from npss_baselines.data.motion import JOINTS
    >>> left = structured(np.ones((5, 160, 63)), np.zeros(63), JOINTS, seed=0)
    >>> bool((left.features[left.known] == 1).any())
    True
    """
    windows, rng = _windows(features), generator(seed)
    centre = _mean(mean, windows)
    known = np.ones(windows.shape, bool)
    values = windows.copy()
    for window, seen, kind in zip(values, known, rng.integers(5, size=len(windows)), strict=True):
        n_frames = len(window)
        if kind == 0:
            seen[:] = rng.random(window.shape) >= rng.uniform(*_LOST)
        elif kind == 1:
            names = rng.choice([*_ENDS, *_LIMBS], 1 + (rng.random() < 1 / 3), replace=False)
            columns = np.concatenate([_columns(branch(skeleton, name), window) for name in names])
            frames = slice(None) if rng.random() < 0.5 else _span(n_frames, rng)
            seen[frames, columns] = False
        elif kind == 2:
            every = rng.integers(_KEYS[0], _KEYS[1] + 1)
            seen[(np.arange(n_frames) - rng.integers(every)) % every > 0] = False
        elif kind == 3:
            for _ in range(rng.integers(1, 4)):
                seen[_span(n_frames, rng)] = False
        else:
            left = kinect(window[np.newaxis], skeleton, seed=rng)
            window[:], seen[:] = left.features[0], left.known[0]
            continue
        window[:] = np.where(seen, window, centre)
    return Corrupted(values, known)


def _span(n_frames: int, rng: np.random.Generator) -> slice:
    """Draw a span of frames."""
    length = min(int(rng.integers(_SPANS[0], _SPANS[1] + 1)), n_frames - 1)
    start = int(rng.integers(n_frames - length + 1))
    return slice(start, start + length)


def camera_noise(n_joints: int = len(JOINTS.names), root: int = 0) -> Float64:
    """Return the standard deviations of the simulated camera's errors, ``(3 J + 3,)``; see `kinect`."""
    noise = np.full((n_joints + 1, 3), JITTER)
    noise[root, ::2] = 0  # the root defines the character's frame
    # Velocities are differences of two positions, and their errors are independent.
    noise[-1] = np.sqrt(2) * np.array([TURN_JITTER, JITTER, JITTER])
    return noise.reshape(-1)


def branch(skeleton: Skeleton, name: str) -> list[int]:
    """Return a joint and all joints below it.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton.
    name : str
        The name of the joint.

    Returns
    -------
    list of int
        The indices of the joints, in the order of the skeleton.

    Raises
    ------
    ValueError
        If the skeleton has no joint of that name.

    Examples
    --------
    >>> from npss.skeleton import H36M
    >>> [H36M.names[j] for j in branch(H36M, "LeftFoot")]
    ['LeftFoot', 'LeftToeBase', 'LeftToeEnd']
    """
    if name not in skeleton.names:
        raise ValueError(f"joint: {name!r} is not one of {', '.join(skeleton.names)}")
    first = skeleton.names.index(name)

    def is_below(j: int) -> bool:
        return j == first or (skeleton.parents[j] >= 0 and is_below(skeleton.parents[j]))

    return [j for j in range(len(skeleton.names)) if is_below(j)]


def _last_seen(seen: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return the last frame so far in which a value ``(n, T, ...)`` was seen; before the first, return the first."""
    frames = np.arange(seen.shape[1]).reshape(-1, *(1,) * (seen.ndim - 2))
    last = np.maximum.accumulate(np.where(seen, frames, -1), axis=1)
    return np.where(last < 0, seen.argmax(axis=1, keepdims=True), last)


def _windows(features: npt.ArrayLike) -> Float64:
    array = real_array("features", features)
    if array.ndim != 3 or 0 in array.shape:
        raise ValueError(f"features: expected shape (n, T, F) = (windows, frames, features), got {array.shape}")
    check_finite("features", array)
    return array.astype(np.float64)


def _mean(mean: npt.ArrayLike, windows: Array) -> Array:
    array = real_array("mean", mean)
    if array.shape != windows.shape[-1:]:
        raise ValueError(f"mean: expected shape (F,) = {windows.shape[-1:]}, got {array.shape}")
    check_finite("mean", array)
    return array


def _columns(joints: Sequence[int], windows: Array) -> npt.NDArray[np.intp]:
    chosen = np.asarray(joints, np.intp)
    n_joints = windows.shape[-1] // 3 - 1
    if not len(chosen) or chosen.min() < 0 or chosen.max() >= n_joints:
        raise ValueError(f"joints: expected indices from 0 to {n_joints - 1}, got {joints!r}")
    return (3 * chosen[:, np.newaxis] + np.arange(3)).ravel()
