"""Files in the format of Human3.6M."""

import numpy as np


def write(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, rows, fmt="%.7f", delimiter=",")
