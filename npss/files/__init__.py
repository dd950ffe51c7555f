"""Read files strictly, and write them atomically."""

from npss.files._arrays import MAX_SIZE, Arrays, Header, in_memory
from npss.files._formats import FORMATS, Format, listed, register_format, suffixes, write_samples
from npss.files._json import parse_json, read_json
from npss.files._samples import Pair
from npss.files._system_errors import doing
from npss.files._text import read_text
from npss.files._write import (
    check_output,
    write_atomically,
    write_bytes_atomically,
    write_figure_atomically,
    write_stream_atomically,
    write_text_atomically,
)

__all__ = [
    "FORMATS",
    "MAX_SIZE",
    "Arrays",
    "Format",
    "Header",
    "Pair",
    "check_output",
    "doing",
    "in_memory",
    "listed",
    "parse_json",
    "read_json",
    "read_text",
    "register_format",
    "suffixes",
    "write_atomically",
    "write_bytes_atomically",
    "write_figure_atomically",
    "write_samples",
    "write_stream_atomically",
    "write_text_atomically",
]
