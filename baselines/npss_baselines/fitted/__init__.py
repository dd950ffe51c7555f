"""Predictors that are fitted to training motion in minutes: see `npss_baselines.fitted.registry`."""

from npss_baselines.fitted.registry import FITTED, FittedSpec

__all__ = ["FITTED", "FittedSpec"]
