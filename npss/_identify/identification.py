"""What `npss.identify` returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from npss._metric.convention import Convention, ConventionName


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Which NPSS a function computes; printed, it says so in words.

    Attributes
    ----------
    convention : str or None
        The named convention that the function computes; None if it computes another function, or if only `order` can
        tell.
    nearest : str or None
        The named convention that differs in the fewest choices; None if the function is no NPSS.
    differences : dict of str to str
        The choices that differ from `nearest`, in words, by axis: ``'power'``, ``'bins'``, ``'distance'``,
        ``'weight'``, ``'aggregation'``, ``'factor'``, ``'mean'``, ``'axis'``; ``'scale'`` or ``'motion'`` if motion of
        another scale, or unusual motion, gets another score; ``'precision'`` if the function is too coarse to tell;
        ``'order'`` if that of the arguments is unknown. Empty for a named convention.
    choices : dict of str to str
        All choices, in words, by axis.
    no_power : str
        What the function does where a feature has no power. It does not change the name. Empty if it was not probed.
    order : str or None
        The order of the arguments: ``'gt,pred'`` or ``'pred,gt'``; None if it is unknown, or makes no difference.
    custom : Convention or None
        The `npss.Convention` of these choices; None if they are not all among its fields.
    call : str or None
        The expression of ``gt`` and ``pred`` with which this library reproduces the function; None if there is none.
    example : tuple of float or None
        The function's value of one example, and the score by `nearest`.
    readings : tuple of Identification
        If the order of the arguments decides: what the function computes if it is ``(gt, pred)``, and if it is ``(pred,
        gt)``.
    text : str
        All of that in words.
    """

    convention: ConventionName | None
    nearest: ConventionName | None
    differences: Mapping[str, str] = field(default_factory=dict)
    choices: Mapping[str, str] = field(default_factory=dict)
    no_power: str = ""
    order: str | None = None
    custom: Convention | None = None
    call: str | None = None
    example: tuple[float, float] | None = None
    readings: tuple[Identification, ...] = ()
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        """Say it in words."""
        return self.text
