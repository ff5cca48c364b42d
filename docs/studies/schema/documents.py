"""Keys that each command prints with ``--json``, their meanings, and the schema of their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from docs.studies.schema.answers import ANSWERS
from docs.studies.schema.studies import STUDIES
from docs.studies.schema.vocabulary import (
    TEXT,
    UNITS,
    Key,
    list_of,
)

ENVELOPE: Mapping[str, Key] = {
    "command": Key("the command, as typed after slipfront", TEXT),
    "version": Key("version of slipfront", TEXT),
    "status": Key("done; converged, resolved or the reason why not; or the verdict", TEXT),
    "units": Key("units of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("files written", list_of(TEXT)),
}
DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {**ANSWERS, **STUDIES}
"""Keys that each command adds to the `ENVELOPE`, in each of its forms."""
