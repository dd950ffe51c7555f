"""Training recipes: each layer alone, then all layers together."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from npss.validation import is_integer, is_real, one_of, positive_integer, positive_number

OPTIMIZERS = ("adam", "sgd")
LR_SCHEDULES = ("epochs", "cosine")
PLACES = ("even", "random")


@dataclass(frozen=True)
class Stage:
    """The settings of a training stage.

    Parameters
    ----------
    epochs : int
        Passes over the windows, each in a new random order; 0 skips the stage.
    batch : int
        Windows in a batch.
    optimizer : {'adam', 'sgd'}
        Optimiser: adam, or sgd without momentum.
    lr : float
        Initial learning rate.
    lr_schedule : {'epochs', 'cosine'}
        Learning-rate schedule: epochs multiplies by `lr_decay` after each epoch; cosine falls from `lr` to zero along
        half a cosine.
    lr_decay : float
        Factor after each epoch, at most 1.
    clip_norm : float or None
        Largest norm of the gradient.
    corruption : float
        Probability that an input value is set to zero; the target is the uncorrupted input.
    rescale : bool
        Whether the remaining values are divided by 1 - `corruption`. If not, the layers learn to compensate for the
        average loss, and uncorrupted motion is reconstructed too large by that factor.
    structured : bool
        Whether windows are instead corrupted as applications do, by
        `npss_baselines.manifold.applications.corrupt.structured`; lost values are zero. Then `corruption` must be 0.
    sparsity : float
        Weight of the magnitudes of the hidden units in the loss.
    unpool : {'even', 'random'}
        Unpooling: even, as the network is configured; or random.

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message begins with its name.
    """

    epochs: int = 25
    batch: int = 1
    optimizer: str = "sgd"
    lr: float = 0.5
    lr_schedule: str = "epochs"
    lr_decay: float = 1.0
    clip_norm: float | None = None
    corruption: float = 0.1
    rescale: bool = False
    structured: bool = False
    sparsity: float = 0.0
    unpool: str = "even"

    def __post_init__(self) -> None:
        if not is_integer(self.epochs):
            raise TypeError(f"epochs: expected a whole number, got {self.epochs!r}")
        if self.epochs < 0:
            raise ValueError(f"epochs: expected 0 or more, got {self.epochs}")
        positive_integer("batch", self.batch)
        one_of("optimizer", self.optimizer, OPTIMIZERS)
        positive_number("lr", self.lr)
        one_of("lr_schedule", self.lr_schedule, LR_SCHEDULES)
        if positive_number("lr_decay", self.lr_decay) > 1:
            raise ValueError(f"lr_decay: expected a factor of at most 1, got {self.lr_decay!r}")
        if self.clip_norm is not None:
            positive_number("clip_norm", self.clip_norm)
        for name in ("corruption", "sparsity"):
            value = getattr(self, name)
            if not is_real(value):
                raise TypeError(f"{name}: expected a number, got {value!r}")
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name}: expected a number of at least 0, got {value!r}")
        if self.corruption >= 1:
            raise ValueError(f"corruption: expected a probability below 1, got {self.corruption!r}")
        for name in ("rescale", "structured"):
            if not isinstance(getattr(self, name), bool):
                raise TypeError(f"{name}: expected true or false, got {getattr(self, name)!r}")
        if self.structured and (self.corruption or self.rescale):
            raise ValueError("structured: it needs corruption 0 and no rescale, since windows are already corrupted")
        one_of("unpool", self.unpool, PLACES)

    def learning_rate(self, epoch: int, share: float = 0.0) -> float:
        """Return the learning rate in an epoch, counted from 0, after a share of it.

        Examples
        --------
        >>> Stage(lr=0.5, lr_decay=0.5).learning_rate(2)
        0.125
        >>> Stage(epochs=2, lr=0.5, lr_schedule="cosine").learning_rate(1)
        0.25
        """
        if self.lr_schedule == "cosine":
            return self.lr * (1 + math.cos(math.pi * (epoch + share) / self.epochs)) / 2
        return self.lr * self.lr_decay**epoch


@dataclass(frozen=True)
class Recipe:
    """All training settings.

    Parameters
    ----------
    scale : {'none', 'global', 'kind', 'feature'}
        Features that share a scale: see `npss_baselines.manifold.motion.scaling`.
    size : float
        Standard deviation of scaled features, or their factor for ``'none'``.
    loss : {'mean', 'sum'}
        Reduction of the squared errors in a window, and of the magnitudes of its hidden units.
    unpool : {'both', 'half'}
        Even unpooling: see `npss_baselines.manifold.model.autoencoder`.
    start : {'glorot', 'orthonormal'}
        Initial weights: see `npss_baselines.manifold.model.initialization`.
    layers : Stage
        Training of each layer alone, from the first on.
    whole : Stage
        Training of all layers together, afterwards.
    """

    scale: str
    size: float
    loss: str
    unpool: str
    start: str
    layers: Stage
    whole: Stage


#: The paper's schedule. Where the paper is silent: the error is a mean, since training with a sum diverges at once;
#: features are in body heights and radians, since training with unit variance diverges too; even unpooling halves, as
#: random unpooling does on average; fine-tuning takes 25 epochs, at a constant rate and on corrupted windows.
PAPER = Recipe(
    scale="none",
    size=1.0,
    loss="mean",
    unpool="half",
    start="glorot",
    layers=Stage(lr=0.5, lr_decay=0.9, sparsity=0.01, unpool="random"),
    whole=Stage(lr=0.01),
)
_LAYERS = Stage(epochs=20, batch=8, optimizer="adam", lr=5e-4, lr_schedule="cosine", clip_norm=0.005, rescale=True)
#: The settings that reconstruct best on the validation subjects. Features are small enough for tanh to be nearly
#: linear: where it is not, atanh amplifies the errors of the layer above. The initial weights already reconstruct
#: motion; a small rate, and clipping the gradient, which has outliers, to its usual norm keep Adam from leaving them in
#: a few steps. Layers come first, since a step of one layer takes less time than one of all.
DEFAULT = Recipe(
    scale="kind",
    size=0.1,
    loss="mean",
    unpool="both",
    start="orthonormal",
    layers=_LAYERS,
    whole=replace(_LAYERS, epochs=30, lr=2e-4),
)
#: The default, whose layers then learn together to restore what applications lose: the mask is known when they are
#: applied, so that projection and known values can take turns.
STRUCTURED = replace(
    DEFAULT, whole=replace(_LAYERS, epochs=30, lr=3e-4, clip_norm=0.05, corruption=0.0, rescale=False, structured=True)
)
RECIPES = {"default": DEFAULT, "paper": PAPER, "structured": STRUCTURED}
