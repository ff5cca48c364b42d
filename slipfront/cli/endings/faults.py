"""Ends of commands: exit codes, and the sentence and the report of a fault of the program (70).

This module imports only the standard library, because it must work when other packages are broken.
"""

from __future__ import annotations

import os
import platform
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence

CRASHED = 70
"""EX_SOFTWARE of sysexits.h."""
READER_GONE, INTERRUPTED, TERMINATED = 141, 130, 143
"""Exit codes that a shell reports for programs ended by SIGPIPE, SIGINT and SIGTERM."""
INTERRUPTION = "Interrupted; files not yet complete were not written."
_PACKAGES = ("slipfront", "numpy", "scipy", "typer", "rich", "h5py", "xarray", "gmsh", "matplotlib")
_LONGEST = 200
_REPORT = """\
slipfront met a fault of its own; the input may be correct.

To report it, open an issue at the source of slipfront, and attach this file and the files that the
command read.  Check this file before: it contains the command line and names of folders.

command:  {command}
python:   {python}
system:   {system}
packages: {packages}

{traceback}"""


def crashed(error: BaseException, arguments: Sequence[str]) -> int:
    """Report an exception that nothing caught, and name it in a sentence; return `CRASHED`."""
    words = " ".join(f"{type(error).__name__}: {error}".split())
    what = words if len(words) <= _LONGEST else f"{words[:_LONGEST]}…"
    text = _REPORT.format(
        command=shlex.join(["slipfront", *map(str, arguments)]),
        python=f"{sys.version.split()[0]} at {sys.executable}",
        system=platform.platform(),
        packages=", ".join(filter(None, map(_installed, _PACKAGES))),
        traceback="".join(traceback.format_exception(error)),
    )
    try:
        descriptor, path = tempfile.mkstemp(prefix="slipfront-fault-", suffix=".txt")
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="replace") as stream:
            stream.write(text)
        where = f"{path} holds what is needed for that"
    except OSError:
        print(text, file=sys.stderr)
        where = "what is needed for that stands above"
    sentence = f"slipfront met a fault of its own ({what}); please report it: {where}."
    print(printable(sentence), file=sys.stderr)
    return CRASHED


def printable(message: object) -> str:
    """Return a message on one line without characters that a terminal would act on."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(message))


def _installed(package: str) -> str:
    """Return a package and its version; an empty string if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version  # 30 ms that few commands need

    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return ""
