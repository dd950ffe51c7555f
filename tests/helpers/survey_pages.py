"""Pages of surveys to take in a browser."""

import numpy as np

from npss import gait

ACTIONS = ("walking", "eating", "smoking", "discussion")
MODELS = ("alpha", "beta", "gamma")

#: A script that returns what cannot be seen or pressed without scrolling.
OUT_OF_SIGHT = """() => [...document.querySelectorAll('button, input, label, canvas, legend, h1, .alert')]
  .filter((element) => element.getClientRects().length)
  .filter((element) => {
    const { left, top, right, bottom } = element.getBoundingClientRect();
    return left < 0 || top < 0 || right > innerWidth || bottom > innerHeight || right - left < 10;
  })
  .map((element) => element.outerHTML)"""


def write_samples(folder):
    """Write a file of samples for each model, of two sequences of each action; eating has no motion of the root."""
    for i, model in enumerate(MODELS):
        arrays = {}
        for j, action in enumerate(ACTIONS):
            truth, pred = gait.gait(2, 25, seed=j), gait.gait(2, 25, seed=10 + 3 * i + j)
            for poses in truth, pred:
                poses[..., 3:6] = 0  # the persons stay upright
                if action == "eating":
                    poses[..., :6] = 0
            arrays |= {f"expmap/gt/{action}_{k}": motion for k, motion in enumerate(truth)}
            arrays |= {f"expmap/preds/{action}_{k}": motion for k, motion in enumerate(pred)}
        np.savez(folder / f"{model}.npz", **arrays)
