"""Pictures of what a manifold does."""
