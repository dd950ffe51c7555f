"""Train the networks of a restorer."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from npss.console import Progress
from npss.skeleton import Skeleton
from npss.validation import Seed, generator
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.model.gaussian import POSE_RIDGE, SpanGaussian, fit_gaussian
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.motion.split import subjects_of
from npss_baselines.manifold.restorers.by_case import ByCase
from npss_baselines.manifold.restorers.camera import Camera
from npss_baselines.manifold.restorers.fill import Fill
from npss_baselines.manifold.restorers.frames import Frames
from npss_baselines.manifold.restorers.keys import Keys
from npss_baselines.manifold.restorers.net import Net
from npss_baselines.manifold.restorers.samples import CameraSampler, FillSampler, KeysSampler, Sampler, Samples

#: Samples by which inputs are standardised, and the smallest deviation that counts.
EXAMPLE, SMALLEST = 4096, 0.02


@dataclass(frozen=True)
class Recipe:
    """How the networks of one case are trained.

    Attributes
    ----------
    width : int
        Units of each of the two hidden layers.
    dropout : float
        The share of hidden units that are left out.
    steps, batch : int
        Steps of AdamW, and samples of each.
    lr, decay : float
        The first learning rate, which falls along half a cosine, and the decay of weights.
    """

    width: int
    dropout: float
    steps: int
    batch: int = 512
    lr: float = 1e-3
    decay: float = 0.01

    def rate(self, step: int) -> float:
        """Return the share of the first learning rate: it rises in the first twentieth, and falls along a cosine."""
        return min(1.0, 20 * (step + 1) / self.steps) * (1 + math.cos(math.pi * step / self.steps)) / 2


@dataclass(frozen=True)
class Settings:
    """How a restorer is trained.

    Attributes
    ----------
    fill, keys, camera : Recipe
        The recipe of each case.
    nets : int
        Networks of each case, whose corrections are averaged.
    windows : int
        Windows that the Gaussian restores for ``camera``.
    """

    fill: Recipe = Recipe(256, 0.2, 1200, lr=2e-3)
    keys: Recipe = Recipe(256, 0.25, 1300, lr=2e-3, decay=0.05)
    camera: Recipe = Recipe(160, 0.2, 900)
    nets: int = 3
    windows: int = 3000


DEFAULT = Settings()
#: To try it out.
QUICK = Settings(Recipe(16, 0.1, 20, 64), Recipe(16, 0.1, 20, 64), Recipe(16, 0.1, 20, 64), nets=1, windows=10)


def train_restorer(
    training: MotionSet,
    *,
    seed: int = 0,
    skeleton: Skeleton = JOINTS,
    settings: Settings = DEFAULT,
    report: Callable[[str], None] = print,
) -> ByCase:
    """Fit the Gaussians and train the networks of a restorer.

    Parameters
    ----------
    training : MotionSet
        The training motion.
    seed : int, optional
        Seed of all random choices.
    skeleton : Skeleton, optional
        The skeleton of the motion.
    settings : Settings, optional
        How the networks are trained.
    report : callable, optional
        Called with a line on each network.

    Returns
    -------
    ByCase
        The restorer.
    """
    scaling = fit_scaling(training.windows, training.mask, "kind")
    gaussian = fit_gaussian(training.windows, training.mask, scaling)
    pose = fit_gaussian(training.windows, training.mask, scaling, span=1, ridge=POSE_RIDGE)
    frames = Frames(training, scaling, skeleton)
    filling = FillSampler(frames, pose, skeleton)
    samplers: Mapping[str, Callable[[np.random.Generator], Sampler]] = {
        "fill": lambda rng: filling,
        "keys": lambda rng: KeysSampler(frames, skeleton),
        "camera": lambda rng: CameraSampler(training, gaussian, skeleton, settings.windows, rng),
    }
    nets = {}
    for number, (case, sampler) in enumerate(samplers.items()):
        rng = np.random.default_rng([seed, number])
        samples, recipe = sampler(rng), getattr(settings, case)
        nets[case] = tuple(
            train_net(samples, recipe, gaussian, skeleton, rng, case, report) for _ in range(settings.nets)
        )
    seen = {
        "sources": list(dict.fromkeys(clip.source for clip in training.clips)),
        "subjects": subjects_of(training),
        "clips": len(training.clips),
        "seed": seed,
    }
    return ByCase(
        gaussian,
        Fill(pose, nets["fill"], filling.sets),
        Keys(scaling, nets["keys"]),
        Camera(scaling, nets["camera"]),
        skeleton,
        seen,
    )


def train_net(
    sampler: Sampler,
    recipe: Recipe,
    gaussian: SpanGaussian,
    skeleton: Skeleton,
    seed: Seed,
    case: str,
    report: Callable[[str], None] = print,
) -> Net:
    """Train a network on the distance of restored joints, with bone lengths restored.

    The loss of each kind of corruption is divided by the running mean of the first guess's, so that kinds weigh
    equally.
    """
    rng = generator(seed)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(rng.integers(2**31)))
        example = sampler.draw(EXAMPLE, rng).inputs
        centre, spread = example.mean(axis=0), np.maximum(example.std(axis=0), SMALLEST)
        standard = torch.from_numpy(centre), torch.from_numpy(1 / spread)
        n_inputs = len(centre)
        layers: list[nn.Module] = []
        for before, after in ((n_inputs, recipe.width), (recipe.width, recipe.width)):
            layers += [nn.Linear(before, after), nn.ReLU(), nn.Dropout(recipe.dropout)]
        last = nn.Linear(recipe.width, sampler.outputs)
        network = nn.Sequential(*layers, last)
        nn.init.zeros_(last.weight)  # the first guess, at first
        nn.init.zeros_(last.bias)
        optimizer = torch.optim.AdamW(network.parameters(), lr=recipe.lr, weight_decay=recipe.decay)
        schedule = torch.optim.lr_scheduler.LambdaLR(optimizer, recipe.rate)
        measure = Distance(gaussian, skeleton)
        scale = torch.zeros(sampler.n_kinds)
        gained: list[float] = []
        network.train()
        with Progress(f"training {case}") as progress:
            for step in range(recipe.steps):
                samples = sampler.draw(recipe.batch, rng)
                kind = torch.from_numpy(samples.kind)
                first = measure(samples, None)
                counts = torch.bincount(kind, minlength=sampler.n_kinds)
                sums = torch.bincount(kind, first, minlength=sampler.n_kinds)
                mean = sums / counts.clamp(min=1)
                scale = torch.where(counts > 0, torch.where(scale > 0, 0.98 * scale + 0.02 * mean, mean), scale)
                inputs = (torch.from_numpy(samples.inputs) - standard[0]) * standard[1]
                change = network(inputs) * torch.from_numpy(samples.amount)
                error = measure(samples, change)
                loss = (error / scale[kind]).mean()
                optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                nn.utils.clip_grad_norm_(network.parameters(), 1.0)
                optimizer.step()
                schedule.step()
                gained.append(float(error.detach().mean() / first.mean()))
                progress((step + 1) / recipe.steps)
        report(f"{case}: {np.mean(gained[-50:]):.3f} of the first guess's error on training samples, with dropout")
    linear = [layer for layer in network if isinstance(layer, nn.Linear)]
    weights = [layer.weight.detach().numpy().T.copy() for layer in linear]
    biases = [layer.bias.detach().numpy().copy() for layer in linear]
    weights[0] /= spread[:, np.newaxis]  # the network takes the inputs as they are
    biases[0] -= centre @ weights[0]
    return Net(tuple(weights), tuple(biases))


class Distance:
    """The distance of restored joints from the truth, averaged over the missing ones of each sample."""

    def __init__(self, gaussian: SpanGaussian, skeleton: Skeleton) -> None:
        scaling = gaussian.scaling
        self._scale, self._mean = (torch.from_numpy(v.astype(np.float32)) for v in (scaling.scale, scaling.mean))
        self._skeleton = skeleton
        self._lengths = np.linalg.norm(skeleton.offsets, axis=-1)

    def __call__(self, samples: Samples, change: Tensor | None) -> Tensor:
        """Return the distance of each sample, in body heights, after a change of the first guess; (n,)."""
        guess = torch.from_numpy(samples.guess)
        if change is not None:
            guess = guess + nn.functional.pad(change, (0, guess.shape[1] - change.shape[1]))
        missing = torch.from_numpy(samples.missing)
        joints = self._positions(guess)
        if change is not None:
            joints = self._with_lengths(joints, missing)
        squares = (joints - self._positions(torch.from_numpy(samples.truth))).square().sum(-1)
        distances = (squares + 1e-10).sqrt() * missing
        mean = distances.sum(1) / missing.sum(1)
        if change is not None and change.shape[1] == guess.shape[1]:  # velocities count little
            mean = mean + 0.02 * (guess - torch.from_numpy(samples.truth))[:, -3:].abs().mean(1) * self._scale[0]
        return mean

    def _positions(self, scaled: Tensor) -> Tensor:
        positions = (scaled * self._scale + self._mean)[:, :-3]
        return positions.reshape(len(scaled), -1, 3)

    def _with_lengths(self, joints: Tensor, missing: Tensor) -> Tensor:
        """Give bones that end in missing joints the skeleton's lengths, from the root outwards."""
        moved = list(joints.unbind(1))
        for joint in self._skeleton._order[1:]:
            if not missing[:, joint].any():
                continue
            parent = moved[self._skeleton.parents[joint]]
            bone = moved[joint] - parent
            size = (bone.square().sum(1, keepdim=True) + 1e-12).sqrt()
            placed = parent + bone * (float(self._lengths[joint]) / size)
            moved[joint] = torch.where(missing[:, joint : joint + 1], placed, moved[joint])
        return torch.stack(moved, 1)
