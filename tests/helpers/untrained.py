"""An untrained manifold."""

import torch

from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig
from npss_baselines.manifold.model.projector import Manifold
from npss_baselines.manifold.motion.scaling import fit_scaling


def manifold_of(motions, seed=0):
    torch.manual_seed(seed)
    network = Autoencoder(AutoencoderConfig(widths=(12, 10), kernel=5)).eval()
    return Manifold(network, fit_scaling(motions.windows, motions.mask, "kind"), f"untrained-{seed}")
