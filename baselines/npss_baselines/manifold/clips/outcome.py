"""What a function makes of a clip."""

from __future__ import annotations

from dataclasses import dataclass

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.upright import Up
from npss_baselines.manifold.clips.gap import Gap


@dataclass(frozen=True, eq=False)
class Outcome:
    """A clip that was made from another, on the same skeleton.

    Attributes
    ----------
    motion : Bvh
        The clip, with the names, channels and frame rate of the other.
    mapping : JointMapping
        The common joints of its skeleton.
    up : {'y', 'z'}
        The axis that points up.
    way : str
        The signature of the way in which it was made.
    gaps : tuple of Gap
        What was missing.
    error : (T, 20) ndarray of float64
        The distance of each common joint from where it should be, in body heights: what the skeleton cannot reach.
    """

    motion: Bvh
    mapping: JointMapping
    up: Up
    way: str
    gaps: tuple[Gap, ...]
    error: Float64
