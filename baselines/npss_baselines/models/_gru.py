"""A GRU layer that reads many frames: the inputs of all of them in one product, then one frame after another."""

from __future__ import annotations

import torch
from torch import Tensor

from npss_baselines.models.cells import GRUCell


def read_gru(cell: GRUCell, inputs: Tensor, h: Tensor) -> tuple[Tensor, Tensor]:
    """Return the outputs (B, T, H) and the last state (B, H): the same as the cell called T times.

    Parameters
    ----------
    cell : GRUCell
        The cell.
    inputs : (B, T, D) Tensor
        Its inputs.
    h : (B, H) Tensor
        The state before the first one.
    """
    n = cell.n_inputs
    of_gates = torch.addmm(cell.gates_bias, inputs.flatten(0, 1), cell.gates[:n])  # (B T, 2 H)
    of_candidate = torch.addmm(cell.candidate_bias, inputs.flatten(0, 1), cell.candidate[:n])  # (B T, H)
    recurrent_gates, recurrent_candidate = cell.gates[n:], cell.candidate[n:]  # (H, 2 H), (H, H)
    outputs = []
    shape = inputs.shape[:2]
    for gates, candidate in zip(
        of_gates.view(*shape, -1).unbind(1), of_candidate.view(*shape, -1).unbind(1), strict=True
    ):
        u, r = torch.sigmoid(torch.addmm(gates, h, recurrent_gates)).chunk(2, 1)
        c = torch.tanh(torch.addmm(candidate, r * h, recurrent_candidate))
        h = torch.lerp(c, h, u)
        outputs.append(h)
    return torch.stack(outputs, 1), h
