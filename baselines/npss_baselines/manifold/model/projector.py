"""What takes motion to a manifold, whatever the manifold is; and the autoencoder as one that does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from npss.validation import Array, check_finite, positive_integer, real_array
from npss_baselines.manifold.model.autoencoder import Autoencoder
from npss_baselines.manifold.motion.scaling import Scaling

_AT_ONCE = 64  # windows, to bound memory


class Projector(Protocol):
    """A manifold of motion of any length, given as features in the units of `motion.features`."""

    @property
    def signature(self) -> str:
        """What it is, to the bit: part of the signature of every number that depends on it."""

    def encode(self, features: npt.ArrayLike) -> Array:
        """Return the code (n, T', H) of motions (n, T, F)."""

    def decode(self, code: npt.ArrayLike, n_frames: int) -> Array:
        """Return the motions (n, n_frames, F) of codes (n, T', H)."""

    def project(self, features: npt.ArrayLike) -> Array:
        """Return the motions (n, T, F) on the manifold that motions are taken to."""


@dataclass(frozen=True, eq=False)
class Manifold:
    """An autoencoder as a `Projector`.

    Motion whose length is no multiple of the frames to a step of the code is padded at its end by mirroring, and cut
    again.

    Attributes
    ----------
    network : Autoencoder
        On any device.
    scaling : Scaling
        By which it sees features.
    signature : str
        Of its weights, and of what they were trained on and how.
    """

    network: Autoencoder
    scaling: Scaling
    signature: str

    def encode(self, features: npt.ArrayLike) -> Array:
        """Return the code of motions.

        Parameters
        ----------
        features : (n, T, F) array_like
            Motions, in the units of `npss_baselines.manifold.motion.features`.

        Returns
        -------
        (n, T', H) ndarray
            Hidden units of the last layer, between -1 and 1, in the network's precision; T' is T over the frames to a
            step, rounded up.

        Raises
        ------
        TypeError, ValueError
            If the motions are not as described.
        """
        motions = motions_of(features, self.network.config.n_features)
        seen = self.scaling.normalize(mirrored(motions, self.network.config.stride))
        with torch.no_grad():
            return np.concatenate([self.network.encode(part).cpu().numpy() for part in self._parts(seen)])

    def decode(self, code: npt.ArrayLike, n_frames: int) -> Array:
        """Return the motions of codes.

        Parameters
        ----------
        code : (n, T', H) array_like
            Hidden units of the last layer. Magnitudes of more than 1 - eps are clipped.
        n_frames : int
            Frames to return, at most those that T' steps are of.

        Returns
        -------
        (n, n_frames, F) ndarray of float64
            Motions, in the units of `npss_baselines.manifold.motion.features`.

        Raises
        ------
        TypeError, ValueError
            If the codes are not as described, or of fewer frames.
        """
        config = self.network.config
        steps = motions_of(code, config.widths[-1], name="code")
        if positive_integer("n_frames", n_frames) > steps.shape[1] * config.stride:
            raise ValueError(f"n_frames: {steps.shape[1]} steps are of {steps.shape[1] * config.stride} frames")
        with torch.no_grad():
            motions = [self.network.decode(part).cpu().numpy() for part in self._parts(steps)]
        return self.scaling.unnormalize(np.concatenate(motions)[:, :n_frames])

    def project(self, features: npt.ArrayLike) -> Array:
        """Return the motions that motions (n, T, F) are taken to: encoded and decoded, float64."""
        code = self.encode(features)
        return self.decode(code, np.shape(features)[1])

    def _parts(self, values: Array) -> list[Tensor]:
        """Return arrays as the network takes them, as many at once as memory should hold."""
        seen_as = next(self.network.parameters())  # its precision and its device
        return list(torch.split(torch.from_numpy(values.astype(np.float64)).to(seen_as), _AT_ONCE))


def motions_of(features: npt.ArrayLike, n_features: int, *, name: str = "features") -> Array:
    """Read motions (n, T, F) of so many features.

    Raises
    ------
    TypeError, ValueError
        If they are not that, none, or not finite; the message begins with `name`.
    """
    array = real_array(name, features)
    if array.ndim != 3 or array.shape[2] != n_features or 0 in array.shape:
        raise ValueError(f"{name}: expected shape (n, T, {n_features}), got {array.shape}")
    check_finite(name, array)
    return array


def mirrored(motions: Array, stride: int, least: int = 1) -> Array:
    """Return motions (n, T, F), mirrored at the end until T is `least` or more and a multiple of `stride`."""
    n_frames = max(motions.shape[1], least)
    more = n_frames + -n_frames % stride - motions.shape[1]
    return np.pad(motions, ((0, 0), (0, more), (0, 0)), mode="reflect")
