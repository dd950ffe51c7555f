"""Windows that overlap, simulated: what are error rates and coverages, if the frames of a clip depend on each other?

Each frame of a clip has an error that is autoregressive (AR(1), coefficient phi), whatever the model; a window's error
is the mean over its target frames, and the score the mean over windows, weighted by the energy of real targets. Over
all starts of a very long record, such errors have mean zero: that is the true difference of two models, and the true
score is what is added to them.
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
    """Return the mean over the target frames from each frame on, ``(..., T)`` to ``(..., T - 99)``."""
    sums = np.cumsum(np.insert(frames, 0, 0.0, axis=-1), axis=-1)
    return (sums[..., N_TARGET:] - sums[..., :-N_TARGET]) / N_TARGET


def generated_pairs(rng, count=60):
    """Return the energies of the frames of pairs of clips, as long as real ones, and a little more unequal."""
    lengths = rng.integers(600, 2000, size=(count, 2))
    return [[np.exp(0.4 * ar1(0.99, length, rng)) for length in pair] for pair in lengths]


def pattern(energies, name="random-256", unit=None):
    """Return the windows of a protocol in a pair of clips, given the energies of their frames.

    `unit` makes other blocks than the protocol's: a function of the place of a window and of the window.
    """
    lengths = tuple(len(clip) for clip in energies)
    draw = {"srnn-8": protocol.srnn_windows, "random-256": protocol.random_windows}[name]
    windows = draw(lengths, n_target=N_TARGET)
    groups = tuple(unit(*one) for one in enumerate(windows)) if unit else protocol.window_blocks(name, lengths)
    means = [window_means(clip) for clip in energies]
    weight = np.array([means[window.clip][window.target.start] for window in windows])
    return Pattern(lengths, windows, weight, Blocks(groups, weight))


def cut(pairs, n_blocks, rng, count):
    """Return random windows of pairs of clips that have so many blocks, cut out of those pairs."""
    found = []
    while len(found) < count:
        clips = []
        for n in (n_blocks // 2, n_blocks - n_blocks // 2):
            clip = pairs[rng.integers(len(pairs))][len(clips)]
            length = STRETCH * n + rng.integers(STRETCH)
            start = rng.integers(max(1, len(clip) - length))
            clips.append(
                np.resize(np.concatenate([clip[start:], clip[start:][::-1]]), length)
            )  # too short: there and back
        one = pattern(clips)
        if one.blocks.n == n_blocks:  # else one of the stretches holds no window
            found.append(one)
    return found


def rates(patterns, phi, *, sets, seed=0):
    """Return how often equal models are told apart at 5 %, and intervals of 95 % hold the true score.

    At least `sets` records are simulated, as many of each pattern.
    """
    rng = np.random.default_rng(seed)
    each = -(-sets // len(patterns))
    rejected, held = [], []
    for one in patterns:
        weight = one.blocks.sums(one.weight)
        error = one.blocks.sums(one.weight * one.errors(phi, rng, each))
        rejected += [sign_flips(errors, weight, seed=i).p_value() <= 0.05 for i, errors in enumerate(error)]
        true = 10.0  # so that no score is negative
        held += list(covers(error + true * weight, np.broadcast_to(weight, error.shape), true, seed=len(held)))
    return float(np.mean(rejected)), float(np.mean(held))


def covers(numerator, weight, true, **options):
    """Say of each row of blocks whether its interval holds the true score."""
    low, high = bootstrap_interval(numerator, weight, **options)
    return (low <= true) & (true <= high)
