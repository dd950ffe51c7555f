"""The fields of signatures: what each says, what it may hold, and in which order they are printed."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from npss.validation import is_integer, one_of, positive_number

Value = str | int | float | bool


class Field(NamedTuple):
    """What a field of a signature says, and what it may hold."""

    says: str
    #: 'text'; 'one of', and then nothing but the texts of `means`; 'whole number' (0 or more), 'number' (positive); or
    #: 'any'.
    kind: str = "text"
    means: Mapping[str, str] = MappingProxyType({})


#: Arguments of `npss.signature` that no field can be called.
ARGUMENTS = ("metric", "version", "convention", "extra")

#: Those that are printed first, in this order; the others, and fields of one's own, follow in alphabetical order.
FIRST = ("representation", "frames", "fps", "window", "protocol", "unwrap")

#: All fields that are known, in the order in which they are printed. The table of docs/signatures.md is this one.
FIELDS: Mapping[str, Field] = MappingProxyType(
    {
        "representation": Field(
            "representation of the motion",
            means={
                "euler": "Euler angles in the Human3.6M convention, columns 0-5 zeroed",
                "global-quaternions": "unit quaternions of global rotations, as LaFAN1's benchmark has them",
            },
        ),
        "frames": Field("predicted frames (T)", "whole number"),
        "fps": Field("frames per second", "number"),
        "window": Field("time window scored, in seconds"),
        "protocol": Field(
            "test windows",
            means={
                "srnn-8": "the eight windows per action of subject 5 (SRNN seeds)",
                "srnn-8-late": "the eight windows per action of subject 5, one frame later (the NPSS paper's code)",
                "random-256": "256 random windows per action of subject 5 (Mao et al.)",
                "lafan1": "the 2232 windows of subject 5 of LaFAN1",
            },
        ),
        "unwrap": Field(
            "jumps of 2 pi removed",
            "one of",
            {
                "off": "no",
                "target": "yes, over the scored frames alone",
                "seed": "yes, from the first seed frame on",
                "continuous": "yes, and those of pi at gimbal lock (npss.rotations.continuous_euler)",
            },
        ),
        "actions": Field("actions, or how many", "any"),
        "at_ms": Field("time of the Euler error, in milliseconds", "number"),
        "average": Field(
            "Euler error", "one of", {"at": "at the stated times", "up-to": "averaged up to the stated times"}
        ),
        "better": Field("which numbers are better", "one of", {"lower": "lower ones", "higher": "higher ones"}),
        "clip": Field("clip that others are compared with"),
        "clips": Field("clips, or how many", "any"),
        "columns": Field(
            "features that count in the Euler error",
            "one of",
            {
                "gt": "those that move in the ground truth (standard deviation > 1e-4 over the frames)",
                "pred": "those that move in the prediction",
                "all": "all",
            },
        ),
        "corruption": Field("what was done to the motion"),
        "draws": Field("predictions whose mean it is", "whole number"),
        "manifold": Field("manifold in which distances are taken"),
        "matches": Field("clips that are to be found"),
        "model": Field("what the motion was projected by"),
        "motion": Field("digest of the motion"),
        "pairs": Field("pairs of windows", "whole number"),
        "quaternions": Field(
            "signs of quaternions",
            "one of",
            {
                "continuous": "in each frame those nearer to the frame before (npss.rotations.continuous)",
                "w>=0": "none has a negative w",
            },
        ),
        "queries": Field("clips that were looked for", "whole number"),
        "samples": Field("motions that were sampled", "whole number"),
        "seed": Field("seed of what is random", "whole number"),
        "shares": Field("shares of the second motion"),
        "source": Field("where the motion is from"),
        "statistics": Field("version of the rules for intervals and p-values", "whole number"),
        "still": Field("sequences that stand still, which the Euler error leaves out", "whole number"),
        "unlabelled": Field("clips without an action's name", "whole number"),
    }
)


def check_value(name: str, value: object) -> None:
    """Raise a TypeError or ValueError unless a known field may hold that value."""
    field = FIELDS[name]
    if field.kind == "one of":
        one_of(name, value, tuple(field.means))
    elif field.kind == "text" and not isinstance(value, str):
        raise TypeError(f"{name}: expected text, got {value!r}")
    elif field.kind == "number":
        positive_number(name, value)
    elif field.kind == "whole number" and not (is_integer(value) and value >= 0):
        error = ValueError if is_integer(value) else TypeError
        raise error(f"{name}: expected a whole number, 0 or more, got {value!r}")


def check_names(
    call: Callable[..., Any], context: Collection[str], extra: object, known: Collection[str] = ()
) -> dict[str, Value]:
    """Return the fields of one's own that were passed to a function, after making sure of the names of all fields.

    Parameters
    ----------
    call : callable
        The function, whose other arguments have names of their own.
    context : collection of str
        Names of fields that were passed as keywords.
    extra : mapping of str to value, optional
        What was passed as ``extra``.
    known : collection of str, optional
        Fields that the function states itself.

    Raises
    ------
    TypeError
        If a keyword is no known field: names the nearest argument or field. If the function states it itself. If
        `extra` is no mapping, or has a name that a known field or an argument has.
    """
    for name in ("metric", "version", *known):
        if name in context:
            raise TypeError(f"{name}: the signature states it anyway; leave it out")
    parameters = inspect.signature(call).parameters.values()
    arguments = [one.name for one in parameters if one.kind is not inspect.Parameter.VAR_KEYWORD]
    for name in context:
        if name not in FIELDS:
            near = difflib.get_close_matches(name, [*arguments, *FIELDS], n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"one of your own goes into extra={{{name!r}: ...}}"
            raise TypeError(f"{name}: not an argument nor a signature field; {hint}")
    if extra is None:
        return {}
    if not isinstance(extra, Mapping):
        raise TypeError(f"extra: expected a mapping of names to values, got {extra!r}")
    for name in extra:
        if not isinstance(name, str):
            raise TypeError(f"extra: expected names, got {name!r}")
        if name in FIELDS:
            raise TypeError(f"extra: {name!r} is a known field: pass {name}=...")
        if name in (*arguments, *ARGUMENTS):
            raise TypeError(f"extra: {name!r} is the name of an argument; call the field something else")
    return dict(extra)
