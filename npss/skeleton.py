"""Forward kinematics: compute positions of joints from rotations, for Human3.6M's and other skeletons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert, result_dtype, rotation_array
from npss.rotations._matrix import MATRIX
from npss.rotations._poses import POSE
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array, Float64, check_finite, each, is_integer, one_of, real_array

__all__ = ["FEATURE_NAMES", "H36M", "Forward", "Skeleton", "poses_to_positions"]

_SIDES = {"left": re.compile(r"(?i:left)|[Ll](?=[A-Z_])"), "right": re.compile(r"(?i:right)|[Rr](?=[A-Z_])")}


class Forward(NamedTuple):
    """The result of forward kinematics.

    Attributes
    ----------
    positions : (..., J, 3) ndarray
        The positions of the joints, in the unit of the offsets.
    rotations : (..., J, 3, 3) ndarray
        The global rotations of the joints: from the frame of each joint to the world.
    """

    positions: Array
    rotations: Array


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of joints with bones of fixed lengths.

    Parameters
    ----------
    names : sequence of str
        Unique names of the J joints.
    parents : sequence of int
        The index of each joint's parent, in any order; -1 for the single root.
    offsets : (J, 3) array_like
        The position of each joint in the frame of its parent, in the unit of positions; for the root, its default
        position. float64, read-only.

    Raises
    ------
    TypeError
        If a name is not a string, a parent not an integer, or an offset not a real number.
    ValueError
        If there are no joints, the three differ in length, a name is a duplicate, an offset is not finite, there is not
        exactly one root, a parent is not a joint, or ancestors form a cycle.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.skeleton import Skeleton
    >>> arm = Skeleton(["shoulder", "elbow", "hand"], [-1, 0, 1], [[0, 0, 0], [3, 0, 0], [2, 0, 0]])
    >>> straight, quarter_turn = np.eye(3), np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    >>> arm.positions([straight, quarter_turn, straight])
    array([[0., 0., 0.],
           [3., 0., 0.],
           [3., 2., 0.]])
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Float64
    _order: tuple[int, ...] = field(init=False, repr=False)  # each joint after its parent

    def __init__(self, names: Sequence[str], parents: Sequence[int], offsets: npt.ArrayLike) -> None:
        joints, tree = each("names", names, "strings"), each("parents", parents, "integers")
        if not joints:
            raise ValueError("names: expected at least one joint")
        for i, name in enumerate(joints):
            if not isinstance(name, str):
                raise TypeError(f"names: expected strings, got {name!r} at index {i}")
            if name in joints[:i]:
                raise ValueError(f"names: duplicate {name!r}, at index {joints.index(name)} and {i}")
        if len(tree) != len(joints):
            raise ValueError(f"parents: expected one for each of {len(joints)} joints, got {len(tree)}")
        array = real_array("offsets", offsets)
        if array.shape != (len(joints), 3):
            raise ValueError(f"offsets: expected shape (J, 3) = ({len(joints)}, 3), got {array.shape}")
        check_finite("offsets", array)
        fixed = array.astype(np.float64)
        fixed.setflags(write=False)
        for name, value in (
            ("names", tuple(joints)),
            ("parents", tuple(map(int, tree))),
            ("offsets", fixed),
            ("_order", _order(tree, joints)),
        ):
            object.__setattr__(self, name, value)

    @property
    def bones(self) -> tuple[tuple[int, int], ...]:
        """The bones to draw: (child, parent) for every joint with a nonzero offset."""
        return tuple((j, parent) for j, parent in enumerate(self.parents) if parent >= 0 and self.offsets[j].any())

    @property
    def sides(self) -> tuple[str, ...]:
        """The side of every joint, 'left', 'right' or 'centre', by its name: ``LeftFoot``, ``LFoot``, ``l_foot``."""
        return tuple(
            next((side for side, begins in _SIDES.items() if begins.match(name)), "centre") for name in self.names
        )

    def forward(
        self, rotations: npt.ArrayLike, *, root: npt.ArrayLike | None = None, offsets: npt.ArrayLike | None = None
    ) -> Forward:
        """Compute the positions and global rotations of the joints by forward kinematics.

        With column vectors, starting at the root::

            turned[j] = turned[parent] @ rotations[j]
            position[j] = position[parent] + turned[parent] @ offsets[j]

        Parameters
        ----------
        rotations : (..., J, 3, 3) array_like
            The rotation of every joint in the frame of its parent, as matrices that rotate column vectors.
        root : (..., 3) array_like, optional
            The position of the root, with the leading axes of `rotations` (default: its offset).
        offsets : (..., J, 3) array_like, optional
            The position of each joint in the frame of its parent, with the leading axes of `rotations`, if it varies,
            as in files with positions of all joints (default: the skeleton's offsets).

        Returns
        -------
        Forward
            ``positions`` (..., J, 3), in the unit of the offsets, and ``rotations`` (..., J, 3, 3), ``turned`` above.
            float32 for float32 rotations, float64 otherwise.

        Raises
        ------
        TypeError
            If an argument does not hold real numbers.
        ValueError
            If a shape is wrong, a value is not finite, or a matrix is not a rotation. The message names the index.

        Examples
        --------
        >>> import numpy as np
        >>> from npss.skeleton import H36M
        >>> positions, rotations = H36M.forward(np.tile(np.eye(3), (10, 32, 1, 1)))
        >>> positions.shape, rotations.shape
        ((10, 32, 3), (10, 32, 3, 3))
        """
        turns = self._read("rotations", rotations)
        bones = self.offsets if offsets is None else _like("offsets", offsets, turns.shape[:-1])
        place = bones[..., self.parents.index(-1), :] if root is None else _like("root", root, (*turns.shape[:-3], 3))
        return self._compose(turns, place, bones)

    def positions(
        self, rotations: npt.ArrayLike, *, root: npt.ArrayLike | None = None, offsets: npt.ArrayLike | None = None
    ) -> Array:
        """Compute the positions of the joints: the first result of `forward`.

        Parameters
        ----------
        rotations, root, offsets : array_like
            As for `forward`.

        Returns
        -------
        (..., J, 3) ndarray
            In the unit of the offsets. float32 for float32 rotations, float64 otherwise.

        Raises
        ------
        TypeError, ValueError
            As for `forward`.
        """
        return self.forward(rotations, root=root, offsets=offsets).positions

    def global_rotations(self, local: npt.ArrayLike) -> Array:
        """Compute the rotations of the joints in the world from those in the frames of their parents.

        Parameters
        ----------
        local : (..., J, 3, 3) array_like
            The rotation of every joint in the frame of its parent, as matrices that rotate column vectors.

        Returns
        -------
        (..., J, 3, 3) ndarray
            float32 for float32, float64 otherwise.

        Raises
        ------
        TypeError, ValueError
            As for `forward`.

        See Also
        --------
        local_rotations : the inverse.

        Examples
        --------
        >>> import numpy as np
        >>> from npss.rotations import expmap_to_matrix, matrix_to_expmap
        >>> from npss.skeleton import Skeleton
        >>> arm = Skeleton(["shoulder", "elbow"], [-1, 0], np.zeros((2, 3)))
        >>> local = expmap_to_matrix([[0.1, 0, 0], [0.2, 0, 0]])
        >>> matrix_to_expmap(arm.global_rotations(local)).round(12)
        array([[0.1, 0. , 0. ],
               [0.3, 0. , 0. ]])
        """
        turns = self._read("local", local)
        turned = np.empty(turns.shape, result_dtype(turns))
        for j in self._order:
            self._turn(turns, turned, j)
        return turned

    def local_rotations(self, turned: npt.ArrayLike) -> Array:
        """Compute the rotations of the joints in the frames of their parents from those in the world.

        Parameters
        ----------
        turned : (..., J, 3, 3) array_like
            Global rotations, as matrices that rotate column vectors.

        Returns
        -------
        (..., J, 3, 3) ndarray
            float32 for float32, float64 otherwise.

        Raises
        ------
        TypeError, ValueError
            As for `forward`.

        Examples
        --------
        >>> import numpy as np
        >>> from npss.rotations import expmap_to_matrix, matrix_to_expmap
        >>> from npss.skeleton import Skeleton
        >>> arm = Skeleton(["shoulder", "elbow"], [-1, 0], np.zeros((2, 3)))
        >>> turned = expmap_to_matrix([[0.1, 0, 0], [0.3, 0, 0]])
        >>> matrix_to_expmap(arm.local_rotations(turned)).round(12)
        array([[0.1, 0. , 0. ],
               [0.2, 0. , 0. ]])
        """
        array = self._read("turned", turned)
        local = array.astype(result_dtype(array))
        for j, parent in enumerate(self.parents):
            if parent >= 0:
                inverse = array[..., parent, :, :].swapaxes(-1, -2).astype(local.dtype, copy=False)
                local[..., j, :, :] = inverse @ local[..., j, :, :]
        return local

    def _read(self, name: str, rotations: npt.ArrayLike) -> Array:
        turns = rotation_array(name, rotations, (len(self.names), 3, 3))
        convert(name, turns, MATRIX, QUATERNION)  # raises unless all are finite rotations
        return turns

    def _turn(self, rotations: Array, turned: Array, j: int) -> None:
        """Fill the global rotation of a joint, after that of its parent."""
        if self.parents[j] < 0:
            turned[..., j, :, :] = rotations[..., j, :, :]
        else:
            np.matmul(turned[..., self.parents[j], :, :], rotations[..., j, :, :], out=turned[..., j, :, :])

    def _compose(self, rotations: Array, root: Array, offsets: Array) -> Forward:
        """Compute `forward` from valid arguments."""
        dtype = result_dtype(rotations)
        turned = np.empty(rotations.shape, dtype)
        positions = np.empty(rotations.shape[:-1], dtype)
        bones = offsets.astype(dtype, copy=False)[..., np.newaxis]
        for j in self._order:
            self._turn(rotations, turned, j)
            parent = self.parents[j]
            if parent < 0:
                positions[..., j, :] = root
            else:
                bone = turned[..., parent, :, :] @ bones[..., j, :, :]
                positions[..., j, :] = positions[..., parent, :] + bone[..., 0]
        return Forward(positions, turned)


def _like(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    array = real_array(name, values)
    if array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}")
    check_finite(name, array)
    return array


def _order(parents: Sequence[int], names: Sequence[str]) -> tuple[int, ...]:
    """Return the order in which each joint follows its parent."""
    for j, parent in enumerate(parents):
        if not is_integer(parent):
            raise TypeError(f"parents: expected integers, got {parent!r} for {names[j]}")
        if not -1 <= parent < len(parents):
            raise ValueError(f"parents: {parent} for {names[j]}; expected -1 or one of the {len(parents)} joints")
    if (roots := parents.count(-1)) != 1:
        raise ValueError(f"parents: expected one root, with parent -1, got {roots}")
    order = [parents.index(-1)]
    for parent in order:  # grows
        order += [j for j in range(len(parents)) if parents[j] == parent]
    if adrift := set(range(len(parents))) - set(order):
        raise ValueError(f"parents: {names[min(adrift)]} is not connected to the root: its ancestors form a cycle")
    return tuple(order)


#: The skeleton of Human3.6M's exponential-map files: 32 joints, in millimetres; x points to the figure's left, y up, z
#: forwards. The numbers are from the published files; the names are descriptive.
H36M = Skeleton(
    (
        *("Hips", "RightUpLeg", "RightLeg", "RightFoot", "RightToeBase", "RightToeEnd"),
        *("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase", "LeftToeEnd"),
        *("Spine", "Spine1", "Neck", "Head", "HeadTop"),
        *("LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand"),
        *("LeftHandThumb", "LeftHandThumbEnd", "LeftHandIndex", "LeftHandIndexEnd"),
        *("RightShoulder", "RightArm", "RightForeArm", "RightHand"),
        *("RightHandThumb", "RightHandThumbEnd", "RightHandIndex", "RightHandIndexEnd"),
    ),
    (
        *(-1, 0, 1, 2, 3, 4),
        *(0, 6, 7, 8, 9),
        *(0, 11, 12, 13, 14),
        *(12, 16, 17, 18),
        *(19, 20, 19, 22),
        *(12, 24, 25, 26),
        *(27, 28, 27, 30),
    ),
    (
        *((0, 0, 0), (-132.948591, 0, 0), (0, -442.894612, 0), (0, -454.206447, 0), (0, 0, 162.767078)),
        *((0, 0, 74.999437), (132.948826, 0, 0), (0, -442.894413, 0), (0, -454.20659, 0), (0, 0, 162.767426)),
        *((0, 0, 74.999948), (0, 0.1, 0), (0, 233.383263, 0), (0, 257.077681, 0), (0, 121.134938, 0)),
        *((0, 115.002227, 0), (0, 257.077681, 0), (0, 151.034226, 0), (0, 278.882773, 0), (0, 251.733451, 0)),
        *((0, 0, 0), (0, 0, 99.999627), (0, 100.000188, 0), (0, 0, 0)),
        *((0, 257.077681, 0), (0, 151.031437, 0), (0, 278.892924, 0), (0, 251.72868, 0)),
        *((0, 0, 0), (0, 0, 99.999888), (0, 137.499922, 0), (0, 0, 0)),
    ),
)
#: The names of the 99 columns of a Human3.6M pose, ``joint.axis``. Euler angles of `npss.poses_to_euler` have the same
#: columns.
FEATURE_NAMES = tuple(f"{joint}.{axis}" for joint in ("translation", *H36M.names) for axis in "xyz")


#: The root: at the origin, facing forwards, or on its path.
Root = Literal["fixed", "path"]


def poses_to_positions(poses: npt.ArrayLike, *, root: Root = "fixed") -> Array:
    """Compute the positions of the joints of Human3.6M poses.

    Parameters
    ----------
    poses : (..., 99) array_like
        Poses as in the files: columns 0-2 are the displacement of the root since the frame before in millimetres, 3-5
        its rotation since then, then the rotations of 31 joints in the frames of their parents. Rotations are
        exponential maps in radians.
    root : {'fixed', 'path'}, optional
        Keep the root at the origin, facing forwards, and use only the scored columns, from 6 on. Or start there and
        follow its displacements and rotations in time, ``(..., T, 99)``; those of the first frame are ignored.

    Returns
    -------
    (..., 32, 3) ndarray
        Positions in millimetres of the joints of `H36M`. float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError
        If `poses` does not hold real numbers, or `root` is not a string.
    ValueError
        If the last axis does not have 99 columns, a value is not finite, an angle is 2**52 or more, `root` is invalid,
        or a path has no time axis.

    Notes
    -----
    The files are made for row vectors: with the matrix R of an exponential map, ``offset @ R``. For
    `Skeleton.positions`, the rotation of a joint is the transposed matrix, that of the negated exponential map. Only
    then knees bend backwards and the standing foot stays in place.

    The test windows of the field use every second frame of the files, and so every second displacement: their paths
    are about half as long as the distance walked.

    References
    ----------
    C. Ionescu et al., "Human3.6M: Large Scale Datasets and Predictive Methods for 3D Human Sensing in Natural
    Environments", TPAMI 2014. The composition follows the code released with J. Martinez et al., "On Human Motion
    Prediction Using Recurrent Neural Networks", CVPR 2017.

    Examples
    --------
    A default pose with the right knee bent by 90 degrees:

    >>> import numpy as np
    >>> from npss.skeleton import FEATURE_NAMES, H36M, poses_to_positions
    >>> pose = np.zeros(99)
    >>> pose[FEATURE_NAMES.index("RightLeg.x")] = -np.pi / 2
    >>> positions = poses_to_positions(pose)
    >>> positions[H36M.names.index("RightFoot")].round(1)
    array([-132.9, -442.9, -454.2])
    """
    array = rotation_array("poses", poses, (POSE,))
    one_of("root", root, get_args(Root))
    if root == "path" and array.ndim < 2:
        raise ValueError(f"poses: a path needs a time axis, expected shape (..., T, {POSE}), got {array.shape}")
    check_finite("poses", array)
    joints = array[..., 3:].reshape((*array.shape[:-1], len(H36M.names), 3))
    rotations = convert("poses: as (..., 32, 3) from column 3 on", joints, EXPMAP, MATRIX).swapaxes(-1, -2)
    turns = rotations[..., 0, :, :].copy()
    rotations[..., 0, :, :] = np.eye(3)
    place = np.zeros((*array.shape[:-1], 3))
    if root == "path":
        for t in range(1, array.shape[-2]):
            facing = rotations[..., t - 1, 0, :, :]
            place[..., t, :] = place[..., t - 1, :] + (facing @ array[..., t, :3, np.newaxis])[..., 0]
            rotations[..., t, 0, :, :] = facing @ turns[..., t, :, :]
    return H36M._compose(rotations, place, H36M.offsets).positions
