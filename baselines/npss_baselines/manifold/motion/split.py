"""Who is trained on, who chooses, and who is held out: by subject, never by window."""

from __future__ import annotations

from typing import NamedTuple

from npss_baselines.data import SOURCES
from npss_baselines.manifold.motion.dataset import MotionSet


class Split(NamedTuple):
    """A set in parts."""

    training: MotionSet
    validation: MotionSet
    test: MotionSet | None


def split(motion: MotionSet) -> Split:
    """Divide a set by subject: what is trained on, what weights are chosen by, and what is tested on, if there is any.

    Parameters
    ----------
    motion : MotionSet
        All of it. Clips whose subject is not stated are trained on.

    Raises
    ------
    ValueError
        If there are fewer than two subjects that are not tested on.
    """
    subjects, held_out = subjects_of(motion), held_out_subjects()
    tested = [subject for subject in subjects if subject in held_out]
    others = [subject for subject in subjects if subject not in held_out]
    if len(others) < 2:
        raise ValueError(
            f"there is motion of {', '.join(subjects) or 'nobody'}; without those who are tested on, "
            f"{', '.join(held_out)}, training needs two: one to train on, and one to choose weights by"
        )
    chosen_by = [subject for subject in others if subject in validation_subjects()] or others[-1:]
    return Split(
        motion.only(exclude_subjects=[*tested, *chosen_by]),
        motion.only(subjects=chosen_by),
        motion.only(subjects=tested) if tested else None,
    )


def subjects_of(motion: MotionSet) -> list[str]:
    """Return who moves, without those that are not named."""
    return sorted({clip.subject for clip in motion.clips} - {""})


def held_out_subjects() -> list[str]:
    """Return the subjects of all sources that are held out: nothing is trained on them."""
    return [source.subject(subject) for source in SOURCES.values() for subject in source.test_subjects]


def validation_subjects() -> list[str]:
    """Return the subjects of all sources by whom weights are chosen; a set with none of them takes its last subject."""
    return [source.subject(subject) for source in SOURCES.values() for subject in source.validation_subjects]
