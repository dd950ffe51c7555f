"""Conventions: the choices behind a score, and the three named sets of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Literal, cast, get_args, get_type_hints

from npss.validation import one_of

#: The names of the named conventions.
ConventionName = Literal["paper", "released", "literal"]


@dataclass(frozen=True, kw_only=True)
class Convention:
    """The choices that define an NPSS; equal conventions give equal numbers.

    F is the discrete Fourier transform of a feature over the T frames of a sequence.

    Parameters
    ----------
    power : {'magnitude', 'real'}
        The power of a bin: ``abs(F)**2``, or ``F.real**2`` (the released code, which assigns complex coefficients to
        a real array).
    bins : {'two-sided', 'one-sided'}
        All T bins, or the first ``T//2 + 1`` as from ``rfft``, none doubled.
    distance : {'cdf', 'spectrum'}
        L1 distance of the cumulative distributions over the bins (the earth mover's distance, in bins), or of the
        normalised spectra.
    weight : {'power', 'uniform'}
        The weight of a feature of a sequence in the mean: the total power of its ground truth, or 1 where that is not
        zero.
    zero : {'dc', 'empty'}
        The spectrum of a prediction without power: all mass in the DC bin, the limit of a vanishing constant; or a
        distribution of zeros, from ``0/0 -> 0``.

    Raises
    ------
    TypeError, ValueError
        If a field is not one of its choices.

    Notes
    -----
    The documentation explains the three named conventions under *Conventions*.

    ============== =========== =========== ========== ========= =======
    name           power       bins        distance   weight    zero
    ============== =========== =========== ========== ========= =======
    ``'paper'``    magnitude   two-sided   cdf        power     dc
    ``'released'`` real        two-sided   cdf        power     empty
    ``'literal'``  magnitude   two-sided   spectrum   uniform   dc
    ============== =========== =========== ========== ========= =======

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5,
    equations 7 to 9.

    Examples
    --------
    >>> import npss
    >>> npss.Convention(weight="uniform")
    Convention(power='magnitude', bins='two-sided', distance='cdf', weight='uniform', zero='dc')
    >>> npss.Convention() == npss.CONVENTIONS["paper"]
    True
    """

    power: Literal["magnitude", "real"] = "magnitude"
    bins: Literal["two-sided", "one-sided"] = "two-sided"
    distance: Literal["cdf", "spectrum"] = "cdf"
    weight: Literal["power", "uniform"] = "power"
    zero: Literal["dc", "empty"] = "dc"

    def __post_init__(self) -> None:
        for field in fields(self):
            one_of(field.name, getattr(self, field.name), CHOICES[field.name])


#: The choices of each field.
CHOICES: dict[str, tuple[str, ...]] = {name: get_args(kind) for name, kind in get_type_hints(Convention).items()}
#: The named conventions: ``paper`` (the text of the paper, default), ``released`` (its code, used in published tables)
#: and ``literal`` (its equations 7 to 9 as printed).
CONVENTIONS: Mapping[ConventionName, Convention] = MappingProxyType(
    {
        "paper": Convention(),
        "released": Convention(power="real", zero="empty"),
        "literal": Convention(distance="spectrum", weight="uniform"),
    }
)


def as_convention(convention: str | Convention) -> Convention:
    """Return the convention, looked up if it is a name.

    Raises
    ------
    TypeError
        If it is neither a name nor a `Convention`.
    ValueError
        If no convention has this name.
    """
    if isinstance(convention, Convention):
        return convention
    one_of("convention", convention, tuple(CONVENTIONS))
    return cast(Mapping[str, Convention], CONVENTIONS)[convention]


def convention_name(convention: Convention) -> ConventionName | None:
    """Return the name of a convention, or None if it has none."""
    return next((name for name, named in CONVENTIONS.items() if named == convention), None)
