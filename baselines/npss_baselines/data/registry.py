"""The registry of sources of motion."""

from __future__ import annotations

import re

from npss.plugins import Registry
from npss_baselines.data.cmu import CMU, CMUStyles
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.source import PoseSource, Source
from npss_baselines.data.synthetic import Synthetic

#: Sources by name, in the order in which their motion is read.
SOURCES: Registry[Source] = Registry(
    "source", {source.name: source for source in (CMU(), CMUStyles(), Human36M(), Synthetic())}
)


def register_source(source: Source) -> None:
    """Register a source for the commands.

    Parameters
    ----------
    source : Source
        A `PoseSource`, for models to predict, or another `Source`, for the manifold alone.

    Raises
    ------
    TypeError
        If it is not a source.
    ValueError
        If its name or option does not consist of lower-case letters, digits and hyphens, or is taken.
    """
    if not isinstance(source, Source):
        raise TypeError(f"source: expected an npss_baselines.data.Source, got {source!r}")
    for attribute in ("name", "option"):
        if not re.fullmatch("[a-z0-9][a-z0-9-]*", text := getattr(source, attribute)):
            raise ValueError(f"source: {attribute}: expected lower-case letters, digits and hyphens, got {text!r}")
    if source.option in (other.option for other in SOURCES.values()):
        raise ValueError(f"source: another source has the option --{source.option}")
    SOURCES.register(source.name, source)


def pose_sources() -> dict[str, PoseSource]:
    """Return the sources that models can predict, by name."""
    return {name: source for name, source in SOURCES.items() if isinstance(source, PoseSource)}
