"""Motion derivatives: backward differences of poses, for a window or frame by frame."""

from __future__ import annotations

import torch
from torch import Tensor


def no_past(poses: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return the past of a window, zeros (B, order * step, D): the first frame's derivatives equal the frame.

    Parameters
    ----------
    poses : (B, ..., D) Tensor
        Any frames of the window, for the batch, width, type and device.
    order, step : int
        As for `derivatives`.
    """
    return poses.new_zeros(len(poses), order * step, poses.shape[-1])


def past_of(poses: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return the past (B, order * step, D) of the frame after poses (B, T, D), which zeros precede."""
    rows = torch.cat([no_past(poses, order, step=step), poses], 1)
    return rows[:, poses.shape[1] :]


def own_past(outputs: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return the past (B, order * step, D) of the last prediction: the predictions before it.

    Parameters
    ----------
    outputs : (B, S, D) Tensor
        The prediction after each input frame; zeros precede the first.
    order, step : int
        As for `derivatives`.
    """
    return past_of(outputs[:, :-1], order, step=step)


def derivatives(
    poses: Tensor, order: int, *, step: int = 1, past: Tensor | None = None, restart: int | None = None
) -> Tensor:
    """Return poses with their backward differences.

    Derivative k of frame t is the difference of derivative k - 1 at frames t and t - step, not divided by time.

    Parameters
    ----------
    poses : (B, T, D) Tensor
        The frames.
    order : int
        The highest derivative, 0 or more.
    step : int, optional
        Step of a difference, in frames (h in the paper).
    past : (B, order * step, D) Tensor, optional
        The frames before `poses`; zeros by default.
    restart : int, optional
        The frame at which the second and higher derivatives restart: they take all earlier frames as zeros, and so
        become as large as a pose. In the paper's released code they restart, by mistake, where the decoder's inputs
        start. By default, none restarts.

    Returns
    -------
    (B, T, (order + 1) * D) Tensor
        Pose, first derivative, second derivative, ...

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, equation 5.

    Examples
    --------
    >>> import torch
    >>> derivatives(torch.tensor([[[1.0], [4.0], [9.0]]]), 2)
    tensor([[[1., 1., 1.],
             [4., 3., 2.],
             [9., 5., 2.]]])
    """
    if restart is not None:
        whole = derivatives(poses, order, step=step, past=past)
        restarted = derivatives(poses[:, restart:], order, step=step)
        first = 2 * poses.shape[2]  # the pose and its first derivative
        return torch.cat([whole[:, :restart], torch.cat([whole[:, restart:, :first], restarted[:, :, first:]], 2)], 1)
    rows = torch.cat([no_past(poses, order, step=step) if past is None else past, poses], 1)
    differences = [rows]
    for _ in range(order):
        differences.append(differences[-1][:, step:] - differences[-1][:, :-step])
    return torch.cat([rows[:, rows.shape[1] - poses.shape[1] :] for rows in differences], -1)


def next_derivatives(pose: Tensor, past: Tensor, order: int, *, step: int = 1) -> tuple[Tensor, Tensor]:
    """Return a pose with its backward differences (B, (order + 1) * D), and the past of the next pose.

    Parameters
    ----------
    pose : (B, D) Tensor
        The frame.
    past : (B, order * step, D) Tensor
        The frames before it.
    order, step : int
        As for `derivatives`.
    """
    row = derivatives(pose[:, None], order, step=step, past=past)[:, 0]
    return row, torch.cat([past, pose[:, None]], 1)[:, 1:]
