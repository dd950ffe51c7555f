"""Sets of prepared motion: every clip at 30 frames per second, on one skeleton, as features and in windows."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from npss.console import Progress
from npss.files import doing, parse_json, write_stream_atomically
from npss.skeleton import Skeleton
from npss.validation import each
from npss_baselines.data.cmu import cmu_clips, styles_clips
from npss_baselines.data.motion import JOINTS, Clip
from npss_baselines.data.motion_h36m import h36m_clips
from npss_baselines.data.motion_synthetic import synthetic_clips
from npss_baselines.manifold.motion.features import FPS, normalise_lengths, to_features
from npss_baselines.manifold.motion.ground import level, on_ground
from npss_baselines.manifold.motion.resample import resample
from npss_baselines.manifold.motion.windows import left_out, windows_of

Float32 = npt.NDArray[np.float32]
Root = str | os.PathLike[str]

#: Raised whenever the same files give other features, be it for how they are read: sets of other versions are not read.
VERSION = 1
#: Whom nothing is trained on.
TEST_SUBJECTS = ("cmu/02", "cmu/14", "h36m/S5", "synthetic/0", "synthetic/1")
#: Sources that do not say which way is up.
TILTED = ("h36m",)
#: What `motion_set(quick=True)` reads: all clips of some subjects of CMU, and the first few of each of some of
#: Human3.6M's and of the dances and martial arts.
QUICK_CMU, QUICK_H36M, QUICK_CLIPS = ("02", "08", "09"), (1, 5), 2


@dataclass(frozen=True)
class ClipInfo:
    """What a prepared clip is; see `npss_baselines.data.motion.Clip`.

    Attributes
    ----------
    name, source, subject, description : str
        As of the clip.
    n_frames : int
        At 30 frames per second.
    """

    name: str
    source: str
    subject: str
    description: str
    n_frames: int


@dataclass(frozen=True, eq=False)
class MotionSet:
    """Motion that has been prepared.

    Attributes
    ----------
    clips : tuple of ClipInfo
        What there is.
    features : tuple of (T_i, F) ndarray of float32
        Of every clip, whole.
    windows : (n, 160, F) ndarray of float32
        Those of `npss_baselines.manifold.motion.windows.windows_of`, clip after clip.
    mask : (n, 160) ndarray of bool
        False where a frame is padding.
    clip_of : (n,) ndarray of int
        Which clip each window is of.
    """

    clips: tuple[ClipInfo, ...]
    features: tuple[Float32, ...]
    windows: Float32
    mask: npt.NDArray[np.bool_]
    clip_of: npt.NDArray[np.intp]

    def only(
        self,
        *,
        subjects: Collection[str] | None = None,
        sources: Collection[str] | None = None,
        exclude_subjects: Collection[str] = (),
    ) -> MotionSet:
        """Return the part of the set that is of some subjects and sources: splits are by subject, never by window.

        Parameters
        ----------
        subjects, sources : collection of str, optional
            Whose and which clips stay; by default all.
        exclude_subjects : collection of str, optional
            Whose do not, such as `TEST_SUBJECTS`. A clip whose subject is not stated (``cmu-styles``) stays.

        Raises
        ------
        TypeError
            If one of them is a single name.
        ValueError
            If no clip is left.
        """
        wanted, named, excluded = (
            None if names is None else set(each(what, names, "names", ordered=False))
            for what, names in (
                ("subjects", subjects),
                ("sources", sources),
                ("exclude_subjects", exclude_subjects),
            )
        )
        stay = [
            i
            for i, clip in enumerate(self.clips)
            if (wanted is None or clip.subject in wanted)
            and (named is None or clip.source in named)
            and clip.subject not in (excluded or ())
        ]
        if not stay:
            raise ValueError(
                f"no clip is left of {len(self.clips)} by subjects {subjects}, sources {sources}, "
                f"without {exclude_subjects}"
            )
        return _set_of([self.clips[i] for i in stay], [self.features[i] for i in stay])

    def counts(self) -> dict[str, int]:
        """Count what there is, for reports.

        Returns
        -------
        dict of str to int
            ``clips``; ``windows``, whole ones; ``padded``, clips too short for one, which are one padded window each;
            ``frames`` at 30 frames per second; ``left_out``, those of them behind the last whole window of a clip.
        """
        whole = self.mask.all(axis=1)
        frames = [clip.n_frames for clip in self.clips]
        return {
            "clips": len(self.clips),
            "windows": int(whole.sum()),
            "padded": int((~whole).sum()),
            "frames": sum(frames),
            "left_out": sum(map(left_out, frames)),
        }


def prepare(clips: Iterable[Clip], *, skeleton: Skeleton = JOINTS) -> MotionSet:
    """Prepare clips: resample them, give them one skeleton, put them on the ground, and take features.

    Parameters
    ----------
    clips : iterable of Clip
        Read one after the other.
    skeleton : npss.skeleton.Skeleton, optional
        Whose bones all get.

    Returns
    -------
    MotionSet
        In the unit of the skeleton: of `JOINTS`, heights.

    Raises
    ------
    ValueError
        If there are no clips, two of a source have the same name, or one cannot be prepared: names it.

    Notes
    -----
    No source says how high the ground is, and some (`TILTED`) not which way is up: see `ground`.

    Examples
    --------
    >>> from npss_baselines.data.motion_synthetic import synthetic_clips
    >>> walks = prepare(synthetic_clips(2, 250, seed=0))
    >>> walks.windows.shape, walks.counts()
    ((4, 160, 63), {'clips': 2, 'windows': 4, 'padded': 0, 'frames': 500, 'left_out': 20})
    """
    infos: dict[tuple[str, str], ClipInfo] = {}
    features = []
    for clip in clips:
        name = f"{clip.source} {clip.name}"
        if (clip.source, clip.name) in infos:
            raise ValueError(f"clips: {name} is there twice")
        try:
            positions = normalise_lengths(resample(clip.positions, clip.fps), skeleton)
            if clip.source in TILTED:
                positions = level(positions, skeleton)
            rows = to_features(on_ground(positions), skeleton).astype(np.float32)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        features.append(rows)
        infos[clip.source, clip.name] = ClipInfo(clip.name, clip.source, clip.subject, clip.description, len(rows))
    if not features:
        raise ValueError("clips: there are none")
    return _set_of(infos.values(), features)


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


def cached(folder: Path, key: Any, make: Callable[[], MotionSet]) -> MotionSet:
    """Return the set that a folder keeps under a key, or make it, and keep it.

    Parameters
    ----------
    folder : Path
        Made if need be.
    key : anything that json can write
        What the set is made from. `VERSION` and the skeleton `JOINTS` are part of it anyway.
    make : callable
        What makes the set. Called if the folder does not have it, or the file is broken.
    """
    whole = json.dumps([VERSION, FPS, JOINTS.names, JOINTS.offsets.tolist(), key])
    path = folder / f"motion-{hashlib.sha256(whole.encode()).hexdigest()[:32]}.npz"
    with contextlib.suppress(FileNotFoundError, ValueError):
        return load(path)
    made = make()
    with doing("making the cache"):
        folder.mkdir(parents=True, exist_ok=True)
    save(path, made)
    return made


def save(path: Path, motion: MotionSet) -> None:
    """Write a set to a file: all of it or nothing.

    Parameters
    ----------
    path : Path
        A file, ``.npz``: the features of all clips, one below the other, and what the clips are as JSON.
    motion : MotionSet
        The set.
    """
    header = json.dumps({"version": VERSION, "clips": [asdict(clip) for clip in motion.clips]})
    features = np.concatenate(motion.features)
    write_stream_atomically(path, lambda stream: np.savez(stream, header=np.array(header), features=features))


def load(path: Path) -> MotionSet:
    """Read a set from a file.

    Parameters
    ----------
    path : Path
        From `save`.

    Returns
    -------
    MotionSet
        As it was.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    ValueError
        If it is another file, of another version, or broken: names it.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            header, rows = parse_json(file["header"].item()), file["features"]
        if header["version"] != VERSION:
            raise ValueError(f"version {header['version']}, not {VERSION}")
        clips = [ClipInfo(**clip) for clip in header["clips"]]
        _check(clips, rows)
    except (ValueError, TypeError, KeyError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: not a set of prepared motion, or a broken one: {error}") from error
    ends = np.cumsum([clip.n_frames for clip in clips])
    return _set_of(clips, np.split(rows, ends[:-1]))


def _check(clips: Sequence[ClipInfo], rows: npt.NDArray[Any]) -> None:
    """Raise an error unless these are clips and the features of all their frames."""
    for clip in clips:
        if type(clip.n_frames) is not int or clip.n_frames < 1:
            raise ValueError(f"clip {clip.name!r} of {clip.n_frames!r} frames")
        if not all(isinstance(text, str) for text in (clip.name, clip.source, clip.subject, clip.description)):
            raise ValueError(f"clip {clip.name!r} is not described in words")
    n_frames = sum(clip.n_frames for clip in clips)
    if rows.dtype != np.float32 or rows.ndim != 2 or len(rows) != n_frames or 0 in rows.shape:
        raise ValueError(f"features of dtype {rows.dtype} and shape {rows.shape} for {n_frames} frames")
    if not np.isfinite(rows).all():
        raise ValueError("features that are not finite")


def _set_of(clips: Iterable[ClipInfo], features: Sequence[Float32]) -> MotionSet:
    """Cut clips into windows."""
    windows, masks = zip(*map(windows_of, features), strict=True)
    clip_of = np.repeat(np.arange(len(features)), [len(mask) for mask in masks])
    return MotionSet(tuple(clips), tuple(features), np.concatenate(windows), np.concatenate(masks), clip_of)


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
