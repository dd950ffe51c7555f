"""Windows as the manifold sees them: 160 frames, each beginning 80 after the one before."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, positive_integer, real_array

#: Frames of a window, and from the beginning of one to that of the next.
WINDOW, STEP = 160, 80


def windows_of(
    features: npt.ArrayLike, *, window: int = WINDOW, step: int = STEP
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Cut a clip into overlapping windows.

    A clip that is shorter than a window is one window: mirrored at its last frame, and at its first again, until it is
    full. Velocities are mirrored like the rest, so that a figure walks on ahead while its steps are played backwards.

    Parameters
    ----------
    features : (T, F) array_like
        A clip.
    window, step : int, optional
        Frames of a window, and from the beginning of one to that of the next.

    Returns
    -------
    windows : (n, window, F) ndarray
        Those that fit; `left_out` tells how many frames behind the last are in none.
    mask : (n, window) ndarray of bool
        False where a frame is padding.

    Raises
    ------
    TypeError
        If `features` does not hold real numbers, or a number is no integer.
    ValueError
        If the shape is another one, there are no frames, or a number is not positive.

    Examples
    --------
    >>> windows, mask = windows_of([[0], [1], [2], [3], [4], [5]], window=4, step=1)
    >>> windows[..., 0].tolist()
    [[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5]]
    >>> windows, mask = windows_of([[0], [1], [2]], window=6)
    >>> windows[..., 0].tolist(), mask.tolist()
    ([[0, 1, 2, 1, 0, 1]], [[True, True, True, False, False, False]])
    """
    clip = real_array("features", features)
    if clip.ndim != 2 or 0 in clip.shape:
        raise ValueError(f"features: expected shape (T, F) = (frames, features), got {clip.shape}")
    window, step = positive_integer("window", window), positive_integer("step", step)
    padding = max(0, window - len(clip))
    padded = np.pad(clip, ((0, padding), (0, 0)), mode="reflect")
    frames = np.arange(0, len(padded) - window + 1, step)[:, np.newaxis] + np.arange(window)  # (n, window)
    return padded[frames], frames < len(clip)


def left_out(n_frames: int, *, window: int = WINDOW, step: int = STEP) -> int:
    """Return how many frames of a clip are in none of its windows, those behind the last.

    Parameters
    ----------
    n_frames : int
        Of the clip.
    window, step : int, optional
        As for `windows_of`; a step is no longer than a window.

    Examples
    --------
    >>> left_out(300), left_out(320), left_out(100)
    (60, 0, 0)
    """
    return max(0, n_frames - window) % step
