"""Pieces of an HTML page: tables, paragraphs, commands and pictures; all text is escaped."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from matplotlib.figure import Figure

from compare.figures.saving import figure_png

BESIDE = 5.0
"""Width of one of two figures side by side [inch]."""


@dataclass(frozen=True)
class Cell:
    """Text of a table cell, and its look: number, long, good, bad, open or plain."""

    text: str
    look: str = ""
    link: str = ""


def number(text: str) -> Cell:
    """Return a cell of digits."""
    return Cell(text, "number")


def words(text: str) -> Cell:
    """Return a cell of text that needs room."""
    return Cell(text, "long")


def table(head: Sequence[str], rows: Iterable[Sequence[str | Cell]], title: str) -> str:
    """Return a table under its title, which scrolls in its own box."""
    heads = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
    lines = "".join(
        "<tr>"
        + "".join(_cell(cell, first=index == 0) for index, cell in enumerate(row))
        + "</tr>\n"
        for row in rows
    )
    return (
        f'<p class="title">{escape(title)}</p><div class="scroll" role="region" tabindex="0" '
        f'aria-label="{escape(title)}"><table><thead><tr>{heads}</tr></thead>\n'
        f"<tbody>{lines}</tbody></table></div>\n"
    )


def _cell(cell: str | Cell, *, first: bool) -> str:
    cell = cell if isinstance(cell, Cell) else Cell(cell)
    text = escape(cell.text)
    if cell.link:
        text = f'<a href="{escape(cell.link)}">{text}</a>'
    look = f' class="{cell.look}"' if cell.look else ""
    return f'<th scope="row"{look}>{text}</th>' if first else f"<td{look}>{text}</td>"


def drawn_figure(figure: Figure, caption: str, *, wide: bool = False) -> str:
    """Return a figure over its caption; unless `wide`, it is drawn at its final small size."""
    width, height = figure.get_size_inches()
    if not wide and width > BESIDE:
        figure.set_size_inches(BESIDE, 0.85 * height)
    return image(figure_png(figure, dpi=110 if wide else 150), caption, caption + ".", wide=wide)


def image(data: bytes, alternative: str, caption: str, *, wide: bool = False) -> str:
    """Return a PNG picture over its caption."""
    look = ' class="wide"' if wide else ""
    source = f"data:image/png;base64,{b64encode(data).decode()}"
    return (
        f'<figure{look}><img src="{source}" alt="{escape(alternative)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def figures(drawn: Iterable[str]) -> str:
    """Arrange figures side by side and in rows."""
    return f'<div class="figures">{"".join(drawn)}</div>'


def data_block(data: object) -> str:
    """Return data for the script of the page, as JSON in which no tag can begin or end."""
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return f'<script type="application/json">{text}</script>'


def paragraph(text: str) -> str:
    """Return a paragraph of text."""
    return f"<p>{escape(text)}</p>\n"


def code(lines: Iterable[str]) -> str:
    """Return lines of commands."""
    text = "\n".join(lines)
    return f"<pre>{escape(text)}</pre>\n"
