"""In-betweening: windows, baselines, and the three numbers of its tables, L2Q, L2P and NPSS, in one call.

From clips to a row of LaFAN1's benchmark::

    test = windows(test_clips)                      # centred and turned; train_statistics(train_clips, skeleton)
    part = transition(test, 30)                     # past, truth and target
    gt = forward(part.truth, skeleton)              # global quaternions and positions
    pred = forward(interpolation(part), skeleton)   # or your model's
    record = measure(gt, pred, stats=stats, protocol=lafan1, model="interpolation")
    print(table([record], published=True))

If you hold global quaternions and positions already, begin at `measure`; for one number, at `l2q` or `l2p`.

Quaternions are in the order w, x, y, z. `lafan1` is the protocol of the benchmark, `npss.protocol.lafan1`.
"""

from npss._metric.in_betweening import l2q
from npss.inbetweening._baselines import BASELINES, interpolation, zero_velocity
from npss.inbetweening._measure import measure
from npss.inbetweening._motion import Global, Local, forward
from npss.inbetweening._positions import Statistics, l2p
from npss.inbetweening._table import table
from npss.inbetweening._windows import Transition, train_statistics, transition, windows
from npss.protocol import lafan1

__all__ = [
    "BASELINES",
    "Global",
    "Local",
    "Statistics",
    "Transition",
    "forward",
    "interpolation",
    "l2p",
    "l2q",
    "lafan1",
    "measure",
    "table",
    "train_statistics",
    "transition",
    "windows",
    "zero_velocity",
]
