"""Tables for the terminal, whose numbers keep their digits however narrow the terminal is."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import rich.table


class PrintedTable(rich.table.Table):
    """A table that breaks words and numbers where a narrow terminal cannot hold them.

    Tables of rich cut them, and 2.2e-13 cut to "2.2e…" is wrong by powers of ten.
    """

    def __init__(self, *words: str, numbers: Iterable[str] = (), **options: Any) -> None:
        """Take headings of words and of numbers, which stand to the right, and options of rich."""
        super().__init__(*words, **options)
        for heading in numbers:
            self.add_column(heading, justify="right")

    def add_column(self, *header: Any, **options: Any) -> None:
        """Add a column as rich does, with "fold" as default overflow."""
        super().add_column(*header, **{"overflow": "fold", **options})
