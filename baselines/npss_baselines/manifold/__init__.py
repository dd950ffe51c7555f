"""The motion manifold of Holden et al. (2015): motion preparation, autoencoder, training, applications."""
