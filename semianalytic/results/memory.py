"""The memory that a computation may take, and the refusal of computations that need more."""

from __future__ import annotations

import os
from pathlib import Path

from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError

GIGABYTE = 10**9

_MEMINFO = Path("/proc/meminfo")
_GROUPS = (
    (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")),
    (
        Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
        Path("/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ),
)


def available_memory() -> int:
    """Return the memory that the machine, or the container of this process, has left [bytes].

    It is taken as 4 GB where the system gives no information.
    """
    amounts = [_of_machine()]
    # A container may have less than its machine: its control group says so, of version 2 or of
    # version 1.
    for limit, used in _GROUPS:
        try:
            amounts.append(int(limit.read_text()) - int(used.read_text()))
        except (OSError, ValueError):
            continue  # no such group, or "max": no limit
    known = [amount for amount in amounts if amount is not None]
    return max(0, min(known)) if known else 4 * GIGABYTE


def _of_machine() -> int | None:
    """Return the memory that the machine has left [bytes]; None where it is not known."""
    try:
        for line in _MEMINFO.read_text(encoding="ascii").splitlines():
            name, _, rest = line.partition(":")
            if name == "MemAvailable":
                return int(rest.split()[0]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    try:
        # Systems without /proc state how much memory there is, not how much is free: half of it is
        # assumed.
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, OSError, ValueError):
        return None


def memory_limit(limit: float | None) -> int:
    """Return the limit that was given, or 70 % of the available memory [bytes]."""
    if limit is None:
        return int(0.7 * available_memory())
    return int(
        checked_number("memory", limit, "be a positive number of bytes", lambda given: given > 0)
    )


def check_memory(needed: int, limit: float | None, what: str, advice: str) -> int:
    """Return what a computation may take [bytes]; refuse it before it starts if it needs more.

    `needed` is the predicted peak [bytes], `limit` what it may take [bytes], 70 % of what is
    available if None; `what` is the computation, as the subject of the sentence, and `advice` the
    change to make, as its end without the full stop.  Raises SceneError if more is needed than
    there may be, or the limit is not a positive number.
    """
    allowed = memory_limit(limit)
    if needed > allowed:
        whose = "are available to it" if limit is None else "are allowed"
        raise SceneError(
            f"{what} would take {gigabytes(needed)} of memory, and {gigabytes(allowed)} {whose}; "
            f"{advice}."
        )
    return allowed


def gigabytes(amount: int) -> str:
    """Write an amount of memory [bytes] in words, of any size."""
    # Beyond the range of floats a whole number is written by its number of digits.
    if amount >= 10**300:
        return f"1e{len(str(amount)) - 10} GB"
    return f"{amount / GIGABYTE:.3g} GB"
