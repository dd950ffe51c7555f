"""All motion that a user has, read and prepared; or generated motion."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from npss.console import Progress
from npss.validation import one_of
from npss_baselines.data import SOURCES
from npss_baselines.data.motion import Clip
from npss_baselines.manifold.motion.cache import cached
from npss_baselines.manifold.motion.dataset import MotionSet, prepare

Root = str | os.PathLike[str]


def motion_set(
    folders: Mapping[str, Root] | None = None, *, cache: Root | None = None, quick: bool = False
) -> MotionSet:
    """Read and prepare all that a user has, or generate motion where that is nothing.

    Parameters
    ----------
    folders : mapping of str to path, optional
        Those of sources, by their names in `npss_baselines.data.SOURCES`. Without any, walks are generated.
    cache : path, optional
        A folder, made if need be, that keeps prepared sets. A set is read from there as long as the names, sizes and
        times of all files that it was made from are the same; a file there that is broken is written anew.
    quick : bool, optional
        Read a small part, to try things: what that is, each source says.

    Returns
    -------
    MotionSet
        By source in the order of the registry, each in its own order.

    Raises
    ------
    FileNotFoundError, ValueError
        As the sources; or as `prepare`; or if there is no such source.
    """
    named = dict(folders or {})
    for name in named:
        one_of("folders", name, tuple(SOURCES))
    roots = {name: Path(named[name]) for name in SOURCES if name in named}

    def make() -> MotionSet:
        return prepare(_clips(roots, None if cache is None else Path(cache), quick))

    if cache is None or not roots:
        return make()
    files = {source: _stamps(root) for source, root in roots.items()}
    return cached(Path(cache), {"quick": quick, "files": files}, make)


def _clips(roots: Mapping[str, Path], cache: Path | None, quick: bool) -> Iterator[Clip]:
    """Read the clips of some sources, and say how far it is."""
    if not roots:
        yield from SOURCES["synthetic"].clips(Path(), quick=quick)
    for name, root in roots.items():
        with Progress(f"reading {name}") as progress:
            yield from SOURCES[name].clips(root, quick=quick, cache=cache, progress=progress)


def _stamps(root: Path) -> list[tuple[str, int, int]]:
    """Return name, size and time of change of all files below a folder, in the order of names."""
    files = sorted(path for path in root.rglob("*") if path.is_file())
    return [(path.relative_to(root).as_posix(), (stat := path.stat()).st_size, stat.st_mtime_ns) for path in files]
