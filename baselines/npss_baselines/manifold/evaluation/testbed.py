"""The testbed of applications: held-out motion, manifolds and their baselines."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from npss.validation import Array
from npss_baselines.manifold.applications import restore
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.restore import LOST_AT_RANDOM, WRIST, Windows
from npss_baselines.manifold.evaluation.pca_size import ALL, Restoration, best_sizes, truncated
from npss_baselines.manifold.model.pca import PCA, fit_pca
from npss_baselines.manifold.model.projector import Manifold, Projector
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.motion.split import held_out_subjects, split
from npss_baselines.manifold.restorers import simple_baselines
from npss_baselines.manifold.restorers.alternating import Alternating
from npss_baselines.manifold.restorers.file import default
from npss_baselines.manifold.restorers.restorer import Restorer
from npss_baselines.manifold.restorers.simple_baselines import SimpleBaselines

#: Names of other rows in tables and pictures, which manifolds must not have.
RESERVED = (
    *("input", "slerp", "pca", "pca-best", "euclidean", "extremes", "length", "chance", "original", "real", "restorer"),
    *simple_baselines.NAMES,
)


@dataclass(frozen=True)
class Testbed:
    """Manifolds, their baselines, and the motion to measure them on.

    Attributes
    ----------
    motions : MotionSet
        All motion, split by subject as for training: baselines are fitted to the training set, and restorations are
        measured on the held-out set.
    manifolds : mapping of str to Manifold
        One or more manifolds by name. A name has no comma and is not in `RESERVED`. The scaling of the first is that of
        the baselines, and its mean replaces lost values.
    seed : int
        Seed of all random choices.
    trained : mapping of Method to Restorer, optional
        Trained restorers, all named ``restorer`` (default: that of the package).

    Raises
    ------
    ValueError
        If the name of a manifold is reserved or has a comma.
    """

    motions: MotionSet
    manifolds: Mapping[str, Manifold]
    seed: int = 0
    trained: Mapping[Method, Restorer] = field(default_factory=lambda: {Method("restorer"): default()})

    def __post_init__(self) -> None:
        for name in self.manifolds:
            if name in RESERVED or "," in name:
                raise ValueError(
                    f"manifolds: invalid name {name!r}; names must not contain a comma or be one of "
                    f"{', '.join(RESERVED)}"
                )

    @property
    def scaling(self) -> Scaling:
        """The scaling of the first manifold."""
        return next(iter(self.manifolds.values())).scaling

    @cached_property
    def training(self) -> MotionSet:
        """Training motion, which baselines are fitted to."""
        return split(self.motions).training

    @cached_property
    def test(self) -> MotionSet:
        """Held-out motion."""
        test = split(self.motions).test
        if test is None:
            raise ValueError(f"no motion of the held-out subjects {', '.join(held_out_subjects())}")
        return test

    @cached_property
    def windows(self) -> Windows:
        """Held-out windows, in float64."""
        return Windows(self.test.windows.astype(np.float64), self.test.mask)

    @cached_property
    def pca(self) -> PCA:
        """As many principal components as the first manifold's code has numbers, or as training windows allow."""
        size = next(iter(self.manifolds.values())).encode(self.training.windows[:1]).size
        return fit_pca(self.training.windows, self.scaling, n_components=size)

    @cached_property
    def best_sizes(self) -> dict[Restoration, int]:
        """The best number of components for each restoration."""
        return best_sizes(self.training, self.scaling, tuple(restore.RESTORATIONS), seed=self.seed)

    def projectors(self, restoration: Restoration | None = None) -> dict[str, Projector]:
        """Return the projectors: ``pca``, ``pca-best`` if its size was chosen for the restoration, and manifolds."""
        size = None if restoration is None else self.best_sizes.get(restoration)
        best = {} if size is None else {"pca-best": self.pca if size == ALL else truncated(self.pca, size)}
        return {"pca": self.pca, **best, **self.manifolds}

    def corrupted(self, application: str, joints: Sequence[str] = (WRIST,)) -> Corrupted:
        """Return the held-out windows, corrupted for an application; ``joints`` are those of ``fill``."""
        return restore.corrupted(application, self.windows, self.scaling.mean, joints=joints, seed=self.seed)

    @cached_property
    def simple_baselines(self) -> SimpleBaselines:
        """The simple baselines to restore motion."""
        return SimpleBaselines(self.training)

    def restorers(self, left: Corrupted) -> dict[Method, Restorer]:
        """Return the restorers of corrupted windows by name: simple baselines, trained ones, and manifolds in turn."""
        if left.exact.all():
            return {}
        restorers = {Method(name): restorer for name, restorer in self.simple_baselines.of(left).items()}
        return restorers | {
            **self.trained,
            **{Method(name, "alternating"): Alternating(manifold) for name, manifold in self.manifolds.items()},
        }

    def restored(self, application: str, left: Corrupted) -> dict[Method, Array]:
        """Return the motions that each method restores from corrupted windows."""
        motions: dict[Method, Array] = {Method("input"): left.features}
        lost = ~left.known
        motions |= {method: restorer.restore(left) for method, restorer in self.restorers(left).items()}
        projected: dict[str, Array] = {}
        for name, projector in self.projectors(Restoration(application)).items():
            same = name == "pca-best" and projector is self.pca
            projected[name] = projected["pca"] if same else projector.project(left.features)
        motions |= {Method(name): motion for name, motion in projected.items()}
        del projected["pca"]
        if application in LOST_AT_RANDOM:
            features = restore.rescaled(left, self.scaling.mean)
            projectors = self.projectors(Restoration(application, rescaled=True))
            projected = {name: projectors[name].project(features) for name in projected}
            motions |= {Method(name, "rescaled"): motion for name, motion in projected.items()}
        if lost.any():
            motions |= {
                Method(name, "known kept"): restore.keep_known(left, motion) for name, motion in projected.items()
            }
        return motions

    @cached_property
    def _pca_signature(self) -> str:
        return self.pca.signature

    def signature_of(self, application: str, method: Method) -> str | None:
        """Return the signature of a method's projector; None if it has none."""
        application = application.partition(" ")[0]  # without joints
        if method.name == "pca-best":
            # Where windows are rescaled, known values are put back into rescaled ones.
            rescaled = application in LOST_AT_RANDOM and bool(method.variant)
            size = min(self.best_sizes[Restoration(application, rescaled)], len(self.pca.components))
            return f"{size} components of {self._pca_signature}"
        if method.name == "pca":
            return self._pca_signature
        if method in self.trained:
            return self.trained[method].signature
        if method.name in simple_baselines.NAMES and application in restore.RESTORATIONS:
            return self.simple_baselines[method.name].signature
        if method.variant == "alternating":
            return Alternating(self.manifolds[method.name]).signature
        manifold = self.manifolds.get(method.name)
        return None if manifold is None else manifold.signature


def fingerprint(motions: MotionSet) -> str:
    """Return the hash that identifies a set of motion in signatures."""
    digest = hashlib.sha256()
    for clip, features in zip(motions.clips, motions.features, strict=True):
        digest.update(f"{clip.source}/{clip.name}".encode() + features.tobytes())
    return digest.hexdigest()[:12]
