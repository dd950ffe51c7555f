"""A loss and its gradients, captured once on a CUDA device and from then on replayed by a single launch.

A recurrent network does thousands of small things one after another, and each of them takes less time than to launch it
from Python. A CUDA graph launches all of them at once; several graphs, each on a stream of its own, run side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor, nn
from torch.autograd.function import once_differentiable

#: From a batch to the loss, ``'loss'``, and its parts.
Loss = Callable[..., dict[str, Tensor]]

_WARM_UP = 2  # passes, so that libraries have the memory and the plans that they cannot ask for in a capture


class Captured:
    """The loss of a batch and its gradients, as a CUDA graph.

    Replayed with a seed, it computes what ``loss(*batch)`` does after ``torch.manual_seed(seed)``, gradients included.

    Parameters
    ----------
    loss : callable
        From a batch to the loss and its parts. It may draw from torch's global generator. What it does must not depend
        on values: it is not called again.
    batch : sequence of Tensor
        The first batch, on a CUDA device; others have the same shapes.
    parameters : sequence of Parameter
        What the gradients are of. They are changed in place, or not at all.
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
        """Begin with a batch, and do not wait for it."""
        self._stream.wait_stream(torch.cuda.current_stream(self._stream.device))
        with torch.cuda.stream(self._stream):
            for own, value in zip(self._batch, batch, strict=True):
                own.copy_(value)
            self._generator.manual_seed(seed)
            self._graph.replay()

    def result(self) -> dict[str, Tensor]:
        """Return the loss of the batch that was launched last, and its parts.

        The loss can be backpropagated until the next launch: its gradients are there already.
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
    """A loss whose gradients are there already."""

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
    """Let what draws from torch's global generator draw from another one: each graph has its own."""
    default = _generator(device)
    before = default.graphsafe_get_state()
    default.graphsafe_set_state(generator)
    try:
        yield
    finally:
        default.graphsafe_set_state(before)
