"""Stick figures that move, as SVG without a script."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from npss.validation import Float64

#: The size of a figure in pixels.
SIZE = 150


def figures(places: Sequence[Float64], colours: Sequence[str], bones: Sequence[tuple[int, int]], seconds: float) -> str:
    """Return figures side by side, seen from their left: positions ``(T, J, 3)``, y up, of equal T."""
    side = [np.stack([place[..., 2], -place[..., 1]], axis=-1) for place in places]
    low = np.min([place.min(axis=(0, 1)) for place in side], axis=0)
    high = np.max([place.max(axis=(0, 1)) for place in side], axis=0)
    drawn = []
    for number, (place, colour) in enumerate(zip(side, colours, strict=True)):
        centre = np.array([(number + 0.5) * SIZE, SIZE / 2])
        points = centre + (place - (low + high) / 2) * (SIZE - 10) / (high - low).max()
        frames = ["".join(f"M{_at(frame[a])}L{_at(frame[b])}" for a, b in bones) for frame in points]
        drawn.append(
            f'<path d="{frames[0]}" stroke="{colour}"><animate attributeName="d" dur="{seconds:g}s" '
            f'repeatCount="indefinite" values="{";".join(frames)}"/></path>'
        )
    return f'<g fill="none" stroke-width="2.5" stroke-linecap="round">{"".join(drawn)}</g>'


def svg(width: float, height: float, content: str) -> str:
    """Return a picture with this content."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f"{content}</svg>\n"
    )


def _at(point: Float64) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"
