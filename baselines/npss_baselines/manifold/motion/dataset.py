"""Prepared motion: all clips at 30 frames per second, on one skeleton, as features and windows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import each
from npss_baselines.data import SOURCES
from npss_baselines.data.motion import JOINTS, Clip
from npss_baselines.manifold.motion.bones import normalise_lengths
from npss_baselines.manifold.motion.features import to_features
from npss_baselines.manifold.motion.ground import level, on_ground
from npss_baselines.manifold.motion.resample import resample
from npss_baselines.manifold.motion.windows import left_out, windows_of

__all__ = ["MotionSet", "prepare"]

Float32 = npt.NDArray[np.float32]


@dataclass(frozen=True)
class ClipInfo:
    """The description of a prepared clip; see `npss_baselines.data.motion.Clip`.

    Attributes
    ----------
    name, source, subject, description : str
        Those of the clip.
    n_frames : int
        Number of frames at 30 frames per second.
    """

    name: str
    source: str
    subject: str
    description: str
    n_frames: int


@dataclass(frozen=True, eq=False)
class MotionSet:
    """A set of prepared motion.

    Attributes
    ----------
    clips : tuple of ClipInfo
        The clips.
    features : tuple of (T_i, F) ndarray of float32
        The features of each whole clip.
    windows : (n, 160, F) ndarray of float32
        The windows of all clips in order; see `npss_baselines.manifold.motion.windows.windows_of`.
    mask : (n, 160) ndarray of bool
        False where a frame is padding.
    clip_of : (n,) ndarray of int
        The index of each window's clip.
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
        """Select clips by subject and source: splits are by subject, never by window.

        Parameters
        ----------
        subjects, sources : collection of str, optional
            Subjects and sources to keep (default: all).
        exclude_subjects : collection of str, optional
            Subjects to remove, such as `npss_baselines.manifold.motion.split.held_out_subjects`. Clips of unknown
            subjects (``cmu-styles``) stay.

        Raises
        ------
        TypeError
            If an argument is a single name.
        ValueError
            If no clip remains.
        """
        kept_subjects, kept_sources, excluded = (
            None if names is None else set(each(argument, names, "names", ordered=False))
            for argument, names in (
                ("subjects", subjects),
                ("sources", sources),
                ("exclude_subjects", exclude_subjects),
            )
        )
        indices = [
            i
            for i, clip in enumerate(self.clips)
            if (kept_subjects is None or clip.subject in kept_subjects)
            and (kept_sources is None or clip.source in kept_sources)
            and clip.subject not in (excluded or ())
        ]
        if not indices:
            raise ValueError(
                f"none of {len(self.clips)} clips matches: subjects {subjects}, sources {sources}, "
                f"excluded subjects {exclude_subjects}"
            )
        return motion_set_of([self.clips[i] for i in indices], [self.features[i] for i in indices])

    def counts(self) -> dict[str, int]:
        """Count clips, windows and frames, for reports.

        Returns
        -------
        dict of str to int
            ``clips``; ``windows``, the whole ones; ``padded``, one for each clip shorter than a window; ``frames`` at
            30 frames per second; ``left_out``, the frames after the last whole window of each clip.
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


def prepare(clips: Iterable[Clip]) -> MotionSet:
    """Prepare clips: resample, normalise bone lengths, put on the ground, compute features.

    Parameters
    ----------
    clips : iterable of Clip
        The clips, read one at a time.

    Returns
    -------
    MotionSet
        The prepared motion, in body heights.

    Raises
    ------
    ValueError
        If there are no clips, two clips of a source have the same name, or a clip cannot be prepared. The message names
        the clip.

    Notes
    -----
    No source states the height of the ground, and some (`Source.y_up`) do not state which way is up: see `ground`.

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
            positions = normalise_lengths(resample(clip.positions, clip.fps), JOINTS)
            if clip.source in SOURCES and not SOURCES[clip.source].y_up:
                positions = level(positions, JOINTS)
            rows = to_features(on_ground(positions), JOINTS).astype(np.float32)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        features.append(rows)
        infos[clip.source, clip.name] = ClipInfo(clip.name, clip.source, clip.subject, clip.description, len(rows))
    if not features:
        raise ValueError("clips: expected at least one")
    return motion_set_of(infos.values(), features)


def motion_set_of(clips: Iterable[ClipInfo], features: Sequence[Float32]) -> MotionSet:
    """Cut the features ``(T, F)`` of clips into windows, and return the set."""
    windows, masks = zip(*map(windows_of, features), strict=True)
    clip_of = np.repeat(np.arange(len(features)), [len(mask) for mask in masks])
    return MotionSet(tuple(clips), tuple(features), np.concatenate(windows), np.concatenate(masks), clip_of)
