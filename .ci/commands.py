#!/usr/bin/env python3
"""Run every command of every page as a shell would: .ci/commands.py [PAGE ...], such as study.md.

Each page has a folder of its own, with files under the names that the page uses: real motion, from the folders that
NPSS_H36M, NPSS_CMU and NPSS_CMU_STYLES name, and real predictions. Trainings are cut short, by options that this
program adds and prints. The commands of docs/extending.md run in its tests, which have its plugins.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from npss import study

PROJECT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT / "tests" / "helpers"))
import lafan1  # noqa: E402
from pages import PAGES, commands  # noqa: E402

VARIABLES = {"H36M": "NPSS_H36M", "CMU": "NPSS_CMU", "STYLES": "NPSS_CMU_STYLES"}
#: What is changed in a command, without its comment: pages call several folders DIR, and full trainings take long.
CHANGES = [
    (r"^pip .* && ", ""),
    (r"--h36m DIR", "--h36m H36M"),
    (r"--bvh DIR", "--bvh BVH"),
    (r" --iterations \d+", ""),
    (r" --tf32", ""),  # needs a GPU
    (r"leaderboard mine.npz --protocol", "leaderboard samples.npz --protocol"),  # of recorded clips
    (r" all-1.npz all-2.npz", ""),  # trained as all-0.npz
    (r" discussion --apart", " --apart --subjects 1 6 8 11"),  # what is there in copies that lack files
    (r"( train vgru-d .*)", r"\1 --iterations 2 --recipe.batch 4"),
    (r"( (?:train (?:manifold|restorer)|manifold (?:table|measure)) (?!.*--quick).*)", r"\1 --quick"),
    (r"( reproduce (?!.*--(?:list|budget|only zero-velocity)).*)", r"\1 --budget minutes"),
]
#: What a page takes from another one.
BEFORE = {"repair.md": "npss-baselines train manifold --quick --out runs/manifold"}
FUNCTION = """
import npss

def {name}(gt, pred):
    return npss.score(gt, pred)
"""
CLASS = """
import numpy as np

class Class:
    def __init__(self):
        self.pairs = []

    def update(self, pred, gt):
        self.pairs.append((gt, pred))

    def compute(self):
        return npss.score(*map(np.concatenate, zip(*self.pairs)))
"""


def changed(command: str) -> str:
    """Return a command as it is run."""
    command = command.partition("  #")[0].rstrip()
    for old, new in CHANGES:
        command = re.sub(old, new, command)
    return command


def shell(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder, which is the user's home, too."""
    home = {"HOME": str(folder), "MPLBACKEND": "agg"}
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", command],
        cwd=folder,
        env=os.environ | home,
        capture_output=True,
        encoding="utf-8",
    )


def prepare(folder: Path) -> None:
    """Write the files that pages name."""
    for name, variable in VARIABLES.items():
        (folder / name).symlink_to(os.environ[variable])
    actions = "--actions walking eating --h36m H36M"
    for command in (
        f"npss-baselines train ridge {actions} --out ridge && npss-baselines predict ridge --h36m H36M --out model.h5",
        f"npss-baselines train nearest-10 {actions} --out near && npss-baselines predict near --h36m H36M --out a.h5",
        "npss-baselines predict ridge --h36m H36M --out samples.npz",
        f"npss-baselines evaluate zero-velocity repeat-50 {actions} --format json >records.json",
    ):
        done = shell(command, folder)
        if done.returncode:
            raise SystemExit(f"{command}\n{done.stderr}")
    for name in ("FILE.h5", "samples.h5", "walking.h5"):
        shutil.copy(folder / "a.h5", folder / name)
    records = (folder / "records.json").read_text(encoding="utf-8")
    for ours, theirs in (("zero-velocity", "VGRU-d"), ("repeat-50", "GRU-d")):  # whom the votes compare
        records = records.replace(f'"{ours}"', f'"{theirs}"')
    (folder / "records.json").write_text(records, encoding="utf-8")
    for directory in ("DIR", "SAMPLES", "samples"):
        (folder / directory).mkdir()
        for source, name in (("model.h5", "VGRU-d.h5"), ("a.h5", "GRU-d.h5")):
            shutil.copy(folder / source, folder / directory / name)

    shutil.copy(folder / "samples.npz", folder / "b.npz")
    rng = np.random.default_rng(0)
    gt, mine, other = rng.normal(size=(3, 12, 100, 99)).cumsum(axis=2) / 30
    np.save(folder / "gt.npy", gt)
    np.save(folder / "pred.npy", mine)
    for name, motion in (("mine", mine), ("theirs", other), ("results", mine)):
        np.savez(folder / f"{name}.npz", **{"all/gt": gt, "all/pred": motion})
    for name, motion in (("gt", gt), ("pred", mine)):
        np.savez(folder / f"{name}.npz", walking=motion)

    (folder / "package").mkdir()
    (folder / "package/__init__.py").touch()
    functions = "".join(FUNCTION.format(name=name) for name in ("function", "my_npss"))
    (folder / "package/module.py").write_text(functions + CLASS, encoding="utf-8")

    votes = []
    for action in ("walking", "eating"):
        questions = study.design(["VGRU-d", "GRU-d"], range(8), 6, seed=0, attention_checks=1)
        votes += study.simulate_votes(questions, {"VGRU-d": 0.8, "GRU-d": 0.0}, 8, action=action, seed=1)
    (folder / "answers").mkdir()
    study.write_votes(folder / "answers/all.csv", votes)
    study.write_votes(folder / "votes.csv", votes)
    shutil.copy(PROJECT / "docs/survey.de.toml", folder)

    cmu = Path(os.environ["NPSS_CMU"])
    clips = sorted(cmu.rglob("*.bvh"))
    for name in ("walk", "clip", "keys"):
        shutil.copy(clips[0], folder / f"{name}.bvh")
    shutil.copy(clips[1], folder / "run.bvh")
    for directory, names in (("FOLDER", "abc"), ("BVH", "ab"), ("BVH/01", "c"), ("BVH/05", "d")):
        (folder / directory).mkdir()
        for name, clip in zip(names, clips, strict=False):
            shutil.copy(clip, folder / directory / f"{name}.bvh")
    for subject in range(1, 6):
        lafan1.write_bvh(folder / f"BVH/walk_subject{subject}.bvh", *lafan1.clip(subject, 120))


def main(names: list[str]) -> int:
    """Run the commands of these pages, of all if none is named."""
    lacking = [variable for variable in VARIABLES.values() if variable not in os.environ]
    if lacking:
        print(f"set {', '.join(lacking)} to folders of motion", file=sys.stderr)
        return 2
    failed = count = 0
    with tempfile.TemporaryDirectory() as temporary:
        prepared = Path(temporary, "prepared")
        prepared.mkdir()
        prepare(prepared)
        for page in PAGES:
            lines = commands(page)
            if page.name == "extending.md" or not lines or (names and page.name not in names):
                continue
            print(f"\n{page.relative_to(PROJECT)}", flush=True)
            folder = Path(temporary, page.stem)
            shutil.copytree(prepared, folder, symlinks=True)
            for line in [BEFORE[page.name], *lines] if page.name in BEFORE else lines:
                began, command = time.monotonic(), changed(line)
                done = shell(command, folder)
                count += 1
                failed += done.returncode != 0
                print(f"{done.returncode:3} {time.monotonic() - began:5.0f} s  {command}", flush=True)
                if done.returncode:
                    print(*done.stderr.splitlines()[-8:], sep="\n", flush=True)
            shutil.rmtree(folder)
    print(f"\n{count} commands ran, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
