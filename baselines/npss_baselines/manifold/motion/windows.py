"""Cut clips into windows of 160 frames, one every 80 frames."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, positive_integer, real_array

#: Frames in a window, and from one window's start to the next.
WINDOW, STEP = 160, 80


def windows_of(
    features: npt.ArrayLike, *, window: int = WINDOW, step: int = STEP
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Cut a clip into overlapping windows.

    A clip shorter than a window is padded to one window by mirroring: at its last frame, then at its first, and so on.
    Velocities are mirrored like the rest, so that a figure walks on while its steps are played backwards.

    Parameters
    ----------
    features : (T, F) array_like
        The clip.
    window, step : int, optional
        Frames in a window, and from one window's start to the next.

    Returns
    -------
    windows : (n, window, F) ndarray
        All whole windows; `left_out` counts the frames after the last.
    mask : (n, window) ndarray of bool
        False where a frame is padding.

    Raises
    ------
    TypeError
        If `features` does not hold real numbers, or a number is not an integer.
    ValueError
        If the shape is wrong, there are no frames, or a number is not positive.

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
    """Count the frames of a clip after its last window.

    Parameters
    ----------
    n_frames : int
        Frames of the clip.
    window, step : int, optional
        As for `windows_of`; the step is at most a window.

    Examples
    --------
    >>> left_out(300), left_out(320), left_out(100)
    (60, 0, 0)
    """
    return max(0, n_frames - window) % step
