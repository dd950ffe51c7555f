"""Files are replaced atomically."""

import os
import stat
from pathlib import Path
from typing import BinaryIO

import pytest

from npss.files._text import read_text
from npss.files._write import (
    write_atomically,
    write_figure_atomically,
    write_stream_atomically,
    write_text_atomically,
)


def test_replaces_the_file(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    write_text_atomically(path, "old\n")
    write_text_atomically(path, "new\r\nü\n")
    assert path.read_bytes() == "new\r\nü\n".encode()
    assert list(tmp_path.iterdir()) == [path]


def test_keeps_the_old_file_when_writing_fails(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old", encoding="utf-8")

    def fill_the_disk(part: Path) -> None:
        part.write_text("half", encoding="utf-8")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match=r"cannot write .*page\.html: No space left on device"):
        write_atomically(path, fill_the_disk)
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_two_writers_do_not_share_a_part(tmp_path: Path) -> None:
    path, parts = tmp_path / "cache", []

    def write(part: Path) -> None:
        parts.append(part)
        if len(parts) == 1:
            write_atomically(path, write)
        part.write_text(part.name, encoding="utf-8")

    write_atomically(path, write)
    assert len(set(parts)) == 2
    assert path.read_text(encoding="utf-8") == parts[0].name


def test_follows_links_and_writes_devices_in_place(tmp_path: Path) -> None:
    path, link = tmp_path / "file", tmp_path / "link"
    link.symlink_to(path)
    write_text_atomically(link, "text")
    assert link.is_symlink()
    assert path.read_text(encoding="utf-8") == "text"
    write_text_atomically(Path(os.devnull), "text")
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)


def test_respects_the_umask(tmp_path: Path) -> None:
    old = os.umask(0o027)
    try:
        write_text_atomically(tmp_path / "file", "text")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def test_keeps_the_permissions_of_what_it_replaces(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    path.chmod(0o600)
    write_text_atomically(path, "text")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_does_not_replace_read_only_files(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    path.chmod(0o400)
    with pytest.raises(OSError, match=r"cannot write .*file: Permission denied"):
        write_text_atomically(path, "text")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(("name", "begins"), [("a.svg", b"<?xml"), ("a.pdf", b"%PDF"), ("a", b"\x89PNG")])
def test_the_suffix_of_a_picture_sets_its_format(tmp_path: Path, name: str, begins: bytes) -> None:
    figure = pytest.importorskip("matplotlib.figure").Figure()
    write_figure_atomically(tmp_path / name, figure)
    assert (tmp_path / name).read_bytes().startswith(begins)


def test_refuses_pictures_in_other_formats(tmp_path: Path) -> None:
    figure = pytest.importorskip("matplotlib.figure").Figure()
    with pytest.raises(ValueError, match=r"a\.txt: expected the suffix of a picture, such as \.svg, \.pdf or \.png"):
        write_figure_atomically(tmp_path / "a.txt", figure)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_reads_utf8_with_and_without_a_mark(tmp_path: Path, mark: bytes) -> None:
    path = tmp_path / "text"
    path.write_bytes(mark + "ü\r\nb\rc\n".encode())
    assert read_text(path) == "ü\nb\nc\n"


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_names_utf16(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "text"
    path.write_bytes("\ufefftext".encode(encoding))
    with pytest.raises(ValueError, match="text: the text is UTF-16; save it as UTF-8"):
        read_text(path)


def test_names_the_line_that_is_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"a\nb\xff\n")
    with pytest.raises(ValueError, match="text: line 2 is not UTF-8 text"):
        read_text(path)


def test_writes_what_is_in_the_stream(tmp_path: Path) -> None:
    write_stream_atomically(tmp_path / "file", lambda stream: stream.write(b"all of it"))
    assert (tmp_path / "file").read_bytes() == b"all of it"


def test_an_error_in_the_stream_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"before")

    def fail(stream: BinaryIO) -> None:
        stream.write(b"half")
        raise ValueError("half of it")

    with pytest.raises(ValueError, match="half of it"):
        write_stream_atomically(path, fail)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]
