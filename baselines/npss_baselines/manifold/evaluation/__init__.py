"""How good a manifold is."""
