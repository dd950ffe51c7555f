"""Which joints of any skeleton are the 20 common ones: guessed from names and hierarchy, or read from a file."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from npss.files import read_json, write_text_atomically
from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.data.motion import JOINTS, NAMES

__all__ = ["JointMapping", "guess", "read"]

#: Joints that a skeleton may lack: each is made by prolonging the bone before it.
MADE = ("LeftHandIndex", "RightHandIndex")
_ARMS = ("LeftArm", "RightArm")

_SIDES = {
    "Left": re.compile(r"(?:^|_|\.)l(?:eft)?(?=_|\.|$)|^left|^l(?=[A-Z])|(?:_|\.)L(?=End|$)", re.IGNORECASE),
    "Right": re.compile(r"(?:^|_|\.)r(?:ight)?(?=_|\.|$)|^right|^r(?=[A-Z])|(?:_|\.)R(?=End|$)", re.IGNORECASE),
}
_FOOT, _HAND = re.compile("foot|ankle"), re.compile("hand|wrist")
_NOT_FOOT, _NOT_HAND = re.compile("end|toe|ball"), re.compile("end|thumb|index|mid|ring|pink|finger|prop|nub")
_FINGERS = tuple(
    map(re.compile, ("mid.*1", "fingerbase", "index.*1", "finger", "mid", "index", "hand.*end|wrist.*end"))
)
_TOES = tuple(map(re.compile, ("toe(?!.*end)|ball", "toe", "end")))
_HEAD, _NECK = re.compile("^head(?!.*(end|top|nub))"), re.compile("neck")
_TWIST = re.compile("roll|twist")


@dataclass(frozen=True)
class JointMapping:
    """The joints of a skeleton that are the 20 common ones.

    Attributes
    ----------
    joints : dict of str to (str or None)
        For each name of `npss_baselines.data.motion.NAMES`, that of a joint of the skeleton; None for a hand's tip that
        is made from the hand.
    """

    joints: Mapping[str, str | None]

    def __post_init__(self) -> None:
        for name in NAMES:
            if name not in self.joints:
                raise ValueError(f"{name}: missing; expected the name of a joint for each of {', '.join(NAMES)}")
        for name, joint in self.joints.items():
            if name not in NAMES:
                raise ValueError(f"{name}: unknown; expected {', '.join(NAMES)}")
            if not (isinstance(joint, str) or (joint is None and name in MADE)):
                raise TypeError(f"{name}: expected the name of a joint, got {joint!r}")
            if joint == "":
                raise ValueError(f"{name}: blank; fill in the name of a joint")
        chosen = [joint for joint in self.joints.values() if joint is not None]
        if duplicates := [joint for joint in chosen if chosen.count(joint) > 1]:
            twice = [name for name, joint in self.joints.items() if joint == duplicates[0]]
            raise ValueError(f"{' and '.join(twice)}: both are {duplicates[0]!r}")

    def __str__(self) -> str:
        """Return the mapping as JSON, as `read` reads it."""
        return json.dumps({name: self.joints[name] for name in NAMES}, indent=2)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the mapping to a file, to be edited."""
        write_text_atomically(Path(path), f"{self}\n")

    def indices(self, skeleton: Skeleton) -> list[int | None]:
        """Return the index of each common joint in a skeleton; None for one that is made.

        Raises
        ------
        ValueError
            If the skeleton has no joint of that name, or a joint is not below the one that it must be below.
        """
        indices: list[int | None] = []
        for name in NAMES:
            joint = self.joints[name]
            if joint is not None and joint not in skeleton.names:
                raise ValueError(f"{name}: the skeleton has no joint {joint!r}; it has {', '.join(skeleton.names)}")
            indices.append(None if joint is None else skeleton.names.index(joint))
        for name, parent, index in zip(NAMES, JOINTS.parents, indices, strict=True):
            # Most skeletons have their arms below the spine, not the neck.
            above = "Hips" if name in _ARMS else NAMES[parent] if parent >= 0 else None
            if above is None or index is None:
                continue
            if indices[NAMES.index(above)] not in _ancestors(skeleton, index):
                raise ValueError(f"{name}: {self.joints[name]!r} is not below {self.joints[above]!r}")
        return indices

    def parents(self, skeleton: Skeleton) -> list[int]:
        """Return the common joint above each common joint in a skeleton; -1 for the hips, and for one that is made."""
        indices = self.indices(skeleton)
        parents = []
        for index in indices:
            above = (indices.index(i) for i in _ancestors(skeleton, index) if i in indices)
            parents.append(next(above, -1))
        return parents

    def positions(self, positions: Float64, skeleton: Skeleton) -> Float64:
        """Return the positions ``(T, 20, 3)`` of the common joints, from those of all joints ``(T, J, 3)``.

        Raises
        ------
        ValueError
            As `indices`.
        """
        indices = self.indices(skeleton)
        common = np.zeros((len(positions), len(NAMES), 3))
        for name, index in zip(NAMES, indices, strict=True):
            if index is not None:
                common[:, NAMES.index(name)] = positions[:, index]
        lengths = np.linalg.norm(JOINTS.offsets, axis=-1)
        for name in NAMES:
            if self.joints[name] is None:
                tip = NAMES.index(name)
                hand = JOINTS.parents[tip]
                bone = common[:, hand] - common[:, JOINTS.parents[hand]]
                common[:, tip] = common[:, hand] + bone * (lengths[tip] / lengths[hand])
        return common


def read(path: str | os.PathLike[str]) -> JointMapping:
    """Read a mapping from a JSON file, an object of names.

    Parameters
    ----------
    path : path
        The file, as `JointMapping.write` writes it.

    Returns
    -------
    JointMapping
        The mapping.

    Raises
    ------
    OSError, TypeError, ValueError
        If the file cannot be read, or holds no mapping; names it.
    """
    values = read_json(Path(path))
    if not isinstance(values, dict):
        raise TypeError(f"{path}: expected an object with the name of a joint for each of {', '.join(NAMES)}")
    try:
        return JointMapping(values)
    except (TypeError, ValueError) as error:
        raise type(error)(f"{path}: {error}") from error


def write_blank(path: str | os.PathLike[str]) -> None:
    """Write a mapping without names of joints to a file, to be filled in."""
    blank = {name: None if name in MADE else "" for name in NAMES}
    write_text_atomically(Path(path), json.dumps(blank, indent=2) + "\n")


def tree(skeleton: Skeleton) -> list[str]:
    """Return the names of a skeleton's joints, each indented below the one that carries it."""
    return [f"{'  ' * len(_ancestors(skeleton, i))}{skeleton.names[i]}" for i in _by_depth(skeleton)]


def _by_depth(skeleton: Skeleton) -> Iterator[int]:
    """Yield the joints of a skeleton, each before those below it, limb by limb."""
    below = [
        [i for i, parent in enumerate(skeleton.parents) if parent == joint] for joint in range(-1, len(skeleton.names))
    ]
    rest = below[0][::-1]
    while rest:
        joint = rest.pop()
        yield joint
        rest += below[joint + 1][::-1]


def guess(skeleton: Skeleton) -> JointMapping:
    """Guess which joints are the common ones.

    Hands, feet and head are found by name. The others follow from the hierarchy: the elbow is above the hand, the hips
    are above both legs and the head. Joints of zero length and twist joints are passed over.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton, as of a BVH file in the dialect of CMU, Mixamo, LaFAN1, Bandai Namco, Xsens, Rokoko or Human3.6M,
        or another with such names.

    Returns
    -------
    JointMapping
        The mapping.

    Raises
    ------
    ValueError
        If a joint is not found; names it, and advises to give a mapping.

    Examples
    --------
    >>> from npss.skeleton import H36M
    >>> mapping = guess(H36M)
    >>> [name for name in NAMES if mapping.joints[name] != name]
    []
    """
    names = {index: _plain(name) for index, name in enumerate(skeleton.names)}
    sides = {index: _side(name) for index, name in enumerate(skeleton.names)}
    found: dict[str, int | None] = {}

    def first(name: str, indices: Iterator[int]) -> int:
        index = next(indices, None)
        if index is None:
            raise ValueError(
                f"no joint for {name} among {', '.join(skeleton.names)}; give a mapping, from names of "
                f"{', '.join(NAMES)} to names of the skeleton"
            )
        return index

    for side in ("Left", "Right"):
        own = [index for index in names if sides[index] == side]
        for end, chain, yes, no in (
            ("Foot", ("Leg", "UpLeg"), _FOOT, _NOT_FOOT),
            ("Hand", ("ForeArm", "Arm"), _HAND, _NOT_HAND),
        ):
            joint = first(f"{side}{end}", (i for i in own if yes.search(names[i]) and not no.search(names[i])))
            found[f"{side}{end}"] = joint
            for name in chain:
                joint = first(f"{side}{name}", _above(skeleton, joint, names))
                found[f"{side}{name}"] = joint
        foot, hand = found[f"{side}Foot"], found[f"{side}Hand"]
        assert foot is not None
        assert hand is not None
        found[f"{side}ToeBase"] = first(f"{side}ToeBase", _below(skeleton, foot, _TOES, names))
        found[f"{side}HandIndex"] = next(_below(skeleton, hand, _FINGERS, names), None)
    found["Head"] = first("Head", (i for i in names if _HEAD.search(names[i])))
    legs = [_ancestors(skeleton, found[f"{side}UpLeg"]) for side in ("Left", "Right")]
    trunk = _ancestors(skeleton, found["Head"])  # from the head down
    hips = first("Hips", (i for i in trunk if i in legs[0] and i in legs[1]))
    spine = trunk[: trunk.index(hips)][::-1]  # from the hips up
    # Without a neck, the joint below the head is the best there is.
    neck = first("Neck", iter([*(i for i in spine if _NECK.search(names[i])), *spine[-1:]]))
    found |= {"Hips": hips, "Neck": neck}
    found["Spine1"] = first("Spine1", _middle(skeleton, neck, spine[: spine.index(neck)]))
    chosen = {name: None if (index := found[name]) is None else skeleton.names[index] for name in NAMES}
    return JointMapping(chosen)


def _middle(skeleton: Skeleton, neck: int, between: Sequence[int]) -> Iterator[int]:
    """Yield the joint between hips and neck whose share of the way is nearest to that in the common skeleton."""
    common = JOINTS.offsets[[NAMES.index(name) for name in ("Spine1", "Neck")]]
    lengths = np.linalg.norm(common, axis=-1)
    share = lengths[0] / lengths.sum()
    heights = np.cumsum([np.linalg.norm(skeleton.offsets[joint]) for joint in (*between, neck)])
    yield from sorted(between, key=lambda joint: abs(heights[between.index(joint)] / heights[-1] - share))


def _plain(name: str) -> str:
    """Return a name without the prefix of a character, in lower case."""
    return name.rpartition(":")[2].lower()


def _side(name: str) -> str:
    """Return the side that a name states: Left, Right or nothing."""
    plain = name.rpartition(":")[2]
    camel = re.match("[lr](?=[A-Z])", plain)
    if camel:
        return "Left" if plain[0] == "l" else "Right"
    return next((side for side, pattern in _SIDES.items() if pattern.search(plain)), "")


def _ancestors(skeleton: Skeleton, joint: int | None) -> list[int]:
    """Return the joints above a joint, the nearest first."""
    found: list[int] = []
    while joint is not None and (joint := skeleton.parents[joint]) >= 0:
        found.append(joint)
    return found


def _above(skeleton: Skeleton, joint: int, names: Mapping[int, str]) -> Iterator[int]:
    """Yield the joints above a joint that have a bone to it and are not for twist only."""
    length = float(np.linalg.norm(skeleton.offsets[joint]))
    for other in _ancestors(skeleton, joint):
        if length > 0 and not _TWIST.search(names[other]):
            yield other
        length += float(np.linalg.norm(skeleton.offsets[other]))


def _below(
    skeleton: Skeleton, joint: int, patterns: Sequence[re.Pattern[str]], names: Mapping[int, str]
) -> Iterator[int]:
    """Yield the joints below a joint by the first pattern that matches, the highest first."""
    below = [i for i in names if joint in _ancestors(skeleton, i) and skeleton.offsets[i].any()]
    below.sort(key=lambda i: len(_ancestors(skeleton, i)))
    for pattern in patterns:
        yield from (i for i in below if pattern.search(names[i]))
