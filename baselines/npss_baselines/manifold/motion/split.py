"""Who is trained on, who chooses, and who is held out: by subject, never by window."""

from __future__ import annotations

from typing import NamedTuple

from npss_baselines.manifold.motion.dataset import MotionSet

#: Whom nothing is trained on.
TEST_SUBJECTS = ("cmu/02", "cmu/14", "h36m/S5", "synthetic/0", "synthetic/1")
#: By whom weights are chosen; nothing is trained on them. Where a set has none of them, it is its last subject.
VALIDATION_SUBJECTS = ("cmu/08", "cmu/12", "h36m/S11", "synthetic/2", "synthetic/3")


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
    subjects = subjects_of(motion)
    tested = [subject for subject in subjects if subject in TEST_SUBJECTS]
    others = [subject for subject in subjects if subject not in TEST_SUBJECTS]
    if len(others) < 2:
        raise ValueError(
            f"there is motion of {', '.join(subjects) or 'nobody'}; without those who are tested on, "
            f"{', '.join(TEST_SUBJECTS)}, training needs two: one to train on, and one to choose weights by"
        )
    chosen_by = [subject for subject in others if subject in VALIDATION_SUBJECTS] or others[-1:]
    return Split(
        motion.only(exclude_subjects=[*tested, *chosen_by]),
        motion.only(subjects=chosen_by),
        motion.only(subjects=tested) if tested else None,
    )


def subjects_of(motion: MotionSet) -> list[str]:
    """Return who moves, without those that are not named."""
    return sorted({clip.subject for clip in motion.clips} - {""})
