"""Evaluation of predictors and models."""
