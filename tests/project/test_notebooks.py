"""Run the notebooks, and compare what they print with what the pages show."""

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
_NUMBER = re.compile(r"-?\d*\.?\d+(?:e-?\d+)?")

pytestmark = pytest.mark.skipif(not NOTEBOOKS, reason="needs the documentation")


def printed(notebook):
    """Return the text of each cell of code; pictures are told by their size only."""
    texts = []
    for cell in notebook.cells:
        if cell.cell_type == "code":
            outputs = ("".join(o.get("text") or o.get("data", {}).get("text/plain", "")) for o in cell.outputs)
            texts.append("".join(outputs))
    return texts


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_stored_output_is_that_of_today(path):
    for package in ("ipykernel", "matplotlib", "pandas", "scipy"):
        pytest.importorskip(package)
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    stored = printed(nbformat.read(path, as_version=4))
    again = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(again, timeout=300, resources={"metadata": {"path": str(path.parent)}}).execute()
    for before, after in zip(stored, printed(again), strict=True):
        hint = f"run: jupyter execute --inplace {path.name}"
        assert _NUMBER.sub("#", before) == _NUMBER.sub("#", after), hint
        numbers = (list(map(float, _NUMBER.findall(text))) for text in (before, after))
        assert next(numbers) == pytest.approx(next(numbers), rel=1e-6), hint
