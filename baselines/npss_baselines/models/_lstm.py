"""LSTM layers with one bias per gate, whose state has the batch first."""

from __future__ import annotations

from torch import Tensor, nn

#: Of a stack of LSTM layers: h and c, (B, L, H) each.
LSTMState = tuple[Tensor, Tensor]


class LSTM(nn.Module):
    """A stack of `torch.nn.LSTM` layers.

    torch gives each gate two biases, of which only the sum matters. The second is zero here and is not trained: the
    papers' layers have one, and so do their parameter counts. Weights start as torch's do, uniformly within
    1 / sqrt(size).

    Parameters
    ----------
    n_in : int
        Width of the input.
    size : int
        Units of a layer.
    n_layers : int, optional
        How many layers, each reading the one before.
    """

    def __init__(self, n_in: int, size: int, n_layers: int = 1) -> None:
        super().__init__()
        self.layers = nn.LSTM(n_in, size, n_layers, batch_first=True)
        for name, bias in self.layers.named_parameters():
            if name.startswith("bias_hh"):
                nn.init.zeros_(bias).requires_grad_(False)

    def begin(self, like: Tensor, n: int) -> LSTMState:
        """Return the state of n sequences before the first frame, zeros of the kind of another tensor."""
        zeros = like.new_zeros(n, self.layers.num_layers, self.layers.hidden_size)
        return zeros, zeros

    def forward(self, inputs: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Read frames (B, T, I), and return the outputs (B, T, H) and the new state."""
        h, c = (part.transpose(0, 1).contiguous() for part in state)  # (L, B, H), as torch has it
        outputs, (h, c) = self.layers(inputs, (h, c))
        return outputs, (h.transpose(0, 1), c.transpose(0, 1))
