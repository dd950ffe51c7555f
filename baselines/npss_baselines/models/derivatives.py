"""Motion derivatives: backward differences of poses, of a whole window or of one frame after another."""

from __future__ import annotations

import torch
from torch import Tensor


def no_past(poses: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return what precedes a window: zeros (B, order * step, D), so that the first frame's differences are the frame.

    Parameters
    ----------
    poses : (B, ..., D) Tensor
        Any frames of the window: batch, width, precision and device are theirs.
    order, step : int
        As for `derivatives`.
    """
    return poses.new_zeros(len(poses), order * step, poses.shape[-1])


def past_of(poses: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return the past (B, order * step, D) of the frame that follows poses (B, T, D), before which there are zeros."""
    rows = torch.cat([no_past(poses, order, step=step), poses], 1)
    return rows[:, poses.shape[1] :]


def own_past(outputs: Tensor, order: int, *, step: int = 1) -> Tensor:
    """Return a past (B, order * step, D) of predictions, for the last of which it is what came before.

    Parameters
    ----------
    outputs : (B, S, D) Tensor
        The predictions after each frame that was read. Before the first one there are zeros.
    order, step : int
        As for `derivatives`.
    """
    return past_of(outputs[:, :-1], order, step=step)


def derivatives(
    poses: Tensor, order: int, *, step: int = 1, past: Tensor | None = None, restart: int | None = None
) -> Tensor:
    """Return poses with their backward differences.

    Difference k of frame t is that of difference k - 1 of frames t and t - step; nothing divides it by the time.

    Parameters
    ----------
    poses : (B, T, D) Tensor
        The frames.
    order : int
        The highest difference, 0 or more.
    step : int, optional
        Frames between the two of which a difference is taken (h of the paper).
    past : (B, order * step, D) Tensor, optional
        The frames before. By default these are zeros.
    restart : int, optional
        The frame at which the differences above the first start anew, for which all frames before it are zeros, so that
        they are as large as a pose: in the paper's released code they do where the decoder's inputs begin, a mistake.
        The first difference goes on. By default all do.

    Returns
    -------
    (B, T, (order + 1) * D) Tensor
        Pose, first difference, second, and so on.

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
        anew = derivatives(poses[:, restart:], order, step=step)
        first = 2 * poses.shape[2]  # the pose and its first difference
        return torch.cat([whole[:, :restart], torch.cat([whole[:, restart:, :first], anew[:, :, first:]], 2)], 1)
    rows = torch.cat([no_past(poses, order, step=step) if past is None else past, poses], 1)
    differences = [rows]
    for _ in range(order):
        differences.append(differences[-1][:, step:] - differences[-1][:, :-step])
    return torch.cat([rows[:, rows.shape[1] - poses.shape[1] :] for rows in differences], -1)


def next_derivatives(pose: Tensor, past: Tensor, order: int, *, step: int = 1) -> tuple[Tensor, Tensor]:
    """Return a pose (B, D) with its backward differences (B, (order + 1) * D), and the past of the next one.

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
