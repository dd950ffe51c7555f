"""Applications of a manifold: restoration, interpolation, sampling, retrieval, distance."""
