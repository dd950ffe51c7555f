"""Score models that predict several motions for each context: NPSS of samples, their errors and their diversity.

Samples have the shape ``(S,) + gt.shape``: S predictions of every sequence.

Examples
--------
>>> import numpy as np
>>> import npss
>>> rng = np.random.default_rng(0)
>>> gt = rng.normal(size=(8, 50, 12)).cumsum(axis=1)
>>> samples = gt + rng.normal(size=(5, 8, 50, 12))
>>> best, mean = (npss.stochastic.score(gt, samples, reduction=which) for which in ("best", "mean"))
>>> best < mean
True
"""

from npss.stochastic._distances import ade, apd, fde, mmade, mmfde
from npss.stochastic._report import SampleReport, report
from npss.stochastic._score import score

__all__ = ["SampleReport", "ade", "apd", "fde", "mmade", "mmfde", "report", "score"]
