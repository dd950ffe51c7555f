"""A GRU layer over many frames: one product for all inputs, then a loop over frames."""

from __future__ import annotations

import torch
from torch import Tensor

from npss_baselines.models.cells import GRUCell


def read_gru(cell: GRUCell, inputs: Tensor, h: Tensor) -> tuple[Tensor, Tensor]:
    """Return the outputs (B, T, H) and the last state (B, H), like T calls of the cell.

    Parameters
    ----------
    cell : GRUCell
        The cell.
    inputs : (B, T, D) Tensor
        The inputs.
    h : (B, H) Tensor
        The initial state.
    """
    n = cell.n_inputs
    gate_inputs = torch.addmm(cell.gates_bias, inputs.flatten(0, 1), cell.gates[:n])  # (B T, 2 H)
    candidate_inputs = torch.addmm(cell.candidate_bias, inputs.flatten(0, 1), cell.candidate[:n])  # (B T, H)
    recurrent_gates, recurrent_candidate = cell.gates[n:], cell.candidate[n:]  # (H, 2 H), (H, H)
    outputs = []
    shape = inputs.shape[:2]
    for gates, candidate in zip(
        gate_inputs.view(*shape, -1).unbind(1), candidate_inputs.view(*shape, -1).unbind(1), strict=True
    ):
        u, r = torch.sigmoid(torch.addmm(gates, h, recurrent_gates)).chunk(2, 1)
        c = torch.tanh(torch.addmm(candidate, r * h, recurrent_candidate))
        h = torch.lerp(c, h, u)
        outputs.append(h)
    return torch.stack(outputs, 1), h
