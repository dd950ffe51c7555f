"""Windows that overlap, simulated: what are error rates and coverages, if the frames of a clip depend on each other?

Each frame of a clip has an error that is autoregressive (AR(1), coefficient phi), whatever the model; a window's error
is the mean over its target frames, and the score the mean over windows, weighted by the energy of real targets. Of a
very long record, the errors average to zero, whatever the weights: that is the true score, and the true difference.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from npss import protocol
from npss._blocks import Blocks
from npss._bootstrap import bootstrap_interval
from npss._sign_flip import sign_flips

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


def generated_energies(rng, count=40, length=3000):
    """Return the energies of the frames of clips, as unequal as those of real motion, and about as slow."""
    return list(np.exp(0.4 * ar1(0.99, (count, length), rng)))


def patterns(energies, n_blocks, rng, count, windows="random-256"):
    """Yield the windows of pairs of clips that have so many blocks, cut out of clips of these energies at random."""
    draw = {"srnn-8": protocol.srnn_windows, "random-256": protocol.random_windows}[windows]
    found = 0
    for _ in range(100_000):
        first = int(rng.integers(1, n_blocks)) if windows == "random-256" else int(rng.integers(4, 9))
        second = n_blocks - first if windows == "random-256" else int(rng.integers(4, 9))
        if max(first, second) > max(8, n_blocks // 2 + 1):
            continue  # real clips have four to nine stretches; longer pairs are halves
        lengths = tuple(int(STRETCH * some + rng.integers(STRETCH)) for some in (first, second))
        if min(lengths) <= 166:
            continue
        places = draw(lengths, n_target=N_TARGET)
        groups = protocol.window_blocks(windows, lengths, n_target=N_TARGET)
        if len(set(groups) - {None}) != n_blocks:
            continue  # no window lies in one of the stretches
        clips = []
        for length in lengths:
            clip = energies[rng.integers(len(energies))]
            while len(clip) < length:  # no real clip is as long: it goes back as it came
                clip = np.concatenate([clip, clip[::-1]])
            start = rng.integers(len(clip) - length + 1)
            clips.append(window_means(clip[start : start + length]))
        weight = np.array([clips[place.clip][place.target.start] for place in places])
        yield Pattern(lengths, places, weight, Blocks(groups, weight))
        if (found := found + 1) == count:
            return
    raise AssertionError(f"only {found} pairs of clips with {n_blocks} blocks")


def rates(energies, phi, n_blocks, *, sets, each=5, seed=0, windows="random-256"):
    """Return how often equal models are told apart at 5 %, and intervals of 95 % hold the true score.

    `sets` records are simulated, `each` of them of one pair of clips.
    """
    rng = np.random.default_rng(seed)
    rejected, held = [], []
    for pattern in patterns(energies, n_blocks, rng, sets // each, windows):
        weight = pattern.blocks.sums(pattern.weight)
        error = pattern.blocks.sums(pattern.weight * pattern.errors(phi, rng, each))
        rejected += [sign_flips(one, weight, seed=i).p_value() <= 0.05 for i, one in enumerate(error)]
        true = 10.0  # so that no error is negative
        low, high = bootstrap_interval(error + true * weight, np.broadcast_to(weight, error.shape))
        held += list((low <= true) & (true <= high))
    return float(np.mean(rejected)), float(np.mean(held))
