"""Backpropagation through time by hand, for the Body RNN: less than two thirds of autograd's time.

Forward, the products are few and large, as they could be with autograd:

- an open and a closed loop share the steps before they part, and are one batch from there on;
- the guides enter by one product for all steps, which serves both loops.

Backward, this module does what autograd does not. Autograd accumulates the gradient of a weight step by step: 150 times
a product and a sum over the whole weight. Here, a step writes the gradients of its sums into its row of a matrix, and
the gradient of a weight is one product at the end, over the rows of all steps. Autograd also copies values together
before a product; here, a step's inputs and gates are neighbours in one row (`npss_baselines.models._rows`). Gradients
flow through the whole feedback: decoder, derivatives and dropout.

`benchmarks/test_training_speed.py` compares its speed with autograd's; the tests compare every entry of its Jacobian.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import torch
from torch import Tensor, nn
from torch.autograd.function import once_differentiable

from npss_baselines.models._rows import Columns, advance, retreat, weight_gradients
from npss_baselines.models.cells import Blocks


class Loop(NamedTuple):
    """The inputs of each step, for a batch of windows."""

    batch: int
    own: tuple[bool, ...]  # (T,): whether a step reads the previous prediction instead of the frame
    beside: bool  # whether, from the first such step on, a second stream reads the frames in open loop
    order: int  # of the derivatives
    step: int  # of the derivatives
    residual: bool  # whether the decoder predicts the difference from the input pose
    own_past: bool = False  # whether derivatives of predictions use predictions alone, and those of frames frames alone

    @property
    def n_shared(self) -> int:
        """The number of steps before the first one that reads a prediction."""
        return (*self.own, True).index(True)

    @property
    def first_past(self) -> int:
        """The first step whose derivatives are computed here: of all predictions, or of the inputs."""
        return max(self.n_shared - self.order * self.step, 0) if self.own_past else self.n_shared

    @property
    def n_streams(self) -> int:
        """The number of streams from then on."""
        return 2 if self.beside else 1

    @property
    def n_visits(self) -> int:
        """The number of batches of rows, over all streams."""
        return self.n_shared + self.n_streams * (len(self.own) - self.n_shared)

    def arrange(self, drawn: Tensor) -> Tensor:
        """Return the rows (R, ...) of values drawn (V, B, ...) for the steps of one stream, then of the other."""
        S, n = self.n_shared, self.n_streams
        streams = drawn[S:].view(n, len(self.own) - S, *drawn.shape[1:])
        return torch.cat([drawn[:S], streams.transpose(0, 1).flatten(0, 1)]).flatten(0, 1)

    def rows(self) -> list[slice]:
        """Return the rows of each step: a batch of each stream, the open one first."""
        ends = [0]
        for t in range(len(self.own)):
            ends.append(ends[-1] + self.batch * (self.n_streams if t >= self.n_shared else 1))
        return [slice(*ends[t : t + 2]) for t in range(len(self.own))]

    def spread(self, frames: Tensor) -> Tensor:
        """Return the rows (R, D) of frames (T, B, D), which a step repeats for each stream."""
        S, n = self.n_shared, self.n_streams
        return torch.cat([frames[:S].flatten(0, 1), frames[S:, None].expand(-1, n, -1, -1).flatten(0, 2)])

    def collect(self, rows: Tensor, out: Tensor) -> None:
        """Sum rows (R, D) over the streams into `out` (T, B, D): the backward pass of `spread`."""
        S, n = self.n_shared, self.n_streams
        out[:S] = rows[: S * self.batch].view(S, self.batch, -1)
        torch.sum(rows[S * self.batch :].view(-1, n, self.batch, rows.shape[1]), 1, out=out[S:])


class _Predictions(torch.autograd.Function):
    """The predictions (R, P) of a Body RNN, in the rows of its loop."""

    @staticmethod
    def forward(
        ctx: Any,
        loop: Loop,
        features: Tensor,
        factors: Tensor | None,
        guides: Tensor,
        guide: Tensor,
        guide_bias: Tensor,
        gates: Tensor,
        candidate: Tensor,
        candidate_bias: Tensor | None,
        decoder: Tensor,
        decoder_bias: Tensor,
    ) -> Tensor:
        (P, H), D = decoder.shape, features.shape[2]
        B, steps, at = loop.batch, loop.rows(), Columns(H, D, gates.shape[1] // H)
        read = loop.spread(features)
        rows, hidden = read.new_empty(len(read), at.h.stop), read.new_empty(len(read), H)
        poses = read.new_empty(len(read), P)
        plan = torch.addmm(guide_bias, guides.flatten(0, 1), guide).view(len(features), B, 3 * H)
        rows[:B, at.h].zero_()
        past: dict[int, Tensor] = {}  # the derivatives of earlier steps, by step
        decoder_t = decoder.t().contiguous()
        for t, step in enumerate(steps):
            row, out, x, pose = rows[step], hidden[step], read[step], poses[step]
            if t >= loop.first_past:
                if not (loop.own[t] or loop.own_past):
                    first = x[-B:, :P]
                else:  # the prediction of this frame; the first has none
                    first = poses[step.start - B : step.start] if t else torch.zeros_like(pose)
                kept = x[-B:] if loop.own[t] or not loop.own_past else torch.empty_like(x[-B:])
                _differentiate(first, past.pop(t - loop.step, None), kept)
                past[t] = kept
            elif t >= loop.n_shared - loop.step:
                past[t] = x[-B:]
            if factors is None:
                row[:, at.x] = x
            else:
                torch.mul(x, factors[step, :D], out=row[:, at.x])
            row[:, at.planned].view(-1, B, 3 * H)[:] = plan[t]
            if candidate_bias is not None:
                row[:, at.c] = candidate_bias
            advance(row, out, gates, candidate, at)
            if t + 1 < len(steps):
                rows[steps[t + 1], at.h].view(-1, len(out), H)[:] = out
            if factors is not None:
                out.mul_(factors[step, D:])
            torch.addmm(decoder_bias, out, decoder_t, out=pose)
            if loop.residual:
                pose += x[:, :P]
        ctx.loop = loop
        ctx.save_for_backward(rows, hidden, factors, guides, guide, gates, candidate, decoder)
        return poses

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, ...]:
        loop: Loop = ctx.loop
        rows, hidden, factors, guides, guide, gates, candidate, decoder = ctx.saved_tensors
        (P, H), B, steps = decoder.shape, loop.batch, loop.rows()
        n_gates, D = gates.shape[1] // H, len(gates) - H
        at = Columns(H, D, n_gates)
        d, d_poses = rows.new_empty(len(rows), at.rh.stop), grad.clone()
        gates_x, gates_h = torch.split(gates, [D, H])
        candidate_h, candidate_x = torch.split(candidate, [len(candidate) - D, D])
        gates_t, candidate_t = gates_h.t().contiguous(), candidate_h.t().contiguous()
        x_t = torch.cat([candidate_x.t(), gates_x.t()])  # from the gradients of the sums to the gradient of x
        d_read: dict[int, Tensor] = {}  # of the last stream, by step
        dh = rows.new_zeros(steps[-1].stop - steps[-1].start, H)
        for t in reversed(range(len(steps))):
            step = steps[t]
            d_pose, d_row = d_poses[step], d[step]
            d_out = d_pose @ decoder
            if factors is not None:
                d_out *= factors[step, D:]
            dh = d_out.add_(dh.view(-1, *d_out.shape).sum(0) if len(dh) > len(d_out) else dh)
            dh = retreat(dh, rows[step], d_row, gates_t, candidate_t, at)
            if t >= loop.first_past:
                if loop.own[t] or not loop.own_past:
                    dx = d_row[-B:, at.sums] @ x_t
                    if factors is not None:
                        dx *= factors[step, :D][-B:]
                else:  # this derivative is kept, not read
                    dx = rows.new_zeros(B, D)
                d_read[t] = dx
                _undifferentiate(dx, d_read.pop(t + loop.step, None), P)
                if t and (loop.own[t] or loop.own_past):
                    before = d_poses[step.start - B : step.start]
                    before += dx[:, :P]
                    if loop.own[t] and loop.residual:
                        before += d_pose[-B:]
        d_gates, d_candidate = weight_gradients(rows, d, at)
        d_candidate_bias = d[:, at.c].sum(0) if n_gates == 3 else None
        d_decoder, d_decoder_bias = d_poses.t() @ hidden, d_poses.sum(0)
        d_plan = rows.new_empty(len(guides), B, 3 * H)
        loop.collect(d[:, at.planned], d_plan)
        sums = d_plan.flatten(0, 1)
        d_guides = (sums @ guide.t()).view_as(guides)
        d_guide, d_guide_bias = guides.flatten(0, 1).t() @ sums, sums.sum(0)
        guide_gradients = d_guides, d_guide, d_guide_bias
        return None, None, None, *guide_gradients, d_gates, d_candidate, d_candidate_bias, d_decoder, d_decoder_bias


def _differentiate(pose: Tensor, past: Tensor | None, out: Tensor) -> None:
    """Write a pose (B, P) and its derivatives into `out` (B, D), given those of the frame `step` before, if any."""
    P = pose.shape[1]
    out[:, :P] = pose
    for k in range(P, out.shape[1], P):
        lower = slice(k - P, k)
        torch.sub(out[:, lower], 0 if past is None else past[:, lower], out=out[:, k : k + P])


def _undifferentiate(dx: Tensor, future: Tensor | None, P: int) -> None:
    """Backpropagate `_differentiate` in `dx` (B, D), given the gradient of the frame `step` after, if any."""
    if future is not None:
        dx[:, :-P] -= future[:, P:]
    for k in reversed(range(P, dx.shape[1], P)):
        dx[:, k - P : k] += dx[:, k : k + P]


def predictions(
    features: Tensor, guides: Tensor, cell: Blocks, decoder: nn.Linear, factors: Tensor | None, loop: Loop
) -> tuple[Tensor, Tensor]:
    """Return the predictions of a Body RNN whose first state is zero.

    Parameters
    ----------
    features : (T, B, D) Tensor
        Poses with derivatives, which get no gradient.
    guides : (T, B, P) Tensor
        The guide of each step.
    cell, decoder : Blocks, Linear
        The model.
    factors : (R, D + H) Tensor, optional
        Dropout factors of the inputs and of the decoder's inputs, in the rows of the loop.
    loop : Loop
        The inputs of each step.

    Returns
    -------
    shared : (S, B, 54) Tensor
        Predictions of the steps before the streams part.
    streams : (T - S, n, B, 54) Tensor
        Predictions of the later steps, for the n streams.
    """
    out: Tensor = _Predictions.apply(  # type: ignore[no-untyped-call]
        loop, features, factors, guides, *cell, decoder.weight, decoder.bias
    )
    n_shared, n_columns = loop.n_shared * loop.batch, out.shape[1]
    shared = out[:n_shared].view(-1, loop.batch, n_columns)
    return shared, out[n_shared:].view(-1, loop.n_streams, loop.batch, n_columns)
