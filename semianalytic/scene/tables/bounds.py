"""Bounds on the bytes, rows and seconds that a file may take, whatever its headers promise."""

from __future__ import annotations

import gzip
import io
import stat
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from semianalytic.scene.errors import DataFileError, SlipfrontError

LARGEST_TEXT = 2**27
"""Bytes of a text, unpacked: 128 MB, two million rows of six numbers, which take half a minute and
400 MB to read; twice that takes twice as long and as much."""
LARGEST_DESCRIPTION = 2**24
"""Bytes of a file that describes a problem, in TOML, of which a second reads a megabyte."""
LARGEST_NUMBERS = 2**25
"""Numbers of arrays together, 256 MB: 4000 times at 2000 positions, four quantities."""
LARGEST_FILE = 2**30
"""Bytes of a file of arrays or of a frame of a mesh."""
LONGEST_LINE = 2**20
"""Bytes of a line of text: ten thousand columns with room to spare."""
MOST_SECONDS = 120.0
"""Seconds that the rows of a text may take to parse, four times what the largest text took."""
LARGEST_STATIONS = 20_000
"""Most stations of a run: a column of numbers that are all different holds no positions."""
MOST_FILES = 10_000
"""Most files of a folder, and frames of a mesh, that are read."""
_CHUNK = 2**20


def size_of(path: Path) -> int:
    """Bytes of an ordinary file.

    Raises DataFileError if it is none, or cannot be looked at.
    """
    with _readable(path):
        status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        raise DataFileError(f"{path} is not an ordinary file; save its contents to a file.")
    return status.st_size


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:  # a ValueError: the name has a NUL character
        reason = getattr(error, "strerror", None) or error
        raise DataFileError(f"{path} cannot be read ({reason}); give a file that can.") from error


@contextmanager
def parsing(path: Path) -> Iterator[None]:
    """Hide what a library prints; whatever it raises becomes a DataFileError of one sentence."""
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            yield
    except SlipfrontError:
        raise
    except (Exception, SystemExit) as error:  # parsers of damaged files fail in any way at all
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataFileError(f"{path} cannot be read ({reason}); write it again.") from error


def beginning_of(path: Path, count: int) -> bytes:
    """The first bytes of an ordinary file; raises as `size_of`."""
    size_of(path)
    with _readable(path), path.open("rb") as stream:
        return stream.read(count)


def check_file_size(path: Path, most: int = LARGEST_FILE) -> None:
    """Refuse what is not an ordinary file, or has too many bytes; raises a DataFileError."""
    size = size_of(path)
    if size > most:
        raise too_large(path, f"{size / 2**20:.0f} MB", f"{most / 2**20:.0f} MB")


def check_numbers(path: Path, numbers: int) -> None:
    """Refuse arrays that hold too many numbers; raises a DataFileError."""
    if numbers > LARGEST_NUMBERS:
        raise too_large(path, f"{numbers:.3g} numbers", f"{LARGEST_NUMBERS:.3g}")


def too_large(path: Path, holds: str, most: str) -> DataFileError:
    """The error of a file that holds more than is read."""
    return DataFileError(
        f"{path} holds {holds}, and at most {most} are read; leave out times or positions."
    )


def content_of(path: Path) -> bytes:
    """All bytes of a text file, unpacked if it is gzipped.

    Raises DataFileError if it is not an ordinary file, a damaged archive, or too large.
    """
    check_file_size(path, LARGEST_TEXT)
    packed = beginning_of(path, 2) == b"\x1f\x8b"
    parts, size = [], 0
    with _readable(path), gzip.open(path, "rb") if packed else path.open("rb") as stream:
        try:
            while part := stream.read(_CHUNK):
                parts.append(part)
                size += len(part)
                if size > LARGEST_TEXT:
                    raise too_large(path, "more", f"{LARGEST_TEXT / 2**20:.0f} MB of text")
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise DataFileError(f"{path} cannot be unpacked ({error}); pack it again.") from error
    return b"".join(parts)
