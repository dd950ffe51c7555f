"""Which validation windows predict the order of predictors on test windows?

``NPSS_H36M=DIR python benchmarks/validation_windows.py [ACTION ...]``

Rank untrained predictors, and fitted ones with several settings, by each metric on three sets of validation windows,
and on the test windows of the same metric; print how well the orders agree, by Kendall's tau-b. The sets:

- windows of the test subject beside the eight test windows, which training uses by default;
- the same clips at every frame that is a multiple of five;
- windows of training subjects, each pair of them held out in turn, by predictors that were fitted to the others.

Predictors with networks are left out, since they would be fitted twelve times.
"""

import os
import sys
from pathlib import Path

import numpy as np
from scipy.stats import kendalltau

import npss
from npss.console import Progress, table
from npss.predictors import PREDICTORS
from npss.protocol import SLICES_MS, Window
from npss_baselines.data import pose_sources
from npss_baselines.data.tasks import task_of
from npss_baselines.fitted.base import FittedPredictor
from npss_baselines.fitted.dc_share import MedianShare
from npss_baselines.fitted.motion import read_motion
from npss_baselines.fitted.nearest import Nearest, NearestSettings
from npss_baselines.fitted.ridge import Ridge, RidgeSettings

PAIRS = ((1, 6), (7, 8), (9, 11))
TEST = ("srnn-8", "random-256")
EVERY = 5  # frames between the starts of two windows of the dense set
LEFT_OUT = ("running-average-2", "running-average-4")  # constant, too: by NPSS, they are zero-velocity
UNTRAINED = {name: predictor for name, predictor in PREDICTORS.items() if name not in LEFT_OUT}
FITTED = {
    **{f"ridge, penalty {penalty:g}": (Ridge, RidgeSettings(penalty=penalty)) for penalty in (0.001, 0.1, 10)},
    **{f"nearest-{n}": (Nearest, NearestSettings(neighbours=n)) for n in (1, 3, 10, 50)},
    "dc-share-median": (MedianShare, MedianShare.Settings()),
}


def main():
    root, source = Path(os.environ["NPSS_H36M"]), pose_sources()["h36m"]
    actions = sys.argv[1:] or list(source.default_actions)
    names = [*UNTRAINED, *FITTED]
    rows = []
    for action in actions:
        tasks = {name: [task] for name, task in test_and_validation(source, root, action).items()}
        scores = {name: measured(predictors(source, root, action, None), of) for name, of in tasks.items()}
        folds = []
        for pair in PAIRS:
            held_out = [subject for subject in pair if has(source, root, action, subject)]
            others = [s for s in source.train_subjects if s not in pair and has(source, root, action, s)]
            if held_out:
                fold = source.held_out_tasks(root, [action], held_out)
                folds.append(measured(predictors(source, root, action, others), fold))
        scores["held out in turn"] = {metric: np.mean([fold[metric] for fold in folds], axis=0) for metric in folds[0]}
        for metric in scores["held out in turn"]:
            for windows in ("beside the test windows", "the same, dense", "held out in turn"):
                agreement = [kendalltau(scores[windows][metric], scores[test][metric]).statistic for test in TEST]
                rows.append([action, metric, windows, *(f"{tau:+.2f}" for tau in agreement)])
    print(f"{len(names)} predictors: {', '.join(names)}")
    print(table(["action", "metric", "validation windows", *TEST], rows, "lllrr", markdown=True))


def test_and_validation(source, root, action):
    """Return the test windows and the validation windows of the test subject."""
    tasks = {protocol: next(source.tasks(root, [action], protocol)) for protocol in TEST}
    (tasks["beside the test windows"],) = source.validation_tasks(root, [action])
    clips = source.test_clips(root, action)
    eight = source.windows("srnn-8", [len(clip) for clip in clips])
    dense = [
        Window(clip, start, 50, 100)
        for clip, poses in enumerate(clips)
        for start in range(16, len(poses) - 149, EVERY)
        if not any(test.clip == clip and abs(test.start - start) < 150 for test in eight)
    ]
    tasks["the same, dense"] = task_of(action, "dense", clips, dense)
    return tasks


def has(source, root, action, subject):
    """Return whether the recordings of a subject are there."""
    try:
        return bool([*source.recordings(root, actions=[action], subjects=[subject])])
    except FileNotFoundError:
        return False


def predictors(source, root, action, subjects):
    """Return predictors by name, fitted to all subjects (None) or to some."""
    motion, _ = read_motion(source, root, [action], subjects=subjects)
    found = dict(UNTRAINED)
    with Progress(f"fitting for {action}") as progress:
        for done, (name, (kind, settings)) in enumerate(FITTED.items(), 1):
            fitted = kind.fit(motion, settings, seed=0, progress=lambda share: None)
            found[name] = FittedPredictor(fitted, 0)
            progress(done / len(FITTED))
    return found


def measured(predictors_by_name, tasks):
    """Return the numbers of predictors by metric, averaged over tasks."""
    numbers = {}
    for predictor in predictors_by_name.values():
        each = []
        for task in tasks:
            gt, pred = (npss.poses_to_euler(poses) for poses in (task.target, predictor(task.seed_frames, 100)))
            row = {f"NPSS {name}": npss.score(gt, pred, convention=name) for name in ("released", "paper")}
            each.append(row | {"Euler error": np.mean([*npss.euler_error(gt, pred, fps=25, at_ms=SLICES_MS).values()])})
        for metric in each[0]:
            numbers.setdefault(metric, []).append(np.mean([row[metric] for row in each]))
    return numbers


if __name__ == "__main__":
    main()
