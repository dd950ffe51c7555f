"""The forward and backward step of a recurrent cell, by hand, for `npss_baselines.models._bptt`.

A step reads and writes one row, [c, u, r, g, r * h, x, h], so that both products of a cell read and write neighbours,
and nothing is copied. Parameters are cut into `Blocks`.
"""

from __future__ import annotations

import torch
from torch import Tensor

aten = torch.ops.aten


class Columns:
    """The columns of the row of a cell with H units, D inputs and 2 gates, or 3 with g."""

    def __init__(self, H: int, D: int, n_gates: int) -> None:
        self.c, self.u, self.r = slice(H), slice(H, 2 * H), slice(2 * H, 3 * H)
        self.gates = slice(H, (1 + n_gates) * H)  # u, r, g
        self.sums = slice((1 + n_gates) * H)  # c, u, r, g
        self.planned = slice((n_gates - 2) * H, (n_gates + 1) * H)  # sums that a static input adds to
        self.rh = slice((1 + n_gates) * H, (2 + n_gates) * H)
        self.grh = slice(3 * H, (2 + n_gates) * H)  # g, r * h
        self.x = slice((2 + n_gates) * H, (2 + n_gates) * H + D)
        self.grhx = slice(3 * H, self.x.stop)  # g, r * h, x: the inputs of the candidate
        self.h = slice(self.x.stop, self.x.stop + H)
        self.xh = slice(self.x.start, self.h.stop)  # x, h: the inputs of the gates


def advance(row: Tensor, out: Tensor, gates: Tensor, candidate: Tensor, at: Columns) -> None:
    """Step forward: from x, h and the planned part of the sums, fill in the row and write the new h to `out`."""
    row[:, at.gates].addmm_(row[:, at.xh], gates).sigmoid_()
    torch.mul(row[:, at.r], row[:, at.h], out=row[:, at.rh])
    c = row[:, at.c].addmm_(row[:, at.grhx], candidate).tanh_()
    torch.lerp(c, row[:, at.h], row[:, at.u], out=out)


def retreat(dh: Tensor, row: Tensor, d: Tensor, gates: Tensor, candidate: Tensor, at: Columns) -> Tensor:
    """Step backward: from the gradient of the new h, write those of the sums to `d`, and return that of h.

    `gates` and `candidate` are transposed here, without the rows for x.
    """
    c, h, dc, drh, dgates = row[:, at.c], row[:, at.h], d[:, at.c], d[:, at.rh], d[:, at.gates]
    back = dh * row[:, at.u]
    aten.tanh_backward.grad_input(dh - back, c, grad_input=dc)
    torch.sub(h, c, out=d[:, at.u]).mul_(dh)
    torch.mm(dc, candidate, out=d[:, at.grh])
    torch.mul(drh, h, out=d[:, at.r])
    aten.sigmoid_backward.grad_input(dgates, row[:, at.gates], grad_input=dgates)
    return back.addcmul_(drh, row[:, at.r]).addmm_(dgates, gates)


def weight_gradients(rows: Tensor, d: Tensor, at: Columns) -> tuple[Tensor, Tensor]:
    """Return the gradients of `gates` and `candidate`, from the rows and the gradients of the sums of all steps."""
    return rows[:, at.xh].t() @ d[:, at.gates], rows[:, at.grhx].t() @ d[:, at.c]
