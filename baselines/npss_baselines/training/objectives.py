"""Training objectives: the losses of the papers, with optional NPSS."""

from __future__ import annotations

from typing import NamedTuple, cast

import torch
from torch import Tensor
from torch.nn.functional import mse_loss

import npss.torch
from npss.protocol import COLUMNS
from npss_baselines.models.base import POSE, MotionModel
from npss_baselines.models.mbr import MBR
from npss_baselines.models.recipe import Recipe

_SCORED = slice(sum(column < 6 for column in COLUMNS), POSE)  # without the root, like all NPSS of poses here


class Statistics(NamedTuple):
    """The statistics of the training data, for normalisation."""

    mean: Tensor  # (54,)
    std: Tensor  # (54,)


def loss(
    model: MotionModel,
    poses: Tensor,
    label: Tensor,
    recipe: Recipe,
    iteration: int,
    *,
    statistics: Statistics | None = None,
) -> dict[str, Tensor]:
    """Return the loss of a batch of windows, and its parts.

    All errors are squared errors, averaged over the batch, the frames and the columns of the normalised pose. With S
    seed frames and K target frames, the regimes are

    ``'eq6'``
        Equation 6 of the NPSS paper: all S + K outputs in open loop (``'open'``), plus lambda times the K outputs after
        the seed in closed loop (``'closed'``). The targets are frames 1 to S + K, and S + 1 to S + K in closed loop, as
        in the released code.
    ``'open'``
        All outputs in open loop.
    ``'sampling'``
        The K frames after the seed in closed loop alone, S to S + K - 1 (``'closed'``; Martinez et al. 2017). MBR-sup,
        which predicts its label, is also measured by the label.
    ``'noise'``
        Open loop, with Gaussian noise on each input frame with probability 1/2, and none on targets (``'open'``).
    ``'auto-conditioning'``
        All outputs. After the seed, the inputs are blocks of true frames and of outputs in turn, true frames first
        (``'conditioned'``).

    Parameters
    ----------
    model : MotionModel
        The model; in training mode, it uses dropout.
    poses : (B, S + K + 1, 54) Tensor
        Normalised windows.
    label : (B, A) Tensor
        The action, one-hot.
    recipe : Recipe
        The regime and its numbers.
    iteration : int
        Counted from 0.
    statistics : Statistics, optional
        Statistics for NPSS, which is of unnormalised poses.

    Returns
    -------
    dict of str to () Tensor
        ``'loss'``, and the unweighted parts by name.

    Raises
    ------
    ValueError
        If the poses are not windows of the recipe, or NPSS has a weight but no statistics.

    Notes
    -----
    Noise and dropout use torch's global generator: seed it for each iteration.

    ``'npss'`` is `npss.torch.score` of the predicted frames after the seed, by the recipe's convention: exponential
    maps in radians of the joints, without the root. It is of the closed loop if the regime has one. It cannot be the
    only loss: it is blind to phase, scale and sign, and has no gradient where a prediction is constant.
    """
    if poses.ndim != 3 or poses.shape[1:] != (recipe.window, POSE):
        raise ValueError(
            f"poses: expected shape (B, {recipe.window}, {POSE}), a window of the recipe, got {tuple(poses.shape)}"
        )
    if label.shape != (len(poses), model.n_actions):
        raise ValueError(f"label: expected shape {(len(poses), model.n_actions)}, got {tuple(label.shape)}")
    if recipe.npss_weight > 0 and statistics is None:
        raise ValueError("statistics: NPSS in the loss is of unnormalised poses, and needs their mean and std")
    total, parts, future, truth = _REGIMES[recipe.regime](model, poses, label, recipe, iteration)
    if recipe.npss_weight > 0 and statistics is not None:
        mean, std = (value[_SCORED] for value in statistics)
        true, predicted = (motion[..., _SCORED] * std + mean for motion in (truth, future))
        parts["npss"] = npss.torch.score(true, predicted, convention=cast(npss.ConventionName, recipe.npss_convention))
        total = total + recipe.npss_weight * parts["npss"]
    return {"loss": total, **parts}


class _Outcome(NamedTuple):
    """The loss without NPSS, its parts, and the frames (B, K, 54) for NPSS."""

    total: Tensor
    parts: dict[str, Tensor]
    future: Tensor
    truth: Tensor


def _eq6(model: MotionModel, poses: Tensor, label: Tensor, recipe: Recipe, iteration: int) -> _Outcome:
    opened, closed = model.open_and_closed(poses[:, :-1], label, recipe.n_seed)
    truth = poses[:, recipe.n_seed + 1 :]
    parts = {"open": mse_loss(opened, poses[:, 1:]), "closed": mse_loss(closed, truth)}
    total, weight = parts["open"], recipe.lambda_at(iteration)
    if weight > 0:  # else the closed loop has no backward pass
        total = total + weight * parts["closed"]
    return _Outcome(total, parts, closed, truth)


def _open(model: MotionModel, poses: Tensor, label: Tensor, recipe: Recipe, iteration: int) -> _Outcome:
    inputs, targets = poses[:, :-1], poses[:, 1:]
    if recipe.regime == "noise":
        inputs = noisy(inputs, recipe.noise_at(iteration))
    outputs, _ = model.read(inputs, model.begin(label, inputs.shape[1]))
    total = mse_loss(outputs, targets)
    return _Outcome(total, {"open": total}, outputs[:, recipe.n_seed :], targets[:, recipe.n_seed :])


def _sampling(model: MotionModel, poses: Tensor, label: Tensor, recipe: Recipe, iteration: int) -> _Outcome:
    seed, truth = poses[:, : recipe.n_seed], poses[:, recipe.n_seed : -1]
    if isinstance(model, MBR):
        future = model.predict_labelled(seed, label, recipe.n_target)  # (B, K, 54 + A)
        total = mse_loss(future, model.labelled(truth, label))
    else:
        future = model.predict(seed, label, recipe.n_target)
        total = mse_loss(future, truth)
    return _Outcome(total, {"closed": total}, future[..., :POSE], truth)


def _auto_conditioning(model: MotionModel, poses: Tensor, label: Tensor, recipe: Recipe, iteration: int) -> _Outcome:
    outputs, targets = conditioned(model, poses[:, :-1], label, recipe.n_seed, recipe.conditioning), poses[:, 1:]
    total = mse_loss(outputs, targets)
    return _Outcome(total, {"conditioned": total}, outputs[:, recipe.n_seed :], targets[:, recipe.n_seed :])


_REGIMES = {
    "eq6": _eq6,
    "open": _open,
    "noise": _open,
    "sampling": _sampling,
    "auto-conditioning": _auto_conditioning,
}


def conditioned(model: MotionModel, poses: Tensor, label: Tensor, n_seed: int, length: int) -> Tensor:
    """Return the predictions after every frame (B, T, 54), auto-conditioned after the seed.

    The inputs are blocks of `length` true frames and blocks of `length` outputs in turn, true frames first.

    Parameters
    ----------
    model : MotionModel
        The model.
    poses : (B, T, 54) Tensor
        The true frames.
    label : (B, A) Tensor
        The action.
    n_seed : int
        Number of seed frames, before the first block.
    length : int
        Frames in a block; the last block may be shorter.
    """
    own = [t >= n_seed and (t - n_seed) // length % 2 == 1 for t in range(poses.shape[1])]
    return model.mixed(poses, label, own)


def noisy(poses: Tensor, std: float) -> Tensor:
    """Add Gaussian noise of standard deviation `std` to each frame (B, T, 54) with probability 1/2."""
    if std == 0:
        return poses
    chosen = torch.rand(*poses.shape[:2], 1, dtype=poses.dtype, device=poses.device) < 0.5
    return poses + chosen * std * torch.randn_like(poses)
