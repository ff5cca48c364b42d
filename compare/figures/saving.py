"""Figures as reproducible files; text in them stays text."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.figure import Figure

from compare.figures.style import look
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import SceneError

NO_DATE = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""Metadata without the time of writing, by format."""


def figure_format(path: str | Path) -> str:
    """Return the format that the name of a figure file asks for; SceneError if it is none."""
    path = Path(path)
    form = path.suffix.removeprefix(".").lower()
    if form not in FigureCanvasBase.get_supported_filetypes():
        raise SceneError(
            f"Figures cannot be written as {path.name!r}; end the name in .png, .pdf or .svg."
        )
    return form


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure in the format of its file name, completely or not at all."""
    drawn, form = BytesIO(), figure_format(path)
    with look():
        figure.savefig(drawn, format=form, metadata=NO_DATE.get(form))
    write_bytes(path, drawn.getbuffer())
