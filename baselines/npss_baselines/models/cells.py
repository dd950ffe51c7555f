"""Recurrent cells: the original GRU, and the NPSS paper's Body cell as printed and as coded.

A kernel is multiplied from the left by the concatenated row vectors in brackets.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn


class Blocks(NamedTuple):
    """The parameters of a cell with H units and g gates, cut for `npss_baselines.models._bptt`.

    One product, the plan, computes the static input's part of the sums for all steps.
    """

    plan: Tensor  # (P, 3 H): from the static input to the sums of candidate, u, r; with a gate g, of u, r, g
    plan_bias: Tensor  # (3 H,)
    gates: Tensor  # (D + H, g H): from [x, h] to u, r, g
    candidate: Tensor  # ((g - 1) H + D, H): from [g, r * h, x]
    candidate_bias: Tensor | None  # (H,); None if in the plan


def kernel(n_rows: int, n_columns: int) -> nn.Parameter:
    """Return an orthogonal matrix, the initial value in the paper's released code."""
    return nn.Parameter(nn.init.orthogonal_(torch.empty(n_rows, n_columns)))


def bias(n: int) -> nn.Parameter:
    """Return biases of 0.1, the initial value in the paper's released code."""
    return nn.Parameter(torch.full((n,), 0.1))


class GRUCell(nn.Module):
    """The original GRU: the reset gate multiplies h before the product, and each gate has one bias.

    ::

        u, r = s([x, h] W + b)
        c = tanh([x, r * h] W_c + b_c)
        h' = u * h + (1 - u) * c

    With [x, p] for x, where p is a guide, this is the Body cell of equations 1 to 4 of the NPSS paper (`text`).

    Parameters
    ----------
    n_inputs : int
        Width of x, including the guide.
    n_units : int
        Width of h.

    References
    ----------
    K. Cho et al., "Learning Phrase Representations using RNN Encoder-Decoder for Statistical Machine Translation",
    EMNLP 2014.
    """

    def __init__(self, n_inputs: int, n_units: int) -> None:
        super().__init__()
        self.n_inputs, self.n_units = n_inputs, n_units
        self.gates, self.gates_bias = kernel(n_inputs + n_units, 2 * n_units), bias(2 * n_units)
        self.candidate, self.candidate_bias = kernel(n_inputs + n_units, n_units), bias(n_units)

    def forward(self, x: Tensor, h: Tensor, p: Tensor | None = None) -> Tensor:
        """Return the state (B, H) after h, from an input (B, D) and an optional guide (B, P)."""
        if p is not None:
            x = torch.cat([x, p], 1)
        u, r = torch.sigmoid(torch.addmm(self.gates_bias, torch.cat([x, h], 1), self.gates)).chunk(2, 1)
        c = torch.tanh(torch.addmm(self.candidate_bias, torch.cat([x, r * h], 1), self.candidate))
        return u * h + (1 - u) * c

    def blocks(self, n_static: int) -> Blocks:
        """Cut the parameters; the last inputs are static."""
        parts = [self.n_inputs - n_static, n_static, self.n_units]
        gates_x, gates_p, gates_h = torch.split(self.gates, parts)
        candidate_x, candidate_p, candidate_h = torch.split(self.candidate, parts)
        return Blocks(
            plan=torch.cat([candidate_p, gates_p], 1),
            plan_bias=torch.cat([self.candidate_bias, self.gates_bias]),
            gates=torch.cat([gates_x, gates_h]),
            candidate=torch.cat([candidate_h, candidate_x]),
            candidate_bias=None,
        )


class CodeCell(nn.Module):
    """The Body cell of the NPSS paper's released code (`code`): the guide has a gate.

    ::

        u, r, g = s([x, h, p] W + b)
        c = tanh([x, r * h, g] W_c + b_c)
        h' = u * h + (1 - u) * c

    Parameters
    ----------
    n_inputs, n_guides, n_units : int
        Widths of x, p and h.
    """

    def __init__(self, n_inputs: int, n_guides: int, n_units: int) -> None:
        super().__init__()
        self.n_inputs, self.n_units = n_inputs, n_units
        self.gates, self.gates_bias = kernel(n_inputs + n_units + n_guides, 3 * n_units), bias(3 * n_units)
        self.candidate, self.candidate_bias = kernel(n_inputs + 2 * n_units, n_units), bias(n_units)

    def forward(self, x: Tensor, h: Tensor, p: Tensor) -> Tensor:
        """Return the state (B, H) after h, from an input (B, D) and a guide (B, P)."""
        u, r, g = torch.sigmoid(torch.addmm(self.gates_bias, torch.cat([x, h, p], 1), self.gates)).chunk(3, 1)
        c = torch.tanh(torch.addmm(self.candidate_bias, torch.cat([x, r * h, g], 1), self.candidate))
        return u * h + (1 - u) * c

    def blocks(self, n_static: int) -> Blocks:
        """Cut the parameters; the guide is static."""
        gates_xh, gates_p = torch.split(self.gates, [self.n_inputs + self.n_units, n_static])
        candidate_x, candidate_h, candidate_g = torch.split(self.candidate, [self.n_inputs, self.n_units, self.n_units])
        return Blocks(
            plan=gates_p,
            plan_bias=self.gates_bias,
            gates=gates_xh,
            candidate=torch.cat([candidate_g, candidate_h, candidate_x]),
            candidate_bias=self.candidate_bias,
        )
