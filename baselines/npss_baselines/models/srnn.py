"""S-RNN: an LSTM per kind of body part, and one per kind of pair of parts (Jain et al. 2016)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from npss.protocol import COLUMNS
from npss.validation import positive_integer
from npss_baselines.models._lstm import LSTM, LSTMState
from npss_baselines.models.base import POSE, MotionModel

#: h and c, (B, I, H) each for I parts, of the edges torso-arm, torso-leg, arm-arm, leg-leg and nodes torso, arm, leg.
SRNNState = tuple[LSTMState, ...]


def _columns(*ranges: range) -> list[int]:
    """Return the indices, among the 54 columns, of those in ranges of the 99."""
    return [i for i, column in enumerate(COLUMNS) if any(column in part for part in ranges)]


TORSO = _columns(range(6), range(36, 51))  # 18, including the root
ARMS = [_columns(range(51, 75)), _columns(range(75, 99))]  # left and right, 10 each
LEGS = [_columns(range(21, 36)), _columns(range(6, 21))]  # left and right, 8 each


@dataclass(frozen=True)
class SRNNConfig:
    """Sizes of S-RNN; the defaults are the published ones.

    Parameters
    ----------
    fc : int
        Units of the layers before the LSTMs, and of the first layer after a node's LSTM.
    edge, node : int
        Units of an edge's and of a node's LSTM.
    fc_last : int
        Units of the last layer but one.
    full_width : bool
        Whether inputs and outputs of every part have all 54 columns, the others being zero and unused: 18,362,390
        parameters instead of 18,285,152. Table 1 of the NPSS paper says 18,368,534, which is neither.
    """

    fc: int = 256
    edge: int = 512
    node: int = 512
    fc_last: int = 100
    full_width: bool = False

    def __post_init__(self) -> None:
        for name in ("fc", "edge", "node", "fc_last"):
            positive_integer(name, getattr(self, name))
        if not isinstance(self.full_width, bool):
            raise TypeError(f"full_width: expected True or False, got {self.full_width!r}")


class SRNN(MotionModel):
    """S-RNN. It predicts the pose itself and ignores the label.

    The body is a graph: torso, two arms, two legs; edges torso-arm, torso-leg, arm-arm and leg-leg. Parts of a kind
    share weights, and so do edges. Each part has an RNN per kind of edge, which reads both ends; at the torso, with two
    edges of a kind, it reads their sum, as in the released code. The part's node RNN reads the part and the outputs
    of its edges.

    Parameters
    ----------
    config : SRNNConfig
        The sizes.
    n_actions : int
        Width of the label.

    References
    ----------
    A. Jain et al., "Structural-RNN: Deep Learning on Spatio-Temporal Graphs", CVPR 2016.
    """

    order: Tensor
    place: Tensor
    masks: Tensor

    def __init__(self, config: SRNNConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.full_width = config.full_width
        torso, arm, leg = (POSE,) * 3 if config.full_width else (len(TORSO), len(ARMS[0]), len(LEGS[0]))

        def edge(*ends: int) -> _Edge:
            return _Edge(POSE if config.full_width else sum(ends), config)

        self.torso_arm, self.torso_leg = edge(torso, arm), edge(torso, leg)
        self.arm_arm, self.leg_leg = edge(arm, arm), edge(leg, leg)
        self.torso, self.arm, self.leg = _Node(torso, config), _Node(arm, config), _Node(leg, config)
        parts = [TORSO, *ARMS, *LEGS]
        order = torch.tensor([column for part in parts for column in part])
        masks = torch.zeros(len(parts), 1, POSE)
        for mask, part in zip(masks, parts, strict=True):
            mask[:, part] = 1
        self.register_buffer("order", order, persistent=False)  # (54,), the columns sorted by part
        self.register_buffer(
            "place", torch.argsort(order), persistent=False
        )  # (54,), the place of each column in that order
        self.register_buffer("masks", masks, persistent=False)  # (5, 1, 54)

    def begin(self, label: Tensor, n_steps: int) -> SRNNState:
        """Return the initial state, zeros."""
        edges = ((self.torso_arm, 3), (self.torso_leg, 3), (self.arm_arm, 2), (self.leg_leg, 2))
        parts = ((self.torso, 1), (self.arm, 2), (self.leg, 2))
        return tuple(rnn.lstm.begin(label, len(label), n) for rnn, n in (*edges, *parts))

    def step(self, pose: Tensor, state: SRNNState) -> tuple[Tensor, SRNNState]:
        """Read a frame."""
        prediction, state = self.read(pose[:, None], state)
        return prediction[:, 0], state

    def read(self, poses: Tensor, state: SRNNState) -> tuple[Tensor, SRNNState]:
        """Read frames at once."""
        torso, arms, legs = self._split(poses)  # (B, 1, T, 18), (B, 2, T, 10), (B, 2, T, 8)
        torso_arm, s0 = self.torso_arm(self._at_torso_and_limbs(torso, arms), state[0])  # (B, 3, T, E)
        torso_leg, s1 = self.torso_leg(self._at_torso_and_limbs(torso, legs), state[1])  # (B, 3, T, E)
        arm_arm, s2 = self.arm_arm(self._join(arms, arms.flip(1)), state[2])  # (B, 2, T, E)
        leg_leg, s3 = self.leg_leg(self._join(legs, legs.flip(1)), state[3])  # (B, 2, T, E)
        torso, s4 = self.torso(torso, torso_arm[:, :1], torso_leg[:, :1], state[4])  # (B, 1, T, 18)
        arms, s5 = self.arm(arms, torso_arm[:, 1:], arm_arm, state[5])  # (B, 2, T, 10)
        legs, s6 = self.leg(legs, torso_leg[:, 1:], leg_leg, state[6])  # (B, 2, T, 8)
        return self._assemble(torso, arms, legs), (s0, s1, s2, s3, s4, s5, s6)

    def _split(self, poses: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return torso, arms and legs: (B, I, T, columns)."""
        if self.full_width:
            parts = poses[:, None] * self.masks  # (B, 5, T, 54)
            return parts[:, :1], parts[:, 1:3], parts[:, 3:]
        columns = torch.split(poses[..., self.order], [len(TORSO), *map(len, ARMS), *map(len, LEGS)], -1)
        return columns[0][:, None], torch.stack(columns[1:3], 1), torch.stack(columns[3:], 1)

    def _assemble(self, torso: Tensor, arms: Tensor, legs: Tensor) -> Tensor:
        """Return poses (B, T, 54) of the parts."""
        if self.full_width:
            return (torch.cat([torso, arms, legs], 1) * self.masks).sum(1)
        return torch.cat([torso[:, 0], *arms.unbind(1), *legs.unbind(1)], -1)[..., self.place]

    def _join(self, first: Tensor, second: Tensor) -> Tensor:
        """Return the inputs of edges between parts."""
        return first + second if self.full_width else torch.cat([first, second], -1)

    def _at_torso_and_limbs(self, torso: Tensor, limbs: Tensor) -> Tensor:
        """Return the inputs of the edges between the torso and its limbs: at the torso, then at each limb."""
        edges = self._join(torso.expand(-1, 2, -1, -1), limbs)
        return torch.cat([edges.sum(1, keepdim=True), edges], 1)


class _PartLSTM(LSTM):
    """An LSTM layer that several parts share."""

    def begin(self, like: Tensor, n: int, n_parts: int = 1) -> LSTMState:
        zeros = like.new_zeros(n, n_parts, self.layers.hidden_size)
        return zeros, zeros

    def forward(self, inputs: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        """Return the outputs (B, I, T, H) for inputs (B, I, T, F), and the new state."""
        shape = inputs.shape[:2]
        rows = tuple(part.reshape(-1, 1, part.shape[-1]) for part in state)  # (B I, 1, H)
        outputs, (h, c) = super().forward(inputs.flatten(0, 1), (rows[0], rows[1]))
        return outputs.reshape(*shape, *outputs.shape[1:]), (h.reshape(*shape, -1), c.reshape(*shape, -1))


class _Edge(nn.Module):
    def __init__(self, n_in: int, config: SRNNConfig) -> None:
        super().__init__()
        self.encoder = _encoder(n_in, config.fc)
        self.lstm = _PartLSTM(config.fc, config.edge)

    def forward(self, ends: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        result: tuple[Tensor, LSTMState] = self.lstm(self.encoder(ends), state)
        return result


class _Node(nn.Module):
    def __init__(self, n_in: int, config: SRNNConfig) -> None:
        super().__init__()
        self.encoder = _encoder(n_in, config.fc)
        self.lstm = _PartLSTM(config.fc + 2 * config.edge, config.node)
        self.decoder = nn.Sequential(
            nn.Linear(config.node, config.fc),
            nn.ReLU(),
            nn.Linear(config.fc, config.fc_last),
            nn.ReLU(),
            nn.Linear(config.fc_last, n_in),
        )

    def forward(self, part: Tensor, first: Tensor, second: Tensor, state: LSTMState) -> tuple[Tensor, LSTMState]:
        hidden, state = self.lstm(torch.cat([self.encoder(part), first, second], -1), state)
        return self.decoder(hidden), state


def _encoder(n_in: int, fc: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(n_in, fc), nn.ReLU(), nn.Linear(fc, fc))
