"""Gaps of a clip: which joint is missing, when, and how that is known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import NAMES
from npss_baselines.manifold.clips.lost import Lost, Mask, without_channels, without_places

What = Literal["place", "rotation", "translation"]
Why = Literal["given", "not a key", "not a number", "held", "jump"]


@dataclass(frozen=True)
class Gap:
    """A stretch of a clip in which something of a joint is missing.

    Attributes
    ----------
    joint : str
        The joint, as the file names it.
    what : {'place', 'rotation', 'translation'}
        What is missing: the place of the joint and of all that hangs from it, or its channels.
    start, end : int
        The first frame, from 0 on, and the frame after the last.
    why : {'given', 'not a key', 'not a number', 'held', 'jump'}
        How it is known.
    """

    joint: str
    what: What
    start: int
    end: int
    why: Why


def lost_in(gaps: Iterable[Gap], motion: Bvh, mapping: JointMapping) -> Lost:
    """Return what is missing in a clip."""
    skeleton, n_frames = motion.skeleton, len(motion.rotations)
    own = {joint: name for name, joint in mapping.joints.items()}
    masks: dict[str, Mask] = {
        "place": np.zeros((n_frames, len(NAMES)), bool),
        "rotation": np.zeros((n_frames, len(skeleton.names)), bool),
        "translation": np.zeros((n_frames, len(skeleton.names)), bool),
    }
    for gap in gaps:
        column = NAMES.index(own[gap.joint]) if gap.what == "place" else skeleton.names.index(gap.joint)
        masks[gap.what][gap.start : gap.end, column] = True
    return without_places(masks["place"], skeleton, mapping) | without_channels(
        masks["rotation"], masks["translation"], skeleton, mapping
    )


class Line(NamedTuple):
    """What is missing in a stretch of time.

    Attributes
    ----------
    text : str
        In words.
    start, end : float or None
        The time of the first frame, and of the one after the last, in seconds; None for frames between keys.
    """

    text: str
    start: float | None = None
    end: float | None = None


def lines(gaps: Sequence[Gap], motion: Bvh) -> list[Line]:
    """Say what is missing, one line for each stretch of time; frames between keys together."""
    together: dict[tuple[int, int, Why], list[str]] = {}
    n_joints = sum(bool(channels) for channels in motion.channels)
    for gap in gaps:
        form = {"place": "the place of {} and of all below it", "rotation": "{}", "translation": "{} (its translation)"}
        together.setdefault((gap.start, gap.end, gap.why), []).append(form[gap.what].format(gap.joint))
    said = []
    between = [gap.end - gap.start for gap in gaps if gap.why == "not a key"]
    if between:
        n_keys = len(motion.rotations) - sum(between)
        said.append(Line(f"{sum(between)} frames around {n_keys} keys, at most {max(between)} in a row"))
    for (first, after, why), joints in sorted(together.items()):
        if why != "not a key":
            who = ", ".join(joints) if len(joints) < n_joints else "the whole figure"
            start, end = first / motion.fps, after / motion.fps
            said.append(Line(f"frames {first} to {after - 1} ({start:.2f} to {end:.2f} s): {who}: {why}", start, end))
    return said
