"""The protocols that comparable numbers share: test windows, times, normalisation, and a check of ground truth.

Human3.6M's windows are functions and constants of this module; those of in-betweening are the object `lafan1`, which
`npss.inbetweening` cuts. `verify` says whether a ground truth is that of a published table.
"""

from npss._metric.euler_error import MOVES
from npss.protocol._h36m import (
    ACTIONS,
    COLUMNS,
    FPS,
    SLICES_MS,
    TEST_LENGTHS,
    TEST_SUBJECT,
    TRAIN_SUBJECTS,
    Normalization,
    Window,
    chain_blocks,
    frames_to_ms,
    ms_to_frames,
    normalization,
    random_windows,
    srnn_windows,
    stretch_blocks,
    window_blocks,
)
from npss.protocol._in_betweening import InBetweening, lafan1
from npss.protocol._verify import VERIFIED, Verification, verify
from npss.rotations._poses import POSE

__all__ = [
    "ACTIONS",
    "COLUMNS",
    "FPS",
    "MOVES",
    "POSE",
    "SLICES_MS",
    "TEST_LENGTHS",
    "TEST_SUBJECT",
    "TRAIN_SUBJECTS",
    "VERIFIED",
    "InBetweening",
    "Normalization",
    "Verification",
    "Window",
    "chain_blocks",
    "frames_to_ms",
    "lafan1",
    "ms_to_frames",
    "normalization",
    "random_windows",
    "srnn_windows",
    "stretch_blocks",
    "verify",
    "window_blocks",
]
