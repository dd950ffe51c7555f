"""Tables of all applications, metrics and methods."""

from __future__ import annotations

from collections.abc import Sequence

from npss import parse_signature, signature
from npss.console import markdown_text, table
from npss.records import Record
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.restore import RESTORATIONS

#: The heading of each metric, and whether lower is better; None where neither is.
METRICS = {
    "lost_error": ("error of lost joints (body heights)", True),
    "joint_error": ("joint error (body heights)", True),
    "bone_error": ("bone error (share)", True),
    "npss": ("NPSS paper", True),
    "foot_speed": ("foot speed (body heights/s)", None),
    "joint_speed": ("joint speed (body heights/s)", None),
    "ratio": ("ratio to the best simple baseline", True),
    "jerk": ("jerk (body heights/s³)", None),
    "snaps": ("snaps (share)", None),
    "nearest_npss": ("NPSS to nearest", True),
    "precision": ("precision", False),
    "recall": ("recall", False),
    "idle": ("idle units", None),
    "saturated": ("saturated values", None),
    "deviation": ("mean deviation", None),
    "auc": ("AUC", False),
    "map": ("mAP", False),
    "nearest": ("nearest", False),
    "map_of_actions": ("mAP of actions", False),
    "nearest_of_actions": ("nearest of actions", False),
}


def text(records: Sequence[Record], *, markdown: bool = False) -> str:
    """Format records: a table for each application, with signatures below; * marks the best, except the input.

    In parentheses are the ends of the 95 % interval of the difference from the method named below.
    """
    groups: dict[str, list[Record]] = {}
    for record in records:
        groups.setdefault(_heading(record), []).append(record)
    parts = []
    for heading, group in groups.items():
        parts.append(f"### {markdown_text(heading)}" if markdown else heading)
        parts.append(_table(group, markdown=markdown))
        if against := dict.fromkeys(record["against"] for record in group if "against" in record):
            parts.append(f"in parentheses: 95 % interval of the difference from {', '.join(against)}")
        parts.append("\n".join(f"    {line}" for line in _signatures(group)))
    return "\n\n".join(parts)


def listing(records: Sequence[Record], *, markdown: bool = False) -> str:
    """Format records in a table with a row each, for distances of single clips."""
    columns = [name for name in records[0] if name not in ("application", "signature", "index")]
    escaped = markdown_text if markdown else str
    cells = [[escaped(_written(record[name])) for name in columns] for record in records]
    align = "".join("r" if name in ("value", "rank") else "l" for name in columns)
    lines = [f"    {line}" for line in _signatures(records)]
    return "\n".join([table(columns, cells, align, markdown=markdown), "", *lines])


def _heading(record: Record) -> str:
    """Return the heading of the table that a record belongs to."""
    application, fields = record["application"], parse_signature(record["signature"])
    if application in ("distance", "nearest"):
        heading = f"{application}: {fields['clips']} clips of {fields['source']}, {fields['actions']} actions"
        return (
            heading
            if application == "distance"
            else f"{heading}; {fields['queries']} queries, matches: {fields['matches']}"
        )
    if record["metric"] == "ratio":
        reference = fields["extra"]["reference"]
        return f"{application}: {fields['corruption']}; error of lost joints, relative to {reference}, by subject"
    if application.partition(" ")[0] in RESTORATIONS:
        return f"{application}: {fields['corruption']}"
    details = {
        "interpolate": "pairs of windows",
        "sample": "codes drawn at random",
        "filters": "hidden units",
    }
    return f"{application}: {details[application]}"


def _ratios(records: Sequence[Record], *, markdown: bool) -> str:
    """Format ratios with their intervals: a column for each subject."""
    escaped = markdown_text if markdown else str
    subjects = {record["subject"]: f"{record['subject']} ({record['clips']} clips)" for record in records}
    methods = list(dict.fromkeys(record["method"] for record in records))
    cells = {
        (record["method"], record["subject"]): f"{record['value']:.3f} [{record['low']:.3f}, {record['high']:.3f}]"
        for record in records
    }
    rows = [[escaped(method), *(cells.get((method, subject), "") for subject in subjects)] for method in methods]
    return table(["method", *subjects.values()], rows, "l" + "r" * len(subjects), markdown=markdown)


def _table(records: Sequence[Record], *, markdown: bool) -> str:
    if records[0]["metric"] == "ratio":
        return _ratios(records, markdown=markdown)
    metrics = list(dict.fromkeys(record["metric"] for record in records))
    methods = list(dict.fromkeys(record["method"] for record in records))
    values = {(record["method"], record["metric"]): record["value"] for record in records}
    ends = {(r["method"], r["metric"]): f" ({r['low']:+.4f} to {r['high']:+.4f})" for r in records if "low" in r}
    best = {}
    for metric in metrics:
        lower = METRICS[metric][1]
        if lower is not None:
            scores = [values[method, metric] for method in methods if method != "input" and (method, metric) in values]
            best[metric] = (min if lower else max)(scores, default=None)
    escaped = markdown_text if markdown else str
    rows = [
        [
            escaped(method),
            *(
                _cell(values.get((method, metric)), best.get(metric)) + ends.get((method, metric), "")
                for metric in metrics
            ),
        ]
        for method in methods
    ]
    names = [METRICS[metric][0] for metric in metrics]
    return table(["method", *names], rows, "l" + "r" * len(metrics), markdown=markdown)


def _written(value: object) -> str:
    return f"{value:.4f}" if isinstance(value, float) else str(value)


def _cell(value: float | None, best: float | None) -> str:
    if value is None:
        return ""
    return f"{value:.4f}" + ("*" if value == best else " ")


def _signatures(records: Sequence[Record]) -> list[str]:
    """Return the signatures of a table: a line for metrics that share it, then a line for each model."""
    metrics: dict[str, dict[str, None]] = {}
    models: dict[str, dict[str, str]] = {}  # by method name and model signature, the first method with it
    for record in records:
        fields = parse_signature(record["signature"])
        if model := fields.pop("model", None):
            models.setdefault(Method.parse(record["method"]).name, {}).setdefault(model, record["method"])
        shared = signature(**{**fields, "metric": "npss", "convention": "paper"})
        metrics.setdefault(shared, {})[fields["metric"]] = None
    lines = []
    for shared, names in metrics.items():
        fields = parse_signature(shared) | {"metric": "+".join(names)}
        lines.append(signature(**fields | ({} if "npss" in names else {"convention": None})))
    for name, methods in models.items():  # the best PCA size depends on the input
        lines += [f"model of {method if len(methods) > 1 else name}: {model}" for model, method in methods.items()]
    return lines
