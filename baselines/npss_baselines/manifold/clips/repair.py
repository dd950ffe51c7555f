"""Restore clips: repair what is missing or damaged, fill in a joint, put frames between keys."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from difflib import get_close_matches

import numpy as np

from npss.validation import each, is_integer, positive_integer, positive_number
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping, guess
from npss_baselines.data.motion import NAMES
from npss_baselines.data.upright import Up, up_of, with_own_up, with_y_up
from npss_baselines.manifold.clips.filling import filled
from npss_baselines.manifold.clips.finding import HELD, find
from npss_baselines.manifold.clips.gap import Gap, lost_in
from npss_baselines.manifold.clips.outcome import Outcome
from npss_baselines.manifold.clips.restoring import restored
from npss_baselines.manifold.motion.own_clip import body_height
from npss_baselines.manifold.motion.runs import runs
from npss_baselines.manifold.restorers.file import default
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.restorers.restorer import Restorer


def repair(
    motion: Bvh,
    *,
    missing: Collection[str] | None = None,
    start: int = 0,
    end: int | None = None,
    only: Collection[str] | None = None,
    shortest: float = HELD,
    restorer: Restorer | None = None,
    mapping: JointMapping | None = None,
    up: Up | None = None,
) -> Outcome:
    """Restore what is missing in a clip: joints that are named, or what is found.

    Without names, these are found: values that are not numbers; joints that are held, that is, do not change at all
    for .1 seconds or longer while others move; joints that jump, that is, leap from one frame to the next and back
    within .2 seconds. See `Outcome.gaps`. Joints that animators hold on purpose look the same: tell them apart by
    `only` and `shortest`.

    Parameters
    ----------
    motion : Bvh
        The clip.
    missing : collection of str, optional
        Joints without a place, as the file or `npss_baselines.data.motion.NAMES` names them; those below them are
        missing, too (default: what is found).
    start, end : int, optional
        The first frame of the file in which they are missing, from 0 on, and the frame after the last (default: all).
    only : collection of str, optional
        Of joints that are held or jump, restore these alone, as the file or
        `npss_baselines.data.motion.NAMES` names them.
    shortest : float, optional
        The shortest time for which a joint is held, in seconds.
    restorer : Restorer, optional
        The way to restore (default: the restorer that comes with the package, or else interpolation in time).
    mapping : JointMapping, optional
        The common joints of the skeleton (default: guessed).
    up : {'y', 'z'}, optional
        The axis that points up (default: that along which the head is above the feet).

    Returns
    -------
    Outcome
        The clip. What is not missing returns exactly; if nothing is, so does the whole clip.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If an argument is invalid, nothing of the clip is known, or the motion cannot be prepared.

    Examples
    --------
    >>> from npss_baselines.data import bvh
    >>> clip = bvh.read("walk.bvh")  # doctest: +SKIP
    >>> fixed = repair(clip, missing=["RightHand"], start=60, end=120)  # doctest: +SKIP
    """
    joints = mapping or guess(motion.skeleton)
    found = find(motion, shortest=positive_number("shortest", shortest))
    if missing is not None and (only is not None or shortest != HELD):
        raise ValueError("only, shortest: choose from what is found; expected no missing")
    if only is not None:
        owned = [name for name, channels in zip(motion.skeleton.names, motion.channels, strict=True) if channels]
        named = _own_names("only", only, joints, owned)
        found = [gap for gap in found if gap.joint in named or gap.why == "not a number"]
    if missing is None:
        gaps = found
    else:
        names = _own_names("missing", missing, joints)
        for name, own in zip(missing, names, strict=True):
            if name != own and name in motion.skeleton.names:
                raise ValueError(
                    f"missing: {name!r} is not restored; the common joint of this name is the file's {own!r}"
                )
        first, last = _frames(start, end, len(motion.rotations))
        gaps = [Gap(name, "place", first, last, "given") for name in names]
        gaps += [gap for gap in found if gap.why == "not a number"]
    return _made(motion, gaps, restorer, joints, up)


def fill(
    motion: Bvh,
    joint: str,
    *,
    start: int = 0,
    end: int | None = None,
    restorer: Restorer | None = None,
    mapping: JointMapping | None = None,
    up: Up | None = None,
) -> Outcome:
    """Fill in a joint, and those below it, from the rest of the figure.

    Parameters
    ----------
    motion : Bvh
        The clip.
    joint : str
        The joint, as the file or `npss_baselines.data.motion.NAMES` names it.
    start, end, restorer, mapping, up
        As for `repair`.

    Returns
    -------
    Outcome
        The clip.

    Raises
    ------
    ImportError, TypeError, ValueError
        As `repair`.
    """
    return repair(motion, missing=[joint], start=start, end=end, restorer=restorer, mapping=mapping, up=up)


def inbetween(
    motion: Bvh,
    *,
    keys: Collection[int] | None = None,
    every: int | None = None,
    restorer: Restorer | None = None,
    mapping: JointMapping | None = None,
    up: Up | None = None,
) -> Outcome:
    """Make the frames between keys.

    Parameters
    ----------
    motion : Bvh
        The clip, of which only keys count.
    keys : collection of int, optional
        The frames of the file that are keys, from 0 on (default: those that differ from the frame before).
    every : int, optional
        Every n-th frame is a key, from the first on.
    restorer, mapping, up
        As for `repair`.

    Returns
    -------
    Outcome
        The clip. Keys return exactly; before the first and after the last one, the figure stays in its place.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If an argument is invalid, or the motion cannot be prepared; or if neither `keys` nor `every` is given, and no
        frame is held.
    """
    n_frames = len(motion.rotations)
    is_key = np.zeros(n_frames, bool)
    if keys is not None and every is not None:
        raise ValueError("every: give either keys or the number of frames from one to the next")
    if every is not None:
        is_key[:: positive_integer("every", every)] = True
    elif keys is not None:
        for key in each("keys", keys, "frames", ordered=False):
            if not is_integer(key):
                raise TypeError(f"keys: expected frames, got {key!r}")
            if not 0 <= key < n_frames:
                raise ValueError(f"keys: the clip has the frames 0 to {n_frames - 1}, not {key}")
            is_key[key] = True
    else:
        is_key[:] = [True, *_changes(motion)]
        if is_key.all():
            raise ValueError(
                "keys: no frame is held, so every frame is a key; name the keys, or every how many frames, or insert "
                "frames where some were deleted"
            )
    if is_key.sum() < 2:
        raise ValueError("keys: expected at least two")
    joints = mapping or guess(motion.skeleton)
    hips = joints.joints["Hips"]
    assert hips is not None
    gaps = [Gap(hips, "place", *run, "not a key") for run in runs(~is_key)]
    return _made(motion, gaps, restorer, joints, up)


def _made(motion: Bvh, gaps: Sequence[Gap], restorer: Restorer | None, mapping: JointMapping, up: Up | None) -> Outcome:
    """Restore the gaps of a clip."""
    way = default() if restorer is None else restorer
    lost = lost_in(gaps, motion, mapping)
    never = [name for name, absent in zip(NAMES, lost.places.T, strict=True) if absent.all()]
    if never and isinstance(way, Interpolation):
        names = ", ".join(never)
        raise ValueError(
            f"missing: {names}: missing in all frames, so there is nothing to interpolate; give a restorer"
        )
    simple = filled(motion, lost)
    axis = up_of(simple, mapping) if up is None else up
    fitted = restored(with_y_up(simple, axis), mapping, lost, way)
    height = body_height(mapping.positions(simple.positions(), motion.skeleton))
    return Outcome(with_own_up(fitted.motion, axis), mapping, axis, way.signature, tuple(gaps), fitted.error / height)


def _own_names(argument: str, names: Collection[str], mapping: JointMapping, others: Collection[str] = ()) -> list[str]:
    """Return joints' names in the file, from those or from their common names; others may be named, too."""
    common = {name: own for name, own in mapping.joints.items() if own is not None}
    known = common | {own: own for own in (*others, *common.values())}  # what the file calls it, first
    found = []
    for name in each(argument, names, "names of joints", ordered=False):
        if not isinstance(name, str):
            raise TypeError(f"{argument}: expected names of joints, got {name!r}")
        if name not in known:
            plain = {re.sub(r"[\W_]", "", word).lower(): word for word in known}
            near = get_close_matches(re.sub(r"[\W_]", "", name).lower(), plain, n=1)
            hint = f"; did you mean {plain[near[0]]}?" if near else ""
            listed = ", ".join(f"{word} ({own})" for word, own in common.items())
            raise ValueError(f"{argument}: {name!r} is not one of the joints {listed}{hint}")
        found.append(known[name])
    return found


def _frames(start: int, end: int | None, n_frames: int) -> tuple[int, int]:
    """Check the first frame and the one after the last."""
    last = n_frames if end is None else end
    for name, value in (("start", start), ("end", last)):
        if not is_integer(value):
            raise TypeError(f"{name}: expected a frame of the file, got {value!r}")
    if not 0 <= start < last <= n_frames:
        raise ValueError(
            f"start: expected frames from 0 to {n_frames}, the first before the last; got {start} to {last}"
        )
    return int(start), int(last)


def _changes(motion: Bvh) -> list[bool]:
    """Return whether each frame but the first differs from the one before."""
    same = [
        (values[1:] == values[:-1]).reshape(len(values) - 1, -1).all(axis=1)
        for values in (motion.rotations, motion.translations)
    ]
    return list(~(same[0] & same[1]))
