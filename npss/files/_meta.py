"""What the arrays of a file of results are: the JSON text ``meta`` beside them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Self, get_args

import numpy as np

from npss.files._json import parse_json
from npss.skeleton import Skeleton
from npss.validation import Array, each, is_integer, one_of, positive_integer, positive_number

#: The signs of quaternions, as signatures state them.
Quaternions = Literal["continuous", "w>=0"]
#: The unit of positions.
Unit = Literal["m", "cm", "mm"]
#: The axis that points upwards.
Up = Literal["x", "y", "z"]

_MILLIMETRES: Mapping[str, float] = {"m": 1000.0, "cm": 10.0, "mm": 1.0}


@dataclass(frozen=True)
class Meta:
    """What the arrays of a file of results are; every field may be left out.

    Attributes
    ----------
    representation : str or None
        What the features are, as signatures state it: ``'euler'``, ``'quaternion'``, ``'matrix'``, ``'positions'``, ...
    fps : float or None
        Frames per second.
    protocol : str or None
        The test windows.
    quaternions : {'continuous', 'w>=0'} or None
        The signs of quaternions, as signatures state them.
    joint_names : tuple of str or None
        The names of the joints.
    parents : tuple of int or None
        The index of each joint's parent, -1 for the root.
    unit : {'m', 'cm', 'mm'} or None
        The unit of positions.
    up : {'x', 'y', 'z'} or None
        The axis that points upwards.
    lengths, groups : dict of str to tuple
        By condition: the frames that count of each sequence, and the block of each sequence or None.
    """

    representation: str | None = None
    fps: float | None = None
    protocol: str | None = None
    quaternions: Quaternions | None = None
    joint_names: tuple[str, ...] | None = None
    parents: tuple[int, ...] | None = None
    unit: Unit | None = None
    up: Up | None = None
    lengths: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    groups: Mapping[str, tuple[str | int | None, ...]] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read the JSON text; errors begin with ``meta``.

        Raises
        ------
        TypeError, ValueError
            If it is no JSON object, or a field is unknown or invalid.
        """
        try:
            values = parse_json(text)
        except ValueError as error:
            raise ValueError(f"meta: {error}") from error
        if not isinstance(values, dict):
            raise TypeError(f"meta: expected a JSON object, got {values!r:.100}")
        known = cls.__dataclass_fields__
        if unknown := [name for name in values if name not in known]:
            raise ValueError(f"meta: unknown field {unknown[0]!r}; known: {', '.join(known)}")
        meta = cls(**{name: _READ[name](f"meta: {name}", value) for name, value in values.items()})
        if meta.joint_names is not None and meta.parents is not None and len(meta.joint_names) != len(meta.parents):
            raise ValueError(
                f"meta: joint_names: expected one for each of {len(meta.parents)} parents, got {len(meta.joint_names)}"
            )
        return meta

    def context(self) -> dict[str, Any]:
        """Return the fields that signatures state."""
        stated = {name: getattr(self, name) for name in ("representation", "protocol", "quaternions")}
        return {name: value for name, value in stated.items() if value is not None}

    def feature_names(self, n_features: int) -> tuple[str, ...] | None:
        """Return a name for each feature, if there are names of joints that divide them."""
        if self.joint_names is None or n_features % len(self.joint_names):
            return None
        n = n_features // len(self.joint_names)
        components = {3: "xyz", 4: "wxyz"}.get(n, tuple(map(str, range(n))))
        return tuple(f"{joint}.{component}" for joint in self.joint_names for component in components)

    def not_drawn(self) -> str:
        """Return why the motion cannot be drawn; empty if it can."""
        if self.representation != "positions":
            return f"representation is {self.representation!r}, and only 'positions' are drawn"
        missing = [name for name in ("parents", "unit", "fps") if getattr(self, name) is None]
        return f"no {', '.join(missing)}" if missing else ""

    def positions(self, motion: Array) -> Array:
        """Return positions (N, T, J, 3) in millimetres, y up, of motion that can be drawn: the root begins above 0.

        Raises
        ------
        ValueError
            If the features are not three for each joint.
        """
        assert self.parents is not None
        joints = len(self.parents)
        if motion.shape[2] != 3 * joints:
            raise ValueError(f"parents: of {joints} joints, but there are {motion.shape[2]} features, not {3 * joints}")
        # A cyclic change of axes is a rotation: it keeps left and right.
        places: Array = np.roll(self.millimetres(motion), {"x": 1, "y": 0, "z": -1}[self.up or "y"], axis=-1)
        start = places[:, :1, [self.parents.index(-1)]]
        moved: Array = places - start * [1, 0, 1]
        return moved

    def millimetres(self, motion: Array) -> Array:
        """Return positions (N, T, J, 3) in millimetres, as they are otherwise.

        Raises
        ------
        ValueError
            If the motion is not positions, its unit is unknown, or the features are not three for each joint.
        """
        if self.representation != "positions" or self.unit is None:
            raise ValueError(
                "it takes positions: a meta with the representation 'positions' and their unit, got "
                f"{self.representation!r} and {self.unit!r}"
            )
        if motion.shape[2] % 3:
            raise ValueError(f"expected three features for each joint, got {motion.shape[2]}")
        return motion.reshape(*motion.shape[:2], -1, 3) * _MILLIMETRES[self.unit]

    def skeleton(self, positions: Array) -> Skeleton:
        """Return the skeleton of positions (N, T, J, 3), with the bones of the first frame."""
        assert self.parents is not None
        frame = positions[0, 0]
        bones = [
            frame[joint] - frame[parent] if parent >= 0 else [0, 0, 0] for joint, parent in enumerate(self.parents)
        ]
        names = self.joint_names or [f"joint {joint}" for joint in range(len(self.parents))]
        return Skeleton(names, self.parents, np.array(bones, dtype=np.float64))


def _text(name: str, value: object) -> str:
    if not isinstance(value, str) or not value:
        raise TypeError(f"{name}: expected text, got {value!r:.100}")
    return value


def _texts(name: str, value: Any) -> tuple[str, ...]:
    texts = tuple(_text(name, one) for one in each(name, value, "texts"))
    if len(set(texts)) < len(texts):
        raise ValueError(f"{name}: duplicate {Counter(texts).most_common(1)[0][0]!r}")
    return texts


def _parents(name: str, value: Any) -> tuple[int, ...]:
    parents = tuple(each(name, value, "integers"))
    zeros = np.zeros((len(parents), 3))
    try:
        Skeleton([str(joint) for joint in range(len(parents))], parents, zeros)  # raises unless they are a tree
    except (TypeError, ValueError) as error:
        raise type(error)(f"meta: {error}") from error
    return parents


def _lengths(name: str, value: object) -> dict[str, tuple[int, ...]]:
    return {
        condition: tuple(positive_integer(f"{name}: {condition}", length) for length in each(name, lengths, "integers"))
        for condition, lengths in _object(name, value).items()
    }


def _groups(name: str, value: object) -> dict[str, tuple[str | int | None, ...]]:
    found = {}
    for condition, labels in _object(name, value).items():
        for label in (of_condition := tuple(each(name, labels, "labels"))):
            if not (label is None or isinstance(label, str) or is_integer(label)):
                raise TypeError(f"{name}: {condition}: expected text, whole numbers or null, got {label!r:.100}")
        found[condition] = of_condition
    return found


def _object(name: str, value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"{name}: expected an object with a list for each condition, got {value!r:.100}")
    return value


def _choice(choices: tuple[str, ...]) -> Any:
    def read(name: str, value: object) -> Any:
        one_of(name, value, choices)
        return value

    return read


_READ: Mapping[str, Any] = {
    "representation": _text,
    "fps": positive_number,
    "protocol": _text,
    "quaternions": _choice(get_args(Quaternions)),
    "joint_names": _texts,
    "parents": _parents,
    "unit": _choice(get_args(Unit)),
    "up": _choice(get_args(Up)),
    "lengths": _lengths,
    "groups": _groups,
}
