"""ERD: LSTM layers between a feed-forward encoder and decoder (Fragkiadaki et al. 2015)."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor, nn

from npss.validation import positive_integer
from npss_baselines.models._lstm import LSTM, LSTMState
from npss_baselines.models.base import POSE, MotionModel


@dataclass(frozen=True)
class ERDConfig:
    """Sizes of ERD. The published ones have 14,842,054 parameters, as Table 1 of the NPSS paper says.

    Parameters
    ----------
    fc : int
        Units of the encoder's two layers and of the decoder's first layer.
    size : int
        Units of an LSTM layer.
    n_layers : int
        Number of LSTM layers.
    fc_last : int
        Units of the decoder's second layer.
    """

    fc: int = 500
    size: int = 1000
    n_layers: int = 2
    fc_last: int = 100

    def __post_init__(self) -> None:
        for name in ("fc", "size", "n_layers", "fc_last"):
            positive_integer(name, getattr(self, name))


class ERD(MotionModel):
    """The encoder-recurrent-decoder. It predicts the pose itself and ignores the label.

    The encoder's second layer and the decoder's last are linear; the others are rectified.

    Parameters
    ----------
    config : ERDConfig
        The sizes.
    n_actions : int
        Width of the label.

    References
    ----------
    K. Fragkiadaki et al., "Recurrent Network Models for Human Dynamics", ICCV 2015.
    """

    def __init__(self, config: ERDConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.encoder = nn.Sequential(nn.Linear(POSE, config.fc), nn.ReLU(), nn.Linear(config.fc, config.fc))
        self.lstm = LSTM(config.fc, config.size, config.n_layers)
        self.decoder = nn.Sequential(
            nn.Linear(config.size, config.fc),
            nn.ReLU(),
            nn.Linear(config.fc, config.fc_last),
            nn.ReLU(),
            nn.Linear(config.fc_last, POSE),
        )

    def begin(self, label: Tensor, n_steps: int) -> LSTMState:
        """Return the initial state, zeros."""
        return self.lstm.begin(label, len(label))

    def step(self, pose: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Read a frame."""
        prediction, state = self.read(pose[:, None], state)
        return prediction[:, 0], state

    def read(self, poses: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Read frames at once."""
        hidden, state = self.lstm(self.encoder(poses), state)  # (B, T, fc) -> (B, T, H)
        return self.decoder(hidden), state  # (B, T, 54)
