"""The VTLN-RNN of the NPSS paper: from noise and the action, a top RNN makes guides for a Body RNN."""

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
    """Options of the VTLN-RNN; the defaults are VGRU-d as released, except for the last two.

    Where the paper and the released code differ, `text` follows the paper and `code` the code.

    Attributes
    ----------
    n_units : int
        Units of each RNN.
    cell : {'code', 'text'}
        Cell of the Body RNN: code for `CodeCell`; text for equations 1 to 4, a `GRUCell` that reads the input and the
        guide.
    noise : {'code', 'text'}
        Scale of the noise: the top RNN starts with mu + sigma * eps, eps ~ N(0, 1). For code, sigma is
        sqrt(softplus(s)); for text, it is the "covariance matrix" itself, softplus(s).
    top_rnn : bool
        Whether to use a top RNN; without it, the Body RNN has no guides and no noise.
    n_guides : int
        Minimum number of steps of the top RNN, K in the paper: the seed and target frames of a training window. It
        takes more if more frames are read or predicted.
    n_derivatives : int
        Motion derivatives that the Body RNN reads beside the pose, 0 to 3.
    derivative_step : int
        Step of a difference, in frames.
    residual : bool
        Whether the decoder predicts the difference from the input pose.
    dropout : float
        Dropout probability, in training, of the Body RNN's input and of the decoder's input. In the text, only VGRU-r1
        has dropout.
    restart_derivatives : bool
        Whether to reproduce a mistake of the released code: in `open_and_closed`, the second and higher derivatives of
        the open loop after the seed take the seed frames as zeros.
    own_past : bool
        Whether derivatives of predictions use predictions alone, including those of the seed frames, and derivatives of
        frames use frames alone, as in the released code. By default, derivatives are of the inputs, which mix frames
        and predictions where one follows the other.
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


#: The long-term model as released.
VGRU_D = VTLNConfig()
#: The short-term model of 50 + 10 frames as released. In the text, it reads derivatives: n_derivatives=3.
VGRU_R1 = VTLNConfig(n_guides=60, n_derivatives=0, residual=True)
#: VGRU-d, but trained by auto-conditioning.
VGRU_AC = VGRU_D


class VTLNState(NamedTuple):
    """The state of the model between frames."""

    h: Tensor  # (B, H): the Body RNN's state
    past: Tensor  # (B, n_derivatives * derivative_step, 54): the last poses read
    guides: Tensor  # (B, K, H): the guides of the steps to come


class VTLN(MotionModel):
    """The VTLN-RNN: top RNN, Body RNN and linear decoder.

    The top RNN reads the label at each of its K steps. Its states, in reverse order, guide the Body RNN. Its initial
    state is drawn for every sequence, not only in training: predictions are samples. All random numbers come from
    torch's global generator.

    As in the released code, kernels start orthogonal and biases at 0.1; the decoder, mu and s start from Glorot's
    uniform distribution.

    Parameters
    ----------
    config : VTLNConfig
        The options of the model.
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
        """Draw the guides of `n_steps` steps; return them with the Body RNN's initial state."""
        zeros = self.decoder.weight.new_zeros
        h = zeros(len(label), self.config.n_units)
        past = zeros(len(label), self.config.n_derivatives * self.config.derivative_step, POSE)
        return VTLNState(h, past, self._guides(label, n_steps).transpose(0, 1))

    def step(self, pose: Tensor, state: VTLNState) -> tuple[Tensor, VTLNState]:
        """Read a frame; return the prediction of the next frame and the new state."""
        if not state.guides.shape[1]:
            raise ValueError("n_steps: more steps than in the call of `begin`")
        order, step = self.config.n_derivatives, self.config.derivative_step
        x, past = next_derivatives(pose, state.past, order, step=step)  # (B, D)
        prediction, h = self._predict(x, state.h, state.guides[:, 0])
        return prediction, VTLNState(h, past, state.guides[:, 1:])

    def _predict(self, x: Tensor, h: Tensor, guide: Tensor) -> tuple[Tensor, Tensor]:
        """Read a pose with its derivatives (B, D); return the prediction (B, 54) and the Body RNN's new state."""
        pose, factors = x[:, :POSE], self._dropout(len(x))
        if factors is not None:
            x = x * factors[:, : self.n_inputs]
        h = self.body(x, h, guide)  # (B, H)
        out = h if factors is None else h * factors[:, self.n_inputs :]
        return self.decoder(out) + pose if self.config.residual else self.decoder(out), h

    def switch(self, outputs: Tensor, state: VTLNState) -> VTLNState:
        """Return the initial state of the closed loop."""
        if not self.config.own_past:
            return state
        past = own_past(outputs, self.config.n_derivatives, step=self.config.derivative_step)
        return state._replace(past=past)

    def switch_back(self, frames: Tensor, state: VTLNState) -> VTLNState:
        """Return the initial state of an open loop after a closed one."""
        if not self.config.own_past:
            return state
        past = past_of(frames, self.config.n_derivatives, step=self.config.derivative_step)
        return state._replace(past=past)

    def open_and_closed(self, poses: Tensor, label: Tensor, n_seed: int) -> tuple[Tensor, Tensor]:
        """Return the open-loop predictions after every frame, and the closed-loop predictions after the seed.

        In training, both loops are one batch, backpropagated by hand (`npss_baselines.models._bptt`): the same numbers,
        faster. Without gradients, or with gradients of the poses, it goes step by step.
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
        """Do the same as `MotionModel.mixed`; in training, as fast as `open_and_closed`."""
        if not torch.is_grad_enabled() or poses.requires_grad:
            return super().mixed(poses, label, own)
        if len(own) != poses.shape[1] or own[0]:
            raise ValueError(f"own: expected {poses.shape[1]} flags, the first of them False, got {list(own)}")
        first, rest = self._unroll(poses, label, tuple(own), beside=False)
        return torch.cat([first, rest[:, 0]]).transpose(0, 1)

    def _unroll(self, poses: Tensor, label: Tensor, own: tuple[bool, ...], *, beside: bool) -> tuple[Tensor, Tensor]:
        """Return the predictions (S, B, 54) before the first step that reads one, and (T - S, n, B, 54) from it on.

        n is 2 if an open loop continues beside the closed one, else 1.
        """
        batch, n_frames, _ = poses.shape
        order, step = self.config.n_derivatives, self.config.derivative_step
        loop = _bptt.Loop(batch, own, beside, order, step, self.config.residual, self.config.own_past)
        features = self._features(poses, loop.n_shared if beside else None).transpose(0, 1)  # (T, B, D)
        guides = self._guides(label, n_frames)[:n_frames]  # (T, B, H)
        factors = self._dropout(batch, loop.n_visits, loop.arrange)
        return _bptt.predictions(features, guides, self.body.blocks(self.n_guide), self.decoder, factors, loop)

    def _features(self, poses: Tensor, n_seed: int | None) -> Tensor:
        """Return the open loop's inputs (B, T, D), if the closed loop starts after `n_seed` frames."""
        order, step = self.config.n_derivatives, self.config.derivative_step
        restart = n_seed if self.config.restart_derivatives else None
        return derivatives(poses, order, step=step, restart=restart)

    def _guides(self, label: Tensor, n_steps: int) -> Tensor:
        """Draw the guides (K, B, H) of at least `n_steps` steps."""
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
        """Draw the dropout factors of the input and hidden state, (n B, D + H), for n steps; None if all are 1.

        Steps are drawn one after another, so that the number of calls does not matter; `arrange` reorders the values
        drawn, (n, B, D + H).
        """
        p, n_columns, like = self.config.dropout, self.n_inputs + self.config.n_units, self.decoder.weight
        if not (self.training and p):
            return None
        # Four values from each random word of 64 bits, several times faster than one each: p is exact to 2**-17.
        words = torch.empty(n, batch, (n_columns + 3) // 4, dtype=torch.int64, device=like.device)
        mask = words.random_(-(2**63), None).view(torch.int16)[..., :n_columns] >= round(p * 2**16) - 2**15
        rows = mask.flatten(0, 1) if arrange is None else arrange(mask)
        return rows.to(like.dtype).mul_(1 / (1 - p))


def _glorot(n: int) -> nn.Parameter:
    """Return a vector drawn from Glorot's uniform distribution for n inputs and n outputs."""
    return nn.Parameter(nn.init.uniform_(torch.empty(n), -math.sqrt(3 / n), math.sqrt(3 / n)))
