"""BVH files: a skeleton, and the rotations and translations of its joints.

The format has no standard. This reader accepts what programs write: the statements below, in this order, and nothing
else. So it refuses a damaged file at the damaged line, and never reads it as another skeleton.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from npss.files import read_text
from npss.rotations import euler_to_matrix
from npss.skeleton import Forward, Skeleton
from npss.validation import Float64

__all__ = ["CHANNELS", "Bvh", "read"]

#: Most joints of a file, end sites included: no body has as many, and time grows with their square.
MAX_JOINTS = 1000
#: Largest absolute value of a length or an angle in degrees: beyond it, rotations lose their digits.
MAX_VALUE = 1e6
#: The channels that a joint may have.
CHANNELS = ("Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation")

_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_FLAGS = re.ASCII | re.IGNORECASE
_COMMENT = re.compile(r"(?:#|//).*")
_NAMED = re.compile(r"(?:ROOT|JOINT) [^{]*", _FLAGS)
# The statements of a hierarchy, with white space as single blanks, and their descriptions in errors.
_STATEMENTS = {
    kind: (text, re.compile(pattern, _FLAGS))
    for kind, text, pattern in (
        ("hierarchy", "HIERARCHY", "HIERARCHY"),
        ("root", "ROOT NAME", r"ROOT (?P<name>.{1,200})"),
        ("joint", "JOINT NAME", r"JOINT (?P<name>.{1,200})"),
        ("end", "End Site", r"End Site(?: .*)?"),
        ("open", "{", r"\{"),
        ("close", "}", r"\}"),
        ("offset", "OFFSET and 3 numbers", rf"OFFSET(?: {_NUMBER}){{3}}"),
        ("channels", "CHANNELS, their number and names", r"CHANNELS (?P<count>\d{1,3})(?P<channels>(?: \S+)*)"),
        ("motion", "MOTION", "MOTION"),
        ("frames", "Frames: NUMBER", r"Frames ?: ?(?P<frames>\d{1,18})"),
        ("time", "Frame Time: SECONDS", rf"Frame Time ?: ?(?P<seconds>{_NUMBER})"),
    )
}
_INSIDE = ("joint", "end", "close")  # a joint, after its channels
_NEXT = {
    "hierarchy": ("root",),
    "root": ("open",),
    "joint": ("open",),
    "end": ("open",),
    "open": ("offset",),
    "channels": _INSIDE,
    "motion": ("frames",),
    "frames": ("time",),
}


@dataclass(frozen=True, eq=False)
class Bvh:
    """The content of a BVH file.

    Attributes
    ----------
    skeleton : Skeleton
        The J joints, in the unit of the file. The end site of the joint ``foot`` is the joint ``footEnd``.
    channels : tuple of (tuple of str or None)
        The channels of every joint, of `CHANNELS`, in the order of the file; rotations are multiplied in this order,
        from the left. None for an end site.
    rotations : (T, J, 3, 3) ndarray of float64
        The rotation of every joint in the frame of its parent; without rotation channels, the identity.
    translations : (T, J, 3) ndarray of float64
        The position of every joint in the frame of its parent, and of the root in the world: its offset, in which a
        position channel replaces its coordinate.
    fps : float
        Frames per second.
    degrees : (T, J, 3) ndarray of float64, optional
        The rotation channels of every joint as a file states them, in the order of the file; 0 where there are none.
        Many triples are the same rotation: `npss_baselines.data.bvh_writer` writes these for rotations that have not
        changed.
    """

    skeleton: Skeleton
    channels: tuple[tuple[str, ...] | None, ...]
    rotations: Float64
    translations: Float64
    fps: float
    degrees: Float64 | None = None

    @property
    def root(self) -> Float64:
        """The position of the root, ``(T, 3)``."""
        return self.translations[:, self.skeleton.parents.index(-1)]

    def positions(self) -> Float64:
        """Compute the positions of the joints, ``(T, J, 3)``, in the unit of the file."""
        positions: Float64 = self.forward().positions
        return positions

    def global_rotations(self) -> Float64:
        """Compute the rotations of the joints in the world, ``(T, J, 3, 3)``."""
        rotations: Float64 = self.skeleton.global_rotations(self.rotations)
        return rotations

    def forward(self) -> Forward:
        """Compute the positions and the global rotations of the joints."""
        return self.skeleton.forward(self.rotations, offsets=self.translations)


def read(path: str | os.PathLike[str], *, missing: bool = False) -> Bvh:
    """Read a BVH file.

    Parameters
    ----------
    path : path
        A UTF-8 file.
    missing : bool, optional
        Accept ``nan`` as the value of a channel: then the rotation or the translation of the joint is NaN in this
        frame. By default, it is refused.

    Returns
    -------
    Bvh
        The motion. A frame time within 0.01 % of 1/N seconds is read as 1/N: 0.00833333 is 120 frames per second.

    Warns
    -----
    UserWarning
        If the file has one frame more or fewer than it says, as some programs count; all its frames are read.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is broken, or has several roots, duplicate names of joints, or duplicate channels of a joint. Names
        the file and, if known, the line and the joint.

    Notes
    -----
    A joint has up to six channels, in any order. A position channel replaces the offset and is not added to it, as in
    the files of Blender, Mixamo and motion capture studios. Keywords may have any case, and a brace may follow on the
    line of a joint. A comment runs from ``#`` or ``//``, or from ``End Site``, to the end of the line. A joint's name
    is an exception, and runs to the brace: ``JOINT left arm #1 {``.
    """
    file = Path(path)
    text = read_text(file)
    try:
        return _parse(text.split("\n"), file, missing)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _parse(lines: Sequence[str], file: Path, missing: bool) -> Bvh:
    header = _read_header(lines)
    rows = _read_rows(lines, header, missing)
    if not len(rows) or abs(len(rows) - header.n_frames) > 1:
        raise ValueError(f"{len(rows)} frames, but the header says {header.n_frames}")
    if len(rows) != header.n_frames:
        warnings.warn(f"{file}: {len(rows)} frames, but the header says {header.n_frames}", stacklevel=3)
    return _convert(header, rows)


@dataclass
class _Joint:
    name: str  # empty for an end site
    parent: int
    offset: list[float]
    channels: tuple[str, ...] | None = None


@dataclass(frozen=True)
class _Header:
    n_lines: int  # up to the first frame
    joints: list[_Joint]
    n_frames: int  # of the header
    fps: float

    @property
    def n_channels(self) -> int:
        return sum(len(joint.channels or ()) for joint in self.joints)


def _read_header(lines: Sequence[str]) -> _Header:
    """Parse the lines before the frames by the grammar of the format; raise at the first line that breaks it."""
    joints: list[_Joint] = []
    names: set[str] = set()
    inside: list[int] = []  # the joints whose braces are open
    n_frames = number = 0
    expected: tuple[str, ...] = ("hierarchy",)
    statements = _statements(lines)
    for number, words in statements:
        kind, match = _match(number, words, expected)
        expected = _NEXT.get(kind, ())
        if kind in ("root", "joint", "end"):
            name = "" if kind == "end" else match["name"]
            if name in names:
                raise ValueError(f"line {number}: duplicate name {name!r}")
            names |= {name} - {""}
            if len(joints) == MAX_JOINTS:
                raise ValueError(f"line {number}: more than {MAX_JOINTS} joints and end sites")
            joints.append(_Joint(name, inside[-1] if inside else -1, []))
        elif kind == "open":
            inside.append(len(joints) - 1)
        elif kind == "offset":
            joints[-1].offset = [_number(number, word) for word in words.split()[1:]]
            expected = ("channels",) if joints[-1].name else ("close",)
        elif kind == "channels":
            joints[-1].channels = _channels(number, joints[-1].name, match["count"], match["channels"].split())
        elif kind == "close":
            inside.pop()
            expected = _INSIDE if inside else ("motion",)
        elif kind == "frames":
            n_frames = int(match["frames"])
        elif kind == "time":
            following_number, following = next(statements, (0, ""))
            if following_number == number:
                raise ValueError(f"line {number}: expected nothing after the frame time, got {following[:60]!r}")
            return _Header(number, joints, n_frames, _frames_per_second(number, match["seconds"]))
    raise ValueError(f"the file ends at line {len(lines) - (lines[-1] == '')}, expected {_describe(expected)}")


def _statements(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Yield the statements of a hierarchy with their line numbers; a brace is a statement."""
    for number, line in enumerate(lines, 1):
        words = " ".join(line.split())
        named = _NAMED.match(words)
        name = named[0] if named else ""
        words = name + _COMMENT.sub("", words[len(name) :])
        yield from ((number, part) for part in map(str.strip, re.split(r"([{}])", words)) if part)


def _match(number: int, words: str, expected: Sequence[str]) -> tuple[str, re.Match[str]]:
    """Return the kind of a statement, one of those expected, and its match."""
    for kind in expected:
        if match := _STATEMENTS[kind][1].fullmatch(words):
            return kind, match
    raise ValueError(f"line {number}: expected {_describe(expected)}, got {words[:60]!r}")


def _describe(kinds: Sequence[str]) -> str:
    return " or ".join(_STATEMENTS[kind][0] for kind in kinds)


def _channels(number: int, joint: str, count: str, words: Sequence[str]) -> tuple[str, ...]:
    """Read the channels of a joint."""
    where = f"line {number}, joint {joint!r}"
    if len(words) != int(count):
        raise ValueError(f"{where}: expected {count} channels, got {len(words)}")
    channels = tuple(word.capitalize() for word in words)
    for i, channel in enumerate(channels):
        if channel not in CHANNELS:
            raise ValueError(f"{where}: unknown channel {words[i][:60]!r}; expected {', '.join(CHANNELS)}")
        if channel in channels[:i]:
            raise ValueError(f"{where}: duplicate channel {channel}")
    return channels


def _frames_per_second(number: int, seconds: str) -> float:
    frame_time = float(seconds)
    if not 1 / MAX_VALUE <= frame_time <= MAX_VALUE:
        raise ValueError(f"line {number}: implausible frame time, {seconds} s")
    rate = 1 / frame_time
    nearest = max(1, round(rate))
    return float(nearest) if abs(nearest * frame_time - 1) < 1e-4 else rate


def _number(number: int, word: str) -> float:
    """Read a number of plausible size."""
    if not re.fullmatch(_NUMBER, word, _FLAGS):
        raise ValueError(f"line {number}: {word[:60]!r} is not a number")
    value = float(word)
    if abs(value) > MAX_VALUE:
        raise ValueError(f"line {number}: {word[:60]!r} is not within +-{MAX_VALUE:g}")
    return value


def _read_rows(lines: Sequence[str], header: _Header, missing: bool) -> Float64:
    """Read the values of the channels, one frame per row; NaN if they may be missing."""
    rows = lines[header.n_lines :]
    if any("#" in line or "//" in line for line in rows):
        rows = [_COMMENT.sub("", line) for line in rows]
    if not any(map(str.strip, rows)):
        return np.empty((0, header.n_channels))
    try:
        values: Float64 = np.loadtxt(rows, ndmin=2, comments=None)
    except ValueError:
        _check_rows(rows, header, missing)  # raises an error that names the line
        raise
    plausible = (np.abs(values) <= MAX_VALUE) | (missing & np.isnan(values))
    if values.shape[1] != header.n_channels or not plausible.all():
        _check_rows(rows, header, missing)
    return values


def _check_rows(rows: Sequence[str], header: _Header, missing: bool) -> None:
    """Raise at the first invalid frame."""
    for number, line in enumerate(rows, header.n_lines + 1):
        words = line.split()
        for word in words:
            if not (missing and word.lower() == "nan"):
                _number(number, word)
        if words and len(words) != header.n_channels:
            raise ValueError(f"line {number}: {len(words)} values for {header.n_channels} channels")


def _convert(header: _Header, rows: Float64) -> Bvh:
    """Convert the values of channels to rotations and translations."""
    joints = header.joints
    skeleton = Skeleton(_names(joints), [joint.parent for joint in joints], [joint.offset for joint in joints])
    translations = np.tile(skeleton.offsets, (len(rows), 1, 1))
    rotations = np.tile(np.eye(3), (len(rows), len(joints), 1, 1))
    # The last column is for the rotations that a joint lacks.
    values = np.column_stack([np.nan_to_num(rows), np.zeros(len(rows))])
    degrees = np.zeros((len(rows), len(joints), 3))
    by_order: dict[str, list[tuple[int, list[int]]]] = {}
    column = 0
    for j, joint in enumerate(joints):
        order, columns = "", []
        for channel in joint.channels or ():
            if channel.endswith("position"):
                translations[:, j, "XYZ".index(channel[0])] = rows[:, column]
            else:
                order += channel[0]
                columns.append(column)
            column += 1
        if order:
            order += "".join(axis for axis in "XYZ" if axis not in order)
            by_order.setdefault(order, []).append((j, [*columns, -1, -1][:3]))
    for order, group in by_order.items():
        degrees[:, [j for j, _ in group]] = angles = values[:, [columns for _, columns in group]]
        rotations[:, [j for j, _ in group]] = euler_to_matrix(np.radians(angles), seq=order)
        for j, columns in group:
            absent = np.isnan(rows[:, [column for column in columns if column >= 0]]).any(axis=1)
            rotations[absent, j] = np.nan
    return Bvh(skeleton, tuple(joint.channels for joint in joints), rotations, translations, header.fps, degrees)


def _names(joints: Sequence[_Joint]) -> list[str]:
    """Return the names of joints; give end sites, which have none, unique names."""
    names = [joint.name for joint in joints]
    for j, joint in enumerate(joints):
        if not joint.name:
            base = f"{names[joint.parent]}End"
            names[j] = base
            copies = 1
            while names.count(names[j]) > 1:
                copies += 1
                names[j] = f"{base}{copies}"
    return names
