"""Measure a prediction by L2Q, L2P and NPSS: one record, with the signature of each number."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy.typing as npt

from npss._analysis.blocks import Label
from npss._metric.fields import Value
from npss._metric.in_betweening import Hemisphere, Joints, Norm, norms, read_joints, read_quaternions
from npss._metric.metric import Metric
from npss._metric.registry import L2P, L2Q
from npss._metric.signature import signature
from npss.inbetweening._motion import Global
from npss.inbetweening._positions import Statistics, Unit, read_scale
from npss.protocol import InBetweening, lafan1, verify
from npss.records import Record
from npss.records import measure as measure_features
from npss.validation import Float64, real_array


def measure(
    gt: Global,
    pred: Global,
    *,
    mean: npt.ArrayLike | None = None,
    std: npt.ArrayLike | None = None,
    stats: Statistics | str | os.PathLike[str] | None = None,
    unit: Unit | None = None,
    past: npt.ArrayLike | None = None,
    hemisphere: Hemisphere = "anchored",
    norm: Norm = "pose",
    protocol: InBetweening | None = None,
    fps: float | None = None,
    model: str | None = None,
    sequences: bool = False,
    groups: Iterable[Label | None] | None = None,
    extra: Mapping[str, Value] | None = None,
) -> Record:
    """Measure a prediction by the three numbers of in-betweening tables: L2Q, L2P, and NPSS by ``'released'``.

    Parameters
    ----------
    gt, pred : Global
        Pairs of global quaternions ``(N, T, J, 4)`` and positions ``(N, T, J, 3)`` of the transition's frames, from
        `forward` or your own code; or flattened joint by joint.
    mean, std, stats, unit : optional
        How positions are standardised, or their unit, as for `l2p`; one of the three is needed.
    past, hemisphere, norm : optional
        As for `l2q`. Quaternions of NPSS are continuous in time, too, unless their signs are taken as given.
    protocol : InBetweening, optional
        The protocol of the windows, such as `lafan1`; stated in signatures. The ground truth is compared to the
        protocol's by `npss.protocol.verify`; if it is another, signatures state ``verified:no``, and the numbers stand
        beside no published ones.
    fps : float, optional
        Frames per second, if there is no protocol.
    model : str, optional
        The name of the model, for tables.
    sequences : bool, optional
        Also measure single windows, from which leaderboards make intervals and tests.
    groups : sequence of str, int or None, optional
        The blocks of the windows, such as the names of their clips; windows that overlap depend on each other.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signatures.

    Returns
    -------
    dict
        A record as of `npss.records.measure`: ``npss`` has the score by convention, ``metrics`` has ``L2Q`` and
        ``L2P``, ``signatures`` the signature of each. ``action`` names the transition, ``verification`` says what
        differs from the protocol's ground truth and what is undecided, ``std`` holds the standard deviations of
        standardised positions.

    Raises
    ------
    TypeError, ValueError
        As for `l2q`, `l2p` and `npss.score`; also if quaternions and positions differ in sequences, frames or joints,
        or the frames or joints are not the protocol's.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Global, measure
    >>> angle = np.linspace(0.5, 1.5, 30)[:, None] * np.ones(22)
    >>> gt = Global(
    ...     np.stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle], axis=-1)[None],
    ...     np.stack([angle, angle, angle], axis=-1)[None],
    ... )
    >>> still = Global(np.repeat(gt.quaternions[:, :1], 30, axis=1), np.repeat(gt.positions[:, :1], 30, axis=1))
    >>> record = measure(gt, still, unit="m", fps=30)
    >>> {name: round(value, 3) for name, value in record["metrics"].items()}, round(record["npss"]["released"], 3)
    ({'L2Q': 2.295, 'L2P': 4.062}, 0.153)
    >>> record["signatures"]["L2P"]
    'l2p|version:1|representation:global-positions|frames:30|fps:30|unwrap:off|norm:pose|positions:m'
    """
    (gt_quaternions, gt_positions), (pred_quaternions, pred_positions) = _read("gt", gt), _read("pred", pred)
    turns = _one_length(read_quaternions(gt_quaternions, pred_quaternions, past=past, hemisphere=hemisphere))
    places = _one_length(read_joints(gt_positions, pred_positions, 3))
    if turns.gt.shape[:3] != places.gt.shape[:3]:
        shapes = f"{turns.gt.shape[:3]} and {places.gt.shape[:3]}"
        raise ValueError(f"gt: quaternions and positions differ in sequences, frames or joints: {shapes}")
    _, n_frames, n_joints, _ = turns.gt.shape
    scale = read_scale(n_joints, mean=mean, std=std, stats=stats, unit=unit)
    verification = None
    fields: dict[str, Any] = {} if fps is None else {"fps": fps}
    if protocol is not None:
        fields = _fields(protocol, fps, n_frames, n_joints)
        before = None if past is None else real_array("past", past)[:, None]
        verification = verify(turns.gt, protocol, past=before)
    signs: dict[str, Any] = {} if hemisphere == "given" else {"quaternions": "continuous"}
    record: Record = {} if model is None else {"model": model}
    record["action"] = lafan1.action(n_frames)
    if verification is not None:
        record["verification"] = verification.as_dict()
        fields |= verification.stated
    record |= measure_features(
        turns.gt,
        turns.pred,
        conventions=("released",),
        sequences=sequences,
        groups=groups,
        extra=extra,
        representation="global-quaternions",
        frames=n_frames,
        **fields,
        **signs,
    )
    fields |= {"frames": n_frames, "unwrap": "off", "norm": norm, "extra": extra or {}}
    differences: dict[Metric, tuple[Float64, dict[str, Any]]] = {
        L2Q: (
            turns.gt - turns.pred,
            {"representation": "global-quaternions", "hemisphere": hemisphere, **signs},
        ),
        L2P: (
            (places.gt - places.pred) / scale,
            {"representation": "global-positions", "positions": "standardised" if unit is None else unit},
        ),
    }
    if unit is None:
        record["std"] = scale.ravel().tolist()  # the unit of L2P, which `table` compares
    record["metrics"] = {}
    if sequences:
        record["sequences"]["metrics"] = {}
    for metric, (difference, own) in differences.items():
        values = norms(difference, norm)
        record["metrics"][metric.heading] = float(values.mean())
        record["signatures"][metric.heading] = signature(None, metric=metric.name, **fields, **own)
        if sequences:
            record["sequences"]["metrics"][metric.heading] = values.tolist()
    return record


def _one_length(groups: list[Joints]) -> Joints:
    if len(groups) > 1:
        lengths = ", ".join(str(group.gt.shape[1]) for group in groups)
        raise ValueError(f"gt: expected sequences of one length, got {lengths} frames; measure each length by itself")
    return groups[0]


def _read(name: str, motion: Global) -> Global:
    if not isinstance(motion, tuple) or len(motion) != 2:
        raise TypeError(f"{name}: expected Global(quaternions, positions), got {type(motion).__name__}")
    if motion[1] is None:
        raise TypeError(f"{name}: no positions; npss.score(..., convention='released') and l2q take quaternions alone")
    return Global(*motion)


def _fields(protocol: InBetweening, fps: float | None, n_frames: int, n_joints: int) -> dict[str, Any]:
    """Return the fields that a protocol states, if the motion may be its own."""
    if not isinstance(protocol, InBetweening):
        raise TypeError(f"protocol: expected an InBetweening such as lafan1, got {protocol!r}")
    if fps not in (None, protocol.fps):
        raise ValueError(f"fps: {protocol.name} has {protocol.fps:g} frames per second, got {fps!r}")
    if n_frames not in protocol.transitions:
        lengths = ", ".join(map(str, protocol.transitions))
        raise ValueError(f"gt: {protocol.name} has transitions of {lengths} frames, got {n_frames}")
    if n_joints != protocol.joints:
        raise ValueError(f"gt: {protocol.name} has {protocol.joints} joints, got {n_joints}")
    return {"fps": protocol.fps, "protocol": protocol.name}
