"""Changes of the pictures, collected and sent to the browser in one message.

Bokeh would send each change of a model separately, in fifty messages per move, which took longer
than the solution.  Bokeh itself sends only the images.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bokeh.model import Model
from bokeh.models import ColumnDataSource, Range1d

FILLED, ROOM = 0.6, 0.04
"""Least share of an axis that values must fill, and the margin near them at first."""


class Board:
    """Changes of models that the browser does not know yet."""

    def __init__(self) -> None:
        self._told: dict[str, dict[str, Any]] = {}
        self._news: dict[str, dict[str, Any]] = {}

    def set(self, model: Model, **properties: Any) -> None:
        """Set properties of a model to lists and numbers."""
        if any(self._told.get(model.id, {}).get(name) != properties[name] for name in properties):
            self._told.setdefault(model.id, {}).update(properties)
            self._news.setdefault(model.id, {}).update(properties)

    def fill(self, source: ColumnDataSource, **columns: Sequence[Any]) -> None:
        """Set columns of a source."""
        self.set(source, data=columns)

    def limit(self, axis: Range1d, low: float, high: float) -> None:
        """Set the limits of an axis; unless they change, the axis stays where a reader moves it."""
        self.set(axis, start=low, end=high, reset_start=low, reset_end=high)

    def follow(self, axis: Range1d, low: float, high: float) -> None:
        """Set the limits of an axis, unless the present ones fit well enough.

        Scales that jump at every move are hard to read.
        """
        told = self._told.get(axis.id)
        if told is not None:
            start, end = told["start"], told["end"]
            if start <= low and high <= end and high - low >= FILLED * (end - start):
                return
        room = ROOM * (high - low)
        self.limit(axis, low - room, high + room)

    def news(self) -> dict[str, dict[str, Any]]:
        """Return the changes since the last call: properties by the id of their model."""
        news, self._news = self._news, {}
        return news
