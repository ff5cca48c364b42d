"""How far a long run has come, shown while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class StepRateColumn(ProgressColumn):
    """Steps per second of late, once two of them are known."""

    def render(self, task: Task) -> Text:
        """The rate, to three digits."""
        rate = task.finished_speed or task.speed
        return Text("" if rate is None else f"{rate:.3g} steps/s")


@contextmanager
def progress_bar(
    console: Console, quiet: bool, doing: str = "simulating"
) -> Iterator[Callable[[int, int], None]]:
    """A progress bar with percentage, step rate and time left.

    Nothing is shown when quiet or not on a terminal.

    Yields
    ------
    callable
        To be called with the number of steps done and the number of all steps.
    """
    with Progress(
        TextColumn(doing),
        BarColumn(),
        TaskProgressColumn(),
        MofNCompleteColumn(),
        StepRateColumn(),
        TimeRemainingColumn(),
        console=console,
        disable=quiet or not console.is_terminal,
        transient=True,
    ) as bar:
        task = bar.add_task(doing, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
