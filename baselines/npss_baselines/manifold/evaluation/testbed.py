"""What applications are measured on and with: held-out motion, manifolds, and their baselines."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from npss.validation import Array
from npss_baselines.manifold.applications import restore
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.restore import LOST_AT_RANDOM, Windows
from npss_baselines.manifold.evaluation.pca_size import ALL, Restoration, best_sizes, truncated
from npss_baselines.manifold.model.pca import PCA, fit_pca
from npss_baselines.manifold.model.projector import Manifold, Projector
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.motion.split import held_out_subjects, split

#: What tables and pictures call what is no manifold.
RESERVED = ("input", "linear", "pca", "pca-best", "euclidean", "extremes", "length", "chance", "original", "real")


@dataclass(frozen=True)
class Testbed:
    """Manifolds, their baselines, and the motion by which they are measured.

    Attributes
    ----------
    motions : MotionSet
        All of it, divided by subject as for training: baselines are fitted to what manifolds are trained on, and
        restoring is measured on what is held out.
    manifolds : mapping of str to Manifold
        By name, one or more; none of `RESERVED`, and without a comma. The mean of the first is what lost values
        become, and baselines see features as it does.
    seed : int
        Of all that is random.

    Raises
    ------
    ValueError
        If a manifold has the name of another method.
    """

    motions: MotionSet
    manifolds: Mapping[str, Manifold]
    seed: int = 0

    def __post_init__(self) -> None:
        for name in self.manifolds:
            if name in RESERVED or "," in name:
                raise ValueError(
                    f"manifolds: {name!r} could be taken for another method; a name has no comma and is none of "
                    f"{', '.join(RESERVED)}"
                )

    @property
    def scaling(self) -> Scaling:
        """That of the first manifold."""
        return next(iter(self.manifolds.values())).scaling

    @cached_property
    def training(self) -> MotionSet:
        """What baselines are fitted to."""
        return split(self.motions).training

    @cached_property
    def test(self) -> MotionSet:
        """What is held out."""
        test = split(self.motions).test
        if test is None:
            raise ValueError(f"there is no motion of those who are held out, {', '.join(held_out_subjects())}")
        return test

    @cached_property
    def windows(self) -> Windows:
        """The windows that are held out, in float64."""
        return Windows(self.test.windows.astype(np.float64), self.test.mask)

    @cached_property
    def pca(self) -> PCA:
        """Principal components of the size of the first manifold's code, or as many as training windows allow."""
        size = next(iter(self.manifolds.values())).encode(self.training.windows[:1]).size
        return fit_pca(self.training.windows, self.scaling, n_components=size)

    @cached_property
    def best_sizes(self) -> dict[Restoration, int]:
        """How many components restore best, by what is restored and how."""
        return best_sizes(self.training, self.scaling, tuple(restore.RESTORATIONS), seed=self.seed)

    def projectors(self, restoration: Restoration | None = None) -> dict[str, Projector]:
        """Return what projects: ``pca``, ``pca-best`` if its size was chosen for that, and the manifolds."""
        size = None if restoration is None else self.best_sizes.get(restoration)
        best = {} if size is None else {"pca-best": self.pca if size == ALL else truncated(self.pca, size)}
        return {"pca": self.pca, **best, **self.manifolds}

    def corrupted(self, application: str) -> Corrupted:
        """Return what an application leaves of the windows that are held out."""
        return restore.corrupted(application, self.windows, self.scaling.mean, seed=self.seed)

    def restored(self, application: str, left: Corrupted) -> dict[Method, Array]:
        """Return what each method makes of what is left."""
        motions: dict[Method, Array] = {Method("input"): left.features}
        lost = ~left.known
        if (lost.any(axis=1) & ~lost.all(axis=1)).any():  # there is something to interpolate between
            motions[Method("linear")] = restore.linear(left)
        projected: dict[str, Array] = {}
        for name, projector in self.projectors(Restoration(application)).items():
            same = name == "pca-best" and projector is self.pca
            projected[name] = projected["pca"] if same else projector.project(left.features)
        motions |= {Method(name): motion for name, motion in projected.items()}
        del projected["pca"]
        if application in LOST_AT_RANDOM:
            seen = restore.rescaled(left, self.scaling.mean)
            projectors = self.projectors(Restoration(application, rescaled=True))
            projected = {name: projectors[name].project(seen) for name in projected}
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
        """Return the signature of what a method projects by; None if it does not."""
        if method.name == "pca-best":
            # Where windows are rescaled, so are those whose known values are then put back.
            rescaled = application in LOST_AT_RANDOM and bool(method.variant)
            size = min(self.best_sizes[Restoration(application, rescaled)], len(self.pca.components))
            return f"{size} components of {self._pca_signature}"
        if method.name == "pca":
            return self._pca_signature
        manifold = self.manifolds.get(method.name)
        return None if manifold is None else manifold.signature


def fingerprint(motions: MotionSet) -> str:
    """Return what tells a set of motion from any other, for signatures."""
    digest = hashlib.sha256()
    for clip, features in zip(motions.clips, motions.features, strict=True):
        digest.update(f"{clip.source}/{clip.name}".encode() + features.tobytes())
    return digest.hexdigest()[:12]
