"""Computations in other processes: fields while a slider moves, marches, maps of regimes.

A process has one job at a time, and a new job replaces the one before.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, Literal, NamedTuple
from urllib.parse import parse_qsl, urlencode

from semianalytic import Marched, Scene, solve
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError, SlipfrontError
from slipfront.explore.views import DISPLACEMENT, SPEED, FieldView, end_time, field_view

Progress = Callable[[int, int], object]

MARCH_POINTS = 40
"""Points across the picture of the field of a march."""
STEPS_TOLD = 50
"""Number of progress reports of a march."""


class Moment(NamedTuple):
    """Time over T of pictures of both bodies, and the name of the quantity that they show."""

    share: float = 1.0
    of: str = SPEED

    @property
    def query(self) -> str:
        """The part of the address after that of the scene, ``&time=0.4&picture=displacement``."""
        said = {"time": f"{self.share:.6g}", "picture": self.of}
        usual = {"time": "1", "picture": SPEED}
        return "".join(f"&{urlencode({k: v})}" for k, v in said.items() if v != usual[k])


LEAST_SHARE = 0.05
"""Earliest time that pictures show, over T; the first waves are narrower than a few pixels then."""


def moment_in(query: str) -> tuple[Moment, str]:
    """Return the moment that an address names, and the address without it.

    A SceneError refuses a time beyond the slider's, and a picture that there is none of.
    """
    pairs = parse_qsl(query.removeprefix("?"), keep_blank_values=True)
    named, rest = dict(pairs), [pair for pair in pairs if pair[0] not in ("time", "picture")]
    text, of = named.get("time", "1"), named.get("picture", SPEED)
    try:
        share = float(text)
    except ValueError:
        share = 0.0
    if not LEAST_SHARE <= share <= 1.0:
        raise SceneError(f"time must be t / T from {LEAST_SHARE} to 1, got {shown(text)}.")
    if of not in (SPEED, DISPLACEMENT):
        raise SceneError(f"picture must be {SPEED} or {DISPLACEMENT}, got {shown(of)}.")
    return Moment(share, of), f"?{urlencode(rest)}" if rest else ""


def solved_field(
    scene: Scene, points: int, rtol: float, moment: Moment, progress: Progress
) -> FieldView:
    """Compute the field of a self-similar scene, or of two different bodies."""
    return field_view(solve(scene, rtol=rtol), points, *moment)


def marched_field(done: Marched, moment: Moment, progress: Progress) -> FieldView:
    """Compute the field of a march that is done, which takes as long as the march."""
    return field_view(done, MARCH_POINTS, *moment)


def marched(scene: Scene, progress: Progress) -> Marched:
    """March a scene until T."""

    told = 0

    def tell(time: float, end: float) -> None:
        nonlocal told
        if (share := int(STEPS_TOLD * time / end)) > told:
            told = share
            progress(told, STEPS_TOLD)

    found: Marched = solve(scene, method="space-time", end_time=end_time(scene), progress=tell)
    return found


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
