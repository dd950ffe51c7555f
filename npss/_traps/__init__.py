"""The traps that `npss.diagnose` looks for."""

from npss._traps._layout import Degrees, JointAxis, Poses, SwappedAxes
from npss._traps._rotations import GimbalFlips, Hemisphere, SignFlips, Wraps
from npss._traps._time import Constant, Context, Padding, Shift
from npss._traps._trap import NOTE, WARNING, Block, Trap
from npss._traps._weight import NoRealPower, Powerless, Weight

__all__ = ["NOTE", "TRAPS", "WARNING", "Block"]

TRAPS: tuple[type[Trap], ...] = (
    Wraps,
    GimbalFlips,
    SignFlips,
    Hemisphere,
    Constant,
    Shift,
    Context,
    Padding,
    Poses,
    Degrees,
    SwappedAxes,
    JointAxis,
    Powerless,
    Weight,
    NoRealPower,
)
