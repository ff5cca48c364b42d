"""Tasks on the workers of a Dask cluster, which may join and leave at any time."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import needing

PATIENCE = 5.0
"""Time to wait for a scheduler, and for a first worker [s]."""


@contextmanager
def connected(address: str | None, patience: float = PATIENCE) -> Iterator[Any]:
    """Connect to the scheduler at an address (tcp://host:8786); yield None without an address.

    SceneError if the address is invalid, ComputationError if no scheduler answers there, and
    MissingLibraryError if Dask is not installed.
    """
    if address is None:
        yield None
        return
    with needing("--scheduler"):
        from distributed import Client
        from distributed.comm import parse_address
        from distributed.comm.registry import get_backend
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # exceptions report failures
    try:
        get_backend(parse_address(address, strict=True)[0])
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise ComputationError(
            f"No Dask scheduler answers at {address} within {patience:g} s; start one with "
            "`dask scheduler`, or give its address."
        ) from error
    except ValueError as error:
        raise SceneError(
            f"--scheduler must be an address such as tcp://127.0.0.1:8786, got {shown(address)}."
        ) from error
    with client:
        yield client


def on_cluster(
    tasks: Sequence[tuple[Callable[..., Any], tuple[Any, ...]]], client: Any
) -> Iterator[tuple[int, Any]]:
    """Call functions on the workers of a cluster; yield (index, result) as each finishes.

    Tasks of a lost worker are repeated by another one.  A ComputationError says that there is no
    worker, one has another version, a task has ended several, or the scheduler is lost.
    """
    from distributed import CancelledError, KilledWorker, as_completed

    if not tasks:
        return
    check_workers(client)
    functions, arguments = zip(*tasks, strict=True)
    futures = client.map(_called, functions, arguments, pure=False)
    places = {future.key: index for index, future in enumerate(futures)}
    try:
        for future, result in as_completed(futures, loop=client.loop, with_results=True):
            yield places.pop(future.key), result
            future.release()  # otherwise the workers would keep all results
    except KilledWorker as error:
        raise ComputationError(
            "a task has ended several workers of the cluster, as happens when memory runs out; "
            "give workers more memory, or ask for smaller chunks."
        ) from error
    except (OSError, TimeoutError, CancelledError) as error:
        raise ComputationError(
            "The scheduler of the cluster was lost; start again to continue."
        ) from error
    finally:
        if places:
            client.cancel([future for future in futures if future.key in places], force=True)


def check_workers(client: Any, patience: float = PATIENCE) -> None:
    """Raise ComputationError unless there are workers, and all have this version of slipfront."""
    if not hasattr(client, "wait_for_workers"):
        raise SceneError(f"client must be one of dask.distributed, got {shown(client)}.")
    own = version("slipfront")
    try:
        client.wait_for_workers(1, timeout=patience)
        versions = client.run(version, "slipfront", on_error="return")
    except (OSError, TimeoutError) as error:
        raise ComputationError(
            "The Dask scheduler has no workers; start some with `dask worker ADDRESS`."
        ) from error
    for address, there in versions.items():
        if there != own:
            missing = isinstance(there, PackageNotFoundError)
            held = "no slipfront" if missing else f"slipfront {there}"
            raise ComputationError(
                f"The worker {address} has {held} and this is {own}; install slipfront {own} "
                "where workers run."
            )


def _called(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call a function; runs on a worker."""
    return function(*arguments)
