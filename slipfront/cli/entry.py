"""Entry point of the program ``slipfront``; it installs signal handlers before importing the rest.

Ctrl-C and SIGTERM both end a command as an interruption: unfinished files are discarded, finished
ones are kept, a message is printed, and the exit code is 130 or 143.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from types import FrameType
from typing import Any

from slipfront.cli.endings.faults import (
    INTERRUPTED,
    INTERRUPTION,
    READER_GONE,
    TERMINATED,
    crashed,
    printable,
)
from slipfront.hidden import hiding

BROKEN_FILE, BROKEN_PACKAGE = 3, 5
"""Exit codes of `DataFileError` and `PluginError`, repeated here as their import may fail."""


def main() -> int:
    """Run the command line of this process and return its exit code, like `commands.main`.

    It is 143 if it was ended by SIGTERM, 5 if a package that it imports is missing or broken.
    """
    terminated = False

    def terminate(number: int, frame: FrameType | None) -> None:
        """Do what Ctrl-C does at this moment, even if Ctrl-C is ignored, as in background jobs."""
        nonlocal terminated
        terminated = True
        on_interrupt = signal.getsignal(signal.SIGINT)
        if callable(on_interrupt):
            on_interrupt(signal.SIGINT, frame)
        else:
            raise KeyboardInterrupt

    sys.unraisablehook = interrupt_again
    heeded = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    try:
        # nothing has begun during the imports, and importing code might swallow an exception
        signal.signal(signal.SIGTERM, _leave)
        if heeded:
            signal.signal(signal.SIGINT, _leave)
        if hidden := hiding():  # before a file of the user runs as if it were a part of slipfront
            print(printable(hidden), file=sys.stderr)
            return BROKEN_PACKAGE
        if sys.argv[1:2] == ["survey"]:  # whose processes are copies of this one, one for each core
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        from slipfront.cli import commands as cli

        cli.command_for(sys.argv[1:])  # which imports the command
        signal.signal(signal.SIGTERM, terminate)
        if heeded:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        code = _flushed(cli.main())
    except KeyboardInterrupt:
        print(INTERRUPTION, file=sys.stderr)
        code = INTERRUPTED
    except ImportError as error:
        reason = f"slipfront cannot start ({error}); install it anew with all it needs."
        print(printable(reason), file=sys.stderr)
        code = BROKEN_PACKAGE
    except Exception as error:
        code = crashed(error, sys.argv[1:])
    # the command is complete, so a signal must not change its exit code any more
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    return TERMINATED if terminated and code == INTERRUPTED else code


def interrupt_again(unraisable: Any) -> None:
    """Interrupt anew if an interruption came where Python drops exceptions, as in `__del__`."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        threading.Timer(0.05, _thread.interrupt_main).start()  # when that code has ended
    else:
        sys.__unraisablehook__(unraisable)


def _flushed(code: int) -> int:
    """Flush the output and return the exit code; otherwise Python itself would exit with 120."""
    if sys.stdout is None:  # stdout was closed before the program began
        return code
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return code or READER_GONE
        print(f"Cannot write the output: {error.strerror or error}.", file=sys.stderr)
        return code or BROKEN_FILE
    return code


def _leave(number: int, frame: FrameType | None) -> None:
    os.write(2, f"{INTERRUPTION}\n".encode())
    os._exit(128 + number)
