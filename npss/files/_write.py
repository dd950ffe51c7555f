"""Write files atomically: to a new file that is then renamed, so that no failure costs the old file."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Callable, Iterable
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO


def check_output(path: Path, inputs: Iterable[Path] = ()) -> None:
    """Check that a file can be written, before the work starts.

    Parameters
    ----------
    path : Path
        The file to write.
    inputs : iterable of Path, optional
        Files that must not be overwritten.

    Raises
    ------
    ValueError
        If the folder does not exist, `path` is a folder, or it is one of the `inputs`.
    """
    if not path.absolute().parent.is_dir():
        raise ValueError(f"{path}: no such folder: {path.parent}")
    if path.is_dir():
        raise ValueError(f"{path}: expected a file to write, got a folder")
    if path.exists() and any(file.exists() and path.samefile(file) for file in inputs):
        raise ValueError(f"{path}: would overwrite an input; write to another file")


def write_atomically(path: Path, write: Callable[[Path], Any]) -> None:
    """Write a new file beside `path`, and rename it to `path` once it is complete.

    The new file has a unique name, so several processes may write the same `path`: the last one wins. Devices and pipes
    are written in place. A link stays a link: the file that it points to is replaced. Permissions are kept.

    Parameters
    ----------
    path : Path
        The file to write.
    write : callable
        ``write(part)`` writes the new file.

    Raises
    ------
    OSError
        If writing fails; the message names `path`, which is unchanged.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        write(target)
        return
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        # Create it here, and exclusively: the name is unique, and the user's umask applies.
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        if target.exists():
            os.close(os.open(target, os.O_WRONLY))  # do not replace a read-only file
            part.chmod(stat.S_IMODE(target.stat().st_mode))
        write(part)
        part.replace(target)
    except OSError as error:
        raise OSError(error.errno, f"cannot write {path}: {error.strerror or error}") from error
    finally:
        part.unlink(missing_ok=True)


def write_figure_atomically(path: Path, figure: Any) -> None:
    """Write a matplotlib figure as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to write; its suffix sets the format (default: PNG).
    figure : Figure
        The figure.

    Raises
    ------
    ValueError
        If matplotlib has no such format.
    """
    formats = figure.canvas.get_supported_filetypes()
    if (form := path.suffix[1:] or "png") not in formats:
        raise ValueError(f"{path}: expected the suffix of a picture, such as .svg, .pdf or .png")
    write_stream_atomically(path, lambda stream: figure.savefig(stream, format=form))


def write_stream_atomically(path: Path, write: Callable[[BinaryIO], Any]) -> None:
    """Write to a stream in memory, then to the file as `write_atomically` does.

    This is for files of other packages: matplotlib, numpy, h5py and torch report a full disk in different ways, or
    leave the file open.

    Parameters
    ----------
    path : Path
        The file to write.
    write : callable
        ``write(stream)`` writes the content.
    """
    content = BytesIO()
    write(content)
    write_bytes_atomically(path, content.getbuffer())


def write_bytes_atomically(path: Path, content: bytes | memoryview) -> None:
    """Write bytes as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to write.
    content : bytes or memoryview
        The content.
    """
    write_atomically(path, lambda part: part.write_bytes(content))


def write_text_atomically(path: Path, text: str) -> None:
    """Write text as UTF-8, with unchanged line ends, as `write_atomically` does.

    Parameters
    ----------
    path : Path
        The file to write.
    text : str
        The content.
    """
    write_atomically(path, lambda part: part.write_text(text, encoding="utf-8", newline=""))
