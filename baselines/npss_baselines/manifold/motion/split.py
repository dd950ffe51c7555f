"""Split motion into training, validation and test sets by subject, never by window."""

from __future__ import annotations

from typing import NamedTuple

from npss_baselines.data import SOURCES
from npss_baselines.manifold.motion.dataset import MotionSet


class Split(NamedTuple):
    """The three sets."""

    training: MotionSet
    validation: MotionSet
    test: MotionSet | None


def split(motion: MotionSet) -> Split:
    """Split a set by subject into training, validation and, if present, test set.

    Parameters
    ----------
    motion : MotionSet
        The whole set. Clips of unknown subjects are in the training set.

    Raises
    ------
    ValueError
        If there are fewer than two subjects besides the held-out ones.
    """
    subjects, held_out = subjects_of(motion), held_out_subjects()
    tested = [subject for subject in subjects if subject in held_out]
    others = [subject for subject in subjects if subject not in held_out]
    if len(others) < 2:
        raise ValueError(
            f"training needs two subjects, one to train on and one to validate on, besides the held-out subjects "
            f"{', '.join(held_out)}; the motion has {', '.join(subjects) or 'none'}"
        )
    validated = [subject for subject in others if subject in validation_subjects()] or others[-1:]
    return Split(
        motion.only(exclude_subjects=[*tested, *validated]),
        motion.only(subjects=validated),
        motion.only(subjects=tested) if tested else None,
    )


def subjects_of(motion: MotionSet) -> list[str]:
    """Return the known subjects."""
    return sorted({clip.subject for clip in motion.clips} - {""})


def held_out_subjects() -> list[str]:
    """Return the held-out subjects of all sources, on whom nothing is trained."""
    return [source.subject(subject) for source in SOURCES.values() for subject in source.test_subjects]


def validation_subjects() -> list[str]:
    """Return the validation subjects of all sources; a set with none of them validates on its last subject."""
    return [source.subject(subject) for source in SOURCES.values() for subject in source.validation_subjects]
