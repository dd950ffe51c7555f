"""Generate gaits in the layout of Human3.6M: motion to try things without data.

The gait is not fitted to any recording. Joints of a leg swing at the stride frequency and its double, the two sides in
antiphase, the arms against the legs. Tempo and vigour drift, so prediction is not trivial.
"""

from __future__ import annotations

import numpy as np

from npss.protocol import COLUMNS, FPS
from npss.rotations._poses import POSE
from npss.validation import Float64, Seed, generator, positive_integer, positive_number, renamed

__all__ = ["gait"]

_ROOT = 6  # columns 0-2: displacement of the root since the frame before, in mm; 3-5: its rotation
# The columns that swing most: mean angle, amplitude at the stride frequency and at its double (radians), and lag in
# strides. The other columns of COLUMNS only sway.
_SWINGS = {
    6: (0.15, 0.40, 0.05, 0.0),  # right hip
    9: (-0.50, -0.40, 0.15, 0.75),  # right knee
    12: (-0.15, 0.15, 0.05, 0.3),  # right foot
    15: (0.60, 0.15, 0.10, 0.4),  # right toes
    21: (0.15, 0.40, 0.05, 0.5),  # left hip
    24: (-0.50, -0.40, 0.15, 0.25),  # left knee
    27: (-0.15, 0.15, 0.05, 0.8),  # left foot
    30: (0.60, 0.15, 0.10, 0.9),  # left toes
    36: (0.05, 0.02, 0.04, 0.0),  # spine
    39: (0.05, 0.02, 0.04, 0.0),  # chest
    42: (-0.80, 0.01, 0.03, 0.1),  # neck
    45: (1.00, 0.01, 0.03, 0.1),  # head
    53: (2.10, 0.03, 0.03, 0.0),  # left shoulder
    54: (0.00, 0.30, 0.05, 0.5),  # left arm, forwards
    56: (0.80, 0.05, 0.03, 0.0),  # left arm, down
    57: (-0.50, -0.25, 0.05, 0.5),  # left elbow
    77: (-2.10, 0.03, 0.03, 0.5),  # right shoulder
    78: (0.00, 0.30, 0.05, 0.0),  # right arm, forwards
    80: (-0.80, 0.05, 0.03, 0.5),  # right arm, down
    81: (-0.50, -0.25, 0.05, 0.0),  # right elbow
}


@renamed(rng="seed")
def gait(n: int, n_frames: int, *, fps: float = FPS, seed: Seed) -> Float64:
    """Generate walks, each of a different walker.

    Parameters
    ----------
    n : int
        Number of sequences.
    n_frames : int
        Frames of each sequence.
    fps : float, optional
        Frames per second.
    seed : int or numpy.random.Generator
        The same number gives the same walks.

    Returns
    -------
    (n, n_frames, 99) ndarray of float64
        Displacement of the root per frame in millimetres, then rotations as exponential maps in radians. The columns
        that are constant in Human3.6M (not in `npss.protocol.COLUMNS`) are zero.

    Raises
    ------
    TypeError
        If an argument is not a number, or `seed` is neither a whole number nor a generator.
    ValueError
        If a number is not positive, or `seed` is negative.

    Examples
    --------
    >>> import numpy as np
    >>> walks = gait(2, 100, seed=0)
    >>> walks.shape
    (2, 100, 99)
    >>> tuple(np.flatnonzero(walks.any(axis=(0, 1)))) == COLUMNS
    True
    """
    n, n_frames, rate = positive_integer("n", n), positive_integer("n_frames", n_frames), positive_number("fps", fps)
    rng = generator(seed)
    time = np.arange(n_frames) / rate
    cadence = rng.uniform(0.75, 1.05, (n, 1))  # strides per second
    tempo = cadence * (1 + 0.1 * _drift(rng, n, time))
    # The integral of the tempo, by the trapezoidal rule: the same walk at every frame rate.
    strides = rng.random((n, 1)) + (np.cumsum(tempo, axis=1) - (tempo + tempo[:, :1]) / 2) / rate
    vigour = rng.uniform(0.8, 1.2, (n, 1)) * (1 + 0.15 * _drift(rng, n, time))  # (n, T)

    walks = np.zeros((n, n_frames, POSE))
    for column in COLUMNS:
        if column in _SWINGS:
            mean, first, second, lag = _SWINGS[column]
        else:
            mean, first, second, lag = 0.0, 0.03, 0.03, rng.random()
        style = rng.normal(size=(4, n, 1))  # distinguishes walkers
        angle = 2 * np.pi * (strides - lag - 0.02 * style[0])
        swing = first * (1 + 0.2 * style[1]) * np.sin(angle) + second * (1 + 0.2 * style[2]) * np.cos(2 * angle)
        walks[..., column] = mean + 0.1 * style[3] + vigour * swing + 0.015 * _drift(rng, n, time)

    walks[..., 3:_ROOT] *= 0.3  # the trunk is steadier than the limbs
    walks[..., :3] *= 50  # sway and bounce ...
    walks[..., 2] += 1300 * vigour * tempo / rate  # ... and forward motion, 1.3 m per stride
    return walks


def _drift(rng: np.random.Generator, n: int, time: Float64) -> Float64:
    """Return slow noise of unit variance, ``(n, T)``: three sines, too slow to predict from the seed frames."""
    frequency = rng.uniform(0.05, 0.5, (n, 1, 3))
    phase = rng.random((n, 1, 3))
    waves = np.sin(2 * np.pi * (frequency * time[:, np.newaxis] + phase))  # (n, T, 3)
    noise: Float64 = np.sqrt(2 / 3) * waves.sum(axis=-1)
    return noise
