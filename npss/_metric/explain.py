"""A signature in plain words, and whether its number may stand beside the published ones."""

from __future__ import annotations

from typing import Any

from npss._metric.convention import CONVENTIONS, Convention, as_convention, convention_name
from npss._metric.fields import FIELDS
from npss._metric.registry import EULER_ERROR, METRICS, NPSS
from npss._metric.signature import METRIC_VERSION, parse_signature, stated_of

_CHOICES = {
    ("power", "magnitude"): "the power of a frequency is the squared magnitude of its Fourier coefficient",
    ("power", "real"): "the power of a frequency is the square of the real part alone of its Fourier coefficient",
    ("bins", "two-sided"): "all T frequency bins count, positive and negative",
    ("bins", "one-sided"): "only the T//2 + 1 bins of a one-sided transform count, each once",
    ("distance", "cdf"): "the distance of two spectra is the L1 distance of their cumulative distributions, in bins",
    ("distance", "spectrum"): "the distance of two spectra is their L1 distance, without cumulating",
    ("weight", "power"): "a feature of a sequence counts by the total power of its ground truth",
    ("weight", "uniform"): "each feature of a sequence whose ground truth has power counts the same",
    ("zero", "dc"): "a prediction that is zero throughout is taken as a constant pose",
    ("zero", "empty"): "a prediction that is zero throughout has an empty distribution, as if 0/0 were 0",
}

_NAMED = {
    "paper": "what the text of the NPSS paper defines",
    "released": "what the code released with the NPSS paper computes, and published tables hold",
    "literal": "equations 7 to 9 of the NPSS paper as they are printed",
}

#: What a number must state to stand beside a published one: for each table, the fields and their values; None for a
#: field that may be left out. A field that no table knows makes the number another one.
_TABLES: dict[str, dict[str, dict[str, tuple[object, ...]]]] = {
    NPSS.name: {
        "tables 4 and 5 of the NPSS paper (Human3.6M)": {
            "convention": ("released",),
            "representation": ("euler",),
            "fps": (25,),
            "frames": (100,),
            "protocol": ("srnn-8", "srnn-8-late"),
            "unwrap": ("off",),
            "window": ("0-1", "1-2", "2-4", None),
        },
        "the LaFAN1 in-betweening tables": {
            "convention": ("released",),
            "representation": ("global-quaternions",),
            "fps": (30,),
            "frames": (5, 15, 30, 45),
            "protocol": ("lafan1",),
            "unwrap": ("off",),
            "quaternions": ("continuous",),
        },
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

_UNKNOWN = "strong evidence, not fact, since at which frame the paper's own rows are cut is not known; its code cuts"
#: How it is known what the tables hold, by metric and protocol.
_EVIDENCE = {
    (NPSS.name, "srnn-8"): f"{_UNKNOWN} one frame later (srnn-8-late)",
    (NPSS.name, "srnn-8-late"): f"{_UNKNOWN} here",
    (NPSS.name, "lafan1"): "fact, since the benchmark's own code computes this number",
    (EULER_ERROR.name, "srnn-8"): f"{_UNKNOWN} one frame later (srnn-8-late)",
    (EULER_ERROR.name, "srnn-8-late"): (
        f"{_UNKNOWN} here, but the zero-velocity row of table 6, copied from Martinez et al., is of srnn-8"
    ),
}


def explain(signature: str) -> str:
    """Say in plain words what a signature's number is, and whether it is comparable to the published tables.

    Parameters
    ----------
    signature : str
        As `npss.signature` writes and this library prints with every number.

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
    NPSS, convention 'paper': what the text of the NPSS paper defines.
    """
    values = parse_signature(signature)
    lines: list[str] = []
    for metric in values["metric"].split("+"):
        lines += _explain_metric(metric, values)
    stated = [
        f"  {field.says}: {field.means.get(values[name], values[name])}"
        for name, field in FIELDS.items()
        if name in values
    ]
    stated += [f"  {name}: {value}" for name, value in values.get("extra", {}).items()]
    lines += ["Stated with it:", *stated] if stated else ["Nothing else is stated."]
    version = values["version"]
    same = "the one this library computes" if version == METRIC_VERSION else f"this library computes {METRIC_VERSION}"
    lines.append(f"Version of the metric: {version}, {same}.")
    for metric in values["metric"].split("+"):
        for table, needed in _TABLES.get(metric, {}).items():
            lines.append(_compare(stated_of(metric, values), table, needed))
    return "\n".join(lines)


def _explain_metric(name: str, values: dict[str, Any]) -> list[str]:
    metric = METRICS.get(name)
    if metric is None:
        return [f"{name}: not a metric of this library, nor registered."]
    if metric.has_conventions:
        return [line for one in _conventions(values) for line in _explain_convention(metric.heading, one)]
    return [f"{metric.heading}: {metric.says}."]


def _explain_convention(heading: str, convention: Convention) -> list[str]:
    name = convention_name(convention)
    head = f"convention '{name}': {_NAMED[name]}." if name else "a convention of its own."
    choices = [f"  - {text}" for (field, choice), text in _CHOICES.items() if getattr(convention, field) == choice]
    return [f"{heading}, {head}", *choices]


def _conventions(values: dict[str, Any]) -> list[Convention]:
    stated = values["convention"]
    several = stated if isinstance(stated, tuple) else () if stated is None else (stated,)
    return [as_convention(one) for one in several]


def _compare(values: dict[str, Any], table: str, needed: dict[str, tuple[object, ...]]) -> str:
    known = {"metric", "version", "extra", *needed}
    missing = [name for name, allowed in needed.items() if name not in values and None not in allowed]
    missing += [f"what {name} means" for name in values if name not in known and values[name] is not None]
    missing += [f"what {name} means" for name in values.get("extra", ())]
    differing: list[str] = []
    subject = METRICS[values["metric"]].heading
    for name, allowed in needed.items():
        if name == "convention":
            # A line that states several conventions belongs to several scores: that of the table's own is meant.
            if CONVENTIONS["released"] not in _conventions(values):
                differing.append("the convention must be released")
            elif len(_conventions(values)) > 1:
                subject += " released (of the several scores, that one alone)"
        elif name in values and values[name] not in allowed:
            wanted = " or ".join(str(value) for value in allowed if value is not None)
            differing.append(f"{name} must be {wanted}, not {values[name]}")
    if values["version"] != METRIC_VERSION:
        differing.append(f"version must be {METRIC_VERSION}, not {values['version']}")
    if differing:
        return f"{subject}: not comparable with {table}: {'; '.join(differing)}."
    if missing:
        unknown = ", ".join(missing)
        return f"{subject}: whether it is comparable with {table} cannot be told: not stated: {unknown}."
    return f"{subject}: comparable with {table}: {_EVIDENCE[values['metric'], values['protocol']]}."
