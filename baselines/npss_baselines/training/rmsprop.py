"""RMSprop as in TensorFlow 1, which trained the NPSS paper's models."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor
from torch.optim import Optimizer

from npss.validation import is_real, positive_number


class RMSpropTF(Optimizer):
    """TensorFlow's version of RMSprop.

    For a gradient g, at each step::

        v = decay * v + (1 - decay) * g**2               initially 1
        m = momentum * m + lr * g / sqrt(v + epsilon)    initially 0
        parameter = parameter - m

    `torch.optim.RMSprop` differs in three ways. Its v starts at 0, so its first steps are 1 / sqrt(1 - decay) times the
    learning rate for every gradient, and far larger than these. Its epsilon is outside the root. Its learning rate is
    outside m, so a lower rate also scales the momentum of earlier steps.

    Parameters
    ----------
    params : iterable
        Parameters, or groups of parameters.
    lr : float
        The learning rate.
    decay : float
        Decay of the average of squares, below 1.
    momentum : float
        Momentum, below 1.
    epsilon : float
        Constant added to the average of squares.

    Raises
    ------
    TypeError, ValueError
        If a number is invalid.

    Examples
    --------
    >>> import torch
    >>> weight = torch.nn.Parameter(torch.tensor([1.0]))
    >>> optimizer = RMSpropTF([weight], lr=0.1)
    >>> (2 * weight).sum().backward()
    >>> optimizer.step()
    >>> round(1 - weight.item(), 4)  # 0.1 * 2 / sqrt(0.9 * 1 + 0.1 * 2**2)
    0.1754
    """

    def __init__(
        self, params: Any, lr: float, *, decay: float = 0.9, momentum: float = 0.95, epsilon: float = 1e-10
    ) -> None:
        positive_number("lr", lr)
        for name, value in (("decay", decay), ("momentum", momentum)):
            if not is_real(value):
                raise TypeError(f"{name}: expected a number, got {value!r}")
            if not 0 <= value < 1:
                raise ValueError(f"{name}: expected a number from 0 to below 1, got {value!r}")
        positive_number("epsilon", epsilon)
        super().__init__(params, {"lr": lr, "decay": decay, "momentum": momentum, "epsilon": epsilon})

    @torch.no_grad()
    def step(self, closure: Callable[[], Any] | None = None) -> Any:
        """Take a step; return the result of the closure, if any."""
        loss = None
        if closure is not None:
            with torch.enable_grad():
                loss = closure()
        for group in self.param_groups:
            pairs = [(parameter, parameter.grad) for parameter in group["params"] if parameter.grad is not None]
            if not pairs:
                continue
            parameters: list[Tensor] = [parameter for parameter, _ in pairs]
            gradients: list[Tensor] = [gradient for _, gradient in pairs]
            for parameter in parameters:
                state = self.state[parameter]
                if not state:
                    state["mean_square"] = torch.ones_like(parameter, memory_format=torch.preserve_format)
                    state["moment"] = torch.zeros_like(parameter, memory_format=torch.preserve_format)
            squares = [self.state[parameter]["mean_square"] for parameter in parameters]
            moments = [self.state[parameter]["moment"] for parameter in parameters]
            # All parameters at once: few launches per step on an accelerator.
            torch._foreach_mul_(squares, group["decay"])
            torch._foreach_addcmul_(squares, gradients, gradients, 1 - group["decay"])
            roots = torch._foreach_add(squares, group["epsilon"])
            torch._foreach_sqrt_(roots)
            torch._foreach_mul_(moments, group["momentum"])
            torch._foreach_addcdiv_(moments, gradients, roots, group["lr"])
            torch._foreach_sub_(parameters, moments)
        return loss
