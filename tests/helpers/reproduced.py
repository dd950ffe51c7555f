"""Records of a plan, measured on generated motion under the names of real tasks."""

import numpy as np

from npss.predictors import PREDICTORS
from npss_baselines.data.synthetic import synthetic_task
from npss_baselines.reproduction.measure import measure


def task(action="walking", protocol="srnn-8", n=4):
    """Return windows of generated walks under another name, in two blocks."""
    made = synthetic_task(n)
    return made._replace(action=action, protocol=protocol, groups=tuple("ab"[i % 2] for i in range(n)))


def noisy(size, seed):
    """Return a predictor that holds the last frame and shakes: other noise in each draw."""
    generator = np.random.default_rng(seed)

    def predict(seed_frames, n_target):
        shape = len(seed_frames), n_target, seed_frames.shape[2]
        return np.repeat(seed_frames[:, -1:], n_target, axis=1) + size * generator.normal(size=shape)

    return predict


def record(row, recipe, seed, predictor, *, action="walking"):
    """Return the record of a run on all protocols."""
    tasks = [task(action, protocol) for protocol in ("srnn-8", "random-256")]
    measured = [measure(row, lambda _: predictor, each, draws=2) for each in tasks]
    measured.append(measure(row, lambda _: predictor, tasks[0], draws=2, unwrapped="target"))
    return {
        "row": row,
        "model": row,
        "recipe": recipe,
        "actions": [action],
        "seed": seed,
        "why": "a test",
        "measured": measured,
    }


def records():
    """Return the records of two untrained rows, and of a model with three seeds."""
    untrained = [record(name, "untrained", 0, PREDICTORS[name]) for name in ("zero-velocity", "repeat-50")]
    trained = [record("vgru-d", "ours", seed, noisy(0.1 + 0.05 * seed, seed)) for seed in range(3)]
    return untrained + trained
