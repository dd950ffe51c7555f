"""The motion manifold of Holden et al. (2015), and functions on clips of one's own.

The functions take and return clips as `npss_baselines.data.bvh` reads them, of any skeleton, and need no torch. They
are imported when they are used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from npss_baselines.manifold.clips.blend import interpolate
    from npss_baselines.manifold.clips.example import damaged, example
    from npss_baselines.manifold.clips.gap import Gap
    from npss_baselines.manifold.clips.insertion import insert
    from npss_baselines.manifold.clips.outcome import Outcome
    from npss_baselines.manifold.clips.projection import project
    from npss_baselines.manifold.clips.repair import fill, inbetween, repair
    from npss_baselines.manifold.clips.sampling import sample
    from npss_baselines.manifold.clips.search import nearest

__all__ = [
    "Gap",
    "Outcome",
    "damaged",
    "example",
    "fill",
    "inbetween",
    "insert",
    "interpolate",
    "nearest",
    "project",
    "repair",
    "sample",
]

_PLACES = {
    "Gap": "gap",
    "Outcome": "outcome",
    "damaged": "example",
    "example": "example",
    "fill": "repair",
    "inbetween": "repair",
    "insert": "insertion",
    "interpolate": "blend",
    "nearest": "search",
    "project": "projection",
    "repair": "repair",
    "sample": "sampling",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'npss_baselines.manifold' has no attribute {name!r}")
    value = getattr(import_module(f"npss_baselines.manifold.clips.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
