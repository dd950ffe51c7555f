"""Figures of the applications of a manifold."""
