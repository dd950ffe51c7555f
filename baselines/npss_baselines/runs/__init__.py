"""Run folders: configuration, weights, checkpoints, and what every training shares."""
