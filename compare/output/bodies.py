"""The two bodies of an answer that holds whole fields, which may be of different materials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from semianalytic import PairSolution
from semianalytic.results.answer import WholeFields
from semianalytic.scene.scene import Material, Scene

Fields = WholeFields | PairSolution
"""Answers that hold the fields in both bodies."""


def materials_of(fields: Fields) -> tuple[Material, Material]:
    """Return the materials of the upper and of the lower body."""
    if isinstance(fields, PairSolution):
        return fields.pair.upper, fields.pair.lower
    return fields.scene.material, fields.scene.material


def scene_of(fields: Fields, y: float = 0.0) -> Scene:
    """Return the scene of an answer, with the material of the body at y [length].

    For two different bodies it is that of one body on its own kind, which has the same friction,
    tractions and units.
    """
    if not isinstance(fields, PairSolution):
        return fields.scene
    upper, lower = materials_of(fields)
    return replace(fields.pair.alike, material=lower if np.signbit(y) else upper)


def fastest_speed(fields: Fields) -> float:
    """Return the speed of the fastest wave in either body [length / time]."""
    return max(scene_of(fields, y).fastest_speed for y in (0.0, -0.0))
