"""Measure restored windows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from npss.records import Record
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.restore import RESTORATIONS, WRIST
from npss_baselines.manifold.evaluation.lost import best_of, by_subject, lost_error, only, ratio
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.features import FPS, local_positions, to_positions
from npss_baselines.manifold.restorers import simple_baselines


def restoration(testbed: Testbed, application: str, joints: Sequence[str] = (WRIST,)) -> Iterator[Record]:
    """Measure restored windows against the originals.

    Metrics: ``lost_error``, the mean distance of joints of which a coordinate was lost or noisy, and ``joint_error`` of
    all joints, in body heights; ``bone_error`` as a share of bone lengths; ``foot_speed``; ``npss`` on positions in the
    character's frame, with windows as sequences. ``ratio`` divides the ``lost_error`` by that of the best simple
    baseline; its records have ``low``, ``high``, ``clips`` and ``subject`` (``all``, or one), too. With joints other
    than `WRIST`, the application's name has those joints: ``fill LeftFoot``.

    Parameters
    ----------
    testbed : Testbed
        The motion and the methods.
    application : str
        One of `RESTORATIONS`.
    joints : sequence of str, optional
        The joints that ``fill`` removes, with all joints below them.
    """
    left, mask = testbed.corrupted(application, joints), testbed.windows.mask
    truth = testbed.windows.features
    gt = local_positions(truth)
    corruption, name = RESTORATIONS[application], application
    if tuple(joints) != (WRIST,):
        corruption, name = f"{' and '.join(joints)} and below missing", f"{application} {' '.join(joints)}"
    context = context_of(testbed.test, frames=gt.shape[1], corruption=corruption, seed=testbed.seed)
    speed = measures.foot_speed(to_positions(truth), JOINTS, mask, fps=FPS)
    errors = {}
    for method, motion in testbed.restored(application, left).items():
        pred = local_positions(motion).astype(np.float64)
        values = {}
        if not left.exact.all():
            errors[str(method)] = lost_error(truth, motion, left, mask)
            values["lost_error"] = errors[str(method)].error
        values |= {
            "joint_error": measures.joint_error(gt, pred, mask),
            "bone_error": measures.bone_error(pred, JOINTS, mask),
            "foot_speed": measures.foot_speed(to_positions(motion), JOINTS, mask, fps=FPS),
            "npss": measures.power_error(gt, pred, mask),
        }
        yield from records_of(testbed, name, method, values, context)
    yield from records_of(testbed, name, Method("original"), {"foot_speed": speed}, context)
    if not errors:
        return
    best = best_of(errors, simple_baselines.NAMES)
    clips = [testbed.test.clips[i] for i in testbed.test.clip_of]
    named = np.array([f"{clip.source}/{clip.name}" for clip in clips])
    for subject, chosen in by_subject([clip.subject for clip in clips]):
        for restorer, lost in errors.items():
            found = ratio(only(lost, chosen), only(errors[best], chosen), named[chosen])
            details = {"low": found.low, "high": found.high, "clips": found.clips, "subject": subject}
            extra = {"extra": {"reference": best}}
            values = {"ratio": found.value}
            for record in records_of(testbed, name, Method.parse(restorer), values, context | extra):
                yield record | details
