"""Measure restored windows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss.records import Record
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.restore import RESTORATIONS
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.features import local_positions


def restoration(testbed: Testbed, application: str) -> Iterator[Record]:
    """Measure restored windows against the originals.

    Metrics: ``joint_error`` in body heights; ``missing_joint_error``, of joints missing in all frames; ``bone_error``
    as a share of bone lengths; ``npss`` on positions in the character's frame, with windows as sequences.
    """
    left, mask = testbed.corrupted(application), testbed.windows.mask
    gt = local_positions(testbed.windows.features)
    missing = ~local_positions(left.known.astype(float)).any(axis=(0, 1, 3))
    context = context_of(testbed.test, frames=gt.shape[1], corruption=RESTORATIONS[application], seed=testbed.seed)
    for method, motion in testbed.restored(application, left).items():
        pred = local_positions(motion).astype(np.float64)
        values = {
            "joint_error": measures.joint_error(gt, pred, mask),
            "bone_error": measures.bone_error(pred, JOINTS, mask),
            "npss": measures.power_error(gt, pred, mask),
        }
        if missing.any():
            values["missing_joint_error"] = measures.joint_error(gt[:, :, missing], pred[:, :, missing], mask)
        yield from records_of(testbed, application, method, values, context)
