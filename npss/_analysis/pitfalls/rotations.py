"""Pitfalls of rotations: jumps in the numbers of a rotation that does not jump."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator

import numpy as np

from npss._analysis.pitfalls.pitfall import NOTE, WARNING, Block, Found, Mask, Pitfall, Tally
from npss.validation import Float64


class _Jump(Pitfall):
    """A pitfall at single places of either motion."""

    what: str
    mend: str

    def __init__(self) -> None:
        self._tallies = {"gt": Tally(), "pred": Tally()}
        self._as_published = True

    def see(self, block: Block) -> None:
        """Count the jumps."""
        self._as_published &= block.as_published()
        for argument, motion in block.named():
            self._tallies[argument].add(block.top, self.where(motion))

    def found(self) -> Iterator[Found]:
        """Yield a finding for each motion; a note if published tables have such jumps, too."""
        for argument, tally in self._tallies.items():
            if tally.count and self._as_published:
                message = f"{self.what}, as in the published tables; {self.mend} removes them and changes the score"
                yield Found(argument, tally.count, tally.first, message, NOTE)
            elif tally.count:
                message = f"{self.what}, which change every score; {self.mend} removes them"
                yield Found(argument, tally.count, tally.first, message, WARNING)

    @abstractmethod
    def where(self, motion: Float64) -> Mask:
        """Return the places of jumps, ``(n, ...)``."""


class Wraps(_Jump):
    """Angles that jump by a full turn while the joint stands still."""

    name = "wrap"
    what = "jumps of about 2 pi between frames"
    mend = "npss.unwrap"

    def where(self, motion: Float64) -> Mask:
        """Mark the frame (n, t, d) before each jump."""
        steps = np.abs(np.diff(motion, axis=1))
        jumps = np.abs(steps - 2 * math.pi) < 1
        return np.asarray(jumps & _angles(motion, 2.1 * math.pi) & _calm(steps, jumps))  # no wrapped angle is larger


class GimbalFlips(_Jump):
    """Euler angles whose outer two jump by half a turn at gimbal lock while the joint moves smoothly."""

    name = "gimbal-flip"
    what = "jumps of about pi in two of three Euler angles, while the rotation continues through gimbal lock"
    mend = "npss.rotations.continuous_euler"

    def where(self, motion: Float64) -> Mask:
        """Mark the frame and the first of three features (n, t, d) before each jump."""
        steps = np.abs(np.diff(motion, axis=1))
        half_turns = (np.abs(steps - math.pi) < 1) | (np.abs(steps - 3 * math.pi) < 1)
        outer = half_turns & _angles(motion, 4.1 * math.pi) & _calm(steps, half_turns)  # unwrapped angles are larger
        flips: Mask = outer[..., :-2] & outer[..., 2:]
        n, t, d = np.nonzero(flips)
        before, after = motion[n, t, d + 1], motion[n, t + 1, d + 1]
        flips[n, t, d] = (_turned(after + before - math.pi) < 1) | (_turned(after + before) < 1)
        return flips


class SignFlips(_Jump):
    """Quaternions that change sign while the rotation stays the same."""

    name = "quaternion-sign"
    what = "quaternions change sign between frames while the rotation stays the same"
    mend = "npss.rotations.continuous"

    def where(self, motion: Float64) -> Mask:
        """Mark the frame and quaternion (n, t, d / 4) before each flip."""
        unit, quaternions = _unit_quaternions(motion)
        products = (quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=-1)
        return np.asarray(unit[:, np.newaxis] & (products < -0.5))


class Hemisphere(Pitfall):
    """Quaternions opposite to those of the ground truth, for similar rotations."""

    name = "hemisphere"

    def __init__(self) -> None:
        self._opposite = Tally()

    def see(self, block: Block) -> None:
        """Count the quaternions that are nearer to the ground truth with the other sign throughout a sequence."""
        (gt_unit, gt), (pred_unit, pred) = (_unit_quaternions(motion) for _, motion in block.named())
        products = (gt * pred).sum(axis=-1)
        opposite = (products.max(axis=1) < 0) & (products.mean(axis=1) < -0.5)
        self._opposite.add(block.top, gt_unit & pred_unit & opposite)

    def found(self) -> Iterator[Found]:
        """Yield their number."""
        if self._opposite.count:
            yield Found(
                "pred",
                self._opposite.count,
                self._opposite.first,
                "quaternions lie in the hemisphere opposite to the ground truth throughout a sequence: NPSS is the "
                "same, but no mean of differences is; npss.rotations.continuous can begin near a start",
            )


class ComponentOrder(Pitfall):
    """Quaternions x, y, z, w beside w, x, y, z."""

    name = "component-order"
    _ORDERS = ("w, x, y, z", "x, y, z, w")
    _SHIFTS = (0, 1, -1)  # of the prediction's components
    _CLOSE = 0.2  # distance, 1 - cos of half the angle: an angle of 74 degrees on average
    _CLOSER = 4  # ratio of distances
    _FEWEST = 8  # quaternions of sequences: with fewer, rotations at random may be close in another order
    _SAME = 0.98  # of the second moment: quaternions so alike may be close in another order, too

    def __init__(self) -> None:
        self._distances = np.zeros(3)  # sums, by shift
        self._moments = np.zeros((2, 4, 4))  # second moments of both motions
        self._frames = 0  # of all quaternions
        self._quaternions = 0
        self._sequences = 0

    def see(self, block: Block) -> None:
        """Add up distances, of either sign, in each order."""
        (gt_unit, gt), (pred_unit, pred) = (_unit_quaternions(motion) for _, motion in block.named())
        n, q = np.nonzero(gt_unit & pred_unit)
        truth, prediction = gt[n, :, q], pred[n, :, q]  # (quaternions, T, 4)
        for i, shift in enumerate(self._SHIFTS):
            products = (truth * np.roll(prediction, shift, axis=-1)).sum(axis=-1)
            self._distances[i] += (1 - np.abs(products)).sum()
        self._moments += [np.einsum("qti,qtj->ij", motion, motion) for motion in (truth, prediction)]
        self._frames += truth.shape[0] * truth.shape[1]
        self._quaternions += len(n)
        self._sequences += len(block.gt)

    def found(self) -> Iterator[Found]:
        """Yield a finding if all together are much closer in another order."""
        if self._quaternions < self._FEWEST:
            return
        as_given, *rolled = np.maximum(self._distances, 0) / self._frames
        best = int(np.argmin(rolled))
        alike = np.linalg.eigvalsh(self._moments / self._frames)[:, -1].max() > self._SAME
        if alike or rolled[best] > self._CLOSE or self._CLOSER * rolled[best] > as_given:
            return
        first, other = self._ORDERS[:: -1 if best else 1]
        yield Found(
            "pred",
            self._sequences,
            (),
            f"quaternions are much closer to the ground truth as {first}: {other} beside {first}?",
        )


def _unit_quaternions(motion: Float64) -> tuple[Mask, Float64]:
    """Return a mask of unit quaternions ``(n, Q)``, and quaternions ``(n, T, Q, 4)``; Q is 0 unless 4 divides D."""
    n, n_frames, d = motion.shape
    quaternions = (motion[..., :0] if d % 4 else motion).reshape(n, n_frames, 0 if d % 4 else d // 4, 4)
    unit: Mask = (np.abs(np.square(quaternions).sum(axis=-1) - 1) < 1e-2).all(axis=1)
    unit &= 2 * unit.sum(axis=1, keepdims=True) >= unit.shape[1]  # a few may be unit by chance, as in rotation matrices
    return unit, quaternions


def _angles(motion: Float64, largest: float) -> Mask:
    """Return which features may be angles, ``(n, 1, D)``: those without larger values, if they are the majority."""
    small: Mask = np.abs(motion).max(axis=1, keepdims=True) < largest
    small &= 2 * small.sum(axis=2, keepdims=True) >= small.shape[2]
    return small


def _calm(steps: Float64, jumps: Mask) -> Mask:
    """Return which features are calm apart from their jumps, ``(n, 1, D)``: in noise, jumps mean nothing."""
    calm: Mask = ((steps > 1) & ~jumps).sum(axis=1, keepdims=True) < 1.5 + 0.1 * steps.shape[1]
    return calm


def _turned(angles: Float64) -> Float64:
    """Return the distance of angles from whole turns."""
    distance: Float64 = np.abs(np.remainder(angles + math.pi, math.tau) - math.pi)
    return distance
