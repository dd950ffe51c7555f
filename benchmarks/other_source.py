"""Restorers of one source on another: CMU's, and simple baselines fitted to CMU, on the held-out subject of Human3.6M.

python benchmarks/other_source.py --cmu DIR --styles DIR --h36m DIR RESTORER ...: the numbers of docs/manifold.md.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from npss_baselines.manifold.applications.restore import Windows, corrupted
from npss_baselines.manifold.evaluation.lost import best_of, lost_error, ratio
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.split import split
from npss_baselines.manifold.restorers import file
from npss_baselines.manifold.restorers.simple_baselines import NAMES, SimpleBaselines

EVERY = 2  # windows


def main() -> None:
    """Print errors of lost joints in body heights, and their ratio to the best simple baseline."""
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--cmu", "--styles", "--h36m"):
        parser.add_argument(option, type=Path, required=True)
    parser.add_argument("--cache", type=Path)
    parser.add_argument("restorers", type=Path, nargs="+")
    options = parser.parse_args()
    cmu = motion_set({"cmu": options.cmu, "cmu-styles": options.styles}, cache=options.cache)
    simple = SimpleBaselines(split(cmu).training)
    test = split(motion_set({"h36m": options.h36m}, cache=options.cache)).test
    assert test is not None
    windows = Windows(test.windows[::EVERY].astype(float), test.mask[::EVERY])
    clips = [test.clips[i].name for i in test.clip_of[::EVERY]]
    for application in ("fill", "inbetween", "kinect", "repair"):
        left = corrupted(application, windows, simple.scaling.mean, seed=0)
        ways = {**simple.of(left), **{path.stem: file.load(path) for path in options.restorers}}
        errors = {
            name: lost_error(windows.features, way.restore(left), left, windows.mask) for name, way in ways.items()
        }
        best = best_of(errors, NAMES)
        for name, error in errors.items():
            found = ratio(error, errors[best], clips)
            ends = f"[{found.low:.3f}, {found.high:.3f}]"
            print(f"{application:10} {name:16} {error.error:.5f}  {found.value:.3f} {ends}", flush=True)


if __name__ == "__main__":
    main()
