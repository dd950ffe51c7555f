"""The convolutional autoencoder, and PCA."""
