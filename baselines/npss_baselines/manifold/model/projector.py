"""Projectors of motion onto a manifold: the protocol, and the autoencoder's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from npss.validation import Array, check_finite, positive_integer, real_array
from npss_baselines.manifold.model.autoencoder import Autoencoder
from npss_baselines.manifold.model.matrix_products import MatrixProducts
from npss_baselines.manifold.motion.scaling import Scaling

__all__ = ["Manifold", "Projector"]

_AT_ONCE = 16  # motions of a part: those of 160 frames stay in a processor's cache


class Projector(Protocol):
    """A manifold of motions of any length, as features of `npss_baselines.manifold.motion.features`."""

    @property
    def signature(self) -> str:
        """The identity of the projector, to the bit; part of the signature of numbers that depend on it."""

    def encode(self, features: npt.ArrayLike) -> Array:
        """Return the code (n, T', H) of motions (n, T, F)."""

    def decode(self, code: npt.ArrayLike, n_frames: int) -> Array:
        """Return the motions (n, n_frames, F) of codes (n, T', H)."""

    def project(self, features: npt.ArrayLike) -> Array:
        """Project motions (n, T, F) onto the manifold."""


@dataclass(frozen=True, eq=False)
class Manifold:
    """An autoencoder as a `Projector`.

    Motion whose length is not a multiple of the frames per step is mirrored at its end, and cut again.

    Attributes
    ----------
    network : Autoencoder
        The network, on any device. Its weights must not change.
    scaling : Scaling
        Scaling of the features.
    signature : str
        Hash of the weights, the training data and the configuration.
    """

    network: Autoencoder
    scaling: Scaling
    signature: str

    def encode(self, features: npt.ArrayLike) -> Array:
        """Encode motions.

        Parameters
        ----------
        features : (n, T, F) array_like
            Motions, in the units of `npss_baselines.manifold.motion.features`.

        Returns
        -------
        (n, T', H) ndarray
            Hidden units of the last layer, between -1 and 1, in the network's precision; T' is T divided by the frames
            per step, rounded up.

        Raises
        ------
        TypeError, ValueError
            If the motions are invalid.
        """
        motions = motions_of(features, self.network.config.n_features)
        scaled = self.scaling.normalize(mirrored(motions, self.network.config.stride))
        return np.concatenate([self._products.encode(part).cpu().numpy() for part in self._parts(scaled)])

    def decode(self, code: npt.ArrayLike, n_frames: int) -> Array:
        """Decode motions.

        Parameters
        ----------
        code : (n, T', H) array_like
            Hidden units of the last layer, clipped to a magnitude of 1 - eps.
        n_frames : int
            Frames to return, at most those of T' steps.

        Returns
        -------
        (n, n_frames, F) ndarray of float64
            Motions, in the units of `npss_baselines.manifold.motion.features`.

        Raises
        ------
        TypeError, ValueError
            If the codes are invalid, or have fewer frames.
        """
        config = self.network.config
        steps = motions_of(code, config.widths[-1], name="code")
        if positive_integer("n_frames", n_frames) > steps.shape[1] * config.stride:
            raise ValueError(
                f"n_frames: {steps.shape[1]} steps have {steps.shape[1] * config.stride} frames, got {n_frames}"
            )
        motions = [self._products.decode(part).cpu().numpy() for part in self._parts(steps)]
        return self.scaling.unnormalize(np.concatenate(motions)[:, :n_frames])

    def project(self, features: npt.ArrayLike) -> Array:
        """Project motions (n, T, F): encode and decode them, in float64."""
        code = self.encode(features)
        return self.decode(code, np.shape(features)[1])

    @cached_property
    def _products(self) -> MatrixProducts:
        return MatrixProducts(self.network)

    def _parts(self, values: Array) -> list[Tensor]:
        """Convert arrays to tensors for the network, in parts that bound memory."""
        parameter = next(self.network.parameters())  # has the precision and the device
        return list(torch.split(torch.from_numpy(values.astype(np.float64, copy=False)).to(parameter), _AT_ONCE))


def motions_of(features: npt.ArrayLike, n_features: int, *, name: str = "features") -> Array:
    """Check motions (n, T, F) with `n_features` features.

    Raises
    ------
    TypeError, ValueError
        If the type or shape is wrong, or a value is not finite; the message begins with `name`.
    """
    array = real_array(name, features)
    if array.ndim != 3 or array.shape[2] != n_features or 0 in array.shape:
        raise ValueError(f"{name}: expected shape (n, T, {n_features}), got {array.shape}")
    check_finite(name, array)
    return array


def mirrored(motions: Array, stride: int, least: int = 1) -> Array:
    """Mirror motions (n, T, F) at the end until T is at least `least` and a multiple of `stride`."""
    n_frames = max(motions.shape[1], least)
    padding = n_frames + -n_frames % stride - motions.shape[1]
    return np.pad(motions, ((0, 0), (0, padding), (0, 0)), mode="reflect")
