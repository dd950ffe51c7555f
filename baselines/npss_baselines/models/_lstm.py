"""LSTM layers with one bias per gate and a batch-first state."""

from __future__ import annotations

from torch import Tensor, nn

#: State of a stack of LSTM layers: h and c, (B, L, H) each.
LSTMState = tuple[Tensor, Tensor]


class LSTM(nn.Module):
    """A stack of `torch.nn.LSTM` layers.

    torch gives each gate two biases, of which only the sum matters. Here, the second is zero and is not trained: the
    papers' layers, and their parameter counts, have one. Weights start as in torch, uniform within 1 / sqrt(size).

    Parameters
    ----------
    n_in : int
        Width of the input.
    size : int
        Units of a layer.
    n_layers : int, optional
        Number of layers; each reads the previous one.
    """

    def __init__(self, n_in: int, size: int, n_layers: int = 1) -> None:
        super().__init__()
        self.layers = nn.LSTM(n_in, size, n_layers, batch_first=True)
        for name, bias in self.layers.named_parameters():
            if name.startswith("bias_hh"):
                nn.init.zeros_(bias).requires_grad_(False)

    def begin(self, like: Tensor, n: int) -> LSTMState:
        """Return the initial state of n sequences: zeros with the type and device of `like`."""
        zeros = like.new_zeros(n, self.layers.num_layers, self.layers.hidden_size)
        return zeros, zeros

    def forward(self, inputs: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Return the outputs (B, T, H) for frames (B, T, I), and the new state."""
        h, c = (part.transpose(0, 1).contiguous() for part in state)  # (L, B, H), torch's layout
        outputs, (h, c) = self.layers(inputs, (h, c))
        return outputs, (h.transpose(0, 1), c.transpose(0, 1))
