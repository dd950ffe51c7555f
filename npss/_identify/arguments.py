"""Find out which argument of a function is the ground truth, from the names of its parameters."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any, NamedTuple

#: Words in names of parameters, whole; and their beginnings or ends.
_TRUTH = (
    "actual",
    "expected",
    "label",
    "labels",
    "orig",
    "original",
    "real",
    "ref",
    "reference",
    "refs",
    "target",
    "targets",
)
_TRUTH_PARTS = ("gt", "true", "truth", "target", "ground")
_PREDICTION = ("est", "fake", "gen", "gens", "hat", "hyp", "out", "output", "outputs", "recon", "synth")
_PREDICTION_PARTS = ("pred", "estimate", "forecast", "generat", "reconstruct", "synthe", "yhat")


class Parameters(NamedTuple):
    """The two parameters that take motions."""

    names: tuple[str, str] | None  # to pass them by, if they are keyword-only
    order: str | None  # "gt,pred", "pred,gt", or None if the names do not say


def parameters_of(function: Callable[..., Any]) -> Parameters:
    """Read the parameters of a function of two motions.

    Raises
    ------
    ValueError
        If it does not take two motions and nothing else.
    """
    name = getattr(function, "__qualname__", type(function).__qualname__)
    try:
        # The parameters of a module of torch are those of its method.
        signature = inspect.signature(getattr(function, "forward", function))
    except (TypeError, ValueError):  # some functions written in C have no signature
        return Parameters(None, None)
    found = list(signature.parameters.values())
    named = [each for each in found if each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD)]
    required = [each for each in named if each.default is each.empty]
    positional = [each for each in named if each.kind is not each.KEYWORD_ONLY]
    if len(required) > 2:
        others = ", ".join(each.name for each in required[2:])
        raise ValueError(
            f"function: {name}{signature} needs more than two motions ({others}); "
            f"pass a function of two, such as lambda gt, pred: {name}(gt, pred, ...)"
        )
    pair = required if len(required) == 2 else [*positional[:2]]
    if len(pair) < 2 and not any(each.kind is each.VAR_POSITIONAL for each in found):
        raise ValueError(f"function: expected a function of two motions, got {name}{signature}")
    if len(pair) < 2:
        return Parameters(None, None)
    first, second = (each.name for each in pair)
    by_keyword = any(each.kind is each.KEYWORD_ONLY for each in pair) or pair != positional[:2]
    return Parameters((first, second) if by_keyword else None, order_of(first, second))


def order_of(first: str, second: str) -> str | None:
    """Return which of two names is the ground truth, ``"gt,pred"`` or ``"pred,gt"``; None if they do not say."""
    words, others = _words(first), _words(second)
    # What the names share says nothing: target_gt, target_pred.
    is_first, is_second = _role(words - others), _role(others - words)
    if is_first and is_second and is_first != is_second:
        return f"{is_first},{is_second}"
    if is_first and not is_second:
        return "gt,pred" if is_first == "gt" else "pred,gt"
    if is_second and not is_first:
        return "gt,pred" if is_second == "pred" else "pred,gt"
    return None


def _words(name: str) -> set[str]:
    return {word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}


def _role(words: set[str]) -> str | None:
    roles = {
        role
        for role, whole, parts in (("gt", _TRUTH, _TRUTH_PARTS), ("pred", _PREDICTION, _PREDICTION_PARTS))
        for word in words
        if word in whole or any(word.startswith(part) or word.endswith(part) for part in parts)
    }
    return roles.pop() if len(roles) == 1 else None
