"""Clips of one's own, of any skeleton: restored, interpolated, compared, projected, and sampled."""
