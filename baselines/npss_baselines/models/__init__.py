"""The models of the NPSS paper and its baselines: see `npss_baselines.models.registry`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from npss_baselines.models.registry import MODELS, ModelSpec, register_model

__all__ = ["MODELS", "ModelSpec", "register_model"]


def __getattr__(name: str) -> Any:
    # Imported on first access: commands without models need no torch.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from npss_baselines.models import registry

    return getattr(registry, name)
