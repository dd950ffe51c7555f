"""The two public implementations of NPSS, rewritten from their descriptions, as references for `npss.score`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def fast(gt: Array, pred: Array, *, real: bool = True) -> float:
    """Score by the widely copied vectorised code, with whole-array transforms and temporaries.

    `real` keeps only the real part of the coefficients, as released code does; otherwise their magnitude counts.
    """
    gt_coefficients = np.fft.fft(gt, axis=1)
    pred_coefficients = np.fft.fft(pred, axis=1)
    gt_power = np.square(np.real(gt_coefficients) if real else np.abs(gt_coefficients))
    pred_power = np.square(np.real(pred_coefficients) if real else np.abs(pred_coefficients))
    gt_total = np.sum(gt_power, axis=1)
    pred_total = np.sum(pred_power, axis=1)
    gt_share = gt_power / gt_total[:, np.newaxis, :]
    pred_share = pred_power / pred_total[:, np.newaxis, :]
    gt_cumulative = np.cumsum(gt_share, axis=1)
    pred_cumulative = np.cumsum(pred_share, axis=1)
    distance = np.sum(np.abs(pred_cumulative - gt_cumulative), axis=1)
    return float(np.average(distance, weights=gt_total))


def loops(gt: Array, pred: Array, *, real: bool = True) -> float:
    """Score by a Python loop over sequences and features, as in the first release."""
    n_sequences, _, n_features = gt.shape
    distances = np.zeros((n_sequences, n_features))
    totals = np.zeros((n_sequences, n_features))
    for i in range(n_sequences):
        for j in range(n_features):
            gt_coefficients = np.fft.fft(gt[i, :, j])
            pred_coefficients = np.fft.fft(pred[i, :, j])
            gt_power = np.square(gt_coefficients.real if real else np.abs(gt_coefficients))
            pred_power = np.square(pred_coefficients.real if real else np.abs(pred_coefficients))
            totals[i, j] = np.sum(gt_power)
            gt_cumulative = np.cumsum(gt_power / totals[i, j])
            pred_cumulative = np.cumsum(pred_power / np.sum(pred_power))
            distances[i, j] = np.sum(np.abs(pred_cumulative - gt_cumulative))
    return float(np.sum(distances * totals) / np.sum(totals))
