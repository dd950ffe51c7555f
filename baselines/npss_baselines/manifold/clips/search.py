"""Find the clips nearest to a clip."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping, guess
from npss_baselines.data.upright import Up, up_of, with_y_up
from npss_baselines.manifold.applications.distance import extremes
from npss_baselines.manifold.motion.own_clip import prepare_clip
from npss_baselines.manifold.motion.scaling import fit_scaling

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch


def nearest(
    motion: Bvh,
    others: Iterable[tuple[str, Bvh]],
    *,
    manifold: Projector | None = None,
    mapping: JointMapping | None = None,
    up: Up | None = None,
    skip: Callable[[str, ValueError], object] | None = None,
) -> list[tuple[str, float]]:
    """Rank clips by their distance to a clip.

    The distance is the G of a manifold, equation 4 of Holden et al. (2015); or without one, the same of features, whose
    positions and three velocities are each scaled by their standard deviation over all frames of all clips. It compares
    the extremes of each feature, and only its order means something.

    Parameters
    ----------
    motion : Bvh
        The clip.
    others : iterable of (str, Bvh)
        The names of the other clips, and the clips, taken one at a time. Their skeletons and frame rates may differ.
    manifold : Projector, optional
        The manifold, as `npss_baselines.manifold.training.folder.load` returns it in `Run.projector`.
    mapping : JointMapping, optional
        The common joints of all clips (default: guessed for each).
    up : {'y', 'z'}, optional
        The axis that points up in all clips (default: that along which the head is above the feet).
    skip : callable, optional
        Called with the name of a clip that cannot be prepared and the error, to leave it out (default: raise it).

    Returns
    -------
    list of (str, float)
        The names and distances, the nearest first.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If there is no other clip, or a clip cannot be prepared; names it.
    """
    names, features = [""], [features_of(motion, mapping, up)]
    for name, other in others:
        try:
            features.append(features_of(other, mapping, up))
        except ValueError as error:
            if skip is None:
                raise ValueError(f"{name}: {error}") from error
            skip(name, error)
            continue
        names.append(name)
    if len(names) == 1:
        raise ValueError("others: expected at least one clip")
    if manifold is None:
        frames = np.concatenate(features)
        scaling = fit_scaling(frames[np.newaxis], np.ones((1, len(frames)), bool), "kind")
        vectors = [extremes(scaling.normalize(clip)) for clip in features]
    else:
        vectors = [extremes(manifold.encode(clip[np.newaxis])[0]) for clip in features]
    distances = np.square(np.array(vectors[1:]) - vectors[0]).sum(axis=1)
    order = np.argsort(distances, kind="stable")
    return [(names[1 + i], float(distances[i])) for i in order]


def features_of(motion: Bvh, mapping: JointMapping | None = None, up: Up | None = None) -> Float64:
    """Return the features ``(T, 63)`` of a clip; see `nearest`."""
    joints = mapping or guess(motion.skeleton)
    return prepare_clip(with_y_up(motion, up_of(motion, joints) if up is None else up), joints).features
