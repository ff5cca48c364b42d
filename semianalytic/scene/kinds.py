"""Kinds of load histories, by the names that they have in files."""

from __future__ import annotations

from collections.abc import Mapping

from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.plugins import HISTORIES, kind_of
from semianalytic.scene.tabulated import Tabulated

HISTORY_KINDS: Mapping[str, type[LoadHistory]] = {
    "step": Step,
    "ramp": Ramp,
    "pulse": Pulse,
    "harmonic": Harmonic,
    "tabulated": Tabulated,
}
HISTORY_FIELDS = ("pressure_history", "shear_history")
"""Fields of a scene that are histories."""


def history_kind(history: LoadHistory) -> str | None:
    """Return the kind of a history in files; None if no installed package brings its class."""
    return kind_of(HISTORIES, LoadHistory, HISTORY_KINDS, type(history))
