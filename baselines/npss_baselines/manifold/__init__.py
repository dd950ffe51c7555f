"""The motion manifold of Holden et al. (2015): preparation of motion, the convolutional autoencoder, and its uses."""
