"""BVH files: generated and real ones against oracles, thousands of broken ones, slow forward kinematics."""

import math
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bvh_files import CHANNELS, generated
from npss_baselines.data import bvh

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)


def statements(lines):
    """Split lines, last first, into words; a name and a brace are words."""
    for line in lines:
        words = " ".join(line.split())
        keyword, name, rest = words.partition(" ")[0].upper(), "", words
        if keyword in ("ROOT", "JOINT") and " " in words:
            name, brace, rest = words.partition("{")
            rest = brace + rest
        for sign in ("#", "//"):
            rest = rest.partition(sign)[0]
        for part in (name + rest).replace("{", "\n{\n").replace("}", "\n}\n").split("\n"):
            if part := part.strip():
                first, *others = part.split(" ")
                yield [first.upper(), " ".join(others)] if first.upper() in ("ROOT", "JOINT") else [first, *others]


def parse(text):
    """Read the text of a BVH file strictly, by recursive descent; raise ValueError if it is broken."""

    def require(condition):
        if not condition:
            raise ValueError

    def number(word):
        require(NUMBER.fullmatch(word) and abs(float(word)) <= 1e6)
        return float(word)

    lines = re.split("\r\n|\r|\n", text.removeprefix("\ufeff"))
    top = next((i for i, line in enumerate(lines, 1) if re.match(r"\s*Frame\s+Time", line, re.I)), len(lines))
    left = list(statements(lines[:top]))[::-1]
    names, parents, offsets, channels = [], [], [], []

    def take(*begin, n=0):
        require(left)
        words = left.pop()
        require([word.lower() for word in words[: len(begin)]] == list(begin))
        require(n is None or len(words) == len(begin) + n)
        return words[len(begin) :]

    def node(parent, name):
        j = len(names)
        names.append(name)
        parents.append(parent)
        take("{")
        offsets.append([number(word) for word in take("offset", n=3)])
        channels.append(None)
        if name is not None:
            count, *words = take("channels", n=None)
            channels[j] = [channel.capitalize() for channel in words]
            require(re.fullmatch(r"\d{1,3}", count, re.ASCII) and int(count) == len(words))
            require(set(channels[j]) <= set(CHANNELS) and len(set(channels[j])) == len(words))
            while left and left[-1] != ["}"]:
                if [word.lower() for word in left[-1][:2]] == ["end", "site"]:
                    left.pop()
                    node(j, None)
                else:
                    node(j, *take("joint", n=1))
        take("}")

    take("hierarchy")
    require(left)
    node(-1, *take("root", n=1))
    of_joints = [name for name in names if name is not None]
    require("" not in of_joints and len(set(of_joints)) == len(of_joints))
    for j, name in enumerate(names):
        if name is None:
            like = (f"{names[parents[j]]}End{copy}" for copy in ["", *range(2, 1000)])
            names[j] = next(other for other in like if other not in names)
    take("motion")
    count = re.fullmatch(r"frames ?: ?(\d{1,18})", " ".join(take(n=None)), re.ASCII | re.I)
    time = re.fullmatch(r"frame time ?: ?(\S+)", " ".join(take(n=None)), re.ASCII | re.I)
    require(count and time and not left and 1e-6 <= number(time[1]) <= 1e6)
    rows = [words for line in lines[top:] if (words := line.split("#")[0].split("//")[0].split())]
    require(rows and abs(len(rows) - int(count[1])) <= 1)
    require({len(words) for words in rows} == {sum(len(of or ()) for of in channels)})
    values = np.array([[number(word) for word in row] for row in rows])
    return names, parents, offsets, channels, values, 1 / number(time[1])


def slow_positions(expected):
    """Compute joint positions from the definition: products of 4 x 4 matrices, joint by joint and frame by frame."""
    names, parents, offsets, channels, rows, _ = expected

    def turn(axis, degrees):
        a, b = [(1, 2), (2, 0), (0, 1)]["XYZ".index(axis)]
        matrix = np.eye(4)
        matrix[a, a] = matrix[b, b] = math.cos(math.radians(degrees))
        matrix[b, a] = math.sin(math.radians(degrees))
        matrix[a, b] = -matrix[b, a]
        return matrix

    positions = np.empty((len(rows), len(names), 3))
    for t, row in enumerate(rows):
        values, world = iter(row), []
        for j, parent in enumerate(parents):
            place, turned = np.eye(4), np.eye(4)
            place[:3, 3] = offsets[j]
            for channel in channels[j] or ():
                if channel[1:] == "position":
                    place["XYZ".index(channel[0]), 3] = next(values)
                else:
                    turned = turned @ turn(channel[0], next(values))
            world.append((np.eye(4) if parent < 0 else world[parent]) @ place @ turned)
            positions[t, j] = world[j][:3, 3]
    return positions


def agrees(motion, expected):
    """Return whether the motion read agrees with the content of the file."""
    names, parents, offsets, channels, rows, fps = expected
    rotations = np.tile(np.eye(3), (len(rows), len(names), 1, 1))
    translations, column = np.tile(np.array(offsets), (len(rows), 1, 1)), 0
    for j, of in enumerate(channels):
        for channel in of or ():
            if channel[1:] == "position":
                translations[:, j, "XYZ".index(channel[0])] = rows[:, column]
            else:
                rotations[:, j] @= Rotation.from_euler(channel[0], rows[:, [column]] % 360, degrees=True).as_matrix()
            column += 1
    return (
        motion.skeleton.names == tuple(names)
        and motion.skeleton.parents == tuple(parents)
        and np.array_equal(motion.skeleton.offsets, offsets)
        and motion.channels == tuple(None if of is None else tuple(of) for of in channels)
        and np.array_equal(motion.translations, translations)
        and np.array_equal(motion.root, translations[:, 0])
        and np.allclose(motion.rotations, rotations, rtol=0, atol=1e-9)
        and np.isclose(motion.fps, fps, rtol=1e-4, atol=0)
    )


@pytest.fixture
def read(tmp_path):
    """Return a function that reads text, or bytes, as a file."""

    def function(text):
        path = tmp_path / "motion.bvh"
        path.unlink(missing_ok=True)  # creating a file is many times faster than overwriting one
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
        # The rotation about the forearm's axis, which comes after, moves nothing.
        expected = [[[1, 2, 3], [4, 2, 3], [6, 2, 3]], [[1, 2, 3], [1, 5, 3], [-1, 5, 3]]]
        assert np.allclose(arm.positions(), expected, rtol=0, atol=1e-12)

    def test_global_rotations_by_hand(self, read):
        arm = read(ARM)
        positions, rotations = arm.forward()
        assert np.array_equal(positions, arm.positions())
        assert np.array_equal(rotations, arm.global_rotations())
        assert np.array_equal(rotations[0], [np.eye(3)] * 3)
        # Along the forearm, the x axis of the elbow and of its end: back along x, as the positions say.
        assert np.allclose(rotations[1, :, :, 0], [[0, 1, 0], [-1, 0, 0], [-1, 0, 0]], rtol=0, atol=1e-12)

    def test_the_order_of_rotations_matters(self, read):
        # About z, then about the turned x: x goes to y, which stays. The other way round it goes on to z.
        bent = ARM.replace("90 0 0 90 90 0", "0 0 0 90 90 0")
        turned = read(bent)
        assert np.allclose(turned.positions()[1, 2], [4, 4, 3], rtol=0, atol=1e-12)
        turned = read(bent.replace("Zrotation Xrotation", "Xrotation Zrotation"))
        assert np.allclose(turned.positions()[1, 2], [4, 2, 5], rtol=0, atol=1e-12)

    @pytest.mark.parametrize("plain", [True, False])
    @pytest.mark.parametrize("seed", range(40))
    def test_generated_files(self, read, seed, plain):
        text, expected = generated(seed, n_joints=1 + seed % 12, n_frames=1 + seed % 5, plain=plain)
        motion = read(text)
        assert agrees(motion, expected)
        assert motion.fps == 120
        assert np.allclose(motion.positions(), slow_positions(expected), rtol=0, atol=1e-9)

    @pytest.mark.parametrize("plain", [True, False])
    def test_the_oracle_reads_what_was_generated(self, plain):
        for seed in range(40):
            text, (names, parents, offsets, channels, rows, _) = generated(seed, plain=plain)
            again = parse(text)
            assert again[:2] == (names, parents)
            assert np.array_equal(again[2], offsets)
            assert again[3] == channels
            assert np.array_equal(again[4], rows)

    @pytest.mark.parametrize("end", ["\r\n", "\r", " \n", "\n\n", "\n\t\n"])
    def test_line_endings(self, read, end):
        text, expected = generated(1)
        assert agrees(read(text.replace("\n", end)), expected)

    @pytest.mark.parametrize(
        ("time", "fps"), [("0.0333333", 30), ("0.008333", 120), ("0.0417083", 1 / 0.0417083), ("1", 1), ("2.5", 0.4)]
    )
    def test_frame_times(self, read, time, fps):
        assert read(ARM.replace("0.04", time)).fps == pytest.approx(fps, rel=1e-12)

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("End Site", "End site"),
            ("End Site", "END SITE"),
            ("End Site", "End Site #1"),
            ("End Site", "End Site elbow_end"),
            ("\n    {\n      OFFSET 2", " {\n      OFFSET 2"),
            ("ROOT shoulder\n{", "ROOT shoulder {"),
            ("ROOT shoulder\n{\n ", "ROOT shoulder{"),
            ("      OFFSET 2 0 0\n    }\n  }\n}\n", "OFFSET 2 0 0 }}} "),
            ("Frames:\t2", "Frames:2"),
            ("Frames:\t2", "frames : 2"),
            ("Frame Time: 0.04", "Frame Time:.04"),
            ("Frame Time: 0.04", "Frame time: 4e-2 # 25 Hz"),
            ("HIERARCHY", "# by hand\nHierarchy // {"),
            ("JOINT elbow\n", "joint elbow\n# the {other} one\n"),
            ("OFFSET 3 0 0", "Offset 3. +0 -.0e5 # {cm}"),
            ("Zrotation Xrotation", "zrotation XROTATION"),
            ("1 2 3 0", "# the first\n1 2 3 0"),
            ("90 90 0\n", "90 90 0 // the last\n\n\n"),
        ],
    )
    def test_other_notations(self, read, old, new):
        assert old in ARM
        assert agrees(read(ARM.replace(old, new, 1)), parse(ARM))

    @pytest.mark.parametrize("name", ["left shoulder", "Hips #0", "mixamorig:Hips", "a//b", "Bip01 L UpperArm", "肩"])
    def test_names(self, read, name):
        assert read(ARM.replace("shoulder", name)).skeleton.names == (name, "elbow", "elbowEnd")
        arm = read(ARM.replace("elbow", name).replace(f"{name}\n  {{", f"{name} {{"))
        assert arm.skeleton.names == ("shoulder", name, f"{name}End")

    def test_positions_of_joints_replace_their_offsets(self, read):
        """As in files of motion capture studios: 1 90 2 with an offset of 0 90 0 is 90 up, not 180."""
        six = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
        rows = ["1 2 3 0 0 0 4 5 6 0 0 0", "1 2 3 90 0 0 5 0 0 90 0 0", ""]
        text = ARM.replace("CHANNELS 3 Zrotation Xrotation Yrotation", six)
        arm = read(text[: text.index("1 2 3")] + "\n".join(rows))
        expected = [[[1, 2, 3], [5, 7, 9], [7, 7, 9]], [[1, 2, 3], [1, 7, 3], [-1, 7, 3]]]
        assert np.allclose(arm.positions(), expected, rtol=0, atol=1e-12)

    def test_missing_values(self, tmp_path):
        """Of rotations, the whole is missing; of translations, one coordinate."""
        path = tmp_path / "arm.bvh"
        path.write_text(ARM.replace("1 2 3 90 0 0 90 90 0", "nan 2 3 90 0 0 90 NaN 0"), encoding="utf-8")
        arm = bvh.read(path, missing=True)
        assert np.argwhere(np.isnan(arm.translations)).tolist() == [[1, 0, 0]]
        assert np.isnan(arm.rotations[1, 1]).all()
        assert np.isnan(arm.rotations).sum() == 9
        assert arm.translations[1, 0, 1:].tolist() == [2, 3]
        with pytest.raises(ValueError, match=r"line 20: 'nan' is not a number$"):
            bvh.read(path)
        path.write_text(ARM.replace("1 2 3 90 0 0 90 90 0", "nan 2 inf 90 0 0 90 90 0"), encoding="utf-8")
        with pytest.raises(ValueError, match=r"line 20: 'inf' is not a number$"):
            bvh.read(path, missing=True)

    def test_positions_after_rotations_and_in_any_order(self, read):
        old = "Xposition Yposition Zposition Zrotation Yrotation Xrotation"
        for new, row in (
            ("Zrotation Yrotation Xrotation Zposition Xposition Yposition", "90 0 0 3 1 2"),
            ("Yposition Zrotation Zposition Yrotation Xposition Xrotation", "2 90 3 0 1 0"),
        ):
            arm = read(ARM.replace(old, new).replace("1 2 3 90 0 0", row))
            assert np.allclose(arm.positions()[1], read(ARM).positions()[1], rtol=0, atol=1e-12)
            assert arm.channels[0] == tuple(new.split())

    def test_a_joint_without_channels_and_one_with_some(self, read):
        text = ARM.replace("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 0")
        arm = read(text.replace("90 0 0 90 90 0", "90 0 0").replace("3 0 0 0 0 0 0", "3 0 0 0"))
        assert arm.channels[1:] == ((), None)
        assert np.allclose(arm.positions()[1], [[1, 2, 3], [1, 5, 3], [1, 7, 3]], rtol=0, atol=1e-12)
        # A knee that only bends, and grows along x: its other two coordinates are those of the offset.
        text = ARM.replace("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 2 Zrotation Xposition")
        knee = read(text.replace("90 0 0 90 90 0", "90 0 0 90 8").replace("3 0 0 0 0 0 0", "3 0 0 0 0 3"))
        assert np.allclose(knee.positions()[1], [[1, 2, 3], [1, 10, 3], [-1, 10, 3]], rtol=0, atol=1e-12)

    def test_a_root_without_positions_is_at_its_offset(self, read):
        text = ARM.replace("CHANNELS 6 Xposition Yposition Zposition", "CHANNELS 3").replace("1 2 3 ", "")
        assert np.array_equal(read(text).root, [[7, 7, 7], [7, 7, 7]])

    def test_end_sites_have_unique_names(self, read):
        """Several end sites of a joint have different names, and none has the name of a joint."""
        end = "    End Site\n    {\n      OFFSET 2 0 0\n    }\n"
        assert read(ARM.replace(end, end * 3)).skeleton.names[2:] == ("elbowEnd", "elbowEnd2", "elbowEnd3")
        assert read(ARM.replace("shoulder", "elbowEnd")).skeleton.names == ("elbowEnd", "elbow", "elbowEnd2")

    @pytest.mark.parametrize("says", [1, 3])
    def test_one_frame_more_or_fewer(self, read, says):
        with pytest.warns(UserWarning, match=rf"motion.bvh: 2 frames, but the header says {says}$") as caught:
            arm = read(ARM.replace("\t2", f"\t{says}"))
        assert agrees(arm, parse(ARM))
        assert [Path(warning.filename).name for warning in caught] == ["test_bvh.py"]

    def test_byte_order_mark(self, read):
        assert agrees(read("\ufeff" + ARM), parse(ARM))

    def test_any_name_of_a_file(self, tmp_path):
        (tmp_path / "ARM.BVH").write_text(ARM, encoding="utf-8")
        assert agrees(bvh.read(tmp_path / "ARM.BVH"), parse(ARM))

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
            (ARM, "", "the file ends at line 0, expected HIERARCHY"),
            ("HIERARCHY\n", "", "line 1: expected HIERARCHY, got 'ROOT shoulder'"),
            ("ROOT shoulder", "ROOT", "line 2: expected ROOT NAME, got 'ROOT'"),
            ("JOINT elbow", "ROOT elbow", "line 6: expected JOINT NAME or End Site or }, got 'ROOT elbow'"),
            ("elbow", "e" * 201, "line 6: expected JOINT NAME or End Site or }, got 'JOINT eeee"),
            ("MOTION", "ROOT prop", "line 16: expected MOTION, got 'ROOT prop'"),
            ("JOINT elbow", "JOINT shoulder", "line 6: duplicate name 'shoulder'"),
            ("JOINT elbow", "JOIMT elbow", "line 6: expected JOINT NAME or End Site or }, got 'JOIMT elbow'"),
            ("    OFFSET 3 0 0\n", "", "line 8: expected OFFSET and 3 numbers, got 'CHANNELS 3 Zrotation"),
            ("3 0 0", "3 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 0'"),
            ("3 0 0", "3 0 0 0", "line 8: expected OFFSET and 3 numbers, got"),
            ("3 0 0", "3 nan 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 nan 0'"),
            ("3 0 0", "3 1_0 0", "line 8: expected OFFSET and 3 numbers, got 'OFFSET 3 1_0 0'"),
            ("3 0 0", "3 1e999 0", "line 8: '1e999' is not within +-1e+06"),
            ("CHANNELS 3", "CHANNELS 4", "line 9, joint 'elbow': expected 4 channels, got 3"),
            ("Zrotation Xrotation", "Xrotation Xrotation", "line 9, joint 'elbow': duplicate channel Xrotation"),
            ("Zrotation Xrotation", "Wrotation Xrotation", "line 9, joint 'elbow': unknown channel 'Wrotation'"),
            ("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition", "line 19: 9 values for 12 channels"),
            ("Xposition Y", "Yposition Y", "line 5, joint 'shoulder': duplicate channel Yposition"),
            ("CHANNELS 3", "CHANNELS three", "line 9: expected CHANNELS, their number and names, got"),
            ("    }\n", "", "line 15: expected JOINT NAME or End Site or }, got 'MOTION'"),
            ("    }\n", "    }\n}\n}\n", "line 16: expected MOTION, got '}'"),
            ("MOTION\n", "", "line 16: expected MOTION, got 'Frames: 2'"),
            ("\t2", "\t-2", "line 17: expected Frames: NUMBER, got 'Frames: -2'"),
            ("\t2", "\t0", "2 frames, but the header says 0"),
            ("\t2", "\t4", "2 frames, but the header says 4"),
            (ARM[ARM.index("1 2 3") :], "", "0 frames, but the header says 2"),
            (ARM[ARM.index("\t2") :], "1\nFrame Time: 1\n", "0 frames, but the header says 1"),
            ("0.04", "0", "line 18: implausible frame time, 0 s"),
            ("0.04", "-0.04", "line 18: implausible frame time, -0.04 s"),
            ("0.04", "nan", "line 18: expected Frame Time: SECONDS, got 'Frame Time: nan'"),
            ("0.04", "1e999", "line 18: implausible frame time, 1e999 s"),
            ("0.04", "1e-320", "line 18: implausible frame time, 1e-320 s"),
            ("1 2 3 0", "1 2 3", "line 19: 8 values for 9 channels"),
            ("1 2 3 9", "1 2 3 0 9", "line 20: 10 values for 9 channels"),
            ("1 2 3 9", "1 2 nan 9", "line 20: 'nan' is not a number"),
            ("1 2 3 9", "1 2 -inf 9", "line 20: '-inf' is not a number"),
            ("1 2 3 9", "1 2 1e999 9", "line 20: '1e999' is not within +-1e+06"),
            ("1 2 3 90", "1 2 3 1.000001e6", "line 20: '1.000001e6' is not within +-1e+06"),
            ("1 2 3 9", "1 2 x 9", "line 20: 'x' is not a number"),
            ("1 2 3 9", "1 2 1_0 9", "line 20: '1_0' is not a number"),
            ("1 2 3 9", "1 2 ３ 9", "line 20: '３' is not a number"),
            ("1 2 3 9", "1 2 3,5 9", "line 20: '3,5' is not a number"),
            ("1 2 3 9", "1 2 -1.#IND 9", "line 20: 3 values for 9 channels"),
            ("1 2 3 0 0 0 0 0 0", "1 2 3 0 0 #0 0 0 0", "line 19: 5 values for 9 channels"),
            ("1 2 3 9", "# {\n1 2 x 9", "line 21: 'x' is not a number"),
            ("0.04", "0.04 }", "line 18: expected nothing after the frame time, got '}'"),
            ("\t2", f"\t{'9' * 5000}", "line 17: expected Frames: NUMBER, got"),
            (ARM, ARM[: ARM.index("elbow")], "line 6: expected JOINT NAME or End Site or }, got 'JOINT'"),
            (ARM, ARM[: ARM.index("    OFFSET")], "the file ends at line 7, expected OFFSET and 3 numbers"),
            (ARM, ARM[: ARM.index("1 2 3")], "0 frames, but the header says 2"),
        ],
    )
    def test_message(self, read, tmp_path, old, new, message):
        assert old in ARM
        with pytest.raises(ValueError, match="^" + re.escape(f"{tmp_path / 'motion.bvh'}: {message}")):
            read(ARM.replace(old, new, 1))

    def test_not_text(self, read):
        with pytest.raises(ValueError, match=r"motion.bvh: line 21 is not UTF-8 text$"):
            read(ARM.encode() + b"\xff\xfe")
        with pytest.raises(ValueError, match=r"motion.bvh: the text is UTF-16; save it as UTF-8$"):
            read(ARM.encode("utf-16"))
        with pytest.raises(ValueError, match=r"motion.bvh: line 1: expected HIERARCHY"):
            read(bytes(1000))

    def test_missing_file(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            bvh.read(tmp_path / "nothing.bvh")

    def test_no_channels(self, read):
        text = re.sub("CHANNELS.*", "CHANNELS 0", ARM)
        with pytest.raises(ValueError, match=r"motion.bvh: line 19: 9 values for 0 channels"):
            read(text)
        with pytest.raises(ValueError, match=r"motion.bvh: 0 frames, but the header says 2"):
            read(text[: text.index("1 2 3")] + "\n\n")

    def test_memory_does_not_depend_on_the_header(self, read):
        tracemalloc.start()
        with pytest.raises(ValueError, match=f"2 frames, but the header says {10**15}"):
            read(ARM.replace("\t2", f"\t{10**15}"))
        assert tracemalloc.get_traced_memory()[1] < 2**24
        tracemalloc.stop()

    @pytest.mark.parametrize("where", ["HIERARCHY", "JOINT", "Frame Time", "1 2 3"])
    @pytest.mark.parametrize("what", ["x", "{", "JOINT ", "1 ", "\x00", "1 # {"])
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
    """Mutate a text at one or two places, which may or may not break it."""
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


@pytest.mark.filterwarnings("ignore:.* frames, but the header says:UserWarning")
@pytest.mark.parametrize("seed", range(8))
def test_mutations_are_refused_or_read_correctly(read, seed):
    rng = np.random.default_rng(seed)
    whole = 0
    for _ in range(250):
        text = mutate(generated(rng.integers(1000), plain=rng.random() < 0.5)[0], rng)
        try:
            expected = parse(text)
        except ValueError:
            with pytest.raises(ValueError, match=r"motion.bvh: "):
                read(text)
        else:
            assert agrees(read(text), expected), text
            whole += 1
    assert 40 < whole < 210  # both cases occur


@given(st.binary(max_size=300))
@example(b"HIERARCHY")
def test_noise(tmp_path_factory, noise):
    path = tmp_path_factory.mktemp("noise") / "noise.bvh"
    path.write_bytes(noise)
    with pytest.raises(ValueError, match=r"noise.bvh: "):
        bvh.read(path)
