"""JSON is read strictly, and errors name the file."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss.files._json import parse_json, read_json

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)


@given(VALUES)
def test_written_json_is_read(value):
    assert parse_json(json.dumps(value)) == value


@pytest.mark.parametrize("opening", ["[", '{"a":'])
def test_nested_too_deeply(tmp_path, opening):
    path = tmp_path / "deep.json"
    path.write_text(opening * 100_000, encoding="utf-8")
    with pytest.raises(ValueError, match=r"deep\.json: invalid JSON: nested too deeply"):
        read_json(path)


def test_a_duplicate_field():
    with pytest.raises(ValueError, match="duplicate field 'b'"):
        parse_json('[{"a": 1, "b": 2, "b": 2}]')


@pytest.mark.parametrize("text", ["", "{", "[1,]", "\ufeff[]", "1" * 10_000])
def test_invalid_json(text):
    with pytest.raises(ValueError, match="invalid JSON"):
        parse_json(text)


def test_files_with_a_mark(tmp_path):
    path = tmp_path / "some.json"
    path.write_bytes(b'\xef\xbb\xbf{"a": "\xc3\xbc"}')
    assert read_json(path) == {"a": "ü"}
    path.write_bytes("\ufeff[]".encode("utf-16-le"))
    with pytest.raises(ValueError, match=r"some\.json: the text is UTF-16; save it as UTF-8"):
        read_json(path)
