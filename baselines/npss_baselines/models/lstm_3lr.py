"""LSTM-3LR: three LSTM layers and a linear decoder (Fragkiadaki et al. 2015)."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor, nn

from npss.validation import positive_integer
from npss_baselines.models._lstm import LSTM, LSTMState
from npss_baselines.models.base import POSE, MotionModel


@dataclass(frozen=True)
class LSTM3LRConfig:
    """Sizes of LSTM-3LR. The published ones have 20,282,054 parameters, as Table 1 of the NPSS paper says.

    Parameters
    ----------
    size : int
        Units of a layer.
    n_layers : int
        Number of layers.
    """

    size: int = 1000
    n_layers: int = 3

    def __post_init__(self) -> None:
        positive_integer("size", self.size)
        positive_integer("n_layers", self.n_layers)


class LSTM3LR(MotionModel):
    """LSTM-3LR. It predicts the pose itself, without a residual, and ignores the label.

    Parameters
    ----------
    config : LSTM3LRConfig
        The sizes.
    n_actions : int
        Width of the label.

    References
    ----------
    K. Fragkiadaki et al., "Recurrent Network Models for Human Dynamics", ICCV 2015.
    """

    def __init__(self, config: LSTM3LRConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.lstm = LSTM(POSE, config.size, config.n_layers)
        self.decoder = nn.Linear(config.size, POSE)

    def begin(self, label: Tensor, n_steps: int) -> LSTMState:
        """Return the initial state, zeros."""
        return self.lstm.begin(label, len(label))

    def step(self, pose: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Read a frame."""
        prediction, state = self.read(pose[:, None], state)
        return prediction[:, 0], state

    def read(self, poses: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Read frames at once."""
        hidden, state = self.lstm(poses, state)  # (B, T, H)
        return self.decoder(hidden), state  # (B, T, 54)
