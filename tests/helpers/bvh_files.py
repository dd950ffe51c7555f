"""BVH files with random trees, channels and values."""

import numpy as np

CHANNELS = [axis + kind for kind in ("position", "rotation") for axis in "XYZ"]


def generated(seed, n_joints=5, n_frames=4, plain=False):
    """Return the text of a BVH file with a random tree, and its content.

    Joints have any channels in any order; or if plain, three rotations each, and the root three positions before them.
    """
    rng = np.random.default_rng(seed)
    names, parents, offsets, channels = [], [], [], []
    lines = ["HIERARCHY"]

    def text(numbers):
        return " ".join(map(str, numbers))

    def some_of(words, style):
        return [] if style == 0 else list(rng.permutation(words)[: rng.integers(1, 7) if style == 1 else len(words)])

    def joint(parent, left):
        """Write a joint and up to `left` below it; return how many there are now."""
        j = len(names)
        names.append(f"joint{j}" if rng.random() < 0.7 or plain else f"left: joint #{j}")
        parents.append(parent)
        offsets.append(rng.normal(size=3).round(4))
        if plain:
            channels.append(CHANNELS[:3] * (parent < 0) + list(rng.permutation(CHANNELS[3:])))
        else:
            style = rng.integers(5)
            channels.append(some_of(CHANNELS[3:] if style == 4 else CHANNELS, style))
            if parent < 0 and not channels[-1]:
                channels[-1] = list(CHANNELS)
        lines.extend([f"{'ROOT' if parent < 0 else 'JOINT'} {names[-1]}", "{", f"\tOFFSET {text(offsets[-1])}"])
        lines.append(f"  CHANNELS {len(channels[-1])} {' '.join(channels[-1])}".rstrip())
        left -= 1
        if left == 0 or (parent >= 0 and rng.random() < 0.3):
            names.append(f"{names[j]}End")
            parents.append(j)
            offsets.append(rng.normal(size=3).round(4))
            channels.append(None)
            lines.extend(["  End Site", "{", f"\tOFFSET {text(offsets[-1])}", "}"])
        while left and (parent < 0 or rng.random() < 0.6):
            left = joint(j, left)
        lines.append("}")
        return left

    joint(-1, n_joints)
    n_channels = sum(len(of or ()) for of in channels)
    rows = rng.uniform(-180, 180, (n_frames, n_channels)).round(4)
    lines += ["MOTION", f"Frames: {n_frames}", "Frame Time: 0.00833333"]
    lines += [text(row) for row in rows]
    return "\n".join(lines) + "\n", (names, parents, offsets, channels, rows, 120)
