"""Manifolds of motion: the convolutional autoencoder, and PCA as its baseline."""
