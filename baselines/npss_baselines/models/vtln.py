"""VTLN-RNN of the NPSS paper: a top RNN plans, from noise and the action, what a Body RNN then does frame by frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from npss.validation import is_integer, is_real, one_of, positive_integer
from npss_baselines.models import _bptt
from npss_baselines.models.base import POSE, MotionModel
from npss_baselines.models.cells import CodeCell, GRUCell
from npss_baselines.models.derivatives import derivatives, next_derivatives, own_past, past_of


@dataclass(frozen=True)
class VTLNConfig:
    """A member of the family; the defaults are VGRU-d as its authors released it, but for the last two.

    Where the paper and the released code differ, `text` is what the paper says and `code` what the code does.

    Attributes
    ----------
    n_units : int
        Units of either RNN.
    cell : {'code', 'text'}
        The Body RNN's: `CodeCell`, or equations 1 to 4, which are `GRUCell` with the guide beside its input.
    noise : {'code', 'text'}
        The top RNN begins with mu + sigma * eps, eps ~ N(0, 1). By the code sigma is sqrt(softplus(s)). By the text it
        is the "covariance matrix" itself, so softplus(s).
    top_rnn : bool
        Whether there is one; without, nothing guides the Body RNN, and nothing is drawn.
    n_guides : int
        How many steps the top RNN makes at least, K of the paper: seed and target frames of a training window. It makes
        more where more frames are to be read or predicted.
    n_derivatives : int
        Backward differences, 0 to 3, that the Body RNN reads beside the pose.
    derivative_step : int
        Frames between the two of which a difference is taken.
    residual : bool
        Whether the decoder predicts the difference from the pose that is read.
    dropout : float
        Probability, in training, for the Body RNN's input, and for its state where the decoder reads it. The text has
        it in VGRU-r1 only.
    restart_derivatives : bool
        Whether, in the open loop of `open_and_closed`, differences above the first take all frames before the closed
        loop begins for zeros: a mistake of the code.
    own_past : bool
        Whether differences in closed loop are those of the model's own predictions alone, of frames that it has read,
        too, and those of frames are of frames alone; as in the released code. By default they are of what was read:
        where the one follows the other, of frames and predictions.
    """

    n_units: int = 512
    cell: str = "code"
    noise: str = "code"
    top_rnn: bool = True
    n_guides: int = 150
    n_derivatives: int = 3
    derivative_step: int = 1
    residual: bool = False
    dropout: float = 0.3
    restart_derivatives: bool = False
    own_past: bool = False

    def __post_init__(self) -> None:
        for name in ("n_units", "n_guides", "derivative_step"):
            positive_integer(name, getattr(self, name))
        for name in ("cell", "noise"):
            one_of(name, getattr(self, name), ("code", "text"))
        for name in ("top_rnn", "residual", "restart_derivatives", "own_past"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"{name}: expected True or False, got {getattr(self, name)!r}")
        if not is_integer(self.n_derivatives) or not 0 <= self.n_derivatives <= 3:
            raise ValueError(f"n_derivatives: expected 0, 1, 2 or 3, got {self.n_derivatives!r}")
        if not is_real(self.dropout) or not 0 <= self.dropout < 1:
            raise ValueError(f"dropout: expected a probability below 1, got {self.dropout!r}")


#: The long-term model, as released.
VGRU_D = VTLNConfig()
#: The short-term model, of 50 + 10 frames, as released. By the text it reads derivatives: n_derivatives=3.
VGRU_R1 = VTLNConfig(n_guides=60, n_derivatives=0, residual=True)
#: The same as VGRU-d; it is trained by auto-conditioning.
VGRU_AC = VGRU_D


class VTLNState(NamedTuple):
    """What the model remembers between frames."""

    h: Tensor  # (B, H): the Body RNN's state
    past: Tensor  # (B, n_derivatives * derivative_step, 54): the last poses that it has read
    guides: Tensor  # (B, K, H): those of the steps to come


class VTLN(MotionModel):
    """Top RNN, Body RNN and linear decoder.

    The top RNN reads the label at each of its K steps. Its states, the last one first, guide the Body RNN. Its first
    state is drawn for each sequence whenever one begins, not only in training: predictions are samples. All
    randomness is that of torch's global generator.

    Kernels begin orthogonal and biases at 0.1, and the decoder, mu and s by Glorot's uniform distribution, as in the
    released code.

    Parameters
    ----------
    config : VTLNConfig
        Which member of the family.
    n_actions : int
        Width of the label.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019.
    """

    def __init__(self, config: VTLNConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.config, n_units = config, config.n_units
        self.n_inputs, self.n_guide = POSE * (config.n_derivatives + 1), n_units if config.top_rnn else 0
        if config.top_rnn:
            self.mu, self.s = _glorot(n_units), _glorot(n_units)
            self.top = GRUCell(n_actions, n_units)
        self.body: GRUCell | CodeCell
        if config.cell == "code":
            self.body = CodeCell(self.n_inputs, self.n_guide, n_units)
        else:
            self.body = GRUCell(self.n_inputs + self.n_guide, n_units)
        self.decoder = nn.Linear(n_units, POSE)
        nn.init.xavier_uniform_(self.decoder.weight)
        self.decoder.bias = _glorot(POSE)

    def begin(self, label: Tensor, n_steps: int) -> VTLNState:
        """Draw the guides of so many steps, and return them with a Body RNN that has read nothing."""
        zeros = self.decoder.weight.new_zeros
        h = zeros(len(label), self.config.n_units)
        past = zeros(len(label), self.config.n_derivatives * self.config.derivative_step, POSE)
        return VTLNState(h, past, self._guides(label, n_steps).transpose(0, 1))

    def step(self, pose: Tensor, state: VTLNState) -> tuple[Tensor, VTLNState]:
        """Read a frame, and return the prediction of the next one and the new state."""
        if not state.guides.shape[1]:
            raise ValueError("n_steps: there are more steps than `begin` was told")
        order, step = self.config.n_derivatives, self.config.derivative_step
        x, past = next_derivatives(pose, state.past, order, step=step)  # (B, D)
        prediction, h = self._predict(x, state.h, state.guides[:, 0])
        return prediction, VTLNState(h, past, state.guides[:, 1:])

    def _predict(self, x: Tensor, h: Tensor, guide: Tensor) -> tuple[Tensor, Tensor]:
        """Read a pose with its differences (B, D); return the prediction (B, 54) and the Body RNN's new state."""
        pose, factors = x[:, :POSE], self._dropout(len(x))
        if factors is not None:
            x = x * factors[:, : self.n_inputs]
        h = self.body(x, h, guide)  # (B, H)
        out = h if factors is None else h * factors[:, self.n_inputs :]
        return self.decoder(out) + pose if self.config.residual else self.decoder(out), h

    def switch(self, outputs: Tensor, state: VTLNState) -> VTLNState:
        """Return the state in which the closed loop begins."""
        if not self.config.own_past:
            return state
        past = own_past(outputs, self.config.n_derivatives, step=self.config.derivative_step)
        return state._replace(past=past)

    def switch_back(self, frames: Tensor, state: VTLNState) -> VTLNState:
        """Return the state in which an open loop begins after a closed one."""
        if not self.config.own_past:
            return state
        past = past_of(frames, self.config.n_derivatives, step=self.config.derivative_step)
        return state._replace(past=past)

    def open_and_closed(self, poses: Tensor, label: Tensor, n_seed: int) -> tuple[Tensor, Tensor]:
        """Return the predictions after every frame, and those that follow the seed in closed loop.

        In training both loops are one batch, which is backpropagated by hand (`npss_baselines.models._bptt`): the same
        numbers as step by step, and faster. It goes step by step where no gradient is wanted, or one of the poses.
        """
        n_frames = poses.shape[1]
        if not 0 < n_seed < n_frames:
            raise ValueError(f"n_seed: expected 1 to {n_frames - 1} of {n_frames} frames, got {n_seed!r}")
        if torch.is_grad_enabled() and not poses.requires_grad:
            own = (False,) * n_seed + (True,) * (n_frames - n_seed)
            seed, rest = self._unroll(poses, label, own, beside=True)
            return torch.cat([seed, rest[:, 0]]).transpose(0, 1), rest[:, 1].transpose(0, 1)
        first, state = self.read(poses[:, :n_seed], self.begin(label, n_frames))
        features, h, opened = self._features(poses, n_seed), state.h, []
        for t in range(n_seed, n_frames):
            prediction, h = self._predict(features[:, t], h, state.guides[:, t - n_seed])
            opened.append(prediction)
        closed = self.continue_closed(first[:, -1], self.switch(first, state), n_frames - n_seed)
        return torch.cat([first, torch.stack(opened, 1)], 1), closed

    def mixed(self, poses: Tensor, label: Tensor, own: Sequence[bool]) -> Tensor:
        """Do what `MotionModel.mixed` does, in training as fast as `open_and_closed`."""
        if not torch.is_grad_enabled() or poses.requires_grad:
            return super().mixed(poses, label, own)
        if len(own) != poses.shape[1] or own[0]:
            raise ValueError(f"own: expected {poses.shape[1]} flags, the first of them False, got {list(own)}")
        first, rest = self._unroll(poses, label, tuple(own), beside=False)
        return torch.cat([first, rest[:, 0]]).transpose(0, 1)

    def _unroll(self, poses: Tensor, label: Tensor, own: tuple[bool, ...], *, beside: bool) -> tuple[Tensor, Tensor]:
        """Return the predictions (S, B, 54) of the steps before the first own one, and (T - S, n, B, 54) of the others.

        There are n = 2 streams if an open loop goes on beside the closed one.
        """
        batch, n_frames, _ = poses.shape
        order, step = self.config.n_derivatives, self.config.derivative_step
        loop = _bptt.Loop(batch, own, beside, order, step, self.config.residual, self.config.own_past)
        features = self._features(poses, loop.n_shared if beside else None).transpose(0, 1)  # (T, B, D)
        guides = self._guides(label, n_frames)[:n_frames]  # (T, B, H)
        factors = self._dropout(batch, loop.n_visits, loop.arrange)
        return _bptt.predictions(features, guides, self.body.blocks(self.n_guide), self.decoder, factors, loop)

    def _features(self, poses: Tensor, n_seed: int | None) -> Tensor:
        """Return what is read (B, T, D) in open loop, of which the closed loop begins after so many frames."""
        order, step = self.config.n_derivatives, self.config.derivative_step
        restart = n_seed if self.config.restart_derivatives else None
        return derivatives(poses, order, step=step, restart=restart)

    def _guides(self, label: Tensor, n_steps: int) -> Tensor:
        """Draw the guides (K, B, H) of as many steps, or more."""
        if label.shape[1:] != (self.n_actions,):
            raise ValueError(f"label: expected shape (B, {self.n_actions}), got {tuple(label.shape)}")
        n = max(n_steps, self.config.n_guides)
        if not self.config.top_rnn:
            return label.new_zeros(n, len(label), 0)
        sigma = functional.softplus(self.s)
        if self.config.noise == "code":
            sigma = sigma.sqrt()
        h = self.mu + sigma * sigma.new_empty(len(label), len(sigma)).normal_()  # (B, H)
        states = []
        for _ in range(n):
            h = self.top(label, h)
            states.append(h)
        return torch.stack(states[::-1])

    def _dropout(self, batch: int, n: int = 1, arrange: Callable[[Tensor], Tensor] | None = None) -> Tensor | None:
        """Draw what dropout multiplies a step's input and hidden state by, (n B, D + H), of n steps; None if by 1.

        Steps are drawn one after another, so that it does not matter in how many calls. What is drawn, (n, B, D + H),
        can then be arranged otherwise.
        """
        p, n_columns, like = self.config.dropout, self.n_inputs + self.config.n_units, self.decoder.weight
        if not (self.training and p):
            return None
        # Four from each random word of 64 bits, several times faster than a draw for each: p is exact to 2**-17.
        words = torch.empty(n, batch, (n_columns + 3) // 4, dtype=torch.int64, device=like.device)
        kept = words.random_(-(2**63), None).view(torch.int16)[..., :n_columns] >= round(p * 2**16) - 2**15
        rows = kept.flatten(0, 1) if arrange is None else arrange(kept)
        return rows.to(like.dtype).mul_(1 / (1 - p))


def _glorot(n: int) -> nn.Parameter:
    """Return a vector drawn from Glorot's uniform distribution for n inputs and n outputs."""
    return nn.Parameter(nn.init.uniform_(torch.empty(n), -math.sqrt(3 / n), math.sqrt(3 / n)))
