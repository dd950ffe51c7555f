"""A network that predicts the shares of each angle's power outside DC, and its speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Self

import numpy as np
import torch
from torch import Tensor, nn

from npss.validation import Array, Float64
from npss_baselines.fitted.angles import ANGLES, SWAPPED
from npss_baselines.fitted.base import Progress, inside, one_thread
from npss_baselines.fitted.descriptors import (
    SPANS,
    Statistics,
    body,
    descriptors,
    share_of,
    span_moments,
    speeds_of,
    statistics_of,
)
from npss_baselines.fitted.motion import Motion, Windows

D = len(ANGLES)
CONTEXT = 16  # numbers about the whole body
OUTPUTS = 2 * len(SPANS) + 1  # both shares of each span, and the speed
_TYPICAL_SPEED = 0.01  # radians per frame


@dataclass(frozen=True)
class NetworkSettings:
    """The settings of a share network and of its training.

    Attributes
    ----------
    networks : int
        Number of networks to average.
    hidden : int
        Units of each of two hidden layers.
    epochs : int
        Passes over the training windows.
    batch : int
        Number of windows in a batch.
    lr, weight_decay : float
        Highest learning rate, and decay of the weights, of AdamW.
    other_weight : float
        Weight of windows of other actions than those to predict.
    whole : float
        Weight of the shares over four seconds, relative to those of a shorter span.
    shift : float
        Standard deviation of the random shift of each angle's mean, relative to that between subjects of an action.
    scale : float
        Standard deviation of the logarithm of the random scale of each angle's deviation.
    """

    networks: int = 3
    hidden: int = 128
    epochs: int = 8
    batch: int = 64
    lr: float = 4e-3
    weight_decay: float = 0.2
    other_weight: float = 0.3
    whole: float = 4.0
    shift: float = 0.7
    scale: float = 0.18


class ShareNetwork(nn.Module):
    """One network for all angles: it reads descriptors, the whole body, the angle and the action.

    Parameters
    ----------
    n_descriptors : int
        Number of descriptors.
    n_actions : int
        Number of actions.
    hidden : int
        Units of each hidden layer.
    """

    read_mean: Tensor
    read_std: Tensor
    body_mean: Tensor
    body_axes: Tensor

    def __init__(self, n_descriptors: int, n_actions: int, hidden: int) -> None:
        super().__init__()
        self.angle, self.action = nn.Embedding(D, 16), nn.Embedding(n_actions, 8)
        self.first = nn.Linear(n_descriptors + CONTEXT + 16 + 8, hidden)
        self.second = nn.Linear(hidden, hidden)
        self.last = nn.Linear(hidden, OUTPUTS)
        self.prior = nn.Parameter(torch.zeros(D, OUTPUTS))
        nn.init.zeros_(self.last.weight)
        nn.init.zeros_(self.last.bias)
        self.register_buffer("read_mean", torch.zeros(n_descriptors))
        self.register_buffer("read_std", torch.ones(n_descriptors))
        self.register_buffer("body_mean", torch.zeros(2 * D))
        self.register_buffer("body_axes", torch.zeros(2 * D, CONTEXT))

    def forward(self, statistics: Statistics, action: Tensor) -> Tensor:
        """Return logits of the shares, and the logarithm of the speed over a typical one: (N, 48, 9)."""
        read = ((descriptors(statistics) - self.read_mean) / self.read_std).clamp(-5, 5)
        context = ((body(statistics) - self.body_mean) @ self.body_axes).clamp(-5, 5)
        n = len(read)
        # Layers of parts add up to the layer of all of them; parts that many rows share are computed once.
        weights = torch.split(self.first.weight, [read.shape[2], CONTEXT, 16, 8], dim=1)
        whole = context @ weights[1].T + self.action(action) @ weights[3].T + self.first.bias
        hidden = read.reshape(n * D, -1) @ weights[0].T
        hidden = hidden.reshape(n, D, -1) + whole[:, None] + (self.angle.weight @ weights[2].T)
        hidden = nn.functional.silu(hidden)
        hidden = nn.functional.silu(self.second(hidden))
        answers: Tensor = self.last(hidden) + self.prior
        return answers


@dataclass(frozen=True, eq=False)
class Targets:
    """What the network learns of training windows.

    Attributes
    ----------
    statistics : Statistics
        Of the seed frames.
    moments : Tensor
        Of the target frames (N, 48, 4, 3), mean relative to the level of the seed frames.
    speed : Tensor
        (N, 48).
    action : Tensor
        (N,).
    """

    statistics: Statistics
    moments: Tensor
    speed: Tensor
    action: Tensor

    @classmethod
    def of(cls, windows: Windows) -> Self:
        """Compute them."""
        statistics = statistics_of(windows.seed)
        moments = span_moments(windows.target, statistics.level.numpy())
        return cls(statistics, moments, speeds_of(windows.target), torch.from_numpy(windows.action))


class Ensemble:
    """Several networks, whose answers are averaged, also over the mirror image."""

    def __init__(self, networks: Sequence[ShareNetwork]) -> None:
        self.networks = [network.eval() for network in networks]

    def answers(self, seed: Float64, action: int) -> tuple[Float64, Float64]:
        """Return the shares (N, 48, 4, 2), `paper` and `released` by span, and the speed (N, 48), for seed frames."""
        statistics = statistics_of(seed.astype(np.float32))
        chosen = torch.full((len(seed),), action)
        total = torch.zeros(len(seed), D, OUTPUTS)
        with torch.no_grad(), one_thread():
            mirror = statistics.mirrored(torch.ones(len(seed), dtype=torch.bool))
            for network in self.networks:
                total += network(statistics, chosen) + network(mirror, chosen)[:, SWAPPED]
        mean = (total / (2 * len(self.networks))).double()
        shares = torch.sigmoid(mean[..., :-1]).reshape(len(seed), D, len(SPANS), 2)
        return shares.numpy(), (_TYPICAL_SPEED * torch.exp(mean[..., -1])).numpy()

    def arrays(self) -> dict[str, Array]:
        """Return the weights of all networks."""
        return {
            f"networks.{i}.{name}": value.detach().numpy()
            for i, network in enumerate(self.networks)
            for name, value in network.state_dict().items()
        }

    @classmethod
    def restore(cls, n_networks: int, hidden: int, arrays: Mapping[str, Array]) -> Self:
        """Return the networks with these weights."""
        networks = []
        for i in range(n_networks):
            own = inside(arrays, f"networks.{i}")
            weights = {name: torch.tensor(array) for name, array in own.items()}
            network = ShareNetwork(len(weights["read_mean"]), len(weights["action.weight"]), hidden)
            try:
                network.load_state_dict(weights)
            except RuntimeError as error:
                raise ValueError(f"network {i}: {error}") from error
            networks.append(network)
        return cls(networks)


def train(motion: Motion, settings: NetworkSettings, *, seed: int, progress: Progress) -> Ensemble:
    """Train the networks on the windows of all actions, on one thread."""
    with one_thread(), torch.random.fork_rng(devices=[]):
        windows = motion.windows()
        targets = Targets.of(windows)
        spread = torch.from_numpy(_spread_between_groups(targets, windows))
        networks = []
        for i in range(settings.networks):
            torch.manual_seed(int(np.random.SeedSequence([seed, i]).generate_state(1)[0]))
            part = partial(_part, progress, i, settings.networks)
            networks.append(_train_one(targets, spread, len(motion.actions), motion.n_predicted, settings, part))
    return Ensemble(networks)


def _part(progress: Progress, i: int, n: int, share: float) -> None:
    """Report a share of the i-th of n parts."""
    progress((i + share) / n)


def _train_one(
    targets: Targets, spread: Tensor, n_actions: int, n_predicted: int, settings: NetworkSettings, progress: Progress
) -> ShareNetwork:
    network = _initial(targets, n_actions, settings.hidden)
    scales = _scales(targets, n_actions)
    importance = torch.where(torch.arange(n_actions) < n_predicted, 1.0, settings.other_weight)
    decayed = [p for p in network.parameters() if p.ndim > 1 and p is not network.prior]
    other = [p for p in network.parameters() if p.ndim == 1 or p is network.prior]
    optimizer = torch.optim.AdamW(
        [{"params": decayed, "weight_decay": settings.weight_decay}, {"params": other, "weight_decay": 0.0}],
        settings.lr,
    )
    n = len(targets.action)
    per_epoch = math.ceil(n / settings.batch)
    total = settings.epochs * per_epoch
    step = 0
    for _ in range(settings.epochs):
        for chosen in torch.split(torch.randperm(n), settings.batch):
            rate = min(1, (step + 1) / (0.05 * total)) * 0.5 * (1 + math.cos(math.pi * step / total))
            for group in optimizer.param_groups:
                group["lr"] = settings.lr * rate
            loss = _loss(network, _augmented(targets, chosen, spread, settings), scales, importance, settings.whole)
            optimizer.zero_grad(set_to_none=True)
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimizer.step()
            step += 1
            progress(step / total)
    return network


def _loss(network: ShareNetwork, batch: Targets, scales: Tensor, importance: Tensor, whole: float) -> Tensor:
    """Return each span's share error, relative to that of zero-velocity, and the deviance of the speed."""
    answers = network(batch.statistics, batch.action)
    mean = batch.statistics.level[..., None] + batch.moments[..., 0]
    error = torch.zeros(len(batch.action))
    spans = torch.tensor([whole] + [1.0] * (len(SPANS) - 1))
    spans = spans / spans.sum()
    for kind in (0, 1):
        outside = batch.moments[..., 1 + kind]
        weight = mean**2 + outside  # (N, 48, 4)
        predicted = torch.sigmoid(answers[..., kind:-1:2])
        difference = weight * (predicted - share_of(outside, mean)).abs()
        error = error + (difference.sum(1) / scales[batch.action, :, kind]) @ spans
    rate = answers[..., -1].clamp(max=8)
    truth = batch.speed / _TYPICAL_SPEED
    deviance = (torch.exp(rate) - truth * rate).mean(1) / scales[batch.action, 0, 2]
    loss: Tensor = (importance[batch.action] * (error / 2 + 0.5 * deviance)).mean()
    return loss


def _augmented(targets: Targets, chosen: Tensor, spread: Tensor, settings: NetworkSettings) -> Targets:
    """Return some windows, moved, scaled and mirrored at random."""
    statistics = Statistics(*(values[chosen] for values in targets.statistics))
    moments, speed, action = targets.moments[chosen], targets.speed[chosen], targets.action[chosen]
    shift = settings.shift * spread[action] * torch.randn(len(chosen), D)
    scale = torch.exp(settings.scale * torch.randn(len(chosen), D))
    statistics = statistics.changed(shift, scale)
    moments = moments * torch.stack([scale, scale**2, scale**2], -1)[:, :, None]
    speed = speed * scale
    mirror = torch.rand(len(chosen)) < 0.5
    whole = Statistics(statistics.level, moments, speed[..., None], statistics.ratio, moments).mirrored(mirror)
    return Targets(statistics.mirrored(mirror), whole.periodic, whole.spread[..., 0], action)


def _initial(targets: Targets, n_actions: int, hidden: int) -> ShareNetwork:
    """Return a network that standardises what it reads, and predicts the weighted median of each angle."""
    read, whole = descriptors(targets.statistics), body(targets.statistics)
    network = ShareNetwork(read.shape[2], n_actions, hidden)
    network.read_mean.copy_(read.mean((0, 1)))
    network.read_std.copy_(read.std((0, 1)) + 1e-6)
    network.body_mean.copy_(whole.mean(0))
    std = whole.std(0) + 1e-6
    standard = ((whole - whole.mean(0)) / std).double()
    values, axes = torch.linalg.eigh(standard.T @ standard / len(standard))
    main = axes[:, -CONTEXT:] / values[-CONTEXT:].clamp(min=1e-6).sqrt()
    network.body_axes.copy_((main / std.double()[:, None]).float())
    mean = targets.statistics.level[..., None] + targets.moments[..., 0]
    with torch.no_grad():
        for kind in (0, 1):
            outside = targets.moments[..., 1 + kind]
            median = weighted_median(share_of(outside, mean), mean**2 + outside)
            network.prior[:, kind:-1:2] = torch.logit(median.clamp(1e-4, 0.99))
        network.prior[:, -1] = torch.log(targets.speed.mean(0) / _TYPICAL_SPEED + 1e-3)
    return network


def _scales(targets: Targets, n_actions: int) -> Tensor:
    """Return, by action and span, the mean share errors of zero-velocity under both conventions, and the mean speed."""
    mean_of = [targets.action == action for action in range(n_actions)]
    powers = [
        torch.stack([targets.moments[chosen, ..., kind].sum(1).mean(0) for kind in (1, 2)], -1) for chosen in mean_of
    ]
    speed = [targets.speed[chosen].mean() / _TYPICAL_SPEED for chosen in mean_of]
    stacked = [torch.cat([p, s.expand(len(SPANS), 1)], -1) for p, s in zip(powers, speed, strict=True)]
    return torch.stack(stacked) + 1e-9  # (A, 4, 3)


def weighted_median(values: Tensor, weights: Tensor) -> Tensor:
    """Return the weighted median over the first axis."""
    order = values.argsort(0)
    cumulative = weights.gather(0, order).cumsum(0)
    place = (cumulative < cumulative[-1:] / 2).sum(0, keepdim=True)
    return values.gather(0, order.gather(0, place))[0]


def _spread_between_groups(targets: Targets, windows: Windows) -> Array:
    """Return the standard deviation between groups of each angle's mean level, by action (A, 48)."""
    level = targets.statistics.level.numpy()
    spreads = []
    for action in range(int(windows.action.max()) + 1):
        groups = np.unique(windows.group[windows.action == action])
        means = [level[(windows.action == action) & (windows.group == g)].mean(0) for g in groups]
        spreads.append(np.std(means, axis=0))
    return np.stack(spreads).astype(np.float32)
