"""Write the JSON Schema of the output of every command with ``--json``, and the table of keys.

``python -m docs.studies.schema --write`` writes docs/schema.json and docs/data/json-keys.csv, which
docs/json.md shows, from `documents` and the fields of the rows.  ``--check`` tests whether they are
up to date.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compare.output.files import write_text
from compare.output.tables import write_rows
from docs.studies.schema import studies
from docs.studies.schema.answers import ANSWERS
from docs.studies.schema.parts import DEFINITIONS
from docs.studies.schema.vocabulary import TEXT, UNITS, Key, Schema, list_of, object_of

DOCS = Path(__file__).resolve().parents[3] / "docs"
COMMAND = "python -m docs.studies.schema --write"
ENVELOPE: Mapping[str, Key] = {
    "command": Key("the command, as typed after slipfront", TEXT),
    "version": Key("version of slipfront", TEXT),
    "status": Key("done; converged, resolved or the reason why not; or the verdict", TEXT),
    "units": Key("units of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("files written", list_of(TEXT)),
}
DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {**ANSWERS, **studies.STUDIES}
"""Keys that each command adds to the `ENVELOPE`, in each of its forms."""


def schema() -> dict[str, Any]:
    """Return the schema of all documents."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "What slipfront prints with --json",
        "anyOf": [_command(name, keys) for name, ways in DOCUMENTS.items() for keys in ways],
        "$defs": DEFINITIONS,
    }


def _command(name: str, keys: Mapping[str, Key]) -> Schema:
    whole = {**ENVELOPE, **keys}
    described = {key: {"description": one.meaning, **one.schema} for key, one in whole.items()}
    described["command"] = {"const": name}
    return object_of([key for key, one in whole.items() if not one.always], **described)


@dataclass(frozen=True)
class KeyRow:
    """A key of the document of a command."""

    command: str
    key: str
    meaning: str


def key_rows() -> list[KeyRow]:
    """Return all keys, beginning with those that all commands share."""
    rows = [KeyRow("all", key, one.meaning) for key, one in ENVELOPE.items()]
    for name, ways in DOCUMENTS.items():
        merged = {key: one for keys in ways for key, one in keys.items()}
        rows += [KeyRow(name, key, one.meaning) for key, one in merged.items()]
    return rows


def schema_text() -> str:
    """Return the text of docs/schema.json."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def write(docs: Path = DOCS) -> None:
    """Write schema and table; raise DataFileError if that fails."""
    write_text(docs / "schema.json", schema_text())
    write_rows(docs / "data" / "json-keys.csv", key_rows(), command=COMMAND)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the schema, or check whether it is up to date; return 1 if it is not."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.schema", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", action="store_true", help="say whether the files are up to date")
    what.add_argument("--write", action="store_true", help="write them")
    if parser.parse_args(arguments).write:
        write()
        return 0
    stale = (DOCS / "schema.json").read_text(encoding="utf-8") != schema_text()
    print("docs/schema.json: " + ("not up to date" if stale else "up to date"))
    return int(stale)
