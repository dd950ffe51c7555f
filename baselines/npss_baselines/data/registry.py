"""The registry of sources of motion."""

from __future__ import annotations

import re

from npss.plugins import Registry
from npss_baselines.data.bvh_folder import BvhFolder
from npss_baselines.data.cmu import CMU, CMUStyles
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.source import PoseSource, Source
from npss_baselines.data.synthetic import Synthetic

#: Sources by name, in the order in which their motion is read.
SOURCES: Registry[Source] = Registry(
    "source", {source.name: source for source in (CMU(), CMUStyles(), Human36M(), BvhFolder(), Synthetic())}
)


_ARGUMENTS = """
    action actions apart application arguments at average budget by cache caption checkpoint-every clip
    clips columns config damaged data depth device draws end every extra facing folder format fps frames
    from future h help hold-out insert iterations joint keys label layers level like list loss manifold
    mapping max-size method methods metrics missing model models n name o only out output parser past
    pictures plan plugin protocol published quick recipe reference report restorer resume run run-name
    runs scale second seed seeds select sequences share shell shortest size start stats subjects
    tensorboard test test-windows tf32 threads to train train-windows transitions truth units unwrap up
    validate-every validate-on version whole wide windows workers
"""
#: Names of the commands' own arguments, which no option of a source can have. A test compares them with the commands.
RESERVED = tuple(_ARGUMENTS.split())


def register_source(source: Source, *, replace: bool = False) -> None:
    """Register a source for the commands.

    Parameters
    ----------
    source : Source
        A `PoseSource`, for models to predict, or another `Source`, for the manifold alone.
    replace : bool, optional
        Replace a registered source of the same name, as when a notebook cell is run again.

    Raises
    ------
    TypeError
        If it is not a source, or its name, option or description is not text.
    ValueError
        If its name or option does not consist of lower-case letters, digits and hyphens, or is taken: by a built-in
        source, by another one without `replace`, or by an option of a command.

    Examples
    --------
    >>> from npss_baselines.data import SOURCES, register_source
    >>> register_source(SOURCES["synthetic"])  # as if it were your own
    Traceback (most recent call last):
    ValueError: the source 'synthetic' is registered already
    """
    if not isinstance(source, Source):
        raise TypeError(f"source: expected an npss_baselines.data.Source, got {source!r}")
    for attribute in ("name", "option", "description"):
        if not isinstance(text := getattr(source, attribute, None), str):
            raise TypeError(f"source: {attribute}: expected text, got {text!r}")
        if attribute != "description" and not re.fullmatch("[a-z0-9][a-z0-9-]*", text):
            raise ValueError(f"source: {attribute}: expected lower-case letters, digits and hyphens, got {text!r}")
    if "%" in source.description:  # which command lines fill in
        raise ValueError(f"source: description: expected text without %, got {source.description!r}")
    if source.option in RESERVED:
        raise ValueError(f"source: option: --{source.option} is an option of the commands; choose another")
    if source.option in (other.option for other in SOURCES.values() if other.name != source.name):
        raise ValueError(f"source: option: --{source.option} is the option of another source; choose another")
    SOURCES.register(source.name, source, replace=replace)


def pose_sources() -> dict[str, PoseSource]:
    """Return the sources that models can predict.

    Returns
    -------
    dict of str to PoseSource
        The sources by name, in the order of registration.
    """
    return {name: source for name, source in SOURCES.items() if isinstance(source, PoseSource)}
