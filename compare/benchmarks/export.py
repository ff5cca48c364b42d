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


def exported(sheets: Sequence[Sheet]) -> dict[str, bytes]:
    """Return page, answer and problem of sheets, and checksums, by path below the folder."""
    contents: dict[str, bytes] = {}
    for sheet in sheets:
        texts = {"md": page_of(sheet), "csv": table_of(sheet), "toml": sheet.file}
        for ending, text in texts.items():
            contents[f"{sheet.name}/{sheet.name}.{ending}"] = text.encode()
    return {**contents, SUMS: checksums(contents).encode()}


def export(folder: Path, sheets: Sequence[Sheet], *, overwrite: bool = False) -> list[Path]:
    """Write sheets into a folder, all or none, and return what was written.

    Files that are there are replaced only with `overwrite`, else refused by a SceneError.
    """
    contents = exported(sheets)
    there = sorted(name for name in contents if (folder / name).exists())
    if there and not overwrite:
        raise SceneError(
            f"{folder / there[0]} exists already; choose another folder, or give --overwrite."
        )
    new = [folder / name for name in contents if name not in there]
    with working_folder(folder):
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
