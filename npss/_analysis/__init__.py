"""Conclusions from scores: reports, comparisons, intervals, tests, pitfalls."""
