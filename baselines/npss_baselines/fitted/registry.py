"""The registry of predictors that are fitted to training motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from npss.plugins import Registry
from npss_baselines.fitted.base import Fitted
from npss_baselines.fitted.calibrated_blend import CalibratedBlend
from npss_baselines.fitted.dc_share import DCShare, MedianShare
from npss_baselines.fitted.nearest import Nearest
from npss_baselines.fitted.ridge import Ridge


@dataclass(frozen=True)
class FittedSpec:
    """A predictor that is fitted to training motion.

    Attributes
    ----------
    name : str
        The name of the predictor.
    description : str
        What it is, in a few words, for help texts.
    kind : type
        The subclass of `Fitted`.
    settings : dataclass
        The settings of the fit, an instance of ``kind.Settings``.
    """

    name: str
    description: str
    kind: type[Fitted]
    settings: Any


#: Fitted predictors by name.
FITTED = Registry(
    "fitted predictor",
    {
        spec.name: spec
        for spec in (
            FittedSpec("ridge", "cosine transform to cosine transform, linear", Ridge, Ridge.Settings()),
            FittedSpec("nearest-10", "mean of the ten nearest continuations", Nearest, Nearest.Settings()),
            FittedSpec("dc-share-median", "power outside DC by medians", MedianShare, MedianShare.Settings()),
            FittedSpec("dc-share", "power outside DC by networks", DCShare, DCShare.Settings()),
            FittedSpec(
                "calibrated-blend",
                "blend of simple predictors with predicted power and speed",
                CalibratedBlend,
                CalibratedBlend.Settings(),
            ),
        )
    },
)
