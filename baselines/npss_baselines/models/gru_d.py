"""GRU-d: two stacked GRUs that read motion derivatives; VGRU-d without its top RNN."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn.functional import dropout

from npss.validation import is_integer, is_real, positive_integer
from npss_baselines.models._gru import read_gru
from npss_baselines.models.base import POSE, MotionModel
from npss_baselines.models.cells import GRUCell
from npss_baselines.models.derivatives import derivatives, next_derivatives, no_past, own_past, past_of

#: The past frames (B, n_derivatives, 54), and h (B, H) of each layer.
GRUdState = tuple[Tensor, tuple[Tensor, ...]]


@dataclass(frozen=True)
class GRUdConfig:
    """Sizes of GRU-d. The published ones have 2,721,846 parameters; Table 1 of the NPSS paper says 2,735,670.

    Parameters
    ----------
    size : int
        Units of a layer.
    n_layers : int
        Number of layers.
    n_derivatives : int
        The highest derivative to read; 0 reads the pose alone.
    dropout : float
        Dropout probability of the inputs and of the last layer's outputs, in training, as in the released code. In the
        paper's text, only the short-term model has dropout.
    restart_derivatives : bool
        Whether, in `open_and_closed`, the second and higher derivatives of the open loop after the seed take the seed
        frames as zeros: a mistake of the released code.
    own_past : bool
        Whether derivatives of predictions use predictions alone, including those of the seed frames, and derivatives of
        frames use frames alone, as in the released code. By default, derivatives are of the inputs.
    """

    size: int = 512
    n_layers: int = 2
    n_derivatives: int = 3
    dropout: float = 0.3
    restart_derivatives: bool = False
    own_past: bool = False

    def __post_init__(self) -> None:
        positive_integer("size", self.size)
        positive_integer("n_layers", self.n_layers)
        if not is_integer(self.n_derivatives):
            raise TypeError(f"n_derivatives: expected an integer, got {self.n_derivatives!r}")
        if self.n_derivatives < 0:
            raise ValueError(f"n_derivatives: expected 0 or more, got {self.n_derivatives}")
        if not is_real(self.dropout):
            raise TypeError(f"dropout: expected a number, got {self.dropout!r}")
        if not 0 <= self.dropout < 1:
            raise ValueError(f"dropout: expected a probability below 1, got {self.dropout}")
        for name in ("restart_derivatives", "own_past"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"{name}: expected True or False, got {getattr(self, name)!r}")


class GRUd(MotionModel):
    """GRU-d. It predicts the pose itself and ignores the label.

    The cells are the original GRU with one bias per gate: 2,721,846 parameters with the decoder. With the two biases of
    torch's GRU it would have 2,724,918. Kernels start orthogonal, and biases at 0.1.

    Parameters
    ----------
    config : GRUdConfig
        The sizes.
    n_actions : int
        Width of the label.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019.
    """

    def __init__(self, config: GRUdConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.config = config
        widths = [(config.n_derivatives + 1) * POSE] + [config.size] * config.n_layers
        self.layers = nn.ModuleList(GRUCell(width, config.size) for width in widths[:-1])
        self.decoder = nn.Linear(config.size, POSE)

    def begin(self, label: Tensor, n_steps: int) -> GRUdState:
        """Return the initial state, zeros."""
        past = no_past(label.new_empty(len(label), POSE), self.config.n_derivatives)
        return past, (label.new_zeros(len(label), self.config.size),) * self.config.n_layers

    def step(self, pose: Tensor, state: GRUdState) -> tuple[Tensor, GRUdState]:
        """Read a frame."""
        past, before = state
        hidden, past = next_derivatives(pose, past, self.config.n_derivatives)  # (B, 216)
        hidden = self._drop(hidden)
        after = []
        for cell, h in zip(self.layers, before, strict=True):
            hidden = cell(hidden, h)  # (B, H)
            after.append(hidden)
        return self.decoder(self._drop(hidden)), (past, tuple(after))

    def read(self, poses: Tensor, state: GRUdState) -> tuple[Tensor, GRUdState]:
        """Read frames layer by layer."""
        past, before = state
        predictions, after = self._read(derivatives(poses, self.config.n_derivatives, past=past), before)
        return predictions, (torch.cat([past, poses], 1)[:, poses.shape[1] :], after)

    def _read(self, features: Tensor, before: tuple[Tensor, ...]) -> tuple[Tensor, tuple[Tensor, ...]]:
        """Read poses with their derivatives (B, T, 216); return predictions, and the new h of each layer."""
        hidden = self._drop(features)
        after = []
        for cell, h in zip(self.layers, before, strict=True):
            hidden, last = read_gru(cast(GRUCell, cell), hidden, h)  # (B, T, H)
            after.append(last)
        return self.decoder(self._drop(hidden)), tuple(after)

    def switch(self, outputs: Tensor, state: GRUdState) -> GRUdState:
        """Return the initial state of the closed loop."""
        if not self.config.own_past:
            return state
        return own_past(outputs, self.config.n_derivatives), state[1]

    def switch_back(self, frames: Tensor, state: GRUdState) -> GRUdState:
        """Return the initial state of an open loop after a closed one."""
        if not self.config.own_past:
            return state
        return past_of(frames, self.config.n_derivatives), state[1]

    def open_and_closed(self, poses: Tensor, label: Tensor, n_seed: int) -> tuple[Tensor, Tensor]:
        """Return the open-loop predictions after every frame, and the closed-loop predictions after the seed."""
        if not self.config.restart_derivatives:
            return super().open_and_closed(poses, label, n_seed)
        seed, state = self.read(poses[:, :n_seed], self.begin(label, poses.shape[1]))
        features = derivatives(poses, self.config.n_derivatives, restart=n_seed)
        rest, _ = self._read(features[:, n_seed:], state[1])
        return torch.cat([seed, rest], 1), self.continue_closed(
            seed[:, -1], self.switch(seed, state), poses.shape[1] - n_seed
        )

    def _drop(self, values: Tensor) -> Tensor:
        return dropout(values, self.config.dropout, self.training)
