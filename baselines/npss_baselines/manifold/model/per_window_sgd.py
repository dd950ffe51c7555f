"""SGD with one window a step, as in the paper, with hand-written gradients of the tied layers.

On one thread, autograd takes 1.7 to 1.9 times as long for a layer and 1.5 times for all layers
(`benchmarks/test_manifold_speed.py`): windows are small, and its overhead exceeds the matrix products. Here

- all arrays are allocated once, for windows of one length;
- the frames seen by a filter are copied side by side, so that a convolution is a single matrix product;
- a layer and its inverse share weights, and one product of twice as many rows gives both gradients;
- that product is added to the weights directly, without a stored gradient or an optimiser.

The tests compare it with autograd and torch's SGD.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor

from npss_baselines.manifold.model.autoencoder import TiedLayer


class PerWindowSGD:
    """SGD on layers that reconstruct a corrupted window.

    Equal to SGD on `npss_baselines.manifold.training.loss.loss_of` for a single window. The layers do not change until
    `keep`.

    Parameters
    ----------
    layers : sequence of TiedLayer
        The layers to train, in order from the window on. Pooling is over two frames.
    n_frames : int
        Frames in a window.
    corruption : float
        Probability that an input value is set to zero.
    sparsity : float
        Weight of the magnitudes of the last layer's hidden units.
    random : bool
        Whether the last layer is unpooled at random, otherwise as configured. Other layers are unpooled evenly.
    """

    def __init__(
        self, layers: Sequence[TiedLayer], n_frames: int, *, corruption: float, sparsity: float, random: bool
    ) -> None:
        self.layers = [_Layer(layer, n_frames // 2**i) for i, layer in enumerate(layers)]
        self.corruption = corruption
        self.sparsity = sparsity
        self.random = random
        self.share = 0.5 if layers[0].config.unpool == "half" else 1.0

    def step(self, window: Tensor, of_frames: Tensor, of_steps: Tensor, lr: float) -> Tensor:
        """Update the weights.

        Parameters
        ----------
        window : (T, F) Tensor
            The window to reconstruct.
        of_frames : (T, 1) Tensor
            Weights of the squared errors of the frames.
        of_steps : (T', 1) Tensor
            Weights of the magnitudes of the last layer's hidden units.
        lr : float
            The learning rate.

        Returns
        -------
        () Tensor
            The loss before the update.
        """
        layers, top = self.layers, self.layers[-1]
        kept = torch.empty_like(window).bernoulli_(1 - self.corruption)
        values = window * kept
        for layer in layers:
            values = layer.encode(values)
        # In the last layer, atanh only undoes tanh.
        spread = top.filtered.clamp(-top.limit, top.limit)
        if self.random:
            is_first = torch.randint(2, spread.shape, device=spread.device) == 0
            first = spread * is_first
            values = top.decode(first, spread - first)
        else:
            values = top.decode(spread * self.share)
        decoded = []
        for layer in reversed(layers[:-1]):
            decoded.append(values)
            values = layer.decode(values.clamp(-layer.largest, layer.largest).atanh() * self.share)

        error = values - window
        weighted = error * of_frames
        loss = (error * weighted).sum()
        gradient = weighted.mul_(2)
        for layer, before in zip(layers[:-1], reversed(decoded), strict=True):
            first, second = layer.decode_backwards(gradient)
            inside = before.abs() <= layer.largest
            gradient = (first + second).mul_(self.share).mul_(inside).div_(1 - before * before * inside)
        first, second = top.decode_backwards(gradient)
        inside = top.filtered.abs() <= top.limit
        gradient = torch.where(is_first, first, second) if self.random else (first + second).mul_(self.share)
        gradient = gradient.mul_(inside)
        if self.sparsity:
            magnitudes = of_steps * self.sparsity
            loss = loss + (top.units.abs() * magnitudes).sum()
            gradient += top.units.sign().mul_(magnitudes).mul_(1 - top.units * top.units)
        for i, layer in reversed(list(enumerate(layers))):
            input_gradient = layer.encode_backwards(gradient, needed=i > 0)
            layer.update(lr)
            if input_gradient is not None:
                below = layers[i - 1].units
                gradient = input_gradient.mul_(1 - below * below)
        return loss

    def keep(self) -> None:
        """Write the weights to the layers."""
        for layer in self.layers:
            layer.keep()


class _Layer:
    """A layer, and its buffers for one window."""

    def __init__(self, layer: TiedLayer, n_frames: int) -> None:
        self.layer = layer
        n_out, n_in, kernel = layer.weight.shape
        self.weight = layer.weight.detach().permute(2, 1, 0).reshape(kernel * n_in, n_out).contiguous()
        self.bias = layer.bias.detach().clone()
        self.largest = 1 - layer.config.eps
        self.limit = math.atanh(self.largest)
        self.n_frames = n_frames
        around, width = kernel // 2, kernel * n_in
        new = self.weight.new_zeros
        # The neighbours of each frame side by side, of the input and of the output gradient.
        self.input, self.output_gradient = (new(n_frames + 2 * around, n_in) for _ in range(2))
        self.inside = slice(around, around + n_frames)
        self.input_seen, self.output_gradient_seen = (
            padded.as_strided((n_frames, width), (n_in, 1)) for padded in (self.input, self.output_gradient)
        )
        self.seen = new(2 * n_frames, width)
        # The other factor of the weight gradient: the gradient of the filtered values, and the unpooled values.
        self.beside = new(2 * n_frames, n_out)
        self.filtered_gradient = self.beside[:n_frames].view(-1, 2, n_out)
        self.spread = self.beside[n_frames:].view(-1, 2, n_out)
        self.bias_gradient = new(n_out)
        # What each frame adds to its neighbours. The terms of one frame lie on a diagonal, which strides of a row down
        # and a frame back turn into an axis.
        self.added = new(n_frames + 2 * around, width)
        self.diagonals = self.added.as_strided((n_frames, kernel, n_in), (width, width - n_in, 1), (kernel - 1) * n_in)
        self.filtered = self.units = self.is_first = new(0)

    def keep(self) -> None:
        n_out, n_in, kernel = self.layer.weight.shape
        with torch.no_grad():
            self.layer.weight.copy_(self.weight.view(kernel, n_in, n_out).permute(2, 1, 0))
            self.layer.bias.copy_(self.bias)

    def encode(self, values: Tensor) -> Tensor:
        """Return the hidden units (T / 2, H) of input (T, F)."""
        self.input[self.inside] = values
        self.seen[: self.n_frames] = self.input_seen
        pairs = torch.mm(self.seen[: self.n_frames], self.weight).view(self.spread.shape)
        first, second = pairs.unbind(1)
        self.is_first = first >= second
        self.filtered = torch.maximum(first, second).add_(self.bias)
        self.units = self.filtered.tanh()
        return self.units

    def decode(self, first: Tensor, second: Tensor | None = None) -> Tensor:
        """Return the output (T, F) of values (T / 2, H) in the first and second frames, which may be equal."""
        self.spread[:, 0] = first
        self.spread[:, 1] = first if second is None else second
        self.spread -= self.bias
        return self._overlaid(self.beside[self.n_frames :])

    def decode_backwards(self, gradient: Tensor) -> tuple[Tensor, Tensor]:
        """Return the gradients of the values in the first and second frames from the output gradient."""
        self.output_gradient[self.inside] = gradient
        self.seen[self.n_frames :] = self.output_gradient_seen
        gradients = torch.mm(self.seen[self.n_frames :], self.weight)
        torch.sum(gradients, 0, out=self.bias_gradient).neg_()
        first, second = gradients.view(self.spread.shape).unbind(1)
        return first, second

    def encode_backwards(self, gradient: Tensor, *, needed: bool) -> Tensor | None:
        """Return the input gradient, if needed, from the gradient of the pre-activations."""
        self.bias_gradient += gradient.sum(0)
        torch.mul(gradient, self.is_first, out=self.filtered_gradient[:, 0])
        torch.sub(gradient, self.filtered_gradient[:, 0], out=self.filtered_gradient[:, 1])
        return self._overlaid(self.beside[: self.n_frames]) if needed else None

    def update(self, lr: float) -> None:
        """Take a step of gradient descent."""
        self.weight.addmm_(self.seen.T, self.beside, alpha=-lr)
        self.bias.sub_(self.bias_gradient, alpha=lr)

    def _overlaid(self, values: Tensor) -> Tensor:
        torch.mm(values, self.weight.T, out=self.added[self.inside])
        return self.diagonals.sum(1)
