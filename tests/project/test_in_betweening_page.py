"""Run the snippets of docs/in-betweening.md, one after the other, and compare its table."""

import numpy as np
import pytest

import lafan1 as oracle
import npss
from npss.inbetweening import Local, forward, interpolation, table, train_statistics, transition, windows
from npss.rotations import euler_to_quaternion
from npss.skeleton import Skeleton
from pages import PROJECT, blocks

PAGE = PROJECT / "docs" / "in-betweening.md"
pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")


def test_snippets(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    skeleton = Skeleton(oracle.NAMES, oracle.PARENTS, oracle.OFFSETS)
    clips = [oracle.clip(seed, 66) for seed in range(4)]
    clips = [Local(euler_to_quaternion(np.radians(angles), seq="ZYX"), root) for angles, root in clips]
    np.savez("stats.npz", **train_statistics(clips, skeleton)._asdict())
    parts = transition(windows(clips), 30)
    gt, pred = forward(parts.truth, skeleton), forward(interpolation(parts), skeleton)
    names = {
        "gt_quaternions": gt.quaternions,
        "gt_positions": gt.positions,
        "quaternions": pred.quaternions,
        "positions": pred.positions,
        "names": skeleton.names,
        "parents": skeleton.parents,
        "offsets": skeleton.offsets,
        "local_quaternions": parts.truth.quaternions,
        "root": parts.truth.root,
        "train_clips": clips,
        "test_clips": clips,
        "npss": npss,
    }
    for snippet in blocks(PAGE, "python"):
        exec(snippet, names)
    out = capsys.readouterr().out
    assert out.startswith("protocol lafan1: not its ground truth\n")
    assert "zero-velocity" in out
    np.testing.assert_array_equal(names["predicted"].quaternions, gt.quaternions)
    assert len(names["rows"]) == 8


def test_published_rows():
    text = table(npss.published.records(protocol="lafan1"), markdown=True)
    assert text.split("\n\n")[0] in PAGE.read_text(encoding="utf-8")
