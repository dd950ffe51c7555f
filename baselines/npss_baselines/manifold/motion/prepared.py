"""All motion that a user has, read and prepared; or generated motion."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path

from npss.console import Progress
from npss_baselines.data.cmu import cmu_clips, styles_clips
from npss_baselines.data.human36m import h36m_clips
from npss_baselines.data.motion import Clip
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.motion.cache import cached
from npss_baselines.manifold.motion.dataset import MotionSet, prepare

Root = str | os.PathLike[str]

#: What `motion_set(quick=True)` reads: all clips of some subjects of CMU, and the first few of each of some of
#: Human3.6M's and of the dances and martial arts.
QUICK_CMU, QUICK_H36M, QUICK_CLIPS = ("02", "08", "09"), (1, 5), 2


def motion_set(
    cmu: Root | None = None,
    styles: Root | None = None,
    h36m: Root | None = None,
    *,
    cache: Root | None = None,
    quick: bool = False,
) -> MotionSet:
    """Read and prepare all that a user has, or generate motion where that is nothing.

    Parameters
    ----------
    cmu, styles, h36m : path, optional
        The folders of CMU's clips, of more of its dances and martial arts, and of Human3.6M. Without any of them it is
        32 generated walks of 500 frames.
    cache : path, optional
        A folder, made if need be, that keeps prepared sets. A set is read from there as long as the names, sizes and
        times of all files that it was made from are the same; a file there that is broken is written anew.
    quick : bool, optional
        A small part of it, for trying things: of CMU the subjects `QUICK_CMU`; of Human3.6M, for each of the subjects
        `QUICK_H36M`, the first `QUICK_CLIPS` clips, and as many dances; of generated walks 8.

    Returns
    -------
    MotionSet
        By source in this order, each in its own order.

    Raises
    ------
    FileNotFoundError, ValueError
        As the sources; or as `prepare`.
    """
    sources = {"cmu": cmu, "cmu-styles": styles, "h36m": h36m}
    roots = {source: Path(root) for source, root in sources.items() if root is not None}

    def make() -> MotionSet:
        return prepare(_clips(roots, cache, quick))

    if cache is None or not roots:
        return make()
    files = {source: _stamps(root) for source, root in roots.items()}
    return cached(Path(cache), {"quick": quick, "files": files}, make)


def _clips(roots: dict[str, Path], cache: Root | None, quick: bool) -> Iterator[Clip]:
    """Read the clips of some sources, and say how far it is."""
    if not roots:
        yield from synthetic_clips(8 if quick else 32, 500, seed=0)
    for source, root in roots.items():
        with Progress(f"reading {source}") as progress:
            yield from _read(source, root, cache, quick, progress)


def _read(source: str, root: Path, cache: Root | None, quick: bool, progress: Progress) -> Iterator[Clip]:
    if source == "cmu":
        return cmu_clips(root, subjects=QUICK_CMU if quick else None, progress=progress)
    if source == "cmu-styles":
        return islice(styles_clips(root, progress=progress), QUICK_CLIPS if quick else None)
    if not quick:
        return h36m_clips(root, cache=cache, progress=progress)
    each_subject = (h36m_clips(root, subjects=[subject], cache=cache) for subject in QUICK_H36M)
    return chain.from_iterable(islice(clips, QUICK_CLIPS) for clips in each_subject)


def _stamps(root: Path) -> list[tuple[str, int, int]]:
    """Return name, size and time of change of all files below a folder, in the order of names."""
    files = sorted(path for path in root.rglob("*") if path.is_file())
    return [(path.relative_to(root).as_posix(), (stat := path.stat()).st_size, stat.st_mtime_ns) for path in files]
