"""Former names, which keep working for one minor version and warn; CHANGELOG lists them."""

from __future__ import annotations

import warnings
from typing import Any


def renamed(former: str, name: str, removed_in: str) -> Any:
    """Return a property that gives an attribute or a method under its former name.

    Parameters
    ----------
    former, name : str
        The name that is going away, under which the property is stored, and the present one.
    removed_in : str
        First version without the former name.

    Examples
    --------
    >>> class Answer:
    ...     edge_speeds = (0.0, 0.9)
    ...     front_speeds = renamed("front_speeds", "edge_speeds", "0.3")
    >>> Answer().front_speeds  # and a DeprecationWarning
    (0.0, 0.9)
    """

    def get(self: object) -> Any:
        warn_of(f"{type(self).__name__}.{former}", name, removed_in)
        return getattr(self, name)

    return property(get, doc=f"Former name of `{name}`, removed in {removed_in}.")


def warn_of(former: str, name: str, removed_in: str) -> None:
    """Warn the caller of the caller that a name is going away."""
    warnings.warn(
        f"{former} is called {name} now; the former name will be removed in {removed_in}.",
        DeprecationWarning,
        stacklevel=3,
    )
