"""The pitfalls that `npss.diagnose` looks for."""

from npss._analysis.pitfalls.layout import Degrees, JointAxis, Poses, SwappedAxes, TimeFirst
from npss._analysis.pitfalls.parts import Share
from npss._analysis.pitfalls.pitfall import NOTE, WARNING, Block, Pitfall
from npss._analysis.pitfalls.rotations import ComponentOrder, GimbalFlips, Hemisphere, SignFlips, Wraps
from npss._analysis.pitfalls.time import Constant, Context, Padding, Shift
from npss._analysis.pitfalls.weight import NoRealPower, Powerless, Weight

__all__ = ["NOTE", "PITFALLS", "WARNING", "Block"]

PITFALLS: tuple[type[Pitfall], ...] = (
    Wraps,
    GimbalFlips,
    SignFlips,
    Hemisphere,
    ComponentOrder,
    Constant,
    Shift,
    Context,
    Padding,
    Poses,
    Degrees,
    SwappedAxes,
    JointAxis,
    TimeFirst,
    Powerless,
    Weight,
    NoRealPower,
    Share,
)
