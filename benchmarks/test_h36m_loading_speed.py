"""Time to load Human3.6M, compared with numpy.loadtxt, file by file in turn in one run.

Use the data set in NPSS_H36M, or a few generated files. ``pytest benchmarks/test_h36m_loading_speed.py -s``
"""

import os
import time

import numpy as np

from npss_baselines.data import h36m


def root_of(tmp_path):
    if "NPSS_H36M" in os.environ:
        return os.environ["NPSS_H36M"]
    rng = np.random.default_rng(0)
    for subject in h36m.SUBJECTS:
        for clip in (1, 2):
            path = tmp_path / "data" / "dataset" / f"S{subject}" / f"walking_{clip}.txt"
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savetxt(path, rng.normal(size=(2000, 99)) * (rng.random(99) < 0.55), fmt="%.7f", delimiter=",")
    return tmp_path / "data"


def timed(function):
    start = time.perf_counter()
    result = function()
    return time.perf_counter() - start, result


def test_loading(tmp_path):
    start = time.perf_counter()
    plain = h36m.open_root(root_of(tmp_path))
    opening = time.perf_counter() - start
    cached = h36m.open_root(plain.folder, cache=tmp_path / "cache")
    seconds = dict.fromkeys(("numpy.loadtxt", "load", "load, filling the cache", "load, from the cache"), 0.0)
    files = sorted(plain.folder.glob("S*/*.txt"))
    for file in files:
        action, clip = file.stem.split("_")
        which = int(file.parent.name[1:]), action, int(clip)
        readers = (
            lambda file=file: np.loadtxt(file, delimiter=",", dtype=np.float32),
            lambda which=which: h36m.load(plain, *which),
            lambda which=which: h36m.load(cached, *which),
            lambda which=which: h36m.load(cached, *which),
        )
        arrays = []
        for name, reader in zip(seconds, readers, strict=True):
            took, rows = timed(reader)
            seconds[name] += took
            arrays.append(rows)
        assert all(np.array_equal(rows, arrays[0]) for rows in arrays[1:])
    print(f"\n{len(files)} files; opening {opening:.3f} s")
    for name, took in seconds.items():
        print(f"{name:24} {took:7.2f} s  ratio {took / seconds['numpy.loadtxt']:.3f}")
