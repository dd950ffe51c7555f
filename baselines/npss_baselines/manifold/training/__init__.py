"""Training of the manifold: configuration, recipes, loss, run folders."""
