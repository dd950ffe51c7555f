"""Generated motion of LaFAN1's skeleton, and in-betweening from its definitions, independent of npss.

Quaternions are multiplied as matrices of SU(2), vectors are turned by scipy, and windows are cut in loops.
"""

import math

import numpy as np
from scipy.spatial.transform import Rotation

PAST, FUTURE, LENGTHS = 10, 10, (5, 15, 30, 45)
NAMES = (
    *("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToe", "RightUpLeg", "RightLeg", "RightFoot", "RightToe"),
    *("Spine", "Spine1", "Spine2", "Neck", "Head"),
    *("LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand", "RightShoulder", "RightArm", "RightForeArm", "RightHand"),
)
PARENTS = (-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 12, 11, 14, 15, 16, 11, 18, 19, 20)
OFFSETS = np.random.default_rng(1).normal(0, 20, (22, 3)).round(3)  # invented, in centimetres


def clip(seed, frames):
    """Return Euler angles z, y, x in degrees ``(T, 22, 3)`` and the root's path in centimetres ``(T, 3)``.

    The hips turn several times, and one arm spins, so that quaternions pass half a turn; all is smooth.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, np.newaxis, np.newaxis] / 30
    waves = [
        rng.uniform(2, 25, (22, 3))
        * np.sin(2 * np.pi * (rng.uniform(0.2, 1.5, (22, 3)) * t + rng.uniform(0, 1, (22, 3))))
        for _ in range(2)
    ]
    angles = sum(waves)
    angles[:, 0, 1] += 120 * t[:, 0, 0]  # turns about the vertical
    angles[:, 0, 2] += 90  # the hips' y axis forwards
    angles[:, 15, 0] += 200 * t[:, 0, 0]
    path = np.stack([80 * t[:, 0, 0], 90 + 3 * np.sin(9 * t[:, 0, 0]), 40 * np.cos(t[:, 0, 0])], axis=-1)
    return ((angles + 180) % 360 - 180).round(6), (path + rng.uniform(-500, 500, 3)).round(6)


def write_bvh(path, angles, root, *, fps=30, offsets=OFFSETS, names=NAMES, parents=PARENTS):
    """Write a clip as LaFAN1's files are: a root of six channels, joints of three, z y x, with end sites."""
    lines = ["HIERARCHY"]

    def joint(j, depth):
        tab = "\t" * depth
        lines.append(f"{tab}{'JOINT' if depth else 'ROOT'} {names[j]}")
        lines.append(f"{tab}{{")
        lines.append(f"{tab}\tOFFSET {' '.join(map(repr, offsets[j].tolist()))}")
        lines.append(
            f"{tab}\tCHANNELS {'3' if depth else '6 Xposition Yposition Zposition'} Zrotation Yrotation Xrotation"
        )
        children = [child for child, parent in enumerate(parents) if parent == j]
        for child in children:
            joint(child, depth + 1)
        if not children:
            lines.extend([f"{tab}\tEnd Site", f"{tab}\t{{", f"{tab}\t\tOFFSET 1.0 2.0 3.0", f"{tab}\t}}"])
        lines.append(f"{tab}}}")

    joint(0, 0)
    lines += ["MOTION", f"Frames: {len(root)}", f"Frame Time: {1 / fps:.6f}"]
    rows = np.concatenate([root[:, np.newaxis], angles], axis=1).reshape(len(root), -1)
    lines += [" ".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def quaternion(axis, degrees):
    """Return the quaternion w, x, y, z of a rotation about an axis of coordinates."""
    half = math.radians(degrees) / 2
    q = [math.cos(half), 0.0, 0.0, 0.0]
    q[1 + "xyz".index(axis)] = math.sin(half)
    return np.array(q)


def product(*factors):
    """Multiply quaternions, as matrices of SU(2)."""
    matrix = np.eye(2, dtype=complex)
    for w, x, y, z in factors:
        matrix = matrix @ np.array([[w + 1j * x, y + 1j * z], [-y + 1j * z, w - 1j * x]])
    return np.array([matrix[0, 0].real, matrix[0, 0].imag, matrix[0, 1].real, matrix[0, 1].imag])


def conjugate(q):
    return q * [1, -1, -1, -1]


def turned(q, vector):
    return Rotation.from_quat(np.roll(q, -1)).apply(vector)


def local_of(angles):
    """Return local quaternions ``(T, 22, 4)``, continuous in time over the clip."""
    local = np.array([[product(*map(quaternion, "zyx", joint)) for joint in pose] for pose in angles])
    for t in range(1, len(local)):
        for j in range(local.shape[1]):
            if local[t, j] @ local[t - 1, j] < 0:
                local[t, j] *= -1
    return local


def world(local, root, *, offsets=OFFSETS, parents=PARENTS):
    """Return global quaternions and positions of one pose."""
    quaternions, positions = [], []
    for j, parent in enumerate(parents):
        if parent < 0:
            quaternions.append(local[j])
            positions.append(root)
        else:
            quaternions.append(product(quaternions[parent], local[j]))
            positions.append(positions[parent] + turned(quaternions[parent], offsets[j]))
    return np.array(quaternions), np.array(positions)


def windows_of(local, root, length, step):
    """Return the windows of a clip, as lists of poses: local quaternions and root, centred and turned."""
    found = []
    start = 0
    while start + length < len(root):
        q, x = local[start : start + length], root[start : start + length].copy()
        x[:, 0] -= x[:, 0].mean()
        x[:, 2] -= x[:, 2].mean()
        forward = turned(q[PAST - 1, 0], [0, 1, 0]) * [1, 0, 1]
        forward /= np.linalg.norm(forward)
        axis = np.cross(forward, [1, 0, 0])
        angle = math.atan2(np.linalg.norm(axis), forward[0])
        shortest = np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis / np.linalg.norm(axis))])
        q = q.copy()
        for t in range(length):
            of_world = [product(shortest, g) for g in world(q[t], x[t])[0]]
            q[t] = [
                g if parent < 0 else product(conjugate(of_world[parent]), g)
                for g, parent in zip(of_world, PARENTS, strict=True)
            ]
        found.append((q, turned(shortest, x)))
        start += step
    return found


def zero_velocity(local, root, n):
    return np.repeat(local[PAST - 1 : PAST], n, axis=0), np.repeat(root[PAST - 1 : PAST], n, axis=0)


def interpolation(local, root, n):
    """Interpolate one window between its last past frame and the target."""
    q, x = [], []
    for i in range(1, n + 1):
        w = float(np.float32(i / (n + 1)))
        x.append(root[PAST - 1] + w * (root[PAST + n] - root[PAST - 1]))
        pose = []
        for a, b in zip(local[PAST - 1], local[PAST + n], strict=True):
            cosine = a @ b
            if cosine < 0:
                cosine, b = -cosine, -b
            if cosine > 0.99:
                q_w = (1 - w) * a + w * b
            else:
                angle = math.acos(cosine)
                q_w = (math.sin((1 - w) * angle) * a + math.sin(w * angle) * b) / math.sin(angle)
            pose.append(q_w / np.linalg.norm(q_w))
        q.append(pose)
    return np.array(q), np.array(x)


def statistics(windows):
    """Return mean and standard deviation of each coordinate over training windows, ``(66,)``."""
    positions = np.array([world(*pose)[1].ravel() for window in windows for pose in zip(*window, strict=True)])
    return positions.mean(axis=0), positions.std(axis=0)


def row(windows, predictor, n, mean, std):
    """Return L2Q, L2P and NPSS of a predictor on transitions of n frames."""
    truths, predictions = [], []
    for local, root in windows:
        inside = slice(PAST, PAST + n)
        truths.append([world(*pose) for pose in zip(local[inside], root[inside], strict=True)])
        predictions.append([world(*pose) for pose in zip(*predictor(local, root, n), strict=True)])
    l2q, l2p = [], []
    for truth, prediction in zip(truths, predictions, strict=True):
        for (q, x), (other_q, other_x) in zip(truth, prediction, strict=True):
            l2q.append(math.sqrt(((q - other_q) ** 2).sum()))
            l2p.append(math.sqrt(((((x.ravel() - mean) / std) - ((other_x.ravel() - mean) / std)) ** 2).sum()))
    features = [np.array([[q.ravel() for q, _ in window] for window in motion]) for motion in (truths, predictions)]
    return np.mean(l2q), np.mean(l2p), npss(*features)


def npss(gt, pred):
    """Return the NPSS of the released code: squared real parts of spectra, cumulated; weights of the ground truth."""
    power = [np.fft.fft(motion, axis=1).real ** 2 for motion in (gt, pred)]
    totals = [part.sum(axis=1, keepdims=True) for part in power]
    first, second = (np.cumsum(part / total, axis=1) for part, total in zip(power, totals, strict=True))
    distance = np.abs(first - second).sum(axis=1)
    return (distance * totals[0][:, 0]).sum() / totals[0].sum()
