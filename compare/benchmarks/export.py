"""Problem sheets as folders of files that anyone can work with."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from compare.benchmarks.answers import checksums, table_of
from compare.benchmarks.pages import page_of
from compare.benchmarks.sheets import SUMS, Sheet
from compare.output.places import working_folder
from semianalytic.results.files import remove_empty, write_bytes
from semianalytic.scene.errors import SceneError

_TEXTS = {"md": page_of, "csv": table_of, "toml": lambda sheet: sheet.file}
"""Texts of a sheet by the endings of their files."""


def exported(sheets: Sequence[Sheet]) -> dict[str, bytes]:
    """Return page, answer and problem of sheets, and checksums, by path below the folder."""
    texts = (text(sheet).encode() for sheet in sheets for text in _TEXTS.values())
    contents = dict(zip(_names(sheets), texts, strict=True))
    return {**contents, SUMS: checksums(contents).encode()}


def _names(sheets: Sequence[Sheet]) -> list[str]:
    return [f"{sheet.name}/{sheet.name}.{ending}" for sheet in sheets for ending in _TEXTS]


def export(folder: Path, sheets: Sequence[Sheet], *, overwrite: bool = False) -> list[Path]:
    """Write sheets into a folder, all or none, and return what was written.

    Files that are there are replaced only with `overwrite`, else refused by a SceneError before
    anything is solved.
    """
    there = sorted(name for name in (*_names(sheets), SUMS) if (folder / name).exists())
    if there and not overwrite:
        raise SceneError(
            f"{folder / there[0]} exists already; choose another folder, or give --overwrite."
        )
    with working_folder(folder):
        contents = exported(sheets)
        new = [folder / name for name in contents if name not in there]
        try:
            for name, data in contents.items():
                write_bytes(folder / name, data)
        except BaseException:
            for path in new:
                with suppress(OSError):
                    path.unlink(missing_ok=True)
            remove_empty([path.parent for path in new if path.parent != folder])
            raise
    return [folder / name for name in contents]
