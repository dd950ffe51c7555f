"""The frame of a page: styles, scripts and data in one file, without access to the network."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, check_finite, positive_number, real_array

_LARGEST = 2**15 - 1  # mm; positions are stored as 16-bit integers


def page(
    *,
    title: str,
    body: str,
    scripts: Sequence[str],
    data: object,
    language: str = "en",
    direction: str = "ltr",
) -> str:
    """Return a page.

    Parameters
    ----------
    title : str
        The title, as plain text.
    body : str
        The body as HTML, with all user text escaped.
    scripts : sequence of str
        Names of script files in this folder, run in this order.
    data : object
        Data for the scripts, as JSON in the element ``data``.
    language : str, optional
        The language tag of the page.
    direction : {'ltr', 'rtl'}, optional
        The direction of its script.
    """
    script = "".join(resource(name) for name in scripts)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    # No other script runs, and nothing is fetched, not even a font.
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )
    return f"""<!doctype html>
<html lang="{escape(language)}" dir="{escape(direction)}">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<link rel="icon" href="data:,">
<style>{resource("page.css")}</style>
</head>
<body>
{body}
<script type="application/json" id="data">{inline_json(data)}</script>
<script>{script}</script>
</body>
</html>
"""


def resource(name: str) -> str:
    """Return the text of a file in this folder."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def inline_json(data: object) -> str:
    """Write JSON for a script element, without characters that could end the element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def figure(skeleton: Skeleton, fps: float) -> dict[str, Any]:
    """Return the data of the player beside the motion: frames per second and bones (child, parent, side)."""
    drawn = _drawn(skeleton)
    bones = [(drawn.index(child), drawn.index(parent), skeleton.sides[child]) for child, parent in skeleton.bones]
    return {"fps": positive_number("fps", fps), "bones": bones}


def positions_array(name: str, values: npt.ArrayLike, skeleton: Skeleton) -> Array:
    """Read positions ``(N, T, J, 3)`` in millimetres."""
    array = real_array(name, values)
    joints = len(skeleton.names)
    if array.ndim != 4 or array.shape[2:] != (joints, 3):
        raise ValueError(f"{name}: expected shape (N, T, {joints}, 3), got {array.shape}")
    if array.size == 0:
        raise ValueError(f"{name}: no motion in an array of shape {array.shape}")
    check_finite(name, array)
    if (far := np.abs(array).max()) > _LARGEST:
        raise ValueError(f"{name}: a joint is {far:.0f} mm from the origin; at most {_LARGEST} can be shown")
    return array


def pack(positions: Array, skeleton: Skeleton) -> str:
    """Encode positions ``(T, J, 3)`` of the drawn joints as 16-bit whole millimetres in base64."""
    drawn = np.rint(positions[:, _drawn(skeleton)]).astype("<i2")
    return base64.b64encode(drawn.tobytes()).decode()


def _drawn(skeleton: Skeleton) -> list[int]:
    return sorted({joint for bone in skeleton.bones for joint in bone})
