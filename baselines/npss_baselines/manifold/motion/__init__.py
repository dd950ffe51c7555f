"""Motion as the manifold sees it: features, windows, normalisation."""
