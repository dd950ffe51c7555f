"""A set of prepared motion: every clip at 30 frames per second, on one skeleton, as features and in windows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import each
from npss_baselines.data import SOURCES
from npss_baselines.data.motion import JOINTS, Clip
from npss_baselines.manifold.motion.bones import normalise_lengths
from npss_baselines.manifold.motion.features import to_features
from npss_baselines.manifold.motion.ground import level, on_ground
from npss_baselines.manifold.motion.resample import resample
from npss_baselines.manifold.motion.windows import left_out, windows_of

Float32 = npt.NDArray[np.float32]


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
            Whose do not, such as `npss_baselines.manifold.motion.split.held_out_subjects`. A clip whose subject is not
            stated (``cmu-styles``) stays.

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
        return motion_set_of([self.clips[i] for i in stay], [self.features[i] for i in stay])

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
    No source says how high the ground is, and some (`Source.y_up`) not which way is up: see `ground`.

    Examples
    --------
    >>> from npss_baselines.data.synthetic import synthetic_clips
    >>> walks = prepare(synthetic_clips(2, 250, seed=0))
    >>> walks.windows.shape, walks.counts()
    ((4, 160, 63), {'clips': 2, 'windows': 4, 'padded': 0, 'frames': 500, 'left_out': 20})
    """
    infos: dict[tuple[str, str], ClipInfo] = {}
    features = []
    for clip in clips:
        name = f"{clip.source} {clip.name}"
        if (clip.source, clip.name) in infos:
            raise ValueError(f"clips: {name}: duplicate clip")
        try:
            positions = normalise_lengths(resample(clip.positions, clip.fps), skeleton)
            if clip.source in SOURCES and not SOURCES[clip.source].y_up:
                positions = level(positions, skeleton)
            rows = to_features(on_ground(positions), skeleton).astype(np.float32)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        features.append(rows)
        infos[clip.source, clip.name] = ClipInfo(clip.name, clip.source, clip.subject, clip.description, len(rows))
    if not features:
        raise ValueError("clips: there are none")
    return motion_set_of(infos.values(), features)


def motion_set_of(clips: Iterable[ClipInfo], features: Sequence[Float32]) -> MotionSet:
    """Return clips with their features ``(T, F)`` cut into windows."""
    windows, masks = zip(*map(windows_of, features), strict=True)
    clip_of = np.repeat(np.arange(len(features)), [len(mask) for mask in masks])
    return MotionSet(tuple(clips), tuple(features), np.concatenate(windows), np.concatenate(masks), clip_of)
