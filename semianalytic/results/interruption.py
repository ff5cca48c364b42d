"""Deferred handling of Ctrl-C, so that a computation in steps never leaves a step half done."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class Interruption:
    """A flag that is set once Ctrl-C was pressed."""

    pressed = False


@contextmanager
def deferred_interrupt() -> Iterator[Interruption]:
    """Note the first Ctrl-C instead of interrupting, so that a step is never left half done.

    The second Ctrl-C interrupts at once.  Outside the main thread nothing is changed.
    """
    noted = Interruption()
    before = signal.getsignal(signal.SIGINT)

    def note(number: int, frame: Any) -> None:
        noted.pressed = True
        signal.signal(signal.SIGINT, before)

    try:
        signal.signal(signal.SIGINT, note)
    except ValueError:  # not the main thread
        yield noted
        return
    try:
        yield noted
    finally:
        signal.signal(signal.SIGINT, before)


def whole(answer: Any) -> Any:
    """Return an answer; raise KeyboardInterrupt if it is a march that Ctrl-C ended early.

    It is for what goes on with the answer, which is not to go on then.
    """
    if getattr(answer, "is_interrupted", False):
        raise KeyboardInterrupt
    return answer
