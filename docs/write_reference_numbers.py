#!/usr/bin/env python3
"""Write the reference numbers from records/: the page, its pictures, all numbers, and the table that npss ships.

The page is docs/reference-numbers.md.in, with tables and numbers filled in: edit that file.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import npss
from npss_baselines.reproduction import pictures, tables
from npss_baselines.reproduction.plan import read_plan
from npss_baselines.reproduction.results import Results, read_records

ROOT = Path(__file__).resolve().parent.parent
RECORDS = ROOT / "records"
TEMPLATE = ROOT / "docs" / "reference-numbers.md.in"
PAGE = ROOT / "docs" / "reference-numbers.md"
NUMBERS = ROOT / "docs" / "reference-numbers.csv"
PACKAGE_DATA = Path(npss.__file__).parent / "measured.csv"
PICTURES = {
    ROOT / "docs" / "reference-models.svg": pictures.models,
    ROOT / "docs" / "reference-amplitudes.svg": pictures.amplitudes,
}
_NOTICE = "<!-- Written by docs/write_reference_numbers.py from records/ and reference-numbers.md.in; edit these. -->\n"


def results() -> Results:
    """Return the results of the records in the project."""
    return Results(read_plan(), read_records(RECORDS))


def texts(found: Results) -> dict[Path, str]:
    """Return the contents of the page and the package data."""
    page = tables.filled(TEMPLATE.read_text(encoding="utf-8"), found)
    return {PAGE: _NOTICE + page, PACKAGE_DATA: tables.package_data(found)}


def digest(found: Results) -> str:
    """Return a digest of the numbers behind the pictures; a picture itself depends on the version of matplotlib."""
    numbers = [
        [of.row.name, of.action, of.protocol, of.record["npss"], of.record.get("amplitude")]
        for of in found.all()
        if of.unwrap == "off"
    ]
    rounded = json.loads(json.dumps(numbers), parse_float=lambda text: f"{float(text):.6g}")
    return hashlib.sha256(json.dumps(rounded, sort_keys=True).encode()).hexdigest()


def digest_of(picture: Path) -> str:
    """Return the digest that a picture states; empty if there is none."""
    found = re.search(r"records ([0-9a-f]{64})", picture.read_text(encoding="utf-8")) if picture.exists() else None
    return found[1] if found else ""


def main() -> None:
    """Write what differs."""
    found = results()
    for path, text in {**texts(found), NUMBERS: tables.numbers(found)}.items():
        path.write_text(text, encoding="utf-8")
    for path, draw in PICTURES.items():
        if digest_of(path) != digest(found):
            draw(found).savefig(path, metadata={"Date": None, "Description": f"records {digest(found)}"})


if __name__ == "__main__":
    main()
