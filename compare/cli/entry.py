"""Where the program ``slipfront`` starts: signals are taken care of before anything is imported.

Ctrl-C and SIGTERM both end a command as an interruption: what is being written is dropped, what was
computed before is kept, one line says so, and the exit code is 130 or 143.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

from compare.cli.interruption import INTERRUPTED, INTERRUPTION, TERMINATED


def main() -> int:
    """Run the command line of this process and return its exit code, as `commands.main`.

    Returns
    -------
    int
        143 if it was ended by SIGTERM.
    """
    terminated = False

    def terminate(number: int, frame: FrameType | None) -> None:
        """Do what Ctrl-C would do now; also where Ctrl-C is ignored, as in background jobs."""
        nonlocal terminated
        terminated = True
        on_interrupt = signal.getsignal(signal.SIGINT)
        if callable(on_interrupt):
            on_interrupt(signal.SIGINT, frame)
        else:
            raise KeyboardInterrupt

    heeded = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    try:
        # while modules are imported nothing has begun, and an exception might get lost in them
        signal.signal(signal.SIGTERM, _leave)
        if heeded:
            signal.signal(signal.SIGINT, _leave)
        from compare.cli import commands as cli

        signal.signal(signal.SIGTERM, terminate)
        if heeded:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        code = cli.main()
    except KeyboardInterrupt:
        print(INTERRUPTION, file=sys.stderr)
        code = INTERRUPTED
    # all is done; what is left is to end
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    return TERMINATED if terminated and code == INTERRUPTED else code


def _leave(number: int, frame: FrameType | None) -> None:
    os.write(2, f"{INTERRUPTION}\n".encode())
    os._exit(128 + number)
