"""The share of an angle's power outside DC, which most of a long NPSS depends on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64


class Moments(NamedTuple):
    """Mean and power of angles over a span of T frames: arrays (N, D).

    By Parseval's theorem, ``variance`` is the power outside DC under the convention `paper`, relative to ``mean ** 2``
    at DC. Under `released`, which squares the real part of the spectrum, it is ``even``, the variance of the circularly
    even half of the motion, (x[t] + x[-t mod T]) / 2.
    """

    mean: Array
    variance: Array
    even: Array

    @property
    def shares(self) -> tuple[Array, Array]:
        """The shares of power outside DC, `paper` and `released`; 0 without any power."""
        return share(self.variance, self.mean), share(self.even, self.mean)


def share(outside: Array, mean: Array) -> Array:
    """Return the share of the power outside DC."""
    total = np.square(mean) + outside
    result: Array = np.divide(outside, total, out=np.zeros_like(total), where=total > 0)
    return result


def moments(motion: npt.NDArray[np.floating]) -> Moments:
    """Return the moments of angles (N, T, D) over all frames.

    Examples
    --------
    >>> import numpy as np
    >>> from npss_baselines.fitted.shares import moments
    >>> time = np.arange(8)
    >>> wave = 1 + np.sin(2 * np.pi * time / 8)  # odd: all power of the real part of its spectrum is at DC
    >>> [float(values[0, 0].round(12)) for values in moments(wave.reshape(1, 8, 1)).shares]
    [0.333333333333, 0.0]
    """
    mean = motion.mean(axis=1)
    deviation = motion - mean[:, np.newaxis]
    even = halves(deviation)[0]
    return Moments(mean, np.square(deviation).mean(axis=1), np.square(even).mean(axis=1))


def halves(motion: npt.NDArray[np.floating]) -> tuple[Float64, Float64]:
    """Return the circularly even and odd halves of motion (N, T, D), which add up to it."""
    reversed_ = np.roll(motion[:, ::-1], 1, axis=1)
    return (motion + reversed_) / 2, (motion - reversed_) / 2
