"""Texts of users: ordinary files of a size that can be meant, or refused at once."""

from __future__ import annotations

import errno
import os
import stat
from os import PathLike
from pathlib import Path

LARGEST = 2**26
"""Bytes of a description or a table of one: 64 MB, a million rows."""


def text_of(path: str | PathLike[str]) -> str:
    """Return the text of a file in UTF-8, without the mark that spreadsheets put before it.

    Raises
    ------
    OSError
        If it cannot be read, is a pipe or a device, which may never end, or is too large.
    ValueError
        If it is not in UTF-8.
    """
    status = os.stat(path)
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "it is not an ordinary file; save what it gives in one")
    if status.st_size > LARGEST:
        raise OSError(errno.EFBIG, f"it has more than {LARGEST >> 20} MB")
    return Path(path).read_text(encoding="utf-8-sig")
