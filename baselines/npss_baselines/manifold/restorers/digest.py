"""The identity of arrays, for signatures."""

from __future__ import annotations

import hashlib

import numpy as np

from npss.validation import Array


def digest_of(*arrays: Array) -> str:
    """Return the hash of arrays, to the bit."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:12]
