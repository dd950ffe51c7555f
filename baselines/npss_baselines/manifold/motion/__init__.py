"""Prepared motion: features, windows, scaling."""
