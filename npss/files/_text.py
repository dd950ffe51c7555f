"""Read text files: UTF-8 in any locale, with or without a byte order mark."""

from __future__ import annotations

from pathlib import Path

_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path) -> str:
    r"""Read a text file; every line ends with ``\n``.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        Its text, without a byte order mark.

    Raises
    ------
    ValueError
        If the file is not UTF-8; the message tells if it is UTF-16, which some programs write. If it is a named pipe,
        which may never be written to.
    OSError
        If the file cannot be read.
    """
    if path.resolve().is_fifo():  # pipes of a shell, such as /dev/stdin, have no other name
        raise ValueError(f"{path}: expected a file, got a named pipe")
    content = path.read_bytes()
    if content.startswith(_UTF16_MARKS):
        raise ValueError(f"{path}: the text is UTF-16; save it as UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise ValueError(f"{path}: line {line} is not UTF-8 text") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")
