"""The sources of motion by name: the one place that commands know data sets from."""

from __future__ import annotations

import re

from npss.plugins import Registry
from npss_baselines.data.cmu import CMU, CMUStyles
from npss_baselines.data.human36m import Human36M
from npss_baselines.data.source import PoseSource, Source
from npss_baselines.data.synthetic import Synthetic

#: By name, in the order in which motion is read from them.
SOURCES: Registry[Source] = Registry(
    "source", {source.name: source for source in (CMU(), CMUStyles(), Human36M(), Synthetic())}
)


def register_source(source: Source) -> None:
    """Add a source to those of the commands.

    Parameters
    ----------
    source : Source
        A `PoseSource`, for models to predict; any other one is for the manifold alone.

    Raises
    ------
    TypeError
        If it is no source.
    ValueError
        If its name or its option is not of lower-case letters, digits and hyphens, or another source has it.
    """
    if not isinstance(source, Source):
        raise TypeError(f"source: expected an npss_baselines.data.Source, got {source!r}")
    for what in ("name", "option"):
        if not re.fullmatch("[a-z0-9][a-z0-9-]*", getattr(source, what)):
            raise ValueError(
                f"source: {what}: expected lower-case letters, digits and hyphens, got {getattr(source, what)!r}"
            )
    if source.option in (other.option for other in SOURCES.values()):
        raise ValueError(f"source: the option --{source.option} is that of another source")
    SOURCES.register(source.name, source)


def pose_sources() -> dict[str, PoseSource]:
    """Return the sources of poses, for models to predict, by name."""
    return {name: source for name, source in SOURCES.items() if isinstance(source, PoseSource)}
