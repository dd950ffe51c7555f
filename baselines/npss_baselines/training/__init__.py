"""Training: recipes, objectives, batches, and runs that can be cut off at any moment."""
