"""Write the JSON Schema of the output of every command with ``--json``, and the table of keys.

``python -m docs.studies.schema`` writes docs/schema.json and docs/data/json-keys.csv, which
docs/json.md shows, from `DOCUMENTS` and the fields of the rows.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compare.output.places import write_text
from docs.studies.runner import Row, write_table
from docs.studies.schema.answers import DOCUMENTS
from docs.studies.schema.vocabulary import DEFINITIONS, TEXT, UNITS, Key, Schema, list_of, object_of

DOCS = Path(__file__).resolve().parents[3] / "docs"
COMMAND = "python -m docs.studies.schema"
ENVELOPE: Mapping[str, Key] = {
    "command": Key("the command, as typed after slipfront", TEXT),
    "version": Key("version of slipfront", TEXT),
    "status": Key("done; converged, resolved or the reason why not; or the verdict", TEXT),
    "units": Key("units of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("files written", list_of(TEXT)),
    "unread": Key("columns of tables that are not read, if there are any", list_of(TEXT), False),
}


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
    described = {key: {"description": item.meaning, **item.schema} for key, item in whole.items()}
    described["command"] = {"const": name}
    return object_of([key for key, values in whole.items() if not values.always], **described)


def key_rows() -> list[Row]:
    """Return all keys, beginning with those that all commands share."""
    return [
        {"command": name, "key": key, "meaning": entry.meaning}
        for name, ways in (("all", (ENVELOPE,)), *DOCUMENTS.items())
        for key, entry in {key: entry for keys in ways for key, entry in keys.items()}.items()
    ]


def write(docs: Path = DOCS) -> None:
    """Write schema and table; raise DataFileError if that fails."""
    text = json.dumps(schema(), indent=1, ensure_ascii=False)
    write_text(docs / "schema.json", text + "\n")
    write_table(docs / "data" / "json-keys.csv", key_rows(), COMMAND)
