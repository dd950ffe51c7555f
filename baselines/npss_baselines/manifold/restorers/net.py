"""A small network of fully connected layers, applied with numpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Array

Float32 = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Net:
    """Layers of rectified linear units, and a linear one.

    Attributes
    ----------
    weights : tuple of (in, out) ndarray of float32
        The weights of each layer.
    biases : tuple of (out,) ndarray of float32
        The biases of each layer.
    """

    weights: tuple[Float32, ...]
    biases: tuple[Float32, ...]

    def __call__(self, inputs: Array) -> Float32:
        """Return the outputs ``(n, out)`` of inputs ``(n, in)``."""
        values = np.asarray(inputs, np.float32)
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True), 1):
            values = values @ weight + bias
            if number < len(self.weights):
                np.maximum(values, 0, out=values)
        return values


def mean_of(nets: tuple[Net, ...], inputs: Array) -> Float32:
    """Return the mean output of several networks."""
    total = nets[0](inputs)
    for net in nets[1:]:
        total = total + net(inputs)
    return total / np.float32(len(nets))
