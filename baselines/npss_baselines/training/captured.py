"""A loss and its gradients as a CUDA graph: captured once, then replayed by a single launch.

A recurrent network runs thousands of small kernels one after another; each takes less time than its launch from Python.
A CUDA graph launches all of them at once. Several graphs, each on its own stream, run side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor, nn
from torch.autograd.function import once_differentiable

#: A function from a batch to the loss, ``'loss'``, and its parts.
Loss = Callable[..., dict[str, Tensor]]

_WARM_UP = 2  # passes, for the libraries' memory and plans, which cannot be made in a capture


class Captured:
    """The loss of a batch and its gradients, as a CUDA graph.

    A replay with a seed computes ``loss(*batch)`` after ``torch.manual_seed(seed)``, and its gradients.

    Parameters
    ----------
    loss : callable
        Function from a batch to the loss and its parts. It may draw from torch's global generator. Its control flow
        must not depend on values, because it is not called again.
    batch : sequence of Tensor
        The first batch, on a CUDA device; later ones have the same shapes.
    parameters : sequence of Parameter
        Parameters of the gradients. They may only change in place.
    """

    def __init__(self, loss: Loss, batch: Sequence[Tensor], parameters: Sequence[nn.Parameter]) -> None:
        device = batch[0].device
        self._batch = [value.clone() for value in batch]
        self._parameters = [parameter for parameter in parameters if parameter.requires_grad]
        self._stream = torch.cuda.Stream(device)  # type: ignore[no-untyped-call]
        self._generator = _generator(device).clone_state()
        self._graph = torch.cuda.CUDAGraph()
        with _drawing_from(self._generator, device):
            self._stream.wait_stream(torch.cuda.current_stream(device))
            with torch.cuda.stream(self._stream):
                for _ in range(_WARM_UP):
                    self._run(loss)
            with torch.cuda.graph(self._graph, stream=self._stream):
                self._parts, self._gradients = self._run(loss)

    def launch(self, seed: int, batch: Sequence[Tensor]) -> None:
        """Launch a batch without waiting for it."""
        self._stream.wait_stream(torch.cuda.current_stream(self._stream.device))
        with torch.cuda.stream(self._stream):
            for captured, value in zip(self._batch, batch, strict=True):
                captured.copy_(value)
            self._generator.manual_seed(seed)
            self._graph.replay()

    def result(self) -> dict[str, Tensor]:
        """Return the loss of the last batch, and its parts.

        The loss can be backpropagated until the next launch: its gradients are already computed.
        """
        torch.cuda.current_stream(self._stream.device).wait_stream(self._stream)
        parts = {name: value.clone() for name, value in self._parts.items()}
        loss = _Replayed.apply(parts["loss"], self._gradients, *self._parameters)  # type: ignore[no-untyped-call]
        return {**parts, "loss": loss}

    def _run(self, loss: Loss) -> tuple[dict[str, Tensor], tuple[Tensor, ...]]:
        with torch.enable_grad():
            parts = loss(*self._batch)
            gradients = torch.autograd.grad(parts["loss"], self._parameters)
        return {name: value.detach() for name, value in parts.items()}, gradients


class _Replayed(torch.autograd.Function):
    """A loss whose gradients are already computed."""

    @staticmethod
    def forward(ctx: Any, loss: Tensor, gradients: Sequence[Tensor], *parameters: Tensor) -> Tensor:
        ctx.gradients = gradients
        return loss.view_as(loss)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor | None, ...]:
        return None, None, *torch._foreach_mul(ctx.gradients, grad)


def _generator(device: torch.device) -> torch.Generator:
    """Return torch's global generator of a CUDA device."""
    generator: torch.Generator = torch.cuda.default_generators[device.index]
    return generator


@contextmanager
def _drawing_from(generator: torch.Generator, device: torch.device) -> Iterator[None]:
    """Replace the state of torch's global generator by that of another: each graph has its own."""
    default = _generator(device)
    before = default.graphsafe_get_state()
    default.graphsafe_set_state(generator)
    try:
        yield
    finally:
        default.graphsafe_set_state(before)
