"""Recipes: the hyperparameters of training, and their schedules."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from npss import CONVENTIONS
from npss.validation import each, is_integer, is_real, one_of, positive_integer, positive_number

#: Training objectives: see `npss_baselines.training.objectives`.
REGIMES = ("eq6", "open", "sampling", "noise", "auto-conditioning")
OPTIMIZERS = ("rmsprop-tf", "adam", "sgd")
LR_SCHEDULES = ("steps", "cosine")

#: Pairs of an iteration and the value from it on; zero before the first.
Schedule = tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Recipe:
    """The hyperparameters of training.

    Parameters
    ----------
    regime : {'eq6', 'open', 'sampling', 'noise', 'auto-conditioning'}
        Training objective: eq6, open, sampling, noise or auto-conditioning, of `npss_baselines.training.objectives`.
    iterations : int
        Number of batches to train on.
    batch : int
        Windows in a batch.
    n_seed : int
        Number of seed frames.
    n_target : int
        Number of target frames. A window has one frame more than both.
    optimizer : {'rmsprop-tf', 'adam', 'sgd'}
        Optimiser: rmsprop-tf (`npss_baselines.training.rmsprop.RMSpropTF`), adam or sgd.
    momentum : float
        Momentum of rmsprop-tf and sgd; adam ignores it.
    lr : float
        Initial learning rate.
    lr_schedule : {'steps', 'cosine'}
        Learning-rate schedule: steps multiplies by `lr_decay` at each of `lr_milestones`; cosine falls from `lr` to
        zero along half a cosine.
    lr_decay : float
        Factor at each milestone, at most 1.
    lr_milestones : tuple of int
        Iterations of the steps, in ascending order.
    clip_norm : float or None
        Largest global norm of the gradient, to which it is clipped; None (null in JSON) for no clipping.
    closed_weight : tuple of (int, float)
        Lambda of equation 6 by iteration: the weight of the closed loop (regime eq6).
    noise_std : tuple of (int, float)
        Standard deviation of the noise by iteration, in units of the normalised pose (regime noise).
    conditioning : int
        Frames in a block (regime auto-conditioning).
    npss_weight : float
        Weight in the loss of the NPSS of the predicted frames.
    npss_convention : {'paper', 'released', 'literal'}
        Convention of NPSS in the loss: paper, released or literal.

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message starts with its name.

    Examples
    --------
    >>> recipe = Recipe(lr=2e-4, lr_decay=0.6, lr_milestones=(2000, 4000), closed_weight=((500, 0.2),))
    >>> recipe.learning_rate(1999), recipe.learning_rate(2000)
    (0.0002, 0.00012)
    >>> recipe.compressed(1000).lr_milestones
    (200, 400)
    >>> recipe.compressed(1000).lambda_at(49), recipe.compressed(1000).lambda_at(50)
    (0.0, 0.2)
    """

    regime: str = "eq6"
    iterations: int = 10_000
    batch: int = 32
    n_seed: int = 50
    n_target: int = 100
    optimizer: str = "rmsprop-tf"
    momentum: float = 0.95
    lr: float = 2e-4
    lr_schedule: str = "steps"
    lr_decay: float = 1.0
    lr_milestones: tuple[int, ...] = ()
    clip_norm: float | None = 1.0
    closed_weight: Schedule = ()
    noise_std: Schedule = ()
    conditioning: int = 5
    npss_weight: float = 0.0
    npss_convention: str = "paper"

    def __post_init__(self) -> None:
        one_of("regime", self.regime, REGIMES)
        one_of("optimizer", self.optimizer, OPTIMIZERS)
        one_of("lr_schedule", self.lr_schedule, LR_SCHEDULES)
        for name in ("iterations", "batch", "n_seed", "n_target", "conditioning"):
            positive_integer(name, getattr(self, name))
        positive_number("lr", self.lr)
        if positive_number("lr_decay", self.lr_decay) > 1:
            raise ValueError(f"lr_decay: expected a factor of at most 1, got {self.lr_decay!r}")
        if _number("momentum", self.momentum) >= 1:
            raise ValueError(f"momentum: expected a number below 1, got {self.momentum!r}")
        if self.clip_norm is not None:
            positive_number("clip_norm", self.clip_norm)
        # JSON has lists for tuples.
        object.__setattr__(self, "lr_milestones", _iterations("lr_milestones", self.lr_milestones))
        for name in ("closed_weight", "noise_std"):
            object.__setattr__(self, name, _schedule(name, getattr(self, name)))
        one_of("npss_convention", self.npss_convention, tuple(CONVENTIONS))
        if _number("npss_weight", self.npss_weight) > 0 and self.n_target < 2:
            raise ValueError("npss_weight: NPSS needs two target frames or more, n_target is 1")

    @property
    def window(self) -> int:
        """Frames of a training window: seed frames, target frames, and the target of the last step."""
        return self.n_seed + self.n_target + 1

    def learning_rate(self, iteration: int) -> float:
        """Return the learning rate of an iteration, counted from 0."""
        if self.lr_schedule == "cosine":
            return self.lr * (1 + math.cos(math.pi * min(iteration / self.iterations, 1))) / 2
        return self.lr * self.lr_decay ** sum(milestone <= iteration for milestone in self.lr_milestones)

    def lambda_at(self, iteration: int) -> float:
        """Return the weight of the closed loop in an iteration."""
        return _value(self.closed_weight, iteration)

    def noise_at(self, iteration: int) -> float:
        """Return the standard deviation of the noise in an iteration."""
        return _value(self.noise_std, iteration)

    def phase(self, iteration: int) -> tuple[float, float]:
        """Return the scheduled values that the loss depends on: while they stay the same, so does the computation."""
        return self.lambda_at(iteration), self.noise_at(iteration)

    def work(self, iteration: int) -> float:
        """Estimate the computation of an iteration, in forward frames.

        The backward pass takes twice as long as the forward pass. With ``'eq6'``, early iterations are faster: the
        closed loop has no backward pass while its weight is zero.
        """
        opened = 3.0 * (self.n_seed + self.n_target)
        if self.regime != "eq6":
            return opened
        return opened + (3.0 if self.lambda_at(iteration) > 0 else 1.0) * self.n_target

    def compressed(self, iterations: int) -> Recipe:
        """Return the recipe for a number of iterations, with all schedules in proportion."""
        positive_integer("iterations", iterations)

        def scaled(iteration: int) -> int:
            return round(iteration * iterations / self.iterations)

        return replace(
            self,
            iterations=iterations,
            lr_milestones=tuple(scaled(milestone) for milestone in self.lr_milestones),
            closed_weight=tuple((scaled(start), value) for start, value in self.closed_weight),
            noise_std=tuple((scaled(start), value) for start, value in self.noise_std),
        )


def _value(schedule: Schedule, iteration: int) -> float:
    """Return the value of a schedule in an iteration."""
    return next((value for start, value in reversed(schedule) if start <= iteration), 0.0)


def _number(name: str, value: object) -> float:
    """Check a finite number that is not negative."""
    if not is_real(value):
        raise TypeError(f"{name}: expected a number, got {value!r}")
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{name}: expected a finite number that is not negative, got {value!r}")
    return float(value)


def _iterations(name: str, values: Iterable[Any]) -> tuple[int, ...]:
    """Check ascending iterations; in a compressed recipe, several may be equal."""
    iterations = each(name, values, "iterations")
    for iteration in iterations:
        if not is_integer(iteration):
            raise TypeError(f"{name}: expected whole numbers of iterations, got {iteration!r}")
    if any(iteration < 0 for iteration in iterations) or iterations != sorted(iterations):
        raise ValueError(f"{name}: expected iterations from 0 on, in ascending order, got {iterations}")
    return tuple(iterations)


def _schedule(name: str, values: Iterable[Any]) -> Schedule:
    """Check pairs of an iteration and a value."""
    steps = [each(f"{name}[{i}]", step) for i, step in enumerate(each(name, values, "pairs"))]
    for i, step in enumerate(steps):
        if len(step) != 2:
            raise ValueError(f"{name}[{i}]: expected a pair of an iteration and a value, got {step}")
    starts = _iterations(name, [step[0] for step in steps])
    return tuple((start, _number(name, step[1])) for start, step in zip(starts, steps, strict=True))
