"""Tests of docs/architecture.md: the picture matches the imports, and all named files exist."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
pytestmark = pytest.mark.skipif(not (ROOT / "npss").is_dir(), reason="needs the source code")


@pytest.fixture
def drawing():
    spec = importlib.util.spec_from_file_location("draw_architecture", ROOT / "docs" / "draw_architecture.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_picture_matches_the_imports(drawing):
    stored = drawing.PICTURE.read_text(encoding="utf-8")
    assert stored == drawing.picture(), "out of date: run python docs/draw_architecture.py"


def test_every_room_has_a_layer(drawing):
    parts = {part for package in drawing.layers() for row in package for part in row}
    folders = (ROOT / "npss", ROOT / "baselines" / "npss_baselines")
    modules = {
        f"{folder.name}.{path.stem}"
        for folder in folders
        for path in folder.iterdir()
        if (path.suffix == ".py" and not path.stem.startswith("__")) or (path / "__init__.py").exists()
    }
    assert modules == parts


def test_arrows_go_down(drawing):
    baselines, library = drawing.layers()
    rows = baselines + library
    layer = {part: number for number, row in enumerate(rows) for part in row}
    arrows = drawing.arrows(drawing.imports(list(layer)))
    assert len(arrows) > 30
    assert all(layer[source] < layer[target] for source, target in arrows)


def test_arrows_that_follow_from_others_are_left_out(drawing):
    graph = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
    assert drawing.arrows(graph) == {("a", "b"), ("b", "c")}


def test_named_files_exist():
    names = re.findall(r"`((?:npss|baselines|docs|tests)/[\w./-]*)`", PAGE.read_text(encoding="utf-8"))
    assert len(names) > 15
    assert [name for name in names if not (ROOT / name).exists()] == []
