"""The commands of ``npss-baselines``."""
