"""How the manifold is trained: layer after layer, and then as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from npss.validation import is_integer, is_real, one_of, positive_integer, positive_number

OPTIMIZERS = ("adam", "sgd")
LR_SCHEDULES = ("epochs", "cosine")
PLACES = ("even", "random")


@dataclass(frozen=True)
class Stage:
    """How layers are trained.

    Parameters
    ----------
    epochs : int
        Passes over the windows, each in another order; 0 leaves the stage out.
    batch : int
        Windows of which the loss is the mean.
    optimizer : {'adam', 'sgd'}
        SGD without momentum.
    lr : float
        The learning rate at first.
    lr_schedule : {'epochs', 'cosine'}
        Multiplied by `lr_decay` after each epoch. Or half a cosine, from `lr` down to zero.
    lr_decay : float
        The factor, not above 1.
    clip_norm : float or None
        The gradient's norm is not allowed to be larger.
    corruption : float
        Probability with which a value of the input is set to zero; the output is to be the input as it was.
    rescale : bool
        Whether the values that are left are divided by 1 - `corruption`. If not, the layers learn to make up for what
        is lost on average, and motion of which nothing is lost comes out too large by that factor.
    sparsity : float
        Weight of the magnitudes of the hidden units in the loss.
    unpool : {'even', 'random'}
        How pooling is inverted: as the network says, or to one place by chance.

    Raises
    ------
    TypeError, ValueError
        If a field is not what it should be; the message begins with its name.
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
                raise ValueError(f"{name}: expected a number from 0 on, got {value!r}")
        if self.corruption >= 1:
            raise ValueError(f"corruption: expected a probability below 1, got {self.corruption!r}")
        if not isinstance(self.rescale, bool):
            raise TypeError(f"rescale: expected true or false, got {self.rescale!r}")
        one_of("unpool", self.unpool, PLACES)

    def learning_rate(self, epoch: int, share: float = 0.0) -> float:
        """Return the learning rate in an epoch, counted from 0, of which a share is done.

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
    """All that there is to decide about training.

    Parameters
    ----------
    scale : {'none', 'global', 'kind', 'feature'}
        Of the features: see `npss_baselines.manifold.motion.scaling`.
    size : float
        What their standard deviation becomes, or by what they are multiplied if the scale is none.
    loss : {'mean', 'sum'}
        Of the squared errors of a window's values, and of the magnitudes of its hidden units.
    unpool : {'both', 'half'}
        Even unpooling: see `npss_baselines.manifold.model.autoencoder`.
    start : {'glorot', 'orthonormal'}
        The weights at first: see `npss_baselines.manifold.model.initialization`.
    layers : Stage
        Each layer alone, from the first one on.
    whole : Stage
        All layers together, after that.
    """

    scale: str
    size: float
    loss: str
    unpool: str
    start: str
    layers: Stage
    whole: Stage


#: The paper's schedule. Where it says nothing: the error is a mean, because with a sum such steps diverge at once;
#: features are in heights and radians, because with unit variance they diverge too; even unpooling halves, because that
#: is what random unpooling does on average; fine tuning takes 25 epochs, at a constant rate and of corrupted windows.
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
#: What reconstructs best on the validation subjects. Features are so small that tanh hardly bends them: where it does,
#: atanh makes what the layer above got wrong larger. The weights start where motion is already reconstructed; Adam
#: would leave that place in few steps, were the rate not small and the gradient, which has outliers, not clipped to its
#: usual norm. Layers first, because a step of one layer takes less time than one of all.
DEFAULT = Recipe(
    scale="kind",
    size=0.1,
    loss="mean",
    unpool="both",
    start="orthonormal",
    layers=_LAYERS,
    whole=replace(_LAYERS, epochs=30, lr=2e-4),
)
RECIPES = {"default": DEFAULT, "paper": PAPER}
