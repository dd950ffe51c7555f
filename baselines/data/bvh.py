"""BVH files: a skeleton, the rotations of its joints and the path of its root.

The library pybvh reads them. It takes some broken files for whole ones: where a brace is missing, joints get another
parent. So the hierarchy is first compared with the grammar of the format, which also tells the line that is broken.
"""

from __future__ import annotations

import math
import os
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from npss._checks import Float64
from npss.rotations import euler_to_matrix
from npss.skeleton import Skeleton

#: A file with more joints, end sites included, is refused: no body has as many, and time grows with their square.
MAX_JOINTS = 1000
#: A number beyond it is refused, be it a length or degrees: rotations lose their digits, and no body has been as far.
MAX_VALUE = 1e6
_MAX_LINE = 4096  # characters of a line before the numbers

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_ROTATIONS = r"(?!.*([XYZ])rotation.*\1rotation)(?: [XYZ]rotation){3}"
# The lines of a hierarchy, their white space being single blanks, and how errors describe them.
_LINES = {
    "hierarchy": ("HIERARCHY", "HIERARCHY"),
    "root": ("ROOT NAME", r"ROOT (?P<name>\S+)"),
    "joint": ("JOINT NAME", r"JOINT (?P<name>\S+)"),
    "end": ("End Site", "End Site"),
    "open": ("{", r"\{"),
    "close": ("}", r"\}"),
    "offset": ("OFFSET and 3 numbers", f"OFFSET(?: {_NUMBER}){{3}}"),
    "root channels": (
        "CHANNELS 6 Xposition Yposition Zposition and 3 rotations about different axes",
        f"CHANNELS 6 Xposition Yposition Zposition{_ROTATIONS}",
    ),
    "channels": ("CHANNELS 3 and 3 rotations about different axes", f"CHANNELS 3{_ROTATIONS}"),
    "motion": ("MOTION", "MOTION"),
    "frames": ("Frames: NUMBER", r"Frames: (?P<frames>\d+)"),
    "time": ("Frame Time: SECONDS", f"Frame Time: (?P<seconds>{_NUMBER})"),
}
_INSIDE = ("joint", "end", "close")  # a joint, after its channels
_NEXT = {
    "hierarchy": ("root",),
    "root": ("open",),
    "joint": ("open",),
    "end": ("open",),
    "open": ("offset",),
    "root channels": _INSIDE,
    "channels": _INSIDE,
    "motion": ("frames",),
    "frames": ("time",),
}
_AFTER_OFFSET = {"root": ("root channels",), "joint": ("channels",), "end": ("close",)}


@dataclass(frozen=True, eq=False)
class Bvh:
    """What a BVH file holds.

    Attributes
    ----------
    skeleton : Skeleton
        The J joints, end sites included: that of the joint ``foot`` is ``footEnd``. In the unit of the file.
    rotations : (T, J, 3, 3) ndarray of float64
        The rotation of every joint in the frame of its parent; of an end site, the identity.
    root : (T, 3) ndarray of float64
        Where the root is, as its channels say: its offset is not added.
    fps : float
        Frames per second.
    """

    skeleton: Skeleton
    rotations: Float64
    root: Float64
    fps: float

    def positions(self) -> Float64:
        """Compute where the joints are, ``(T, J, 3)``, in the unit of the file."""
        positions: Float64 = self.skeleton.positions(self.rotations, root=self.root)
        return positions


def read(path: str | os.PathLike[str]) -> Bvh:
    """Read a BVH file.

    Parameters
    ----------
    path : path
        A file whose name ends in ``.bvh``.

    Returns
    -------
    Bvh
        Its motion. A frame time within 0.01 % of 1/N seconds is read as 1/N: 0.00833333 is 120 frames per second.

    Raises
    ------
    ImportError
        If pybvh is not installed.
    OSError
        If there is no such file.
    ValueError
        If the file is broken, or is none that is read here: every joint has three rotations, about three different
        axes in any order, and the root alone has positions, X, Y and Z, before them. Names the file and, where it can
        be known, the line.
    """
    try:
        import pybvh
    except ImportError:
        raise ImportError("reading BVH files needs pybvh: pip install 'npss[manifold]'") from None
    file = Path(path)
    try:
        header = _read_header(file)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a file without frames, for which there is an error
            try:
                content = pybvh.read_bvh_file(file, world_up="+y")
            except ValueError:
                _check_numbers(file, header)  # its error names a line
                raise
        values = content.root_pos, np.degrees(content.joint_angles)
        if header.comments or not all((np.abs(array) <= MAX_VALUE).all() for array in values):  # NaN included
            _check_numbers(file, header)
        return _convert(content)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


@dataclass(frozen=True)
class _Header:
    lines: int  # of the file, up to the first frame
    channels: int
    frames: str
    comments: bool  # whether there is a "#" after it: the library would take what follows for a comment


def _read_header(path: Path) -> _Header:
    """Compare what comes before the numbers with the grammar of the format; raise at the first line that differs."""
    names: set[str] = set()
    n_joints = depth = channels = number = 0
    frames = block = ""
    expected: tuple[str, ...] = ("hierarchy",)
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(iter(lambda: file.readline(_MAX_LINE), ""), 1):
            words = " ".join(line.split())
            if len(line) == _MAX_LINE:
                raise ValueError(f"line {number}: expected {_describe(expected)}, got {_MAX_LINE} characters or more")
            if not words:
                continue
            kind, match = _match(number, words, expected)
            if kind in ("root", "joint", "end"):
                block, n_joints = kind, n_joints + 1
                if n_joints > MAX_JOINTS:
                    raise ValueError(f"line {number}: more than {MAX_JOINTS} joints and end sites")
            if kind in ("root", "joint"):
                if match["name"] in names:
                    raise ValueError(f"line {number}: the name {match['name']!r} is there twice")
                names.add(match["name"])
            elif kind == "offset":
                for word in words.split()[1:]:
                    _number(number, word)
            elif kind == "frames":
                frames = match["frames"]
            elif kind == "time":
                seconds = float(match["seconds"])
                if not (seconds > 0 and 0 < 1 / seconds < math.inf):
                    raise ValueError(f"line {number}: a frame time of {match['seconds']} s")
                return _Header(
                    number, channels, frames, any("#" in part for part in iter(lambda: file.read(2**20), ""))
                )
            depth += (kind == "open") - (kind == "close")
            channels += {"root channels": 6, "channels": 3}.get(kind, 0)
            if kind == "offset":
                expected = _AFTER_OFFSET[block]
            elif kind == "close":
                expected = _INSIDE if depth else ("motion",)
            else:
                expected = _NEXT[kind]
    raise ValueError(f"ends with line {number}: expected {_describe(expected)}")


def _match(number: int, words: str, expected: tuple[str, ...]) -> tuple[str, re.Match[str]]:
    """Return which of the lines that are expected this one is."""
    for kind in expected:
        if match := re.fullmatch(_LINES[kind][1], words, re.ASCII):
            return kind, match
    raise ValueError(f"line {number}: expected {_describe(expected)}, got {words[:60]!r}")


def _describe(kinds: tuple[str, ...]) -> str:
    return " or ".join(_LINES[kind][0] for kind in kinds)


def _number(number: int, word: str) -> None:
    """Raise unless a word in a line is a number that makes sense."""
    try:
        value = float(word)
    except ValueError:
        raise ValueError(f"line {number}: {word[:60]!r} is not a number") from None
    if not abs(value) <= MAX_VALUE:  # NaN included
        raise ValueError(f"line {number}: {word[:60]!r} is not within +-{MAX_VALUE:g}")


def _check_numbers(path: Path, header: _Header) -> None:
    """Raise at the first frame that is none, or if there are more or fewer than the file says."""
    rows = 0
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            words = line.split()
            if number <= header.lines or not words:
                continue
            rows += 1
            for word in words:
                _number(number, word)
            if len(words) != header.channels:
                raise ValueError(f"line {number}: {len(words)} values for {header.channels} channels")
    if rows != int(header.frames):
        raise ValueError(f"{rows} frames, where it says {header.frames}")


def _convert(content: Any) -> Bvh:
    """Convert what the library has read."""
    nodes = content.nodes
    joints = [j for j, node in enumerate(nodes) if not node.is_end_site()]
    skeleton = Skeleton(
        [f"{node.parent.name}End" if node.is_end_site() else node.name for node in nodes],
        [-1 if node.parent is None else nodes.index(node.parent) for node in nodes],
        [node.offset for node in nodes],
    )
    rotations = np.tile(np.eye(3), (content.frame_count, len(nodes), 1, 1))
    orders = content.euler_orders
    for order in sorted(set(orders)):
        of = [i for i, its in enumerate(orders) if its == order]
        rotations[:, [joints[i] for i in of]] = euler_to_matrix(content.joint_angles[:, of], seq=order)
    return Bvh(skeleton, rotations, content.root_pos, 1 / content.frame_time)
