"""Files that appear complete or not at all, and in which damage is detected.

A new file is filled under a temporary name in its folder and renamed when it is on the disk; a
temporary file that a killed writer has left is removed by the next one.  A file that is read back
ends in a seal, the SHA-256 of everything before it, which is checked before anything is parsed.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import Any

from semianalytic.scene.errors import DataFileError
from semianalytic.scene.extras import needing

NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}

_SEALED = re.compile(
    rb"(?:\$Comments\n|<!-- |\n)slipfront sha256 ([0-9a-f]{64})(?:\n\$EndComments| -->|)\n\Z"
)
_UNSEALED = "it has lost its checksum"
_KEEPS_WHAT_IS_OPEN = sys.platform == "win32"
"""Whether the system neither renames nor removes a file that is open.

Such a file is closed before it gets its name.  Elsewhere it stays locked until then, so that
another writer does not take it for what a killed one has left."""
_LOCKED_BYTE = 2**31 - 2
"""Byte that a lock covers on Windows, where nobody else can read or write what is locked."""


class Seal(Enum):
    """The text around the seal at the end of a file, chosen so that other programs can read it."""

    TRAILING = ("\n", "\n")
    """The seal after the end of an HDF5 file, where its readers do not look."""
    XML = ("<!-- ", " -->\n")
    MSH = ("$Comments\n", "\n$EndComments\n")

    def of(self, digest: str) -> bytes:
        """Return the seal of a file of this SHA-256, in hexadecimal digits."""
        before, after = self.value
        return f"{before}slipfront sha256 {digest}{after}".encode()


@contextmanager
def new_file(
    path: str | Path, size: int = 0, seal: Seal | None = None, suffix: str = ""
) -> Iterator[Path]:
    """Open a temporary file to fill, which takes its place under `path` when it is on the disk.

    An earlier file under `path` stays until then.  Missing folders are made.  The size is the final
    one, if it is known [bytes], for the message if the disk is too small; the seal is put at the
    end, and the temporary name ends in the suffix.

    Raises DataFileError if the file or its folder cannot be written; if the disk is too small, the
    message says how much is needed and free.
    """
    made: list[Path] = []
    held: tuple[Path, int | None] | None = None
    try:
        # A link stays a link: the file that it points to is replaced.
        place = Path(os.path.realpath(path))
        made = make_folder(place.parent)
        if place.exists() and not place.is_file():
            reason = errno.EISDIR if place.is_dir() else errno.EINVAL
            raise OSError(reason, "it is not an ordinary file")
        _sweep(place)
        held = part, descriptor = _new_part(place, suffix)
        yield part
        if seal is not None:
            with part.open("r+b") as stream:
                end = seal.of(hashlib.file_digest(stream, "sha256").hexdigest())
                stream.seek(0, os.SEEK_END)
                stream.write(end)
        # The contents reach the disk before the name does: a crash between the two leaves the
        # earlier file, never an empty one.
        os.fsync(descriptor)
        size = max(size, os.fstat(descriptor).st_size)
        if _KEEPS_WHAT_IS_OPEN:
            os.close(descriptor)
            held = part, None
        os.replace(part, place)
        made = []
    except OSError as error:
        if held is not None:
            if held[1] is not None:
                size = max(size, os.fstat(held[1]).st_size)
            discard(*held)
            held = None
        raise DataFileError(refusal(Path(path), error, size)) from error
    finally:
        if held is not None:
            discard(*held)
        remove_empty(made)


def write_bytes(path: str | Path, data: Any, seal: Seal | None = None) -> None:
    """Write bytes as a file that appears complete or not at all; DataFileError if it cannot."""
    end = b"" if seal is None else seal.of(hashlib.sha256(data).hexdigest())
    with new_file(path, len(data) + len(end)) as part, part.open("r+b") as stream:
        stream.write(data)
        stream.write(end)


@contextmanager
def whole_hdf5(path: str | Path) -> Iterator[Any]:
    """Open a new sealed HDF5 file to fill, which appears under its name only when complete.

    It is filled in memory and written at the end, because HDF5 files are spoiled if the disk
    becomes full.  Raises MissingLibraryError without h5py, and DataFileError as `new_file`.
    """
    with needing("an HDF5 file"):
        import h5py

    image = BytesIO()
    with h5py.File(image, "w") as file:
        yield file
    write_bytes(path, image.getbuffer(), Seal.TRAILING)


@contextmanager
def sealed_hdf5(path: str | Path) -> Iterator[Any]:
    """Open an HDF5 file written by `whole_hdf5` for reading.

    Its seal is checked before it is opened.  A file without a seal is opened, so that a foreign
    file can be told from a damaged one, and refused at the end.  Raises MissingLibraryError without
    h5py, OSError if it cannot be opened, and ValueError if its seal is broken or missing.
    """
    with needing("an HDF5 file"):
        import h5py

    sealed = has_seal(path)
    with h5py.File(path, "r") as file:
        yield file
    if not sealed:
        raise ValueError(_UNSEALED)


def check_seal(path: str | Path) -> None:
    """Raise OSError if a file cannot be read, ValueError if its seal is broken or missing."""
    if not has_seal(path):
        raise ValueError(_UNSEALED)


def has_seal(path: str | Path) -> bool:
    """Return whether a file ends in a seal; raise ValueError if it does not match the rest."""
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):  # a pipe or a device may have no end
        raise ValueError("it is not an ordinary file")
    with Path(path).open("rb") as stream:
        start = max(status.st_size - 160, 0)
        # The seal is at the end: the last bytes show whether there is one.
        stream.seek(start)
        seal = _SEALED.search(stream.read())
        if seal is None:
            return False
        left = start + seal.start()
        stream.seek(0)
        digest = hashlib.sha256()
        while left and (chunk := stream.read(min(left, 1 << 20))):
            digest.update(chunk)
            left -= len(chunk)
    if digest.hexdigest() != seal[1].decode():
        raise ValueError("its checksum does not fit what it holds: it is damaged")
    return True


def row_checksum(cells: list[str]) -> str:
    """Return the checksum of a row of a table, for tables that are read back or grow by rows."""
    # 64 bits find damage; nobody has a reason to forge a row of his own table.
    return hashlib.sha256("\n".join(cells).encode()).hexdigest()[:16]


def make_folder(folder: Path) -> list[Path]:
    """Make a folder and those above; return missing ones, innermost first, or none if it fails."""
    missing = []
    for place in (folder, *folder.parents):
        if place.exists():
            break
        missing.append(place)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        remove_empty(missing)
        raise
    return missing


def remove_empty(folders: list[Path]) -> None:
    """Remove folders, innermost first, as far as they are empty."""
    with suppress(OSError):
        for folder in folders:
            folder.rmdir()


def try_lock(descriptor: int) -> bool:
    """Try to lock an open file; the system releases the lock when the process ends.

    Return whether it was locked; True where the file system has no such locks.
    """
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        # Any other error says that the file system has no locks, and then nobody holds one.
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES)
    return True


def _new_part(place: Path, suffix: str) -> tuple[Path, int]:
    """Make an empty, locked file next to `place`; return its path and descriptor."""
    while True:
        part = place.with_name(f".{_stem(place)}.{secrets.token_hex(6)}.part{suffix}")
        descriptor = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        # another writer may have taken it for a dead one before it was locked
        if try_lock(descriptor) and os.fstat(descriptor).st_nlink:
            return part, descriptor
        os.close(descriptor)


def discard(part: Path, descriptor: int | None) -> None:
    """Remove a file that this process has locked, if it still has that name, and close it."""
    if descriptor is not None and _KEEPS_WHAT_IS_OPEN:
        os.close(descriptor)
        descriptor = None
    with suppress(OSError):
        # Removed while it is still locked, or another writer could sweep it up in between.
        part.unlink(missing_ok=True)
    if descriptor is not None:
        os.close(descriptor)


def _sweep(place: Path) -> None:
    """Remove temporary files that killed writers of the same file have left."""
    leftover = re.compile(re.escape(f".{_stem(place)}.") + r"[0-9a-f]{12}\.part(\.\w+)?")
    with os.scandir(place.parent) as entries:
        names = [entry.name for entry in entries if leftover.fullmatch(entry.name)]
    for name in names:
        part = place.with_name(name)
        with suppress(OSError):
            # Opening a pipe of that name would wait for ever.
            if not stat.S_ISREG(part.lstat().st_mode):
                continue
            descriptor = os.open(part, os.O_RDWR)
            if try_lock(descriptor):
                discard(part, descriptor)
            else:
                os.close(descriptor)


def _stem(place: Path) -> str:
    """Shorten a name so that an ending can be added."""
    # The whole temporary name must fit into the 255 bytes that file systems allow.
    return place.name[:40]


def refusal(path: Path, error: OSError, needed: int) -> str:
    """Say in one sentence why a file of `needed` bytes cannot be written."""
    reason = error.strerror or str(error)
    if error.errno not in NO_ROOM:
        return f"Cannot write {path}: {reason}."
    folder = path.absolute().parent
    free = shutil.disk_usage(folder).free
    return (
        f"Cannot write {path}: {reason}; at least {needed:,} bytes are needed in {folder} and "
        f"{free:,} are free."
    )
