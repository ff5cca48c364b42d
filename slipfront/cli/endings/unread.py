"""Columns of tables that no field of a scene is read from: every command says them once."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from semianalytic.scene.errors import SceneError
from semianalytic.scene.tables.columns import UnreadColumns

NOTES: list[str] = []
"""Remarks of the current command, for the document of --json."""


@contextmanager
def unread_said(*, as_json: bool) -> Iterator[None]:
    """Collect what is not read while a command runs, and print it behind the summary."""
    NOTES.clear()
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def show(message: Any, category: type[Warning], *where: Any, **more: Any) -> None:
            if not issubclass(category, UnreadColumns):
                usual(message, category, *where, **more)
            elif str(message) not in NOTES:
                NOTES.append(str(message))

        warnings.simplefilter("always", UnreadColumns)
        warnings.showwarning = show
        try:
            yield
        except SceneError:
            NOTES.clear()  # a refusal is all that it says
            raise
        finally:
            for note in () if as_json else NOTES:
                print(note)
