"""Explain a signature in plain words, and whether its number is comparable to published ones."""

from __future__ import annotations

from typing import Any

from npss._metric.convention import CONVENTIONS, Convention, as_convention, convention_name
from npss._metric.fields import FIELDS
from npss._metric.registry import EULER_ERROR, L2P, L2Q, METRICS, NPSS
from npss._metric.signature import METRIC_VERSION, parse_signature, stated_of

_CHOICES = {
    ("power", "magnitude"): "the power of a frequency is the squared magnitude of its Fourier coefficient",
    ("power", "real"): "the power of a frequency is the square of the real part of its Fourier coefficient",
    ("bins", "two-sided"): "all T frequency bins count, positive and negative",
    ("bins", "one-sided"): "only the T//2 + 1 bins of a one-sided transform count, each once",
    ("distance", "cdf"): "the distance of two spectra is the L1 distance of their cumulative distributions, in bins",
    ("distance", "spectrum"): "the distance of two spectra is their L1 distance, without cumulating",
    ("weight", "power"): "a feature of a sequence is weighted by the total power of its ground truth",
    ("weight", "uniform"): "all features of a sequence whose ground truth has power have the same weight",
    ("zero", "dc"): "a prediction of zeros counts as a constant pose",
    ("zero", "empty"): "a prediction of zeros has an empty distribution, as if 0/0 were 0",
}

_NAMED = {
    "paper": "the definition in the text of the NPSS paper",
    "released": "the computation of the NPSS paper's released code, used in published tables",
    "literal": "equations 7 to 9 of the NPSS paper as printed",
}

_LAFAN1 = "the LaFAN1 in-betweening tables"
_TRANSITIONS = {"fps": (30,), "frames": (5, 15, 30, 45), "protocol": ("lafan1",), "unwrap": ("off",)}
#: The fields and values that make a number comparable to each published table; None: the field may be missing. A field
#: unknown to the table makes the number incomparable.
_TABLES: dict[str, dict[str, dict[str, tuple[object, ...]]]] = {
    NPSS.name: {
        "tables 4 and 5 of the NPSS paper (Human3.6M)": {
            "convention": ("released",),
            "representation": ("euler",),
            "fps": (25,),
            "frames": (100,),
            "protocol": ("srnn-8", "srnn-8-late"),
            "unwrap": ("off",),
            "normalize": (None,),
            "window": ("0-1", "1-2", "2-4", None),
        },
        _LAFAN1: {
            "convention": ("released",),
            "representation": ("global-quaternions",),
            **_TRANSITIONS,
            "normalize": (None,),
            "quaternions": ("continuous",),
        },
    },
    L2Q.name: {
        _LAFAN1: {
            "representation": ("global-quaternions",),
            **_TRANSITIONS,
            "quaternions": ("continuous",),
            "hemisphere": ("anchored",),
            "norm": ("pose",),
        }
    },
    L2P.name: {
        _LAFAN1: {
            "representation": ("global-positions",),
            **_TRANSITIONS,
            "norm": ("pose",),
            "positions": ("standardised",),
        }
    },
    EULER_ERROR.name: {
        "tables 6 and 7 of the NPSS paper (Human3.6M)": {
            "representation": ("euler",),
            "fps": (25,),
            "frames": (100,),
            "protocol": ("srnn-8", "srnn-8-late"),
            "unwrap": ("off",),
            "columns": ("gt",),
            "average": ("at",),
        },
    },
}

_UNKNOWN = "strong evidence, not fact: the first frame behind the paper's rows is unknown; its code cuts"
#: The evidence for the content of the tables, by metric and protocol.
_EVIDENCE = {
    (NPSS.name, "srnn-8"): f"{_UNKNOWN} one frame later (srnn-8-late)",
    (NPSS.name, "srnn-8-late"): f"{_UNKNOWN} here",
    **{(metric.name, "lafan1"): "fact: the benchmark's own code computes this number" for metric in (NPSS, L2Q, L2P)},
    (EULER_ERROR.name, "srnn-8"): f"{_UNKNOWN} one frame later (srnn-8-late)",
    (EULER_ERROR.name, "srnn-8-late"): (
        f"{_UNKNOWN} here, but the zero-velocity row of table 6, copied from Martinez et al., uses srnn-8"
    ),
}


def explain(signature: str) -> str:
    """Explain a signature in plain words, and say whether its number is comparable to published tables.

    Parameters
    ----------
    signature : str
        A signature, as `npss.signature` writes it.

    Returns
    -------
    str
        Several lines.

    Raises
    ------
    TypeError, ValueError
        If it is not a signature.

    Examples
    --------
    >>> import npss
    >>> print(npss.explain("npss|version:1|convention:paper|frames:100").splitlines()[0])
    NPSS, convention 'paper': the definition in the text of the NPSS paper.
    """
    values = parse_signature(signature)
    lines: list[str] = []
    for metric in values["metric"].split("+"):
        lines += _explain_metric(metric, values)
    fields = [
        f"  {field.says}: {field.means.get(values[name], values[name])}"
        for name, field in FIELDS.items()
        if name in values
    ]
    fields += [f"  {name}: {value}" for name, value in values.get("extra", {}).items()]
    lines += ["Other fields:", *fields] if fields else ["No other fields."]
    version = values["version"]
    current = ", the current version" if version == METRIC_VERSION else f"; the current version is {METRIC_VERSION}"
    lines.append(f"Version: {version}{current}.")
    for metric in values["metric"].split("+"):
        for table, required in _TABLES.get(metric, {}).items():
            lines.append(_compare(stated_of(metric, values), table, required))
    return "\n".join(lines)


def _explain_metric(name: str, values: dict[str, Any]) -> list[str]:
    metric = METRICS.get(name)
    if metric is None:
        return [f"{name}: unknown metric, neither built in nor registered."]
    if metric.has_conventions:
        return [line for convention in _conventions(values) for line in _explain_convention(metric.heading, convention)]
    return [f"{metric.heading}: {metric.says}."]


def _explain_convention(heading: str, convention: Convention) -> list[str]:
    name = convention_name(convention)
    title = f"convention '{name}': {_NAMED[name]}." if name else "a custom convention."
    choices = [f"  - {text}" for (field, choice), text in _CHOICES.items() if getattr(convention, field) == choice]
    return [f"{heading}, {title}", *choices]


def _conventions(values: dict[str, Any]) -> list[Convention]:
    convention = values["convention"]
    conventions = convention if isinstance(convention, tuple) else () if convention is None else (convention,)
    return [as_convention(convention) for convention in conventions]


def _compare(values: dict[str, Any], table: str, required: dict[str, tuple[object, ...]]) -> str:
    expected = {"metric", "version", "extra", "verified", *required}
    missing = [name for name, allowed in required.items() if name not in values and None not in allowed]
    missing += [f"the meaning of {name}" for name in values if name not in expected and values[name] is not None]
    missing += [f"the meaning of {name}" for name in values.get("extra", ())]
    differing: list[str] = []
    subject = METRICS[values["metric"]].heading
    for name, allowed in required.items():
        if name == "convention":
            # A signature with several conventions belongs to several scores; only the table's own counts.
            if CONVENTIONS["released"] not in _conventions(values):
                differing.append("the convention must be released")
            elif len(_conventions(values)) > 1:
                subject += " released (only this one of the scores)"
        elif name in values and values[name] not in allowed:
            choices = " or ".join(str(value) for value in allowed if value is not None) or "left out"
            differing.append(f"{name} must be {choices}, not {values[name]}")
    if values.get("verified") == "no":
        differing.append(f"the ground truth is not that of {values.get('protocol', 'the protocol')}")
    if values["version"] != METRIC_VERSION:
        differing.append(f"version must be {METRIC_VERSION}, not {values['version']}")
    if differing:
        return f"{subject}: not comparable with {table}: {'; '.join(differing)}."
    if missing:
        return f"{subject}: may or may not be comparable with {table}; not stated: {', '.join(missing)}."
    return f"{subject}: comparable with {table}: {_EVIDENCE[values['metric'], values['protocol']]}."
