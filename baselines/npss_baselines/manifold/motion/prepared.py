"""Read and prepare motion from all given sources."""

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

__all__ = ["motion_set"]

Root = str | os.PathLike[str]


def motion_set(
    folders: Mapping[str, Root] | None = None, *, cache: Root | None = None, quick: bool = False
) -> MotionSet:
    """Read and prepare motion from folders; without any, generate it.

    Parameters
    ----------
    folders : mapping of str to path, optional
        Folders by source name in `npss_baselines.data.SOURCES`. Without any, walks are generated.
    cache : path, optional
        A folder for prepared sets, created if missing. A cached set is used while the names, sizes and modification
        times of all its files are unchanged. A broken cache file is replaced.
    quick : bool, optional
        Read the small part that each source defines, to try things out.

    Returns
    -------
    MotionSet
        The clips by source, in the order of the registry.

    Raises
    ------
    FileNotFoundError, ValueError
        As raised by the sources and by `prepare`, or if a source does not exist.
    """
    paths = dict(folders or {})
    for name in paths:
        one_of("folders", name, tuple(SOURCES))
    roots = {name: Path(paths[name]) for name in SOURCES if name in paths}

    def make() -> MotionSet:
        return prepare(_clips(roots, None if cache is None else Path(cache), quick))

    if cache is None or not roots:
        return make()
    files = {source: _stamps(root) for source, root in roots.items()}
    return cached(Path(cache), {"quick": quick, "files": files}, make)


def _clips(roots: Mapping[str, Path], cache: Path | None, quick: bool) -> Iterator[Clip]:
    """Read the clips of sources, and show progress."""
    if not roots:
        yield from SOURCES["synthetic"].clips(Path(), quick=quick)
    for name, root in roots.items():
        with Progress(f"reading {name}") as progress:
            yield from SOURCES[name].clips(root, quick=quick, cache=cache, progress=progress)


def _stamps(root: Path) -> list[tuple[str, int, int]]:
    """Return name, size and modification time of all files below a folder, sorted by name."""
    files = sorted(path for path in root.rglob("*") if path.is_file())
    return [(path.relative_to(root).as_posix(), (stat := path.stat()).st_size, stat.st_mtime_ns) for path in files]
