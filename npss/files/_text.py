"""Read text files: UTF-8 whatever the locale, with or without a byte order mark."""

from __future__ import annotations

from pathlib import Path

_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path) -> str:
    r"""Return the text of a file; every end of line is ``\n``.

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
        If it is not UTF-8; says so where it is UTF-16, which some programs write. If it is a named pipe, to which
        nobody may ever write.
    OSError
        If it cannot be read.
    """
    if path.resolve().is_fifo():  # those of a shell, such as /dev/stdin, have no other name
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
