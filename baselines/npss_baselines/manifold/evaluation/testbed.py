"""What uses are measured on and with: held-out motion, manifolds, and their rivals."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from npss.validation import Array
from npss_baselines.manifold.applications import restore
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.restore import LOST_AT_RANDOM, RESCALED, Windows
from npss_baselines.manifold.evaluation.pca_size import ALL, best_sizes, truncated
from npss_baselines.manifold.model import pca
from npss_baselines.manifold.model.pca import PCA
from npss_baselines.manifold.model.projector import Manifold, Projector
from npss_baselines.manifold.motion.normalization import Normalization
from npss_baselines.manifold.motion.prepared import TEST_SUBJECTS, MotionSet
from npss_baselines.manifold.motion.split import split

#: What tables and pictures call what is no manifold: of their names, it is all that stands before a comma.
TAKEN = ("input", "linear", "pca", "pca-best", "euclidean", "extremes", "length", "chance", "original", "real")


@dataclass(frozen=True)
class Bench:
    """Manifolds, their rivals, and the motion by which they are measured.

    Attributes
    ----------
    motions : MotionSet
        All of it, divided by subject as for training: rivals are fitted to what manifolds are trained on, and restoring
        is measured on what is held out.
    manifolds : mapping of str to Manifold
        By name, one or more; none of `TAKEN`, and without a comma. The mean of the first is what lost values become,
        and rivals see features as it does.
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
            if name in TAKEN or "," in name:
                raise ValueError(
                    f"manifolds: {name!r} could be taken for another method; a name has no comma and is none of "
                    f"{', '.join(TAKEN)}"
                )

    @property
    def normalization(self) -> Normalization:
        """That of the first manifold."""
        return next(iter(self.manifolds.values())).normalization

    @cached_property
    def training(self) -> MotionSet:
        """What rivals are fitted to."""
        return split(self.motions).training

    @cached_property
    def test(self) -> MotionSet:
        """What is held out."""
        test = split(self.motions).test
        if test is None:
            raise ValueError(f"there is no motion of those who are held out, {', '.join(TEST_SUBJECTS)}")
        return test

    @cached_property
    def windows(self) -> Windows:
        """The windows that are held out, in float64."""
        return Windows(self.test.windows.astype(np.float64), self.test.mask)

    @cached_property
    def rival(self) -> PCA:
        """Principal components of the size of the first manifold's code, or as many as training windows allow."""
        size = next(iter(self.manifolds.values())).encode(self.training.windows[:1]).size
        return pca.fit(self.training.windows, self.normalization, n_components=size)

    @cached_property
    def best_sizes(self) -> dict[str, int]:
        """How many components restore best, by use."""
        return best_sizes(self.training, self.normalization, tuple(restore.USES), seed=self.seed)

    def projectors(self, use: str = "") -> dict[str, Projector]:
        """Return what projects: ``pca``, ``pca-best`` if its size was chosen by that use, and the manifolds."""
        size = self.best_sizes.get(use) if use else None
        best = {} if size is None else {"pca-best": self.rival if size == ALL else truncated(self.rival, size)}
        return {"pca": self.rival, **best, **self.manifolds}

    def corrupted(self, use: str) -> Corrupted:
        """Return what a use leaves of the windows that are held out."""
        return restore.corrupted(use, self.windows, self.normalization.mean, seed=self.seed)

    def restored(self, use: str, left: Corrupted) -> dict[str, Array]:
        """Return what each method makes of what is left."""
        motions: dict[str, Array] = {"input": left.features}
        lost = ~left.known
        if (lost.any(axis=1) & ~lost.all(axis=1)).any():  # there is something to interpolate between
            motions["linear"] = restore.linear(left)
        projected: dict[str, Array] = {}
        for name, projector in self.projectors(use).items():
            same = name == "pca-best" and projector is self.rival
            projected[name] = projected["pca"] if same else projector.project(left.features)
        motions |= projected
        del projected["pca"]
        if use in LOST_AT_RANDOM:
            seen = restore.rescaled(left, self.normalization.mean)
            projectors = self.projectors(use + RESCALED)
            projected = {name: projectors[name].project(seen) for name in projected}
            motions |= {name + RESCALED: motion for name, motion in projected.items()}
        if lost.any():
            motions |= {f"{name}, known kept": restore.keep_known(left, motion) for name, motion in projected.items()}
        return motions

    @cached_property
    def _rival_signature(self) -> str:
        return self.rival.signature

    def signature_of(self, use: str, method: str) -> str | None:
        """Return the signature of what a method projects by; None if it does not."""
        name = method.partition(",")[0]
        if name == "pca-best":
            changed = use in LOST_AT_RANDOM and method != name
            size = min(self.best_sizes[use + RESCALED if changed else use], len(self.rival.components))
            return f"{size} components of {self._rival_signature}"
        return self._rival_signature if name == "pca" else getattr(self.manifolds.get(name), "signature", None)


def fingerprint(motions: MotionSet) -> str:
    """Return what tells a set of motion from any other, for signatures."""
    digest = hashlib.sha256()
    for clip, features in zip(motions.clips, motions.features, strict=True):
        digest.update(f"{clip.source}/{clip.name}".encode() + features.tobytes())
    return digest.hexdigest()[:12]
