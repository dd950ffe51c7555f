"""Predictors and models, measured."""
