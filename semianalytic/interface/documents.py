"""Interfaces as text and numbers, and whether other processes can receive them."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from semianalytic.interface.fields import Expression
from semianalytic.interface.interface import Interface

_POINTS, _TIMES = 257, 9
"""Positions and times at which functions are sampled to tell one interface from another."""


def interface_document(
    interface: Interface, end: float, options: Mapping[str, Any]
) -> dict[str, Any]:
    """Return an interface, its end time and the options of its run as text and numbers, for JSON.

    Functions are told apart by their values at some positions and times.
    """
    x = np.linspace(-interface.length / 2, interface.length / 2, _POINTS)
    t = np.linspace(0.0, end, _POINTS)
    return {
        "interface": _written(interface, x, t),
        "end_time": end,
        "options": {name: _written(value, x, t) for name, value in options.items()},
    }


def _written(value: Any, x: Any, t: Any) -> Any:
    # JSON has these as they are; numbers of numpy become Python's own below.
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        # JSON has no infinity.
        return value if np.isfinite(value) else str(value)
    if isinstance(value, Expression):
        return {"text": value.text, **value.numbers} if value.numbers else value.text
    if isinstance(value, tuple | list):
        return [_written(one, x, t) for one in value]
    if isinstance(value, np.ndarray):
        long = value.size > _POINTS
        return hashlib.sha256(value.tobytes()).hexdigest() if long else value.tolist()
    if isinstance(value, np.floating | np.integer):
        return value.item()
    if is_dataclass(value) and not isinstance(value, type):
        written = {one.name: _written(getattr(value, one.name), x, t) for one in fields(value)}
        return {"kind": type(value).__name__, **written}
    if callable(value):
        return {"function": _digest(value, x, t)}
    return repr(value)


def _digest(function: Callable[..., Any], x: Any, t: Any) -> str:
    """Return a digest of the values of a function of x, of x and t, or of t."""
    digest = hashlib.sha256()
    # A function does not say what it takes: all three ways are tried, and failures count too.
    for arguments in ((x,), *((x, one) for one in t[:: _POINTS // _TIMES]), *((one,) for one in t)):
        try:
            digest.update(np.asarray(function(*arguments), dtype=float).tobytes())
        except Exception:  # a function of other arguments fails in any way
            digest.update(b"-")
    return digest.hexdigest()


def can_travel(interface: Interface) -> bool:
    """Return whether other processes can receive an interface.

    They cannot receive functions and laws of a notebook or of the program that is running.
    """
    try:
        # Pickle refers to such functions by name, and other processes have another __main__.
        return b"__main__" not in pickle.dumps(interface)
    except Exception:  # what cannot be pickled fails in any way
        return False
