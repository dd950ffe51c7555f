"""Evaluation of a manifold and its baselines."""
