"""Tables in HTML, by which notebooks show answers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape


def html_table(caption: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in HTML.

    Parameters
    ----------
    caption : str
        Sentence above the table.
    columns : sequence of str
        Headings.
    rows : iterable of sequence of str
        Cells, as many in each row as there are columns.  All text is escaped.
    """
    head = "".join(f"<th>{escape(one)}</th>" for one in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    # white-space: a unit stays beside its number
    return (
        f'<table style="white-space: nowrap"><caption>{escape(caption)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )
