"""Error rates and coverages where windows overlap: the numbers of docs/statistics.md.

``python benchmarks/significance.py [SETS]``

Simulate errors with weights of Human3.6M's windows if ``NPSS_H36M`` names its folder, otherwise of generated motion;
the output states which. Then, on real motion only, compute intervals of blocks drawn from all subjects. It takes a few
minutes. ``tests/helpers/overlap.py`` describes the simulation.
"""

import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))
import overlap
from npss import CONVENTIONS, poses_to_euler, protocol
from npss._analysis.blocks import Blocks
from npss._metric.contributions import contributions
from npss.predictors import repeat, zero_velocity
from npss_baselines.data import h36m

PHIS = (0.9, 0.98)
N_BLOCKS = (8, 10, 13, 20, 32)
N_SEED, STEP = 50, 10  # of real windows: seed frames, and frames from one window to the next


def main():
    sets = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    root = os.environ.get("NPSS_H36M")
    clips = real_clips(root) if root else {}
    if root:
        pairs = [[(clip**2).sum(axis=1) for clip in pair] for pair in clips.values()]
        print(f"weights: {len(pairs)} pairs of clips of Human3.6M, all subjects; {sets} sets a case")
    else:
        pairs = overlap.generated_pairs(np.random.default_rng(0))
        print(f"weights: generated, since NPSS_H36M is not set; {sets} sets a case")
    simulated(pairs, sets)
    if root:
        real(clips, sets)


def real_clips(root):
    """Return the Euler angles of both clips of each subject and action, ``(T, 99)`` at 25 frames per second."""
    data = h36m.open_root(root)
    missing = set(h36m.missing(data))
    clips = {}
    for subject in h36m.SUBJECTS:
        for action in protocol.ACTIONS:
            if not missing & {f"S{subject}/{action}_{clip}.txt" for clip in (1, 2)}:
                poses = [h36m.load(data, subject, action, clip, fps=protocol.FPS) for clip in (1, 2)]
                clips[subject, action] = [poses_to_euler(clip.astype(np.float64)) for clip in poses]
    return clips


def simulated(pairs, sets):
    """Print error rates and coverages of simulated errors."""

    def patterns(name, fewest=0, unit=None):
        return [pattern for pair in pairs if (pattern := overlap.pattern(pair, name, unit)).blocks.n >= fewest]

    def stretch_of_one_target(place, window):
        return f"{window.clip}, {window.target.start // overlap.N_TARGET}"

    rng = np.random.default_rng(0)
    cases = {  # patterns, and whether to compute intervals
        "random-256: every window a block": (patterns("random-256", unit=lambda place, _: place), True),
        "random-256: stretches of T, every window": (patterns("random-256", unit=stretch_of_one_target), True),
        "random-256: stretches of 2 T, whole windows; 6 blocks or more": (patterns("random-256", 6), False),
        **{f"random-256: the same, {n} blocks": (overlap.cut(pairs, n, rng, 100), True) for n in (10, 13, 20)},
        "srnn-8: every window a block": (patterns("srnn-8", unit=lambda place, _: place), False),
        "srnn-8: chains; 6 blocks or more": (patterns("srnn-8", 6), False),
    }
    print(f"\n{'':62}  phi   P(p <= .05)  coverage of 95 %")
    for name, (sample, with_interval) in cases.items():
        for phi in PHIS:
            wrong = "every window" in name  # slow, and a rough number is enough
            rejected, held = overlap.rates(sample, phi, sets=sets // 5 if wrong else sets)
            print(f"{name:62}  {phi:<4}  {rejected:.3f}        {f'{held:.3f}' if with_interval else ''}", flush=True)


def real(clips, sets):
    """Print coverages of intervals of real scores, for blocks drawn from the stretches of all subjects."""
    print("\ncoverage of 95 %, blocks drawn from all subjects' stretches: lowest, median and highest of the actions")
    print(f"{'':25}  " + "  ".join(f"{n} blocks".ljust(14) for n in N_BLOCKS))
    motions = {action: windows_of(action, clips) for action in protocol.ACTIONS}
    for name, predictor in (("zero-velocity", zero_velocity), ("repeat-50", repeat)):
        for convention in CONVENTIONS:
            coverages = []
            for windows, labels in motions.values():
                seed, target = windows[:, :N_SEED], windows[:, N_SEED:]
                _, emd, weight, *_ = contributions(target, predictor(seed, overlap.N_TARGET), CONVENTIONS[convention])
                blocks = Blocks(labels, weight.sum(axis=1))
                parts = [blocks.sums(values.sum(axis=1)) for values in (emd * weight, weight)]
                coverages.append([coverage(*parts, n, sets) for n in N_BLOCKS])
            ends = zip(*np.quantile(coverages, (0, 0.5, 1), axis=0), strict=True)
            cells = ["  ".join(f"{share:.2f}" for share in three).ljust(14) for three in ends]
            print(f"{name:13} {convention:11}  " + "  ".join(cells), flush=True)


def windows_of(action, clips):
    """Return the windows of all subjects that lie within a stretch, ``(N, 150, 99)``, and their stretches."""
    windows, labels = [], []
    for (subject, performed), pair in clips.items():
        for number, clip in enumerate(pair if performed == action else ()):
            for start in range(N_SEED, len(clip) - overlap.N_TARGET + 1, STEP):
                if start % overlap.STRETCH <= overlap.STRETCH - overlap.N_TARGET:
                    windows.append(clip[start - N_SEED : start + overlap.N_TARGET])
                    labels.append(f"{subject}, {number}, {start // overlap.STRETCH}")
    return np.stack(windows), tuple(labels)


def coverage(numerator, weight, n, sets):
    """Return how often an interval of `n` random blocks covers the score of all blocks."""
    drawn = np.random.default_rng(0).integers(len(weight), size=(sets, n))
    true = numerator.sum() / weight.sum()
    return np.mean([
        overlap.covers(numerator[blocks], weight[blocks], true, seed=i, resamples=999)
        for i, blocks in enumerate(np.array_split(drawn, max(1, sets // 20)))
    ])  # fmt: skip


if __name__ == "__main__":
    main()
