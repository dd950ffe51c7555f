"""BVH files: generated ones against oracles, thousands of broken ones, and pybvh's own forward kinematics."""

import re
import sys
import tracemalloc

import numpy as np
import pybvh
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from baselines.data import bvh

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)


def generated(seed, n_joints=5, n_frames=4):
    """Return the text of a BVH file with a tree at random, and what it says."""
    rng = np.random.default_rng(seed)
    names, parents, offsets, orders = [], [], [], []
    lines = ["HIERARCHY"]

    def text(numbers):
        return " ".join(map(str, numbers))

    def joint(parent, left):
        """Write a joint and up to `left` below it; return how many there are now."""
        j = len(names)
        names.append(f"joint{j}")
        parents.append(parent)
        offsets.append(rng.normal(size=3).round(4))
        orders.append(ORDERS[rng.integers(6)])
        channels = "".join(f" {axis}rotation" for axis in orders[-1])
        positions = " Xposition Yposition Zposition" if parent < 0 else ""
        lines.extend([f"{'ROOT' if parent < 0 else 'JOINT'} {names[-1]}", "{", f"\tOFFSET {text(offsets[-1])}"])
        lines.append(f"  CHANNELS {6 if parent < 0 else 3}{positions}{channels}")
        left -= 1
        if left == 0 or (parent >= 0 and rng.random() < 0.3):
            names.append(f"joint{j}End")
            parents.append(j)
            offsets.append(rng.normal(size=3).round(4))
            orders.append(None)
            lines.extend(["  End Site", "{", f"\tOFFSET {text(offsets[-1])}", "}"])
        while left and (parent < 0 or rng.random() < 0.6):
            left = joint(j, left)
        lines.append("}")
        return left

    joint(-1, n_joints)
    n_channels = 3 + 3 * sum(order is not None for order in orders)
    rows = rng.uniform(-180, 180, (n_frames, n_channels)).round(4)
    lines += ["MOTION", f"Frames: {n_frames}", "Frame Time: 0.00833333"]
    lines += [text(row) for row in rows]
    return "\n".join(lines) + "\n", (names, parents, offsets, orders, rows, 120)


def parse(text):
    """Read the text of a BVH file in another way: by splitting it into words, strictly. ValueError if it is broken."""

    def require(condition):
        if not condition:
            raise ValueError

    def number(word):
        require(NUMBER.fullmatch(word) and abs(float(word)) <= 1e6)
        return float(word)

    lines = [words for line in re.split("\r\n|\r|\n", text) if (words := line.split())]
    lines.reverse()
    names, parents, offsets, orders = [], [], [], []

    def take(n, *begin):
        require(lines and len(lines[-1]) == n and lines[-1][: len(begin)] == list(begin))
        return lines.pop()[len(begin) :]

    def node(parent, name, kind):
        j = len(names)
        names.append(name)
        parents.append(parent)
        take(1, "{")
        offsets.append([number(word) for word in take(4, "OFFSET")])
        orders.append(None)
        if kind != "End":
            n = 6 if kind == "ROOT" else 3
            channels = take(n + 2, "CHANNELS", str(n))
            orders[-1] = "".join(channel[0] for channel in channels[-3:])
            expected = [f"{axis}position" for axis in "XYZ"][: n - 3] + [f"{axis}rotation" for axis in orders[-1]]
            require(channels == expected and orders[-1] in ORDERS)
            while lines and lines[-1] != ["}"]:
                if lines[-1] == ["End", "Site"]:
                    lines.pop()
                    node(j, f"{name}End", "End")
                else:
                    node(j, *take(2, "JOINT"), "JOINT")
        take(1, "}")

    take(1, "HIERARCHY")
    node(-1, *take(2, "ROOT"), "ROOT")
    require(len(set(names)) == len(names))
    take(1, "MOTION")
    (count,), (time,) = take(2, "Frames:"), take(3, "Frame", "Time:")
    require(re.fullmatch(r"\d+", count, re.ASCII) and NUMBER.fullmatch(time))
    require(float(time) > 0 and 0 < 1 / float(time) < np.inf)
    n_channels = 3 + 3 * sum(order is not None for order in orders)
    require(lines and str(len(lines)) == count.lstrip("0") and {len(words) for words in lines} == {n_channels})
    rows = np.array([[number(word) for word in words] for words in reversed(lines)])
    return names, parents, offsets, orders, rows, 1 / float(time)


def agrees(motion, said):
    """Say whether what was read is what the file says."""
    names, parents, offsets, orders, rows, fps = said
    rotations, column = np.tile(np.eye(3), (len(rows), len(names), 1, 1)), 3
    for j, order in enumerate(orders):
        if order is not None:
            rotations[:, j] = Rotation.from_euler(order, rows[:, column : column + 3] % 360, degrees=True).as_matrix()
            column += 3
    return (
        motion.skeleton.names == tuple(names)
        and motion.skeleton.parents == tuple(parents)
        and np.array_equal(motion.skeleton.offsets, offsets)
        and np.array_equal(motion.root, rows[:, :3])
        and np.allclose(motion.rotations, rotations, rtol=0, atol=1e-9)
        and np.isclose(motion.fps, fps, rtol=1e-4)
    )


@pytest.fixture
def read(tmp_path):
    """Return a function that reads text, or bytes, as a file."""

    def function(text):
        path = tmp_path / "motion.bvh"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return bvh.read(path)

    return function


ARM = """HIERARCHY
ROOT shoulder
{
  OFFSET 7 7 7
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT elbow
  {
    OFFSET 3 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 2 0 0
    }
  }
}
MOTION
Frames:\t2
Frame Time: 0.04
1 2 3 0 0 0 0 0 0
1 2 3 90 0 0 90 90 0
"""


class TestReading:
    def test_an_arm_by_hand(self, read):
        arm = read(ARM)
        assert arm.skeleton.names == ("shoulder", "elbow", "elbowEnd")
        assert arm.fps == 25
        # Straight along x; then the upper arm along y, and the forearm, turned by 90 degrees once more, back along x.
        # Turning about the forearm's own axis, which comes after, moves nothing.
        expected = [[[1, 2, 3], [4, 2, 3], [6, 2, 3]], [[1, 2, 3], [1, 5, 3], [-1, 5, 3]]]
        assert np.allclose(arm.positions(), expected, rtol=0, atol=1e-12)

    def test_the_order_of_rotations_counts(self, read):
        # About z, then about the turned x: x goes to y, which stays. The other way round it goes on to z.
        bent = ARM.replace("90 0 0 90 90 0", "0 0 0 90 90 0")
        turned = read(bent)
        assert np.allclose(turned.positions()[1, 2], [4, 4, 3], rtol=0, atol=1e-12)
        turned = read(bent.replace("Zrotation Xrotation", "Xrotation Zrotation"))
        assert np.allclose(turned.positions()[1, 2], [4, 2, 5], rtol=0, atol=1e-12)

    @pytest.mark.parametrize("seed", range(40))
    def test_generated_files(self, read, tmp_path, seed):
        text, said = generated(seed, n_joints=1 + seed % 12, n_frames=1 + seed % 5)
        motion = read(text)
        assert agrees(motion, said)
        assert motion.fps == 120
        oracle = pybvh.read_bvh_file(tmp_path / "motion.bvh", world_up="+y").node_positions()
        assert np.allclose(motion.positions(), oracle, rtol=0, atol=1e-9)

    def test_the_oracle_reads_what_was_generated(self):
        for seed in range(40):
            names, parents, offsets, orders, rows, _ = generated(seed)[1]
            again = parse(generated(seed)[0])
            assert again[:2] == (names, parents)
            assert np.array_equal(again[2], offsets)
            assert again[3] == orders
            assert np.array_equal(again[4], rows)

    @pytest.mark.parametrize("end", ["\r\n", "\r", " \n", "\n\n", "\n\t\n"])
    def test_ends_of_lines(self, read, end):
        text, said = generated(1)
        assert agrees(read(text.replace("\n", end)), said)

    @pytest.mark.parametrize(
        ("time", "fps"), [("0.0333333", 30), ("0.008333", 120), ("0.0417083", 1 / 0.0417083), ("1", 1), ("2.5", 0.4)]
    )
    def test_frame_times(self, read, time, fps):
        assert read(ARM.replace("0.04", time)).fps == pytest.approx(fps, rel=1e-12)

    def test_the_limit_on_numbers(self, read):
        arm = read(ARM.replace("1 2 3 90", "-1e6 2 3 1e6").replace("OFFSET 2", "OFFSET -1e6"))
        assert arm.root[1, 0] == arm.skeleton.offsets[2, 0] == -1e6
        turned = Rotation.from_euler("Z", 1e6 % 360, degrees=True).as_matrix()
        assert np.allclose(arm.rotations[1, 0], turned, rtol=0, atol=1e-9)

    def test_the_limit_on_joints(self, read):
        assert len(read(chain(bvh.MAX_JOINTS - 1)).skeleton.names) == bvh.MAX_JOINTS
        with pytest.raises(ValueError, match="line 4002: more than 1000 joints and end sites"):
            read(chain(bvh.MAX_JOINTS))


def chain(n):
    """Write a chain of n joints."""
    channels = "Zrotation Yrotation Xrotation"
    root = f"HIERARCHY\nROOT j0\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition {channels}\n"
    joints = "".join(f"JOINT j{j}\n{{\nOFFSET 0 1 0\nCHANNELS 3 {channels}\n" for j in range(1, n))
    end = "End Site\n{\nOFFSET 0 1 0\n}\n" + "}\n" * n
    return f"{root}{joints}{end}MOTION\nFrames: 1\nFrame Time: 0.01\n{'0 ' * (3 + 3 * n)}\n"


class TestBrokenFiles:
    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            (ARM, "", "ends with line 0: expected HIERARCHY"),
            ("HIERARCHY\n", "", "line 1: expected HIERARCHY, got 'ROOT shoulder'"),
            ("ROOT shoulder", "ROOT left shoulder", "line 2: expected ROOT NAME, got 'ROOT left shoulder'"),
            ("JOINT elbow", "JOINT shoulder", "line 6: the name 'shoulder' is there twice"),
            ("JOINT elbow", "JOIMT elbow", "line 6: expected JOINT NAME or End Site or }, got 'JOIMT elbow'"),
            ("    OFFSET 3 0 0\n", "", "line 8: expected OFFSET and 3 numbers, got 'CHANNELS 3 Zrotation"),
            ("3 0 0", "3 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 0'"),
            ("3 0 0", "3 0 0 0", "line 8: expected OFFSET and 3 numbers, got"),
            ("3 0 0", "3 nan 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 nan 0'"),
            ("3 0 0", "3 1_0 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 1_0 0'"),
            ("3 0 0", "3 1e999 0", "line 8: '1e999' is not within +-1e+06"),
            ("CHANNELS 3", "CHANNELS 4", "line 9: expected CHANNELS 3 and 3 rotations about different axes, got"),
            ("Zrotation Xrotation", "Xrotation Xrotation", "line 9: expected CHANNELS 3 and 3 rotations about diff"),
            ("Zrotation Xrotation", "Wrotation Xrotation", "line 9: expected CHANNELS 3 and 3 rotations about diff"),
            ("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition", "line 9: expected CHANNELS 3 and 3 rotations"),
            ("Xposition Y", "Yposition Y", "line 5: expected CHANNELS 6 Xposition Yposition Zposition and 3 rot"),
            ("    }\n", "", "line 15: expected JOINT NAME or End Site or }, got 'MOTION'"),
            ("    }\n", "    }\n}\n}\n", "line 16: expected MOTION, got '}'"),
            ("MOTION\n", "", "line 16: expected MOTION, got 'Frames: 2'"),
            ("\t2", "\t-2", "line 17: expected Frames: NUMBER, got 'Frames: -2'"),
            ("\t2", "\t0", "2 frames, where it says 0"),
            ("\t2", "\t3", "2 frames, where it says 3"),
            ("\t2", "\t1", "2 frames, where it says 1"),
            ("0.04", "0", "line 18: a frame time of 0 s"),
            ("0.04", "-0.04", "line 18: a frame time of -0.04 s"),
            ("0.04", "nan", "line 18: expected Frame Time: SECONDS, got 'Frame Time: nan'"),
            ("0.04", "1e999", "line 18: a frame time of 1e999 s"),
            ("0.04", "1e-320", "line 18: a frame time of 1e-320 s"),
            ("1 2 3 0", "1 2 3", "line 19: 8 values for 9 channels"),
            ("1 2 3 9", "1 2 3 0 9", "line 20: 10 values for 9 channels"),
            ("1 2 3 9", "1 2 nan 9", "line 20: 'nan' is not within +-1e+06"),
            ("1 2 3 9", "1 2 -inf 9", "line 20: '-inf' is not within +-1e+06"),
            ("1 2 3 9", "1 2 1e999 9", "line 20: '1e999' is not within +-1e+06"),
            ("1 2 3 90", "1 2 3 1.000001e6", "line 20: '1.000001e6' is not within +-1e+06"),
            ("1 2 3 9", "1 2 x 9", "line 20: 'x' is not a number"),
            ("1 2 3 0 0 0 0 0 0", "1 2 3 0 0 0 0 0 0 # 1", "line 19: '#' is not a number"),
            ("1 2 3 0 0 0 0 0 0", "# 1\n1 2 3 0 0 0 0 0 0", "line 19: '#' is not a number"),
            (ARM, ARM[: ARM.index("elbow")], "line 6: expected JOINT NAME or End Site or }, got 'JOINT'"),
            (ARM, ARM[: ARM.index("    OFFSET")], "ends with line 7: expected OFFSET and 3 numbers"),
            (ARM, ARM[: ARM.index("1 2 3")], "0 frames, where it says 2"),
        ],
    )
    def test_message(self, read, tmp_path, old, new, message):
        assert old in ARM
        with pytest.raises(ValueError, match="^" + re.escape(f"{tmp_path / 'motion.bvh'}: {message}")):
            read(ARM.replace(old, new, 1))

    def test_end_sites_have_names_of_their_own(self, read):
        with pytest.raises(ValueError, match=r"motion.bvh: names: 'elbowEnd' is there twice"):
            read(ARM.replace("shoulder", "elbowEnd"))

    def test_no_text(self, read):
        with pytest.raises(ValueError, match=r"motion.bvh: 'utf-8' codec can't decode byte"):
            read(ARM.encode() + b"\xff\xfe")
        with pytest.raises(ValueError, match=r"motion.bvh: line 1: expected HIERARCHY"):
            read(bytes(1000))

    def test_other_names(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            bvh.read(tmp_path / "nothing.bvh")
        (tmp_path / "arm.txt").write_text(ARM)
        with pytest.raises(ValueError, match=r"arm.txt: .*not a bvh file"):
            bvh.read(tmp_path / "arm.txt")

    def test_without_the_library(self, read, monkeypatch):
        monkeypatch.setitem(sys.modules, "pybvh", None)
        with pytest.raises(ImportError, match=r"needs pybvh: pip install 'npss\[manifold\]'"):
            read(ARM)

    def test_memory_does_not_follow_what_the_file_claims(self, read):
        tracemalloc.start()
        with pytest.raises(ValueError, match=f"2 frames, where it says {10**15}"):
            read(ARM.replace("\t2", f"\t{10**15}"))
        assert tracemalloc.get_traced_memory()[1] < 2**24
        tracemalloc.stop()

    @pytest.mark.parametrize("where", ["HIERARCHY", "JOINT", "Frame Time", "1 2 3"])
    @pytest.mark.parametrize("what", ["x", "{", "JOINT ", "1 ", "\x00", "# "])
    def test_long_lines(self, read, what, where):
        with pytest.raises(ValueError, match=r"motion.bvh: "):
            read(ARM.replace(where, f"{what * 100_000}{where}", 1))


NASTY = (
    *("", "nan", "inf", "-", "+", ".", "1e999", "-1e-999", "0x10", "1_0", "1d2", "1,5", "１", "²", "١", "#", '"', "\\"),
    *("{", "}", "\x00", "\ufeff", "\x1c", "\x0b", "\x85", "\xa0", "\u2028", "\r", "\n", "\t", " ", "\n\n", "0", "-0"),
    *("End Site", "JOINT a", "OFFSET", "CHANNELS 3", "MOTION", "Frames: 4", "Frame Time:", "Xrotation", "Zposition"),
)


BLANKS = ("  ", "\t", "\xa0", "\x0b", "\x1c", "\u3000", " \r\n ", "")


def mutate(text, rng):
    """Break a text at one or two places, or merely change it."""
    for _ in range(rng.integers(1, 3)):
        lines = text.split("\n")
        a, b = rng.integers(len(lines), size=2)
        i, j = sorted(rng.integers(len(text) + 1, size=2))
        nasty, blank = NASTY[rng.integers(len(NASTY))], BLANKS[rng.integers(len(BLANKS))]
        match rng.integers(12):
            case 0:
                text = text[:i] + chr(rng.integers(32, 127)) + text[i + 1 :]
            case 1:
                text = text[:i] + nasty + text[i:]
            case 2:
                text = text[:i] + text[i + rng.integers(1, 4) :]
            case 3:
                text = text[:i]
            case 4:
                text = "\n".join(lines[:a] + lines[a + 1 :])
            case 5:
                text = "\n".join(lines[:a] + [lines[b]] + lines[a:])
            case 6:
                lines[a], lines[b] = lines[b], lines[a]
                text = "\n".join(lines)
            case 7:
                words = lines[a].split(" ")
                words[rng.integers(len(words))] = nasty
                text = "\n".join([*lines[:a], " ".join(words), *lines[a + 1 :]])
            case 8:
                text = text[:i] + text[i : i + 50] + text[i:]
            case 9:
                text = text[:i] + text[i:j].replace(" ", blank) + text[j:]
            case 10:
                text = text[:i] + text[i:j].replace("\n", f"\n{blank}") + text[j:]
            case 11:
                text = text[:i] + re.sub(r"(?<=\.)\d", str(a % 10), text[i:j]) + text[j:]
        if not text:
            break
    return text


@pytest.mark.parametrize("seed", range(8))
def test_mutations_are_refused_or_read_as_what_they_say(read, seed):
    rng = np.random.default_rng(seed)
    whole = 0
    for _ in range(250):
        text = mutate(generated(rng.integers(1000))[0], rng)
        try:
            said = parse(text)
        except ValueError:
            with pytest.raises(ValueError, match=r"motion.bvh: "):
                read(text)
        else:
            assert agrees(read(text), said), text
            whole += 1
    assert 40 < whole < 210  # both are put to the test


@given(st.binary(max_size=300))
@example(b"HIERARCHY")
def test_noise(tmp_path_factory, noise):
    path = tmp_path_factory.mktemp("noise") / "noise.bvh"
    path.write_bytes(noise)
    with pytest.raises(ValueError, match=r"noise.bvh: "):
        bvh.read(path)
