"""Checkpoints: written atomically, and read without running code."""

from __future__ import annotations

import io
import pickle
from pathlib import Path
from typing import Any

import torch

from npss.extras import install_hint
from npss.files import doing, write_stream_atomically

try:
    from lightning.pytorch.plugins import TorchCheckpointIO
except ImportError:
    raise ImportError(f"training needs lightning; {install_hint('all', baselines=True)}") from None


class AtomicIO(TorchCheckpointIO):
    """Read and write Lightning's checkpoints, atomically and without running code."""

    def save_checkpoint(self, checkpoint: dict[str, Any], path: Any, storage_options: Any | None = None) -> None:
        """Write a checkpoint; Lightning itself would use a file in another folder, perhaps on another disk."""
        write_stream_atomically(Path(path), lambda stream: torch.save(checkpoint, stream))

    def load_checkpoint(self, path: Any, map_location: Any = "cpu", weights_only: Any = True) -> dict[str, Any]:
        """Read a checkpoint; nothing in it can run code."""
        with doing("reading the checkpoint"):
            content = io.BytesIO(Path(path).read_bytes())
        try:
            checkpoint = torch.load(content, map_location="cpu", weights_only=True)
            if not isinstance(checkpoint, dict) or "state_dict" not in checkpoint:
                raise ValueError("no weights in it")
        except (EOFError, OSError, pickle.UnpicklingError, RuntimeError, ValueError) as error:
            raise ValueError(
                f"{path}: not a checkpoint, or an incomplete one ({error}); without this file, the run starts over"
            ) from error
        return checkpoint
