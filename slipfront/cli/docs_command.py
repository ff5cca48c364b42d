"""``slipfront docs`` prints the pages of the documentation that messages name."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markdown import Markdown
from rich.markup import escape

from compare.output.printed import PrintedTable
from semianalytic.scene.checks import meant, shown
from semianalytic.scene.errors import SceneError
from slipfront.cli.options import AsJson
from slipfront.cli.terminal import print_json

_HOUSE = Path(__file__).parents[1]
FOLDERS = (_HOUSE / "docs", _HOUSE.parent / "docs")
"""Where pages are: in an installed package (see pyproject.toml), and in a checkout."""
WIDEST = 110
"""Columns of text that are read with ease; a page is not set wider on a wide terminal."""


def docs(
    page: Annotated[
        str | None,
        typer.Argument(
            metavar="PAGE",
            help="Page to print, such as docs/limits.md or limits; without it all are listed.",
            autocompletion=lambda: sorted(pages()),
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print a page of the documentation, such as docs/limits.md, which a message has named."""
    if page is None:
        titles = {}
        for name, path in sorted(pages().items()):
            headings = (line[2:] for line in _text(path).splitlines() if line.startswith("# "))
            titles[name] = next(headings, name)
        if as_json:
            print_json("docs", {"pages": titles})
            return
        table = PrintedTable("page", "title", title="Pages of the documentation")
        for name, title in titles.items():
            table.add_row(name, escape(title))
        Console().print(table)
        return
    path = found_page(page)
    text = _text(path)
    if as_json:
        print_json("docs", {"page": path.stem, "text": text})
    elif sys.stdout.isatty():
        Console(width=min(Console().width, WIDEST)).print(Markdown(text, hyperlinks=False))
    else:
        print(text, end="")


def pages() -> dict[str, Path]:
    """Return the pages that are installed, by name."""
    folder = next((folder for folder in FOLDERS if folder.is_dir()), FOLDERS[0])
    return {path.stem: path for path in folder.glob("*.md")}


def found_page(name: str) -> Path:
    """Return the file of a page that messages write as docs/limits.md, or limits.md or limits."""
    known = pages()
    stem = name.rsplit("/", 1)[-1].removesuffix(".md")
    if stem in known:
        return known[stem]
    hint = meant(stem, known, "'slipfront docs' lists them.")
    raise SceneError(f"There is no page called {shown(name)}; {hint}")


def _text(path: Path) -> str:
    """Return the text of a page without the settings that the site reads at its top."""
    text = path.read_text(encoding="utf-8")
    return text.split("\n---\n", 1)[1] if text.startswith("---\n") else text
