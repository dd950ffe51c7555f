"""Training of models: objectives, optimiser, loop and validation."""
