"""Parallel tasks in processes with one linear-algebra thread, which stop cleanly on interrupts."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from types import ModuleType
from typing import Any

from semianalytic.scene.errors import ComputationError

_log = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
Task = tuple[Callable[..., Any], tuple[Any, ...]]

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment variables of a process with one linear-algebra thread."""


def run_tasks(
    tasks: Sequence[Task],
    workers: int | None = None,
    progress: Progress | None = None,
    client: Any = None,
) -> Iterator[tuple[int, Any]]:
    """Call module-level functions in processes; yield (index of task, result) as each finishes.

    The processes do not run the calling program again, so it needs no ``if __name__ ==`` unless
    the functions are its own.  There are as many as cores unless workers are given; with 1, tasks
    run here, in order, and with a client of a Dask cluster its workers run them.  `progress` is
    called with the number of finished tasks and of all tasks.  ComputationError is raised if a
    process is killed (on a cluster: repeatedly), or the cluster does not answer.
    """
    count = min(workers or os.cpu_count() or 1, len(tasks))
    place = "a cluster" if client is not None else f"{max(count, 1)} processes"
    _log.debug("%d tasks on %s", len(tasks), place)
    if client is not None:
        from compare.tasks.cluster import on_cluster

        results = on_cluster(tasks, client)
    else:
        here = ((at, function(*given)) for at, (function, given) in enumerate(tasks))
        results = here if count <= 1 else _in_processes(tasks, count)
    for done, result in enumerate(results, 1):
        if progress is not None:
            progress(done, len(tasks))
        yield result


def in_fresh_process(function: Callable[..., Any], *given: Any) -> Any:
    """Call a module-level function in a new process of one thread; raises as `run_tasks`."""
    ((_, result),) = _in_processes([(function, given)], 1, fresh=True)
    return result


def _in_processes(
    tasks: Sequence[Task], count: int, *, fresh: bool = False
) -> Iterator[tuple[int, Any]]:
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    others = set(multiprocessing.active_children())
    os.environ.update(ONE_THREAD)
    # Copies of this process need no imports; they lack its other threads, whose locks stay locked,
    # and keep the threads of linear algebra that it began with.
    safe = threading.active_count() == 1 and before["OPENBLAS_NUM_THREADS"] == "1"
    copied = safe and not fresh and sys.platform == "linux"
    context = multiprocessing.get_context("fork" if copied else "spawn")
    pool = ProcessPoolExecutor(count, context, initializer=_serve_parent)
    finished = False
    try:
        # Ctrl-C is also held back from workers that are still starting
        with _interrupts_held_back(), _without_main(tasks):
            futures = {
                pool.submit(function, *arguments): index
                for index, (function, arguments) in enumerate(tasks)
            }
        for future in as_completed(futures):
            yield futures[future], future.result()
        finished = True
    except BrokenProcessPool as error:
        raise ComputationError(
            "a worker process was killed, as happens when memory runs out; "
            "make room and start again, with fewer points if need be."
        ) from error
    finally:
        if not finished:
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Delay Ctrl-C, and hide it from processes started meanwhile, where the system allows it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _without_main(tasks: Sequence[Task]) -> Iterator[None]:
    """Keep processes from running the main program again, unless it defines a function of tasks."""
    main = sys.modules["__main__"]
    if all(function.__module__ != main.__name__ for function, _ in tasks):
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _serve_parent() -> None:
    """Initialise a worker: leave Ctrl-C to the parent, and end when the parent ends in any way."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a copy of the parent has that of the parent
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=([parent.sentinel],), daemon=True).start()


def _end_after(sentinels: list[Any]) -> None:
    wait(sentinels)
    os._exit(1)
