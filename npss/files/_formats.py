"""File formats by suffix: what each can hold, and what reads and writes it. To add one, register it.

Files come from anywhere: a reader runs no code of a file's, opens no other file that one names, and of a file that may
expand, it says what is declared before anything is read, so that `npss.files` can refuse what is too large.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal, get_args

from npss.extras import install_hint
from npss.files._arrays import Arrays, check_regular
from npss.files._json import read_json
from npss.files._numpy import open_npz, read_npy, write_npz
from npss.files._write import write_stream_atomically
from npss.plugins import Registry
from npss.validation import Array, each

#: What a file can hold, or "write": that it can be written.
Content = Literal["array", "arrays", "samples", "records", "write"]

_SUFFIX = re.compile(r"\.\w+")


@dataclass(frozen=True)
class Format:
    """A file format: what reads and writes each thing that it can hold.

    Parameters
    ----------
    suffixes : tuple of str
        How names of its files end: ``(".h5", ".hdf5")``.
    array : callable, optional
        ``array(path)`` returns the one array of a file: ground truth or prediction, in any representation.
    arrays : callable, optional
        ``arrays(path)`` opens such arrays by name: a context manager that yields `Arrays`, as `in_memory` does.
    samples : callable, optional
        ``samples(path)`` opens arrays named ``expmap/gt/ACTION_i`` and ``expmap/preds/ACTION_i``, each (T, 99):
        Human3.6M exponential maps at 25 frames per second; a context manager as that of `arrays`.
    records : callable, optional
        ``records(path)`` returns a list of dictionaries, as ``npss-baselines evaluate --format json`` prints them; its
        errors name the file.
    write : callable, optional
        ``write(stream, arrays)`` writes a mapping of names to arrays to a binary stream, as `samples` reads them.
    extra : str, optional
        The extra of ``npss-metric`` that brings the package which it needs.

    Raises
    ------
    TypeError, ValueError
        If the suffixes are none, a field is no function, or there is nothing that reads or writes.
    """

    suffixes: tuple[str, ...]
    array: Callable[[Path], Array] | None = None
    arrays: Callable[[Path], AbstractContextManager[Arrays]] | None = None
    samples: Callable[[Path], AbstractContextManager[Arrays]] | None = None
    records: Callable[[Path], Any] | None = None
    write: Callable[[BinaryIO, Mapping[str, Array]], None] | None = None
    extra: str | None = None

    def __post_init__(self) -> None:
        given_suffixes = each("suffixes", self.suffixes, "texts")
        if not given_suffixes or not all(isinstance(one, str) and _SUFFIX.fullmatch(one) for one in given_suffixes):
            raise ValueError(f"suffixes: expected a dot and letters each, such as .npz, got {self.suffixes!r}")
        given = {content: getattr(self, content) for content in get_args(Content)}
        if wrong := [content for content, function in given.items() if not (function is None or callable(function))]:
            raise TypeError(f"{wrong[0]}: expected a function, got {given[wrong[0]]!r}")
        if not any(given.values()):
            raise ValueError(f"{self.suffixes[0]}: expected one function at least, of {', '.join(given)}")


def register_format(form: Format, *, replace: bool = False) -> None:
    """Let every command and function that reads or writes files know a format.

    Parameters
    ----------
    form : Format
        The format.
    replace : bool, optional
        Take the place of registered formats of these suffixes, as a notebook does whose cell is run again.

    Raises
    ------
    TypeError
        If it is none.
    ValueError
        If one of its suffixes is registered already and not to be replaced, or built in.

    Examples
    --------
    >>> from npss.files import FORMATS, Format, in_memory, register_format
    >>> import numpy as np
    >>> register_format(Format(suffixes=(".npy",), array=np.load))  # as if it were one of your own
    Traceback (most recent call last):
    ValueError: the suffix '.npy' is registered already
    """
    if not isinstance(form, Format):
        raise TypeError(f"form: expected a Format, got {form!r}")
    for suffix in form.suffixes:
        FORMATS.register(suffix, form, replace=replace)


def suffixes(*contents: Content) -> tuple[str, ...]:
    """Return the suffixes of files that can hold one of these.

    Parameters
    ----------
    *contents : {'array', 'arrays', 'samples', 'records', 'write'}
        What a file can hold, or ``'write'``: that it can be written.

    Returns
    -------
    tuple of str
        With their dots, in the order in which they were registered.
    """
    return tuple(suffix for suffix, form in FORMATS.items() if any(getattr(form, content) for content in contents))


def listed(*contents: Content) -> str:
    """Return the suffixes of files that can hold one of these, in words.

    Parameters
    ----------
    *contents : {'array', 'arrays', 'samples', 'records', 'write'}
        What a file can hold, or ``'write'``: that it can be written.

    Returns
    -------
    str
        For a message.

    Examples
    --------
    >>> listed("array", "arrays")
    '.npy or .npz'
    """
    *others, last = suffixes(*contents)
    return f"{', '.join(others)} or {last}" if others else last


def read_array(path: Path) -> Array:
    """Read the one array of a file; `naming_file` lets errors name it."""
    check_regular(path)
    with _needing(path, "reading"):
        return FORMATS[path.suffix].array(path)  # type: ignore[misc]  # the caller has looked


@contextmanager
def open_arrays(path: Path, content: Literal["arrays", "samples"]) -> Iterator[Arrays]:
    """Open a file of arrays by name; `naming_file` lets errors name it."""
    check_regular(path)
    with ExitStack() as stack:
        with _needing(path, "reading"):
            arrays = stack.enter_context(getattr(FORMATS[path.suffix], content)(path))
        yield arrays


def write_samples(path: Path, arrays: Mapping[str, Array]) -> None:
    """Write samples, whole or not at all, in the format that the suffix says.

    Parameters
    ----------
    path : Path
        The file.
    arrays : mapping of str to ndarray
        By name, as `Format` describes them.

    Raises
    ------
    ValueError
        If no format of that suffix can be written, or a package is missing.
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
    """Let the error of a missing package say what needs it."""
    try:
        yield
    except ModuleNotFoundError as error:
        extra = FORMATS[path.suffix].extra
        hint = f"; {install_hint(extra)}" if extra else ", which is not installed"
        raise ValueError(f"{doing} {path.suffix} needs {error.name}{hint}") from None


def _open_h5(path: Path) -> AbstractContextManager[Arrays]:
    from npss.files._h5 import open_h5  # here, since few need h5py

    return open_h5(path)


def _write_h5(stream: BinaryIO, arrays: Mapping[str, Array]) -> None:
    from npss.files._h5 import write_h5

    write_h5(stream, arrays)


#: By suffix.
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
