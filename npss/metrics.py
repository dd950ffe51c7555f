"""Metrics: those of this library, and your own, which `register` makes known to records, tables and commands."""

from npss._metric.metric import Metric
from npss._metric.registry import METRICS, register

__all__ = ["METRICS", "Metric", "register"]
