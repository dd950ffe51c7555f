"""MBR: one GRU that reads the seed frames and then its output (Martinez, Black, Romero 2017)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from npss.validation import positive_integer
from npss_baselines.models._gru import read_gru
from npss_baselines.models.base import POSE, MotionModel
from npss_baselines.models.cells import GRUCell

#: h (B, H), and the label (B, A), or (B, 0) if it is not read.
MBRState = tuple[Tensor, Tensor]


@dataclass(frozen=True)
class MBRConfig:
    """Sizes and choices of MBR; the defaults are MBR-unsup.

    Parameters
    ----------
    size : int
        Units of the GRU.
    residual : bool
        Whether the decoder predicts the difference from the last frame: in MBR-unsup and MBR-sup, not in MBR-long.
    label : bool
        Whether the model also reads and predicts the action: in MBR-sup.
    """

    size: int = 1024
    residual: bool = True
    label: bool = False

    def __post_init__(self) -> None:
        positive_integer("size", self.size)
        for name in ("residual", "label"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"{name}: expected True or False, got {getattr(self, name)!r}")


class MBR(MotionModel):
    """The sequence-to-sequence model of Martinez et al., encoder and decoder tied.

    Tied, the two are one GRU: the encoder reads the seed frames except the last, and the decoder starts with the last.
    Its loss is of the decoder's outputs alone: the regime ``'sampling'`` of `npss_baselines.training.objectives`.

    With 54 columns in and out and one bias per gate, it has 3,370,038 parameters. Table 1 of the NPSS paper says
    3,425,334 for MBR-long: 54 x 1024 more, unexplained.

    The input and output of MBR-sup, including the residual, are the pose and the one-hot label. In closed loop it reads
    its predicted label, as in the released code; `step` and `read` use the true one. Only the regime ``'sampling'``
    measures the label: in open loop, the label's rows of the decoder have no gradient.

    Weights start as in the released code: kernels by Glorot's uniform rule, biases 1 for the gates and 0 for the
    candidate, the decoder uniform within 0.04.

    Parameters
    ----------
    config : MBRConfig
        Sizes and choices.
    n_actions : int
        Width of the label; published: 15 for MBR-sup.

    References
    ----------
    J. Martinez, M. J. Black, J. Romero, "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.
    """

    def __init__(self, config: MBRConfig, n_actions: int) -> None:
        super().__init__(n_actions)
        self.residual, self.label = config.residual, config.label
        width = POSE + (n_actions if config.label else 0)
        self.cell = GRUCell(width, config.size)
        self.decoder = nn.Linear(config.size, width)
        for kernel in (self.cell.gates, self.cell.candidate):
            nn.init.xavier_uniform_(kernel)
        nn.init.ones_(self.cell.gates_bias)
        nn.init.zeros_(self.cell.candidate_bias)
        for parameter in self.decoder.parameters():
            nn.init.uniform_(parameter, -0.04, 0.04)

    def begin(self, label: Tensor, n_steps: int) -> MBRState:
        """Return the initial state."""
        return label.new_zeros(len(label), self.cell.n_units), label if self.label else label[:, :0]

    def step(self, pose: Tensor, state: MBRState) -> tuple[Tensor, MBRState]:
        """Read a frame, with the true label."""
        h, label = state
        output, h = self._step(torch.cat([pose, label], 1), h)
        return output[:, :POSE], (h, label)

    def read(self, poses: Tensor, state: MBRState) -> tuple[Tensor, MBRState]:
        """Read frames, with the true label."""
        outputs, h = self._read(self.labelled(poses, state[1]), state[0])
        return outputs[..., :POSE], (h, state[1])

    def continue_closed(self, pose: Tensor, state: MBRState, n: int) -> Tensor:
        """Return n predictions in closed loop after a pose, which is read with the true label."""
        h, label = state
        return self._continue(torch.cat([pose, label], 1), h, n)[..., :POSE]

    def predict(self, seed_frames: Tensor, label: Tensor, n: int) -> Tensor:
        """Predict the n frames after the seed frames."""
        return self.predict_labelled(seed_frames, label, n)[..., :POSE]

    def predict_labelled(self, seed_frames: Tensor, label: Tensor, n: int) -> Tensor:
        """Predict poses and labels (B, n, 54 + A) of the n frames after the seed frames; A is 0 without labels."""
        h, label = self.begin(label, seed_frames.shape[1] + n - 1)
        outputs, h = self._read(self.labelled(seed_frames, label), h)
        first = outputs[:, -1]
        return torch.cat([first[:, None], self._continue(first, h, n - 1)], 1)

    def labelled(self, poses: Tensor, label: Tensor) -> Tensor:
        """Return poses and labels (B, T, 54 + A) of frames with the same label; A is 0 without labels."""
        if not self.label:
            return poses
        return torch.cat([poses, label[:, None].expand(-1, poses.shape[1], -1)], 2)

    def _step(self, frame: Tensor, h: Tensor) -> tuple[Tensor, Tensor]:
        h = self.cell(frame, h)
        return self._decode(frame, h), h

    def _read(self, frames: Tensor, h: Tensor) -> tuple[Tensor, Tensor]:
        hidden, h = read_gru(self.cell, frames, h)
        return self._decode(frames, hidden), h

    def _continue(self, frame: Tensor, h: Tensor, n: int) -> Tensor:
        outputs = [frame[:, None][:, :0]]
        for _ in range(n):
            frame, h = self._step(frame, h)
            outputs.append(frame[:, None])
        return torch.cat(outputs, 1)

    def _decode(self, frames: Tensor, hidden: Tensor) -> Tensor:
        decoded: Tensor = self.decoder(hidden)
        return frames + decoded if self.residual else decoded
