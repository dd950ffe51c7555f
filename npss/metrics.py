"""The registry of metrics: built-in ones, and your own, which `register` adds for records, tables and commands."""

from npss._metric.metric import Metric
from npss._metric.registry import METRICS, register

__all__ = ["METRICS", "Metric", "register"]
