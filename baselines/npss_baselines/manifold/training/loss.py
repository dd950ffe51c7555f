"""The loss of the manifold's layers: to reconstruct a corrupted window, by few hidden units."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from npss_baselines.manifold.model.autoencoder import TiedLayer


def loss_of(
    layers: Sequence[TiedLayer],
    windows: Tensor,
    of_frames: Tensor,
    of_steps: Tensor,
    *,
    corruption: float,
    sparsity: float,
    random: bool,
    rescale: bool = False,
) -> Tensor:
    """Return the loss of a batch: the mean over windows of their weighted squared errors and sparsity.

    Parameters
    ----------
    layers : sequence of TiedLayer
        In training, from what the windows are on.
    windows : (B, T, F) Tensor
        What is reconstructed, from a corrupted copy.
    of_frames : (B, T, 1) Tensor
        Weights of the squared errors of frames; 0 where a window is padded.
    of_steps : (B, T', 1) Tensor
        Weights of the magnitudes of the last layer's hidden units.
    corruption : float
        Probability with which an input value is set to zero. Drawn from torch's global generator.
    sparsity : float
        Weight of these magnitudes.
    random : bool
        Whether the last layer is unpooled to one place by chance.
    rescale : bool, optional
        Whether the input values that are left are divided by 1 - `corruption`.

    Returns
    -------
    () Tensor
        The loss.
    """
    values = windows * torch.empty_like(windows).bernoulli_(1 - corruption)
    if rescale:
        values = values / (1 - corruption)
    for layer in layers:
        values = layer(values)
    loss = sparsity * (values.abs() * of_steps).sum() if sparsity else windows.new_zeros(())
    for layer in reversed(layers):
        values = layer.inverse(values, "random" if random and layer is layers[-1] else None)
    return (loss + ((values - windows).square() * of_frames).sum()) / len(windows)
