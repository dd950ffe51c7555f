"""The motion manifold: a convolutional autoencoder over time, whose encoder and decoder share weights."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn.functional import conv1d, conv_transpose1d

from npss.validation import each, is_real, one_of, positive_integer

#: How the inverse of max pooling places a value; ``random`` only where a single layer is trained.
UNPOOL = ("both", "half", "random")


@dataclass(frozen=True)
class AutoencoderConfig:
    """The configuration of the network.

    Parameters
    ----------
    n_features : int
        Features in a frame: 3 J + 3 for J joints.
    widths : tuple of int
        Number of filters in each layer.
    kernel : int
        Length of a filter in frames; odd.
    pool : int
        Frames in a max pooling window; 1 turns pooling off.
    unpool : {'both', 'half'}
        How unpooling spreads a value evenly: repeat it in every frame, or divide it among them. The paper does not say
        which.
    eps : float
        Values are clipped to a magnitude of 1 - eps before atanh, since the layer above can reconstruct any value.
        Pre-activations are recovered up to atanh(1 - eps).

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message begins with its name.
    """

    n_features: int = 63
    widths: tuple[int, ...] = (64, 128, 256)
    kernel: int = 15
    pool: int = 2
    unpool: str = "both"
    eps: float = 1e-3

    def __post_init__(self) -> None:
        for name in ("n_features", "kernel", "pool"):
            positive_integer(name, getattr(self, name))
        widths = tuple(positive_integer(f"widths[{i}]", width) for i, width in enumerate(each("widths", self.widths)))
        if not widths:
            raise ValueError("widths: expected at least one layer")
        object.__setattr__(self, "widths", widths)  # JSON gives a list
        if self.kernel % 2 == 0:
            raise ValueError(f"kernel: expected an odd number of frames, got {self.kernel}")
        one_of("unpool", self.unpool, UNPOOL[:2])
        if not is_real(self.eps):
            raise TypeError(f"eps: expected a number, got {self.eps!r}")
        if not 0 < self.eps < 1:
            raise ValueError(f"eps: expected a number between 0 and 1, got {self.eps!r}")

    @property
    def depth(self) -> int:
        """Number of layers."""
        return len(self.widths)

    @property
    def stride(self) -> int:
        """Frames per step of the code."""
        return int(self.pool**self.depth)


class TiedLayer(nn.Module):
    """A convolution with max pooling and tanh, and its inverse with the same weights.

    Motion has shape (B, T, F), hidden units (B, T / pool, H).

    Parameters
    ----------
    n_in, n_out : int
        F and H.
    config : AutoencoderConfig
        The other settings.
    """

    def __init__(self, n_in: int, n_out: int, config: AutoencoderConfig) -> None:
        super().__init__()
        self.config = config
        #: weight[h, f, k] is that of filter h, feature f and lag k - K // 2.
        self.weight = nn.Parameter(torch.empty(n_out, n_in, config.kernel))
        self.bias = nn.Parameter(torch.zeros(n_out))
        limit = math.sqrt(6 / (config.kernel * (n_in + n_out)))  # Glorot and Bengio
        nn.init.uniform_(self.weight, -limit, limit)

    def forward(self, x: Tensor) -> Tensor:
        """Return tanh(maxpool(x * W + b)), (B, T / pool, H)."""
        filtered = convolve(x, self.weight)
        if self.config.pool > 1:  # the bias does not change the order
            filtered = filtered.view(len(x), -1, self.config.pool, self.bias.numel()).max(2).values
        return torch.tanh(filtered + self.bias)

    def inverse(self, y: Tensor, unpool: str | None = None) -> Tensor:
        """Return (unpool(atanh(y)) - b) * W~, (B, T, F), where W~ is W transposed over filters and flipped in time.

        Parameters
        ----------
        y : (B, T / pool, H) Tensor
            Hidden units, clipped to a magnitude of 1 - eps.
        unpool : {'both', 'half', 'random'}, optional
            How to unpool (default: as configured). ``'random'`` draws the frame of each value from torch's global
            generator, and sets the others to zero.
        """
        largest = 1 - self.config.eps
        return spread(self._unpool(torch.atanh(y.clamp(-largest, largest)), unpool) - self.bias, self.weight)

    def _unpool(self, values: Tensor, unpool: str | None) -> Tensor:
        pool, mode = self.config.pool, unpool or self.config.unpool
        if pool == 1:
            return values
        if mode == "random":
            places = torch.randint(pool, values.shape, device=values.device).unsqueeze(2)
            frames = torch.arange(pool, device=values.device).view(1, 1, -1, 1)
            return (values.unsqueeze(2) * (places == frames)).flatten(1, 2)
        return (values if mode == "both" else values / pool).repeat_interleave(pool, 1)


class Autoencoder(nn.Module):
    """The network: layers that each divide the number of frames by `pool`.

    Parameters
    ----------
    config : AutoencoderConfig
        Its configuration.

    References
    ----------
    D. Holden, J. Saito, T. Komura, T. Joyce, "Learning Motion Manifolds with Convolutional Autoencoders", SIGGRAPH Asia
    2015 Technical Briefs.

    Examples
    --------
    >>> import torch
    >>> network = Autoencoder(AutoencoderConfig())
    >>> motion = torch.zeros(2, 160, 63)
    >>> network.encode(motion).shape, network.project(motion).shape
    (torch.Size([2, 20, 256]), torch.Size([2, 160, 63]))
    """

    def __init__(self, config: AutoencoderConfig) -> None:
        super().__init__()
        self.config = config
        sizes = (config.n_features, *config.widths)
        self.layers = nn.ModuleList(TiedLayer(*pair, config) for pair in itertools.pairwise(sizes))

    def first(self, depth: int | None = None) -> list[TiedLayer]:
        """Return the first `depth` layers, starting at the motion (default: all)."""
        return cast(list[TiedLayer], list(self.layers)[:depth])

    def encode(self, x: Tensor, depth: int | None = None) -> Tensor:
        """Return the hidden units (B, T / pool**depth, H) of motion (B, T, F) after `depth` layers (default: all)."""
        depth = self.config.depth if depth is None else depth
        if x.shape[1] % self.config.pool**depth:
            raise ValueError(f"x: {x.shape[1]} frames are not a multiple of {self.config.pool**depth}")
        for layer in self.first(depth):
            x = layer(x)
        return x

    def decode(self, y: Tensor, depth: int | None = None) -> Tensor:
        """Reconstruct the motion (B, T, F) from hidden units."""
        for layer in reversed(self.first(depth)):
            y = layer.inverse(y)
        return y

    def project(self, x: Tensor, depth: int | None = None) -> Tensor:
        """Project motion (B, T, F) onto the manifold: encode and decode it."""
        return self.decode(self.encode(x, depth), depth)


def convolve(x: Tensor, weight: Tensor) -> Tensor:
    """Return y[t, h] = sum over f and k of x[t + k - K // 2, f] weight[h, f, k], (B, T, H).

    Motion is padded with zeros.
    """
    return conv1d(x.transpose(1, 2), weight, padding=weight.shape[2] // 2).transpose(1, 2)


def spread(y: Tensor, weight: Tensor) -> Tensor:
    """Return x[t, f] = sum over h and k of y[t - k + K // 2, h] weight[h, f, k], (B, T, F): the adjoint of `convolve`.

    The same as `convolve` with W~: W flipped in time and transposed over filters.
    """
    return conv_transpose1d(y.transpose(1, 2), weight, padding=weight.shape[2] // 2).transpose(1, 2)
