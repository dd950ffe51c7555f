"""The fields of signatures: meanings, allowed values and order."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from npss.validation import is_integer, one_of, positive_number

Value = str | int | float | bool


class Field(NamedTuple):
    """The meaning of a signature field and its allowed values."""

    says: str
    #: 'text'; 'one of' the keys of `means`; 'whole number' (0 or more, or such a key); 'number' (positive); or 'any'.
    kind: str = "text"
    means: Mapping[str, str] = MappingProxyType({})


#: Arguments of `npss.signature`, which are not valid field names.
ARGUMENTS = ("metric", "version", "convention", "extra")

#: The fields printed first, in this order. Others, and user-defined fields, follow in alphabetical order.
FIRST = ("representation", "frames", "fps", "window", "protocol", "unwrap")

#: All known fields, in the order of printing. The table of docs/signatures.md lists the same.
FIELDS: Mapping[str, Field] = MappingProxyType(
    {
        "representation": Field(
            "representation of the motion",
            means={
                "euler": "Euler angles in the Human3.6M convention, columns 0-5 zeroed",
                "matrix": "rotation matrices, row by row",
                "global-quaternions": "unit quaternions of global rotations, as in LaFAN1's benchmark",
                "global-positions": "positions of joints in the frame of the window, as in LaFAN1's benchmark",
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
                "target": "yes, over the scored frames only",
                "seed": "yes, starting at the first seed frame",
                "continuous": "yes, and jumps of pi at gimbal lock (npss.rotations.continuous_euler)",
            },
        ),
        "actions": Field("actions, or how many", "any"),
        "at_ms": Field("time of the error, in milliseconds", "number"),
        "average": Field(
            "errors",
            "one of",
            {
                "at": "at the given times",
                "up-to": "averaged up to the given times",
                "sum": "summed up to the given times",
            },
        ),
        "better": Field("better direction", "one of", {"lower": "lower", "higher": "higher"}),
        "clip": Field("clip that others are compared with"),
        "clips": Field("clips, or how many", "any"),
        "columns": Field(
            "features compared in the Euler error",
            "one of",
            {
                "gt": "those that move in the ground truth (standard deviation > 1e-4 over the frames)",
                "pred": "those that move in the prediction",
                "set": "those that move in the ground truth of the whole set",
                "all": "all",
            },
        ),
        "corruption": Field("corruption of the motion"),
        "draws": Field("predictions of each sequence", "whole number"),
        "hemisphere": Field(
            "signs of quaternions in L2Q",
            "one of",
            {
                "anchored": "continuous in time; the prediction begins in the hemisphere of the ground truth",
                "nearest": "the nearer one, for every joint and frame",
                "given": "as they are",
            },
        ),
        "lengths": Field("predicted frames, if sequences differ: the fewest and the most"),
        "manifold": Field("manifold in which distances are measured"),
        "matches": Field("clips to retrieve"),
        "model": Field("model that projects the motion"),
        "motion": Field("digest of the motion"),
        "norm": Field(
            "norm of the differences in L2Q and L2P",
            "one of",
            {
                "pose": "over all joints and components of a frame, averaged over frames",
                "joint": "of each joint, averaged over joints and frames",
                "rmse": "the root of the mean square over frames, joints and components of a sequence",
            },
        ),
        "normalize": Field(
            "unit of the score",
            "one of",
            {"bound": "its largest value, T / 2 or 2; the weight is the power / T^2, if it is the power"},
        ),
        "pairs": Field("pairs of windows", "whole number"),
        "positions": Field(
            "positions in L2P",
            "one of",
            {
                "standardised": "each coordinate by its mean and standard deviation over the training windows",
                "m": "in metres",
                "cm": "in centimetres",
                "mm": "in millimetres",
            },
        ),
        "quaternions": Field(
            "signs of quaternions",
            "one of",
            {
                "continuous": "nearest to the frame before (npss.rotations.continuous)",
                "w>=0": "no w is negative (taken as w, x, y, z)",
            },
        ),
        "queries": Field("query clips", "whole number"),
        "reduction": Field(
            "draws",
            "one of",
            {
                "mean": "the mean of their scores",
                "best": "of each sequence, the one with the lowest score",
                "worst": "of each sequence, the one with the highest score",
            },
        ),
        "samples": Field("sampled motions", "whole number"),
        "seed": Field("seed of the random generator", "whole number"),
        "shares": Field("shares of the second motion"),
        "source": Field("source of the motion"),
        "statistics": Field("version of the rules for intervals and p-values", "whole number"),
        "still": Field(
            "still sequences, excluded from the Euler error",
            "whole number",
            {"zero": "none, their error counts as zero"},
        ),
        "unlabelled": Field("clips without an action label", "whole number"),
        "verified": Field(
            "ground truth compared to the protocol's", "one of", {"no": "it is another (npss.protocol.verify)"}
        ),
    }
)


def check_value(name: str, value: object) -> None:
    """Raise a TypeError or ValueError unless the value is valid for a known field."""
    field = FIELDS[name]
    if field.kind == "one of":
        one_of(name, value, tuple(field.means))
    elif field.kind == "text" and not isinstance(value, str):
        raise TypeError(f"{name}: expected text, got {value!r}")
    elif field.kind == "number":
        positive_number(name, value)
    elif field.kind == "whole number" and not (is_integer(value) and value >= 0) and value not in field.means:
        error = ValueError if is_integer(value) else TypeError
        words = "".join(f" or {word!r}" for word in field.means)
        raise error(f"{name}: expected a whole number, 0 or more{words}, got {value!r}")


def check_names(
    call: Callable[..., Any], context: Collection[str], extra: object, known: Collection[str] = ()
) -> dict[str, Value]:
    """Check the names of the fields passed to a function, and return the user-defined ones.

    Parameters
    ----------
    call : callable
        The function.
    context : collection of str
        Names of the fields passed as keywords.
    extra : mapping of str to value, optional
        The value of the argument ``extra``.
    known : collection of str, optional
        Fields that the function fills in.

    Raises
    ------
    TypeError
        If a keyword is not a known field (the message names the nearest argument or field), or is one that the
        function fills in; if `extra` is not a mapping, or has the name of a known field or an argument.
    """
    for name in ("metric", "version", *known):
        if name in context:
            raise TypeError(f"{name}: the signature states it anyway; leave it out")
    parameters = inspect.signature(call).parameters.values()
    arguments = [parameter.name for parameter in parameters if parameter.kind is not inspect.Parameter.VAR_KEYWORD]
    for name in context:
        if name not in FIELDS:
            near = difflib.get_close_matches(name, [*arguments, *FIELDS], n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"pass your own fields as extra={{{name!r}: ...}}"
            raise TypeError(f"{name}: neither an argument nor a signature field; {hint}")
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
            raise TypeError(f"extra: {name!r} is the name of an argument; rename the field")
    return dict(extra)
