"""How the manifold is trained."""
