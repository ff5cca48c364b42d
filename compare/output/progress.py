"""Progress display of long runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich import progress
from rich.console import Console
from rich.text import Text


class StepRateColumn(progress.ProgressColumn):
    """Current rate in steps per second, once two steps are known."""

    def render(self, task: progress.Task) -> Text:
        """Return the rate with three digits."""
        rate = task.finished_speed or task.speed
        return Text("" if rate is None else f"{rate:.3g} steps/s")


@contextmanager
def progress_bar(
    console: Console, quiet: bool, doing: str = "simulating"
) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar with percentage, step rate and remaining time.

    It yields a function of the number of finished steps and of all steps.  Nothing is shown if
    `quiet` is true or the output is no terminal.
    """
    with progress.Progress(
        progress.TextColumn(doing),
        progress.BarColumn(),
        progress.TaskProgressColumn(),
        progress.MofNCompleteColumn(),
        StepRateColumn(),
        progress.TimeRemainingColumn(),
        console=console,
        disable=quiet or not console.is_terminal,
        transient=True,
        auto_refresh=False,  # by a thread, with which no process could be a copy of this one
    ) as bar:
        task, drawn = bar.add_task(doing, total=None), -1.0

        def show(done: int, total: int) -> None:
            nonlocal drawn
            due = monotonic() - drawn > 0.1
            bar.update(task, completed=done, total=total, refresh=due)
            drawn = monotonic() if due else drawn

        yield show
