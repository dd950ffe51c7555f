"""What a manifold is for: restoring, interpolating, finding, comparing motion."""
