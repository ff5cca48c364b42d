"""Problem sheets as folders of files that anyone can work with."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from compare.benchmarks.answers import SUMS, answer_files, written_bytes
from compare.benchmarks.figures import sheet_figure
from compare.benchmarks.interfaces.sheets import InterfaceSheet
from compare.benchmarks.pages import (
    ANSWERS,
    FIGURE,
    INTERFACE,
    RECORDS,
    Block,
    Code,
    Heading,
    Text,
    as_html,
    as_markdown,
    sheet_blocks,
)
from compare.benchmarks.sheet import Sheet
from compare.benchmarks.starters import starter_inputs
from compare.figures.saving import figure_png
from compare.output.places import working_folder
from semianalytic.results.files import remove_empty, write_bytes
from semianalytic.scene.errors import SceneError

README = "README.md"


def exported(sheets: Sequence[Sheet]) -> dict[str, bytes]:
    """Return the contents of the exported files by path below the export folder."""
    contents: dict[str, bytes] = {}
    for sheet in sheets:
        for name, data in _sheet_files(sheet).items():
            contents[f"{sheet.name}/{name}"] = data
    contents[README] = as_markdown(_readme(sheets)).encode()
    answers = [f"{sheet.name}/{name}" for sheet in sheets for name in (ANSWERS, RECORDS)]
    sums = (f"{hashlib.sha256(contents[name]).hexdigest()}  {name}\n" for name in answers)
    contents[SUMS] = "".join(sums).encode()
    return contents


def _sheet_files(sheet: Sheet) -> dict[str, bytes]:
    records, answers = (written_bytes(name) for name in answer_files(sheet))
    figure = figure_png(sheet_figure(sheet), dpi=150)
    blocks = list(sheet_blocks(sheet))
    return {
        f"{sheet.name}.md": as_markdown(blocks).encode(),
        f"{sheet.name}.html": as_html(blocks, {FIGURE: figure}).encode(),
        FIGURE: figure,
        RECORDS: records,
        ANSWERS: answers,
        **{name: text.encode() for name, text in starter_inputs(sheet).items()},
        **({INTERFACE: sheet.text.lstrip().encode()} if isinstance(sheet, InterfaceSheet) else {}),
    }


def _readme(sheets: Sequence[Sheet]) -> list[Block]:
    """How to use an export."""
    return [
        Heading("slipfront benchmarks", 1),
        Text(
            "Problems of dynamic friction with exact answers, or answers with a stated error: "
            + ", ".join(f"[{sheet.name}]({sheet.name}/{sheet.name}.md)" for sheet in sheets)
            + ". Each folder holds the sheet (Markdown, HTML), its figure, the records at the "
            f"stations ({RECORDS}), all numbers ({ANSWERS}) and inputs to start from."
        ),
        Heading("Score a run"),
        Text("Write your records as the sheet says, then compare codes or resolutions:"),
        Code(
            (
                "pip install 'slipfront[plot]'",
                "slipfront benchmark score mine-50.csv mine-100.csv mine-200.csv",
                "slipfront benchmark enter march preloaded --cells 100 --output theirs.csv",
                "slipfront benchmark score mine-100.csv theirs.csv --output scores",
            )
        ),
        Text(
            "The last command writes scores.csv, scores.json and scores.png into a folder. "
            "`sha256sum --check SHA256SUMS` tells whether the answers are as they were handed out."
        ),
        Heading("Start with UGUCA"),
        Text(
            "uguca/uguca_sheet.cc is a program for its library (0.9), uguca/NAME.in its "
            "parameters. Kernel tables must be of the exact Poisson ratio: the code looks for a "
            "file whose name has the ratio cut to two digits, and the one that it ships is of "
            "0.33, which leaves a third of a percent at ν = 1/3. Its top_velo is a mean over the "
            "step that follows; slip is twice top_disp where one body alone is computed, top_disp "
            "less bot_disp elsewhere. The edge of the contact lies half a cell behind the last "
            "node of the slot."
        ),
        Code(
            ("c++ uguca_sheet.cc -I UGUCA/src ... -luguca -o uguca_sheet", "./uguca_sheet NAME.in")
        ),
        Heading("Start with SEM2DPACK"),
        Text(
            "sem2dpack/Par.inp and the files it names are all that sem2dsolve needs. Lengths and "
            "times are 100 times those of the sheet, slip too, all else is the same; slip rates "
            "are half a step later than slip. In antiplane shear its slip and shear traction have "
            "the other sign. It has no viscous film."
        ),
    ]


def export(folder: Path, sheets: Sequence[Sheet], *, overwrite: bool = False) -> list[Path]:
    """Write sheets into a folder: all of them, or none.

    Parameters
    ----------
    folder : Path
    sheets : sequence of Sheet
    overwrite : bool
        Whether files that are there may be replaced.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    SceneError
        If a file is there, and is not to be replaced.
    DataFileError
        If the folder cannot be written.
    """
    contents = exported(sheets)
    there = sorted(name for name in contents if (folder / name).exists())
    if there and not overwrite:
        raise SceneError(
            f"{folder / there[0]} is there already; choose another folder, or give --overwrite."
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
            places = {place for path in new for place in path.parents if folder in place.parents}
            for place in sorted(places, key=lambda one: -len(one.parts)):
                remove_empty([place])
            raise
    return [folder / name for name in contents]
