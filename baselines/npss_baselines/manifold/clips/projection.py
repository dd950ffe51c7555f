"""Project a clip onto a manifold."""

from __future__ import annotations

from typing import TYPE_CHECKING

from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping, guess
from npss_baselines.data.upright import Up, up_of, with_own_up, with_y_up
from npss_baselines.manifold.clips.outcome import Outcome
from npss_baselines.manifold.motion.own_clip import body_height, prepare_clip

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch


def project(motion: Bvh, manifold: Projector, *, mapping: JointMapping | None = None, up: Up | None = None) -> Outcome:
    """Project a clip onto a manifold: what it cannot hold is lost.

    Parameters
    ----------
    motion : Bvh
        The clip.
    manifold : Projector
        The manifold, as `npss_baselines.manifold.training.folder.load` returns it in `Run.projector`.
    mapping : JointMapping, optional
        The common joints of the skeleton (default: guessed).
    up : {'y', 'z'}, optional
        The axis that points up (default: that along which the head is above the feet).

    Returns
    -------
    Outcome
        The clip. Details above 12 Hz, and joints that no common joint turns, stay as they are.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If the motion cannot be prepared.
    """
    joints = mapping or guess(motion.skeleton)
    axis = up_of(motion, joints) if up is None else up
    clip = prepare_clip(with_y_up(motion, axis), joints)
    fitted = clip.back(manifold.project(clip.features[None])[0])
    error = fitted.error / body_height(clip.common)
    return Outcome(with_own_up(fitted.motion, axis), joints, axis, manifold.signature, (), error)
