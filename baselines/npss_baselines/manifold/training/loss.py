"""The loss of the manifold: reconstruction of corrupted windows, with sparse hidden units."""

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
    corrupted: Tensor | None = None,
) -> Tensor:
    """Return the loss of a batch: weighted squared errors and sparsity, averaged over windows.

    Parameters
    ----------
    layers : sequence of TiedLayer
        The layers to train, in order from the windows on.
    windows : (B, T, F) Tensor
        The windows to reconstruct, from a corrupted copy.
    of_frames : (B, T, 1) Tensor
        Weights of the squared errors of the frames; 0 where a window is padded.
    of_steps : (B, T', 1) Tensor
        Weights of the magnitudes of the last layer's hidden units.
    corruption : float
        Probability that an input value is set to zero, drawn from torch's global generator.
    sparsity : float
        Weight of the magnitudes of the hidden units.
    random : bool
        Whether the last layer is unpooled at random.
    rescale : bool, optional
        Whether the remaining input values are divided by 1 - `corruption`.
    corrupted : (B, T, F) Tensor, optional
        The corrupted windows, instead.

    Returns
    -------
    () Tensor
        The loss.
    """
    if corrupted is None:
        values = windows * torch.empty_like(windows).bernoulli_(1 - corruption)
        if rescale:
            values = values / (1 - corruption)
    else:
        values = corrupted
    for layer in layers:
        values = layer(values)
    loss = sparsity * (values.abs() * of_steps).sum() if sparsity else windows.new_zeros(())
    for layer in reversed(layers):
        values = layer.inverse(values, "random" if random and layer is layers[-1] else None)
    return (loss + ((values - windows).square() * of_frames).sum()) / len(windows)
