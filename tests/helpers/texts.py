"""Text files that readers of JSON accept or name."""

import re

import pytest


def check_texts(read, file, content):
    """Check that the layout of a valid JSON text does not matter, and that invalid texts are named.

    Parameters
    ----------
    read : callable
        Reads the file.
    file : Path
        The file to write.
    content : str
        A valid text.
    """
    file.write_text(content, encoding="utf-8-sig")
    value = read(file)
    for text, message in (
        (content.encode("utf-16"), "the text is UTF-16"),
        (b"[" * 100_000, "invalid JSON: nested too deeply"),
        (b"\xff{", "line 1 is not UTF-8 text"),
    ):
        file.write_bytes(text)
        with pytest.raises(ValueError, match=rf"{re.escape(file.name)}: {message}"):
            read(file)
    return value
