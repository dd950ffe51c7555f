"""The network as one matrix product a layer, with weights arranged once: for use, not for training.

A projection of 160 frames by the paper's three layers is 157 million operations by convolutions, here 125 million.

- The neighbours of each frame are copied side by side, so that a convolution is a single matrix product.
- Even unpooling repeats each value in `pool` successive frames. Instead, the weights that meet the same value are added
  once, and a product gives all frames of a step at a time: 9 sums of weights a step and frame instead of 15 weights.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import pad

from npss_baselines.manifold.model.autoencoder import Autoencoder, TiedLayer


class MatrixProducts:
    """The encoder and decoder of a network, whose weights must not change.

    Parameters
    ----------
    network : Autoencoder
        The network; results are its own, up to rounding.
    """

    def __init__(self, network: Autoencoder) -> None:
        with torch.inference_mode():
            self._layers = [_Layer(layer) for layer in network.first()]

    @torch.inference_mode()
    def encode(self, x: Tensor) -> Tensor:
        """Return the hidden units (B, T', H) of motion (B, T, F); T is a multiple of the frames per step."""
        for layer in self._layers:
            x = layer.encode(x)
        return x

    @torch.inference_mode()
    def decode(self, y: Tensor) -> Tensor:
        """Return the motion (B, T, F) of hidden units (B, T', H)."""
        for layer in reversed(self._layers):
            y = layer.decode(y)
        return y


class _Layer:
    """A layer's weights, arranged for products with neighbouring frames or steps side by side."""

    def __init__(self, layer: TiedLayer) -> None:
        weight, config = layer.weight.detach(), layer.config
        n_out, n_in, kernel = weight.shape
        self.bias, self.pool, self.largest = layer.bias.detach().clone(), config.pool, 1 - config.eps
        self.share = 1 / config.pool if config.unpool == "half" else 1.0
        self.frames = kernel // 2  # neighbours on either side
        self.forward = weight.permute(2, 1, 0).reshape(kernel * n_in, n_out)
        # Frame `phase` of a step sees frame `inner` of the step at distance `step` by the weight of one lag.
        self.steps = -(-self.frames // config.pool)
        self.inverse = weight.new_zeros(2 * self.steps + 1, n_out, config.pool, n_in)
        for row in range(2 * self.steps + 1):
            for phase in range(config.pool):
                for inner in range(config.pool):
                    lag = phase - config.pool * (row - self.steps) - inner + self.frames
                    if 0 <= lag < kernel:
                        self.inverse[row, :, phase] += weight[:, :, lag]
        self.inverse = self.inverse.view(-1, config.pool * n_in)

    def encode(self, x: Tensor) -> Tensor:
        filtered = _side_by_side(x, self.frames) @ self.forward
        return filtered.view(len(x), -1, self.pool, len(self.bias)).amax(2).add_(self.bias).tanh_()

    def decode(self, y: Tensor) -> Tensor:
        values = y.clamp(-self.largest, self.largest).atanh_().mul_(self.share).sub_(self.bias)
        return (_side_by_side(values, self.steps) @ self.inverse).view(len(y), y.shape[1] * self.pool, -1)


def _side_by_side(values: Tensor, around: int) -> Tensor:
    """Return each row of ``(B, T, C)`` with its neighbours, ``(B T, (2 around + 1) C)``; zeros beyond the ends."""
    padded = pad(values, (0, 0, around, around))
    n, rows, width = padded.shape
    shape = (n, rows - 2 * around, (2 * around + 1) * width)
    return padded.as_strided(shape, (rows * width, width, 1)).reshape(-1, shape[2])
