"""The base class of models: a module that reads poses and predicts the next one."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn

#: Columns of a normalised pose (`npss.protocol.COLUMNS`).
POSE = 54

#: A model's state between frames: nested tuples of tensors whose first axis is the batch.
State = Any


class MotionModel(nn.Module, ABC):
    """A model of motion, one frame at a time.

    Frames are numbered from 0, the first input. Step t reads frame t and predicts frame t + 1.

    Parameters
    ----------
    n_actions : int
        Width of the label; for a model of a single action, 1, and the label is always 1.
    """

    def __init__(self, n_actions: int) -> None:
        super().__init__()
        self.n_actions = n_actions

    @abstractmethod
    def begin(self, label: Tensor, n_steps: int) -> State:
        """Return the initial state.

        Parameters
        ----------
        label : (B, A) Tensor
            The action, one-hot.
        n_steps : int
            Number of steps to come; some models plan them all.
        """

    @abstractmethod
    def step(self, pose: Tensor, state: State) -> tuple[Tensor, State]:
        """Read a frame (B, 54); return the prediction of the next frame (B, 54) and the new state."""

    def read(self, poses: Tensor, state: State) -> tuple[Tensor, State]:
        """Read frames (B, T, 54); return the prediction after each (B, T, 54) and the last state.

        The result equals that of T steps; models override it to be faster.
        """
        predictions = []
        for pose in poses.unbind(1):
            prediction, state = self.step(pose, state)
            predictions.append(prediction)
        return torch.stack(predictions, 1), state

    def switch(self, outputs: Tensor, state: State) -> State:
        """Return the initial state of the closed loop, from the state after the seed and its predictions (B, S, 54).

        By default, it is the state after the seed.
        """
        return state

    def switch_back(self, frames: Tensor, state: State) -> State:
        """Return the initial state of an open loop, from the state after a closed one and all frames (B, T, 54) so far.

        By default, it is the state after the closed loop.
        """
        return state

    def continue_closed(self, pose: Tensor, state: State, n: int) -> Tensor:
        """Return n predictions (B, n, 54) in closed loop after a pose (B, 54): each is the next input."""
        predictions = []
        for _ in range(n):
            pose, state = self.step(pose, state)
            predictions.append(pose)
        return torch.stack(predictions, 1)

    def predict(self, seed_frames: Tensor, label: Tensor, n: int) -> Tensor:
        """Predict the n frames (B, n, 54) after the seed frames (B, S, 54)."""
        read, state = self.read(seed_frames, self.begin(label, seed_frames.shape[1] + n - 1))
        first = read[:, -1]
        if n == 1:
            return first[:, None]
        closed = self.continue_closed(first, self.switch(read, state), n - 1)
        return torch.cat([first[:, None], closed], 1)

    def open_and_closed(self, poses: Tensor, label: Tensor, n_seed: int) -> tuple[Tensor, Tensor]:
        """Return the open-loop predictions after every frame, and the closed-loop predictions after the seed.

        Both share the pass over the seed frames and its random numbers.

        Parameters
        ----------
        poses : (B, T, 54) Tensor
            Inputs of the open loop.
        label : (B, A) Tensor
            The action.
        n_seed : int
            Number of seed frames. The closed loop reads the prediction after them, and makes T - n_seed steps.

        Returns
        -------
        opened : (B, T, 54) Tensor
            Predictions of frames 1 to T.
        closed : (B, T - n_seed, 54) Tensor
            Predictions of frames n_seed + 1 to T, each from the previous one.
        """
        seed, state = self.read(poses[:, :n_seed], self.begin(label, poses.shape[1]))
        rest, _ = self.read(poses[:, n_seed:], state)
        closed = self.continue_closed(seed[:, -1], self.switch(seed, state), poses.shape[1] - n_seed)
        return torch.cat([seed, rest], 1), closed

    def mixed(self, poses: Tensor, label: Tensor, own: Sequence[bool]) -> Tensor:
        """Return the prediction after every step, some of which read the previous prediction: auto-conditioning.

        Parameters
        ----------
        poses : (B, T, 54) Tensor
            The frames.
        label : (B, A) Tensor
            The action.
        own : sequence of bool
            For each of the T steps, whether it reads the previous prediction instead of the frame; the first is False.

        Returns
        -------
        (B, T, 54) Tensor
            Predictions of frames 1 to T.
        """
        if len(own) != poses.shape[1] or own[0]:
            raise ValueError(f"own: expected {poses.shape[1]} flags, the first of them False, got {list(own)}")
        state, predictions, frames = self.begin(label, len(own)), [poses[:, 0]], iter(poses.unbind(1))
        for feed_back, block in itertools.groupby(own):
            true = list(itertools.islice(frames, len(list(block))))
            n_before = len(predictions) - 1
            if not feed_back:
                before = self.switch_back(poses[:, :n_before], state) if n_before else state
                read, state = self.read(torch.stack(true, 1), before)
                predictions += read.unbind(1)
                continue
            state = self.switch(torch.stack(predictions[1:], 1), state)
            for _ in true:
                prediction, state = self.step(predictions[-1], state)
                predictions.append(prediction)
        return torch.stack(predictions[1:], 1)
