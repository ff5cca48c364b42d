"""Velocities, positions and senses of slip as texts show them, and tables of notebooks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import Literal


def digits_apart(edges: Iterable[float], least: int, form: Literal["f", "g"] = "g") -> int:
    """Return how many digits show different edges as different, and distances to two digits.

    Strips around the Rayleigh front, of reverse slip without friction or of stick with little
    friction, may be narrower than 1e-12 of its speed and would otherwise appear empty.

    Infinite edges are left out, and what agrees to 15 significant digits is taken to be the same;
    digits are significant ones ("g") or those after the point ("f").
    """
    # The same edge may have been computed twice: what differs by rounding alone is one number.
    different = {float(f"{edge:.15g}") for edge in edges if math.isfinite(edge)}
    for digits in range(least, 17):
        if len({f"{number:.{digits}{form}}" for number in different}) == len(different):
            # One digit more than distinguishes them, which shows by how much they differ.
            return digits if digits == least else digits + 1
    return 17


def number_or_infinity(value: float, digits: int = 6, form: Literal["f", "g"] = "g") -> str:
    """Return a number with so many digits, significant ones ("g") or those after the point ("f").

    An infinite one, such as the edge of slip ahead of all waves, is "∞".
    """
    return "∞" if math.isinf(value) else f"{value:.{digits}{form}}"


def kind_of_slip(sense: int) -> str:
    """Return "slip" for a sense towards +x, else "reverse slip"; figures have a colour for each."""
    return "slip" if sense > 0 else "reverse slip"


def html_table(caption: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a caption, headings and rows of cells as a table in HTML; all text is escaped."""
    head = "".join(f"<th>{escape(column)}</th>" for column in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    # white-space: a unit stays with its number
    return (
        f'<table style="white-space: nowrap"><caption>{escape(caption)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )
