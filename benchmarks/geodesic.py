"""Retrieval of clips of the same action by the length of geodesics, beside G, on as many clips as time allows.

``python benchmarks/geodesic.py RUN --cmu CMU [--cache CACHE] [--actions 4] [--clips 6]``

Each of the most frequent actions takes part with evenly spread clips of CMU, and each clip with its first whole window.
A geodesic takes some tenths of a second; all pairs are measured.
"""

import argparse
from collections import Counter
from pathlib import Path

import numpy as np
import torch

from npss_baselines.manifold.applications.distance import extremes
from npss_baselines.manifold.applications.geodesic import geodesic_between
from npss_baselines.manifold.applications.retrieval import distances_of, retrieve
from npss_baselines.manifold.evaluation.intervals import difference_interval
from npss_baselines.manifold.evaluation.similarity import labels_of
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.training.folder import load


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--cmu", required=True)
    parser.add_argument("--cache")
    parser.add_argument("--actions", type=int, default=4)
    parser.add_argument("--clips", type=int, default=6)
    parser.add_argument("--pieces", type=int, default=4)
    parser.add_argument("--iterations", type=int, default=8)
    options = parser.parse_args()
    torch.set_num_threads(1)

    manifold = load(options.run).projector
    motions = motion_set({"cmu": options.cmu}, cache=options.cache)
    labels = labels_of(motions)
    first = {}
    for window in np.flatnonzero(motions.mask.all(axis=1)):
        clip = int(motions.clip_of[window])
        if labels[clip]:
            first.setdefault(clip, int(window))
    frequent = [label for label, n in Counter(labels[clip] for clip in first).most_common(options.actions)]
    chosen = []
    for label in frequent:
        clips = [clip for clip in first if labels[clip] == label]
        chosen += [clips[i] for i in np.linspace(0, len(clips) - 1, min(options.clips, len(clips))).round().astype(int)]
    actions, windows = [labels[clip] for clip in chosen], motions.windows[[first[clip] for clip in chosen]]
    subjects = [motions.clips[clip].subject for clip in chosen]

    codes, n = manifold.encode(windows), len(chosen)
    projected = manifold.scaling.normalize(manifold.project(windows)).reshape(n, -1)
    lengths, straight = np.zeros((2, n, n))
    for i in range(n):
        for j in range(i):
            path = geodesic_between(
                manifold, windows[i], windows[j], pieces=options.pieces, iterations=options.iterations
            )
            lengths[i, j] = lengths[j, i] = path.length
            straight[i, j] = straight[j, i] = path.straight
    chords = distances_of(projected)
    distances = {
        "g": distances_of(extremes(codes)),
        "extremes, normalised": distances_of(extremes(manifold.scaling.normalize(windows))),
        "geodesic": lengths,
        "decoded line": straight,
        "euclidean, of projections": chords,
        "euclidean, of codes": distances_of(codes.reshape(n, -1)),
    }
    print(f"{n} windows of {', '.join(f'{actions.count(label)} {label}' for label in frequent)}")
    pairs = np.tril_indices(n, -1)
    for what, others in (("projections", chords), ("decoded lines", straight)):
        ratio = lengths[pairs] / others[pairs]
        print(f"geodesic / {what}: {ratio.mean():.4f}, {ratio.min():.4f} to {ratio.max():.4f}")
    results = {name: retrieve(each, actions, subjects) for name, each in distances.items()}
    for name, result in results.items():
        ones = np.ones(n)
        low, high = difference_interval((results["g"].precision, ones), (result.precision, ones), seed=0)
        precision, nearest = result.mean()
        print(f"{name:26} mAP {precision:.3f} nearest {nearest:.3f}; difference from g {low:+.3f} to {high:+.3f}")


if __name__ == "__main__":
    main()
