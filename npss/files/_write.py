"""Write files aside, then rename them: a full disk, an error or a kill never costs what was there before."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Callable, Iterable
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO


def check_output(path: Path, inputs: Iterable[Path] = ()) -> None:
    """Make sure, before the work of making it, that a file can be written.

    Parameters
    ----------
    path : Path
        The file to be written.
    inputs : iterable of Path, optional
        Files that are not to be overwritten: whoever names one as the output has mistaken it for another.

    Raises
    ------
    ValueError
        If there is no such folder, `path` is a folder, or it is one of the `inputs`.
    """
    if not path.absolute().parent.is_dir():
        raise ValueError(f"{path}: there is no folder {path.parent}")
    if path.is_dir():
        raise ValueError(f"{path}: expected a file to write, got a folder")
    if path.exists() and any(file.exists() and path.samefile(file) for file in inputs):
        raise ValueError(f"{path}: it is to be read, and would be overwritten; write to another file")


def write_atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Let `write` write a new file beside `path`, and rename it to `path` once it is whole.

    The new file has a name of its own, so several processes may write the same `path`: the last one wins. What is no
    regular file (a device, a pipe) is written in place. A link stays a link: the file that it points to is replaced.
    Permissions stay as they are.

    Parameters
    ----------
    path : Path
        The file to be written.
    write : callable
        ``write(part)`` writes the new file, of whatever kind.

    Raises
    ------
    OSError
        If writing fails; the message names `path`, which is as it was.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        write(target)
        return
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        # Create it here, and exclusively: the name is nobody else's, and the user's umask applies.
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        if target.exists():
            os.close(os.open(target, os.O_WRONLY))  # a file that nobody may write is not replaced, either
            part.chmod(stat.S_IMODE(target.stat().st_mode))
        write(part)
        part.replace(target)
    except OSError as error:
        raise OSError(error.errno, f"cannot write {path}: {error.strerror or error}") from error
    finally:
        part.unlink(missing_ok=True)


def write_figure_atomically(path: Path, figure: Any) -> None:
    """Write a figure of matplotlib as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to be written; the end of its name says the format, which is PNG where it has none.
    figure : Figure
        The figure.
    """
    write_stream_atomically(path, lambda stream: figure.savefig(stream, format=path.suffix[1:] or "png"))


def write_stream_atomically(path: Path, write: Callable[[BinaryIO], Any]) -> None:
    """Let `write` write to a stream in memory, and write what is in it as `write_atomically` does.

    For what other packages write: matplotlib, numpy, h5py and torch report a full disk in words of their own, or leave
    the file open.

    Parameters
    ----------
    path : Path
        The file to be written.
    write : callable
        ``write(stream)`` writes all that it is to hold.
    """
    content = BytesIO()
    write(content)
    write_bytes_atomically(path, content.getbuffer())


def write_bytes_atomically(path: Path, content: bytes | memoryview) -> None:
    """Write bytes as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to be written.
    content : bytes or memoryview
        All that it is to hold.
    """
    write_atomically(path, lambda part: part.write_bytes(content))


def write_text_atomically(path: Path, text: str) -> None:
    """Write text as UTF-8, with the ends of lines as they are, as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to be written.
    text : str
        All that it is to hold.
    """
    write_atomically(path, lambda part: part.write_text(text, encoding="utf-8", newline=""))
