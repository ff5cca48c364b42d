"""Work shared out over processes of one linear-algebra thread, stopped cleanly on interrupt."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

Progress = Callable[[int, int], None]
Task = tuple[Callable[..., Any], tuple[Any, ...]]
Item = TypeVar("Item")

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""What the environment of a process of one linear-algebra thread holds."""


def counted(items: Iterable[Item], count: int, progress: Progress | None) -> Iterator[Item]:
    """The items as they are made; `progress` is told how many of the count there are."""
    for done, item in enumerate(items, 1):
        if progress is not None:
            progress(done, count)
        yield item


def run_tasks(
    tasks: Sequence[Task], workers: int | None = None, progress: Progress | None = None
) -> Iterator[tuple[int, Any]]:
    """Call module-level functions in processes; yield (index of task, result) as each is done.

    Parameters
    ----------
    tasks : sequence of (function, arguments)
    workers : int, optional
        Number of processes; the number of cores unless given.  1 runs here, in order.
    progress : callable, optional
        Called with the number of tasks done and the number of all tasks.
    """
    count = min(workers or os.cpu_count() or 1, len(tasks))
    results = _in_order(tasks) if count <= 1 else _in_processes(tasks, count)
    yield from counted(results, len(tasks), progress)


def _in_order(tasks: Sequence[Task]) -> Iterator[tuple[int, Any]]:
    for index, (function, arguments) in enumerate(tasks):
        yield index, function(*arguments)


def _in_processes(tasks: Sequence[Task], count: int) -> Iterator[tuple[int, Any]]:
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    pool = ProcessPoolExecutor(
        count, multiprocessing.get_context("spawn"), initializer=_leave_interrupts_to_parent
    )
    try:
        futures = {
            pool.submit(function, *arguments): index
            for index, (function, arguments) in enumerate(tasks)
        }
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
