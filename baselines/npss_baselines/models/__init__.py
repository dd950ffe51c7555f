"""The models of the NPSS paper and its baselines, their recipes, and a registry for more."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from npss_baselines.models.base import POSE, MotionModel
    from npss_baselines.models.recipe import Recipe
    from npss_baselines.models.registry import MODELS, ModelSpec, register_model

__all__ = ["MODELS", "POSE", "ModelSpec", "MotionModel", "Recipe", "register_model"]

_PLACES = {"POSE": "base", "MotionModel": "base", "Recipe": "recipe"}


def __getattr__(name: str) -> Any:
    # Imported on first access: commands without models need no torch.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_PLACES.get(name, 'registry')}"), name)
