"""The weights that training starts from."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from npss.validation import one_of
from npss_baselines.manifold.model.autoencoder import Autoencoder

INITIALIZATIONS = ("glorot", "orthonormal")


def initialize(network: Autoencoder, how: str) -> None:
    """Set the weights; what is random is drawn from torch's global generator.

    Parameters
    ----------
    network : Autoencoder
        As it was made: by Glorot and Bengio's uniform distribution, and zero biases.
    how : {'glorot', 'orthonormal'}
        Leave it so, as the paper does. Or each filter sees a single frame, by an orthonormal change of basis, and if
        there are twice as many filters as inputs, each has its negative beside it: of every two frames, pooling takes
        the maximum of the one and, as it were, the minimum of the other, of which the inverse makes the mean. So before
        any training, reconstructed motion is the average over the frames of a step.

    Raises
    ------
    ValueError
        If there is no such initialization.

    Examples
    --------
    Slow motion, so small that tanh changes it little, is nearly its own projection:

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
                    layer.weight.mul_(math.sqrt(network.config.pool))  # once in the layer, and once more in its inverse


def _frame(filters: int, inputs: int) -> Tensor:
    """Return (filters, inputs) orthonormal columns, or rows if there are fewer of them."""
    if filters >= 2 * inputs:
        half = _orthonormal(filters // 2, inputs) / 2**0.5
        return torch.cat([half, -half, half.new_zeros(filters % 2, inputs)])
    return _orthonormal(filters, inputs) if filters >= inputs else _orthonormal(inputs, filters).T


def _orthonormal(rows: int, columns: int) -> Tensor:
    frame: Tensor = torch.linalg.qr(torch.randn(rows, columns)).Q
    return frame
