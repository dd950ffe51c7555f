"""Write and read signatures: one line that states every choice behind a number.

``npss|version:1|convention:paper|representation:euler|frames:100|fps:25|unwrap:off``

``|`` separates fields, ``:`` a field's name from its value. Numbers, booleans and unambiguous text are bare; other text
is quoted as JSON. Separators and ``%`` in text are escaped as ``%7C``, ``%3A``, ``%2B`` and ``%25``, so that a
signature always splits at its separators.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from npss._metric.convention import Convention, ConventionName, as_convention, convention_name
from npss._metric.fields import FIELDS, FIRST, Value, check_names, check_value
from npss._metric.metric import FIELD, NAME, Metric
from npss._metric.registry import METRICS, NPSS, metric_called
from npss.validation import each, is_integer, positive_integer

#: Increased only when a release changes numbers, as its changelog then says.
METRIC_VERSION = 1

_METRIC = rf"{NAME}(\+{NAME})*"
_INTEGER = r"-?[0-9]+"
_FLOAT = r"-?[0-9]+(\.[0-9]+)?(e[+-]?[0-9]+)?"
_PLAIN = r"[^\s\"](.*[^\s\"])?"
_ESCAPES = {"%": "%25", "|": "%7C", ":": "%3A", "+": "%2B"}


def signature(
    convention: ConventionName | Convention | Sequence[ConventionName | Convention] | None = "paper",
    *,
    metric: str = NPSS.name,
    version: int = METRIC_VERSION,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> str:
    """Return the line that states every choice behind a score.

    A pure function: equal values give equal text, in any order of the keywords.

    Parameters
    ----------
    convention : str, Convention, or a sequence of them; optional
        The convention of the score; several if one record holds several scores; None for a metric without
        conventions (the Euler error).
    metric : str, optional
        The metric, or several joined by ``+``: ``'npss'``, ``'euler_error'``, ``'mse'``, or one of your own.
    version : int, optional
        The version of the metric: it changes only when numbers change.
    extra : mapping of str to str, int, float or bool; optional
        Your own fields, whose names differ from known fields and arguments.
    **context : str, int, float or bool
        Known fields: ``representation`` (``'euler'``), ``frames`` (T), ``fps`` (frames per second), ``window``
        (``'0-1'``, in seconds), ``protocol`` (``'srnn-8'``), ``unwrap`` (``'off'``, ``'target'``, ``'seed'``), and
        others that docs/signatures.md lists.

    Returns
    -------
    str
        The signature; `parse_signature` reads it.

    Raises
    ------
    TypeError
        If a keyword is not a known field (the message names the nearest), `extra` has the name of a known field or an
        argument, or a value has the wrong type for its field.
    ValueError
        If a value is invalid for its field, NaN or infinite, a convention or metric is invalid, or a convention is
        given for a metric without conventions.

    Examples
    --------
    >>> import npss
    >>> npss.signature("released", fps=25, frames=100, representation="euler")
    'npss|version:1|convention:released|representation:euler|frames:100|fps:25'
    >>> npss.signature(npss.Convention(weight="uniform"), frames=100)
    'npss|version:1|convention:power=magnitude,bins=two-sided,distance=cdf,weight=uniform,zero=dc|frames:100'
    >>> npss.signature(frames=100, extra={"data": "v2"})
    'npss|version:1|convention:paper|frames:100|data:v2'
    """
    own_fields = check_names(signature, context, extra)
    if not isinstance(metric, str):
        raise TypeError(f"metric: expected text such as 'npss', got {metric!r}")
    if not re.fullmatch(_METRIC, metric):
        raise ValueError(f"metric: expected lower-case names joined by '+', got {metric!r}")
    parts = [metric, f"version:{positive_integer('version', version)}"]
    if convention is not None:
        if not any(name in METRICS and METRICS[name].has_conventions for name in metric.split("+")):
            raise ValueError(f"convention: {metric} has none; pass None")
        conventions = (
            [convention] if isinstance(convention, str | Convention) else each("convention", convention, "conventions")
        )
        if not conventions:
            raise ValueError("convention: expected at least one")
        parts.append("convention:" + "+".join(map(_write_convention, conventions)))
    for name in own_fields:
        if not re.fullmatch(FIELD, name):
            raise ValueError(f"extra: expected names of ASCII letters, digits and '_', got {name!r}")
    for name, value in context.items():
        check_value(name, value)
    values = {**context, **own_fields}
    ordered = [name for name in FIRST if name in values] + sorted(set(values) - set(FIRST))
    return "|".join([*parts, *(f"{name}:{_write(name, values[name])}" for name in ordered)])


def parse_signature(signature: str) -> dict[str, Any]:
    """Parse a signature.

    Parameters
    ----------
    signature : str
        A signature, as written by `signature`.

    Returns
    -------
    dict
        The arguments of `signature`, so that ``npss.signature(**npss.parse_signature(s)) == s``: ``metric``,
        ``version``, ``convention`` (a name, or a `Convention` if unnamed; a tuple of several; None if the metric has
        none), known fields by name, and other fields, if any, in ``extra``.

    Raises
    ------
    TypeError
        If it is not text.
    ValueError
        If it is not a signature. The message quotes the invalid part.

    Examples
    --------
    >>> import npss
    >>> npss.parse_signature("npss|version:1|convention:released|frames:100")
    {'metric': 'npss', 'version': 1, 'convention': 'released', 'frames': 100}
    """
    if not isinstance(signature, str):
        raise TypeError(f"signature: expected text, got {signature!r}")
    metric, *parts = signature.split("|")
    if not re.fullmatch(_METRIC, metric) or not parts:
        raise ValueError(f"signature: {signature!r} does not begin with a metric and its version")
    values: dict[str, Any] = {"metric": metric}
    extra: dict[str, Value] = {}
    for part in parts:
        name, colon, text = part.partition(":")
        if not colon or not re.fullmatch(FIELD, name) or name in (*values, *extra, "extra"):
            raise ValueError(f"signature: {part!r} is not a field 'name:value', or a duplicate, in {signature!r}")
        if name == "convention":
            values[name] = _read_convention(text)
        elif name == "version" or name in FIELDS:
            values[name] = _read(name, text)
        else:
            extra[name] = _read(name, text)
    if not is_integer(values.get("version")):
        raise ValueError(f"signature: expected a whole number as version in {signature!r}")
    for name in FIELDS.keys() & values.keys():
        try:
            check_value(name, values[name])
        except (TypeError, ValueError) as error:
            raise ValueError(f"signature: {error} in {signature!r}") from error
    values.setdefault("convention", None)
    return values | ({"extra": extra} if extra else {})


def stated_of(metric: str, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a parsed signature, perhaps of several metrics, that apply to one metric."""
    if values["metric"] == metric:
        return values
    entry = metric_called(metric)
    joined = values["metric"].split("+")
    others = {name for other in joined if other in METRICS for name in METRICS[other].fields}
    # A metric that is not one of the several states its own value of a field itself, unless it depends on the motion.
    own = {name for name, value in entry.fields.items() if value is None or metric in joined}
    own_values = {name: value for name, value in values.items() if name in own or name not in others}
    own_values = {"convention": None, **own_values, "metric": metric}
    if entry.takes != "angles":
        return {name: value for name, value in own_values.items() if name not in ("representation", "unwrap")}
    # In a record, jumps are removed only for NPSS.
    return own_values if "unwrap" in entry.fields else own_values | {"unwrap": "off"}


def stated_with(
    call: Callable[..., Any], context: Mapping[str, Value], extra: Mapping[str, Value] | None, **known: Value
) -> dict[str, Any]:
    """Return the fields of a signature: those passed to a function, and those that it fills in.

    Raises
    ------
    TypeError
        As for `check_names`; also if `context` states how the number is normalised, which `call` does not do.
    """
    for name in {"lengths", "normalize"} & set(context):
        raise TypeError(f"{name}: {call.__name__} does not normalise scores; leave it out")
    return {**known, **context, "extra": check_names(call, context, extra, known)}


def differences(own: str, other: str) -> list[str]:
    """Return the fields in which a signature differs from another one: ``fps must be 30, not 60``."""
    mine, theirs = _fields_of(own), _fields_of(other)
    found = []
    for name in dict.fromkeys([*theirs, *mine]):
        if name not in mine:
            found.append(f"{name} must be {theirs[name]}, but is not stated")
        elif name not in theirs:
            found.append(f"{name} must not be stated, but is {mine[name]}")
        elif mine[name] != theirs[name]:
            found.append(f"{name} must be {theirs[name]}, not {mine[name]}")
    return found


def higher_is_better(signature: str) -> bool:
    """Return whether a signature states that higher is better."""
    return bool(parse_signature(signature).get("better") == "higher")


def with_fields_of(metric: Metric, fields: Mapping[str, Any]) -> dict[str, Any]:
    """Add the fields of a metric to those of a signature.

    Raises
    ------
    TypeError
        If the signature has one of them already.
    """
    own = metric.stated()
    extra, own_extra = fields.get("extra", {}), own.pop("extra", {})
    for name in (*own, *own_extra):
        if name in fields or name in extra:
            raise TypeError(f"{name}: the signature states it anyway; leave it out")
    return {**fields, **own, "extra": {**own_extra, **extra}}


def _fields_of(signature: str) -> dict[str, str]:
    """Return the fields of a signature as text."""
    metric, *parts = signature.split("|")
    return {"metric": metric} | dict(part.split(":", 1) for part in parts)


def _write(name: str, value: object) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{name}: expected a finite number, got {value}")
        # 25.0 and 25 are the same number, so their signatures must be equal.
        return str(int(value)) if value.is_integer() else repr(value)
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected text, a number or a truth value, got {value!r}")
    bare = re.fullmatch(_PLAIN, value) and value.isprintable() and not _is_number_or_truth(value)
    text = value if bare else json.dumps(value)
    return "".join(_ESCAPES.get(letter, letter) for letter in text)


def _read(name: str, text: str) -> Value:
    if text in ("true", "false"):
        return text == "true"
    if re.fullmatch(_INTEGER, text):
        return int(text)
    if re.fullmatch(_FLOAT, text):
        return float(text)
    for letter, escape in reversed(_ESCAPES.items()):
        text = text.replace(escape, letter)
    if text.startswith('"'):
        try:
            value = json.loads(text)
        except json.JSONDecodeError as error:
            raise ValueError(f"signature: {name}: {text!r} is not quoted text ({error})") from error
        return str(value)
    return text


def _is_number_or_truth(text: str) -> bool:
    return text in ("true", "false") or bool(re.fullmatch(_FLOAT, text))  # _FLOAT matches integers, too


def _write_convention(convention: str | Convention) -> str:
    convention = as_convention(convention)
    choices = ",".join(f"{field.name}={getattr(convention, field.name)}" for field in fields(convention))
    return convention_name(convention) or choices


def _read_convention(text: str) -> str | Convention | tuple[str | Convention, ...]:
    conventions = tuple(map(_read_one_convention, text.split("+")))
    return conventions[0] if len(conventions) == 1 else conventions


def _read_one_convention(text: str) -> str | Convention:
    if "=" not in text:
        as_convention(text)
        return text
    pairs = [choice.partition("=") for choice in text.split(",")]
    choices = {name: choice for name, _, choice in pairs}
    if sorted(name for name, _, _ in pairs) != sorted(field.name for field in fields(Convention)):
        raise ValueError(f"convention: expected each choice of a Convention once, got {text!r}")
    convention = Convention(**choices)  # type: ignore[arg-type]  # checked by Convention
    return convention_name(convention) or convention
