"""Attributes that are computed when they are first used, without a lock.

In Python 3.11 `functools.cached_property` holds one lock per attribute of a class, for all objects.
Two threads deadlock if each computes such an attribute of one object and needs that of the other,
as happens where the shear problem of an opening uses the normal problem, which is of the same
class.  From 3.12 on there is no lock: two threads may both compute an attribute; they obtain the
same value, and the last one is kept.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

__all__ = ["cached_property"]

if TYPE_CHECKING:
    from functools import cached_property
else:

    class cached_property(functools.cached_property):
        """The `cached_property` of Python 3.12 and later."""

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            """Return the value, which the instance keeps from then on."""
            if instance is None:
                return self
            value = instance.__dict__.get(self.attrname, self)
            if value is self:
                value = instance.__dict__[self.attrname] = self.func(instance)
            return value
