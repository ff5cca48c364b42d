"""Jobs in a separate process: one at a time, and a new job replaces the one before."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, Literal, NamedTuple

from semianalytic.scene.errors import SlipfrontError


class News(NamedTuple):
    """A message of a process: progress (done, all), the result, or an error message."""

    kind: Literal["progress", "result", "refusal"]
    content: Any


class Worker:
    """A process that calls module-level functions with arguments and a progress callback.

    The callback takes (done, all).  A new job ends the one before it, if necessary by ending the
    process.
    """

    def __init__(self) -> None:
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self.busy = False

    def start(self, function: Callable[..., Any], *arguments: Any) -> None:
        """Start a job; what the one before has not sent yet is lost."""
        if self.busy:
            self.stop()
        if self._pipe is None:
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
        self._pipe.send((function, arguments))
        self.busy = True

    def news(self) -> News | None:
        """Return the newest message since the last call, or None."""
        newest = None
        while (
            self.busy and self._pipe is not None and (newest is None or newest.kind == "progress")
        ):
            try:
                if not self._pipe.poll():
                    break
                newest = News(*self._pipe.recv())
            except (EOFError, OSError):
                newest = News("refusal", "The process that computes it has ended; move a slider.")
                self.stop()
            if newest.kind != "progress":
                self.busy = False
        return newest

    def stop(self) -> None:
        """End the process, whatever it is doing."""
        if self._process is not None:
            self._process.terminate()
            self._process.join()
        if self._pipe is not None:
            self._pipe.close()
        self._process, self._pipe, self.busy = None, None, False


def _serve(pipe: Connection) -> None:
    """Run jobs until the page is gone; this is the main function of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(10)
    with suppress(EOFError, BrokenPipeError):  # the page is gone
        while True:
            function, arguments = pipe.recv()

            def progress(done: int, steps: int) -> None:
                pipe.send(("progress", (done, steps)))

            try:
                pipe.send(("result", function(*arguments, progress)))
            except SlipfrontError as error:
                pipe.send(("refusal", str(error)))
