"""Attributes that are worked out when they are first asked for, without a lock.

Python 3.11 has `functools.cached_property` hold a lock per attribute of a class, whatever the
object: two threads that ask two objects for attributes of which each needs the other's wait for one
another for ever, as where the shear problem of an opening asks the normal one, which is of the same
class.  From 3.12 on there is no lock.  Two threads may then both work an attribute out; they come
to the same value, and the last one is kept.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

__all__ = ["cached_property"]

if TYPE_CHECKING:
    from functools import cached_property
else:

    class cached_property(functools.cached_property):
        """That of Python 3.12 and later."""

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            """The value, which the instance keeps from then on."""
            if instance is None:
                return self
            value = instance.__dict__.get(self.attrname, self)
            if value is self:
                value = instance.__dict__[self.attrname] = self.func(instance)
            return value
