"""Initial weights of the network."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from npss.validation import one_of
from npss_baselines.manifold.model.autoencoder import Autoencoder

INITIALIZATIONS = ("glorot", "orthonormal")


def initialize(network: Autoencoder, how: str) -> None:
    """Set the initial weights, drawn from torch's global generator.

    Parameters
    ----------
    network : Autoencoder
        A new network, which has Glorot and Bengio's uniform weights and zero biases.
    how : {'glorot', 'orthonormal'}
        ``'glorot'`` keeps these weights, as the paper does. With ``'orthonormal'``, each filter sees a single frame,
        through an orthonormal change of basis. If there are at least twice as many filters as inputs, each filter has
        a negated copy: pooling then keeps the maximum and the minimum of two frames, and the inverse averages them.
        Before training, reconstructed motion is thus the average over the frames of a step.

    Raises
    ------
    ValueError
        If the initialization is unknown.

    Examples
    --------
    Slow motion, small enough for tanh to be nearly linear, is nearly unchanged by projection:

    >>> import torch
    >>> from npss_baselines.manifold.model.autoencoder import AutoencoderConfig
    >>> _ = torch.manual_seed(0)
    >>> network = Autoencoder(AutoencoderConfig())
    >>> initialize(network, "orthonormal")
    >>> motion = torch.linspace(0, 0.1, 160).view(1, 160, 1).expand(1, 160, 63)
    >>> with torch.no_grad():
    ...     error = (network.project(motion) - motion).abs().max()
    >>> bool(error < 0.01)
    True
    """
    one_of("how", how, INITIALIZATIONS)
    if how == "orthonormal":
        with torch.no_grad():
            for layer in network.first():
                filters, inputs, lags = layer.weight.shape
                layer.weight.zero_()
                layer.weight[:, :, lags // 2] = _frame(filters, inputs)
                if network.config.unpool == "half":
                    layer.weight.mul_(math.sqrt(network.config.pool))  # in the layer, and again in its inverse


def _frame(filters: int, inputs: int) -> Tensor:
    """Return a (filters, inputs) matrix with orthonormal columns, or orthonormal rows if there are fewer rows."""
    if filters >= 2 * inputs:
        half = _orthonormal(filters // 2, inputs) / 2**0.5
        return torch.cat([half, -half, half.new_zeros(filters % 2, inputs)])
    return _orthonormal(filters, inputs) if filters >= inputs else _orthonormal(inputs, filters).T


def _orthonormal(rows: int, columns: int) -> Tensor:
    frame: Tensor = torch.linalg.qr(torch.randn(rows, columns)).Q
    return frame
