#!/usr/bin/env python3
"""Draw docs/architecture.svg: the parts of each package in the layers of pyproject.toml, with arrows by the imports.

An arrow goes from a part to one of the same package that it imports; those that follow from two others are left out.
"""

from __future__ import annotations

import ast
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "architecture.svg"
_WIDTH, _HEIGHT_OF_ALL, _TOP = 960, 860, 55  # of the picture, and the middle of its first row
_HEIGHT, _LETTER = 28, 7.6  # of a box, width of a letter
_PANELS = ((10, 310), (330, 950))  # from left to right: npss_baselines, npss


def layers() -> tuple[list[list[str]], list[list[str]]]:
    """Return the parts of each layer from the top, of npss_baselines and of npss."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rows = []
    for contract in project["tool"]["importlinter"]["contracts"][:2]:
        (container,) = contract.get("containers", [""])
        names = [row.split(" | ") for row in contract["layers"] if row != "npss_baselines"]
        rows.append([[f"{container}.{name}".lstrip(".") for name in row] for row in names])
    library, baselines = rows
    return baselines, library


def imports(parts: list[str]) -> dict[str, set[str]]:
    """Return which parts each part imports when it runs."""
    found: dict[str, set[str]] = {part: set() for part in parts}
    for folder in (ROOT / "npss", ROOT / "baselines" / "npss_baselines"):
        for path in folder.rglob("*.py"):
            module = ".".join(path.relative_to(folder.parent).with_suffix("").parts)
            tree = ast.parse(path.read_text(encoding="utf-8"))
            for source in _parts_of(module, parts):
                found[source] |= {target for name in _imported(tree) for target in _parts_of(name, parts)} - {source}
    return found


def arrows(graph: dict[str, set[str]]) -> set[tuple[str, str]]:
    """Return the imports that do not follow from others."""

    def below(part: str) -> set[str]:
        return graph[part].union(*(below(other) for other in graph[part]))

    return {(a, b) for a in graph for b in graph[a] if not any(b in below(other) for other in graph[a])}


def _package(part: str) -> str:
    return part.partition(".")[0]


def _parts_of(module: str, parts: list[str]) -> list[str]:
    return [part for part in parts if f"{module}.".startswith(f"{part}.")]


def _imported(node: ast.AST) -> list[str]:
    """Return the modules that code imports, other than for types."""
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        return [name for other in node.orelse for name in _imported(other)]
    if isinstance(node, ast.ImportFrom):
        return [f"{node.module}.{alias.name}" for alias in node.names]
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [name for child in ast.iter_child_nodes(node) for name in _imported(child)]


def picture() -> str:
    """Return the picture as SVG."""
    place = {}
    for rows, (left, right) in zip(layers(), _PANELS, strict=True):
        step = (_HEIGHT_OF_ALL - 2 * _TOP) / (len(rows) - 1)
        for y, row in enumerate(rows):
            width = (right - left) / len(row)
            # Rows of one part go to and fro, so that arrows past a row are seen.
            shift = 80 * (-1) ** y if len(row) == 1 and 0 < y < len(rows) - 1 else 0
            place |= {part: (left + width * (x + 0.5) + shift, _TOP + step * y) for x, part in enumerate(row)}
    lines = []
    for source, target in sorted(arrows(imports(list(place)))):
        if _package(source) != _package(target):
            continue
        (x1, y1), (x2, y2) = place[source], place[target]
        ends = f'x1="{x1:.0f}" y1="{y1 + _HEIGHT / 2:.0f}" x2="{x2:.0f}" y2="{y2 - _HEIGHT / 2 - 2:.0f}"'
        lines.append(f"<line {ends}><title>{source} imports {target}</title></line>")
    boxes = []
    for part, (x, y) in place.items():
        name = part.removeprefix("npss_baselines.").removeprefix("npss.")
        width = _LETTER * len(name) + 20
        kind = "baselines" if part.startswith("npss_baselines") else "private" if name.startswith("_") else "public"
        box = f'x="{x - width / 2:.0f}" y="{y - _HEIGHT / 2:.0f}" width="{width:.0f}" height="{_HEIGHT}" rx="4"'
        text = f'<text x="{x:.0f}" y="{y + 4:.0f}">{escape(name)}</text>'
        boxes.append(f'<g class="{kind}"><title>{part}</title><rect {box}/>{text}</g>')
    height = _HEIGHT_OF_ALL
    heads = [
        f'<text x="{(left + right) / 2:.0f}" y="20" style="font-weight:bold">{name}</text>'
        for name, (left, right) in zip(("npss_baselines", "npss"), _PANELS, strict=True)
    ]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" role="img">',
            "<title>The parts of npss_baselines (blue) and npss, and which imports which</title>",
            "<style>text{font:13px monospace;text-anchor:middle;fill:#000}rect{stroke:#555}line{stroke:#888}",
            ".baselines rect{fill:#d6e8f7}.public rect{fill:#fff}.private rect{fill:#ddd;stroke-dasharray:3}</style>",
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" orient="auto">',
            '<path d="M0 0 8 4 0 8z" fill="#888"/></marker></defs>',
            f'<rect width="{_WIDTH}" height="{height}" style="fill:#fafafa;stroke:none"/>',
            '<g style="marker-end:url(#tip)">',
            *lines,
            "</g>",
            *boxes,
            *heads,
            "</svg>",
            "",
        ]
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
