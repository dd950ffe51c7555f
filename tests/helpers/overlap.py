"""Simulate overlapping windows, for error rates and coverages where the frames of a clip depend on each other.

Errors of the frames of a clip are autoregressive (AR(1), coefficient phi). A window's error is the average over its
target frames, and the score is the average over windows, weighted by the energy of real targets. Errors have mean zero,
which is the true difference of two models; a constant added to them is the true score.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from npss import protocol
from npss._analysis.blocks import Blocks
from npss._analysis.bootstrap import bootstrap_interval
from npss._analysis.sign_flip import sign_flips

N_TARGET = 100
STRETCH = 2 * N_TARGET


class Pattern(NamedTuple):
    """The test windows of two clips."""

    lengths: tuple[int, int]
    windows: tuple[protocol.Window, ...]
    weight: np.ndarray  # (N,)
    blocks: Blocks

    def errors(self, phi, rng, count):
        """Return the errors of the windows in `count` simulated records, ``(count, N)``."""
        means = [window_means(ar1(phi, (count, length), rng)) for length in self.lengths]
        return np.stack([means[window.clip][:, window.target.start] for window in self.windows], axis=1)


def ar1(phi, shape, rng):
    """Return stationary autoregressive series of variance 1, along the last axis."""
    steps = rng.normal(size=shape) * np.sqrt(1 - phi**2)
    steps[..., 0] /= np.sqrt(1 - phi**2)
    return lfilter([1.0], [1.0, -phi], steps, axis=-1)


def window_means(frames):
    """Return the average over the target frames from each frame on, ``(..., T)`` to ``(..., T - 99)``."""
    sums = np.cumsum(np.insert(frames, 0, 0.0, axis=-1), axis=-1)
    return (sums[..., N_TARGET:] - sums[..., :-N_TARGET]) / N_TARGET


def generated_pairs(rng, count=60):
    """Return frame energies of pairs of clips, of realistic lengths and slightly more unequal."""
    lengths = rng.integers(600, 2000, size=(count, 2))
    return [[np.exp(0.4 * ar1(0.99, length, rng)) for length in pair] for pair in lengths]


def pattern(energies, name="random-256", unit=None):
    """Return the windows of a protocol in a pair of clips, from their frame energies.

    `unit`, a function of the index of a window and of the window, replaces the protocol's blocks.
    """
    lengths = tuple(len(clip) for clip in energies)
    draw = {"srnn-8": protocol.srnn_windows, "random-256": protocol.random_windows}[name]
    windows = draw(lengths, n_target=N_TARGET)
    groups = (
        tuple(unit(i, window) for i, window in enumerate(windows)) if unit else protocol.window_blocks(name, lengths)
    )
    means = [window_means(clip) for clip in energies]
    weight = np.array([means[window.clip][window.target.start] for window in windows])
    return Pattern(lengths, windows, weight, Blocks(groups, weight))


def cut(pairs, n_blocks, rng, count):
    """Return random patterns of `n_blocks` blocks, cut out of pairs of clips."""
    patterns = []
    while len(patterns) < count:
        clips = []
        for n in (n_blocks // 2, n_blocks - n_blocks // 2):
            clip = pairs[rng.integers(len(pairs))][len(clips)]
            length = STRETCH * n + rng.integers(STRETCH)
            start = rng.integers(max(1, len(clip) - length))
            clips.append(np.resize(np.concatenate([clip[start:], clip[start:][::-1]]), length))  # mirror short clips
        candidate = pattern(clips)
        if candidate.blocks.n == n_blocks:  # otherwise a stretch has no window
            patterns.append(candidate)
    return patterns


def rates(patterns, phi, *, sets, seed=0):
    """Return the rate of false positives at 5 %, and the coverage of 95 % intervals.

    At least `sets` records are simulated, equally many for each pattern.
    """
    rng = np.random.default_rng(seed)
    count = -(-sets // len(patterns))
    rejected, held = [], []
    for simulated in patterns:
        weight = simulated.blocks.sums(simulated.weight)
        error = simulated.blocks.sums(simulated.weight * simulated.errors(phi, rng, count))
        rejected += [sign_flips(errors, weight, seed=i).p_value() <= 0.05 for i, errors in enumerate(error)]
        true = 10.0  # so that no score is negative
        held += list(covers(error + true * weight, np.broadcast_to(weight, error.shape), true, seed=len(held)))
    return float(np.mean(rejected)), float(np.mean(held))


def covers(numerator, weight, true, **options):
    """Return whether the interval of each row of blocks covers the true score."""
    low, high = bootstrap_interval(numerator, weight, **options)
    return (low <= true) & (true <= high)
