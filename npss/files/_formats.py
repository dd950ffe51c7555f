"""File formats by suffix: the contents of each, and their readers and writers. To add a format, register it.

Files may come from anywhere. A reader runs no code from a file and opens no other file that it names. For a file that
may expand, it reports headers before it reads arrays, so that `npss.files` can refuse large ones.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal, get_args

import numpy as np

from npss.extras import install_hint
from npss.files._arrays import Arrays, check_regular
from npss.files._json import read_json
from npss.files._numpy import open_npz, read_npy, write_npz
from npss.files._write import write_stream_atomically
from npss.plugins import Registry
from npss.validation import Array, each

#: The content that a format can read, or "write" for a format that can be written.
Content = Literal["array", "arrays", "samples", "records", "write"]

_SUFFIX = re.compile(r"\.\w+")


@dataclass(frozen=True)
class Format:
    """A file format: its readers and its writer.

    Parameters
    ----------
    suffixes : tuple of str
        The suffixes of its files: ``(".h5", ".hdf5")``.
    array : callable, optional
        ``array(path)`` returns the only array of a file: ground truth or prediction, in any representation.
    arrays : callable, optional
        ``arrays(path)`` opens such arrays by name: a context manager that yields `Arrays`, as `in_memory` does.
    samples : callable, optional
        ``samples(path)`` opens arrays named ``expmap/gt/ACTION_i`` and ``expmap/preds/ACTION_i``, each (T, 99):
        Human3.6M exponential maps at 25 frames per second; a context manager as for `arrays`.
    records : callable, optional
        ``records(path)`` returns a list of dictionaries, as ``npss-baselines evaluate --format json`` prints them; its
        errors name the file.
    write : callable, optional
        ``write(stream, arrays)`` writes a mapping of names to arrays to a binary stream, as `samples` reads them.
    extra : str, optional
        The extra of ``npss-metric`` that brings the required package.

    Raises
    ------
    TypeError, ValueError
        If the suffixes are invalid, a field is not a function, or there is neither a reader nor a writer.
    """

    suffixes: tuple[str, ...]
    array: Callable[[Path], Array] | None = None
    arrays: Callable[[Path], AbstractContextManager[Arrays]] | None = None
    samples: Callable[[Path], AbstractContextManager[Arrays]] | None = None
    records: Callable[[Path], Any] | None = None
    write: Callable[[BinaryIO, Mapping[str, Array]], None] | None = None
    extra: str | None = None

    def __post_init__(self) -> None:
        suffixes = each("suffixes", self.suffixes, "texts")
        if not suffixes or not all(isinstance(suffix, str) and _SUFFIX.fullmatch(suffix) for suffix in suffixes):
            raise ValueError(f"suffixes: expected a dot and letters each, such as .npz, got {self.suffixes!r}")
        functions = {content: getattr(self, content) for content in get_args(Content)}
        if wrong := [name for name, function in functions.items() if not (function is None or callable(function))]:
            raise TypeError(f"{wrong[0]}: expected a function, got {functions[wrong[0]]!r}")
        if not any(functions.values()):
            raise ValueError(f"{self.suffixes[0]}: expected at least one function of {', '.join(functions)}")


def register_format(form: Format, *, replace: bool = False) -> None:
    """Register a format for every command and function that reads or writes files.

    Parameters
    ----------
    form : Format
        The format.
    replace : bool, optional
        Replace registered formats of these suffixes, as when the cell of a notebook runs again.

    Raises
    ------
    TypeError
        If `form` is not a format.
    ValueError
        If a suffix is registered already and not to be replaced, or built in.

    Examples
    --------
    >>> from npss.files import FORMATS, Format, in_memory, register_format
    >>> import numpy as np
    >>> register_format(Format(suffixes=(".npy",), array=np.load))  # as if it were your own
    Traceback (most recent call last):
    ValueError: the suffix '.npy' is registered already
    """
    if not isinstance(form, Format):
        raise TypeError(f"form: expected a Format, got {form!r}")
    FORMATS.register_all(dict.fromkeys(form.suffixes, form), replace=replace)


def suffixes(*contents: Content) -> tuple[str, ...]:
    """Return the suffixes of formats with any of these contents.

    Parameters
    ----------
    *contents : {'array', 'arrays', 'samples', 'records', 'write'}
        Contents that a format can read, or ``'write'`` for formats that can be written.

    Returns
    -------
    tuple of str
        The suffixes with their dots, in the order of registration.
    """
    return tuple(suffix for suffix, form in FORMATS.items() if any(getattr(form, content) for content in contents))


def listed(*contents: Content) -> str:
    """Return the suffixes of formats with any of these contents, as text.

    Parameters
    ----------
    *contents : {'array', 'arrays', 'samples', 'records', 'write'}
        Contents that a format can read, or ``'write'`` for formats that can be written.

    Returns
    -------
    str
        The suffixes for a message.

    Examples
    --------
    >>> listed("array", "arrays")
    '.npy or .npz'
    """
    *others, last = suffixes(*contents)
    return f"{', '.join(others)} or {last}" if others else last


def read_array(path: Path) -> Array:
    """Read the only array of a file; `naming_file` names the file in errors."""
    check_regular(path)
    with _needing(path, "reading"):
        return np.asanyarray(FORMATS[path.suffix].array(path))  # type: ignore[misc]  # the caller has checked it


@contextmanager
def open_arrays(path: Path, content: Literal["arrays", "samples"]) -> Iterator[Arrays]:
    """Open a file of named arrays; `naming_file` names the file in errors."""
    check_regular(path)
    with ExitStack() as stack:
        with _needing(path, "reading"):
            arrays = stack.enter_context(getattr(FORMATS[path.suffix], content)(path))
        yield arrays


def write_samples(path: Path, arrays: Mapping[str, Array]) -> None:
    """Write samples atomically, in the format of the suffix.

    Parameters
    ----------
    path : Path
        The file.
    arrays : mapping of str to ndarray
        Arrays by name, as `Format` describes them.

    Raises
    ------
    ValueError
        If the format of the suffix cannot be written, or a package is missing.
    OSError
        If writing fails.
    """
    if path.suffix not in suffixes("write"):
        raise ValueError(f"{path}: expected a {listed('write')} file")
    write = FORMATS[path.suffix].write
    with _needing(path, "writing"):
        write_stream_atomically(path, lambda stream: write(stream, arrays))  # type: ignore[misc]


@contextmanager
def _needing(path: Path, doing: str) -> Iterator[None]:
    """Say in the error of a missing package which format needs it."""
    try:
        yield
    except ModuleNotFoundError as error:
        extra = FORMATS[path.suffix].extra
        hint = f"; {install_hint(extra)}" if extra else ", which is not installed"
        raise ValueError(f"{doing} {path.suffix} needs {error.name}{hint}") from None


def _open_h5(path: Path) -> AbstractContextManager[Arrays]:
    from npss.files._h5 import open_h5  # imported here: few files need h5py

    return open_h5(path)


def _write_h5(stream: BinaryIO, arrays: Mapping[str, Array]) -> None:
    from npss.files._h5 import write_h5

    write_h5(stream, arrays)


#: All formats by suffix.
FORMATS = Registry(
    "suffix",
    {
        suffix: form
        for form in (
            Format((".npy",), array=read_npy),
            Format((".h5", ".hdf5"), samples=_open_h5, write=_write_h5, extra="h5"),
            Format((".npz",), arrays=open_npz, samples=open_npz, write=write_npz),
            Format((".json",), records=read_json),
        )
        for suffix in form.suffixes
    },
)
