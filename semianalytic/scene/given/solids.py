"""Real solids to begin with, in SI units, each with the source of its numbers."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from semianalytic.scene.arguments import checking
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.material import Material
from semianalytic.scene.units import measure


@dataclass(frozen=True)
class Solid:
    """A solid that is known by name.

    Attributes
    ----------
    material : Material
        Its numbers, in SI units.
    source : str
        Specimen on which they were measured, and the source in print.
    """

    material: Material
    source: str


@cache
def solids() -> Mapping[str, Solid]:
    """Return the solids of `solids.toml` by name, in its order."""
    text, found = (Path(__file__).parent / "solids.toml").read_text(encoding="utf-8"), {}
    for name, of in tomllib.loads(text).items():
        modulus, density = (of[key] for key in ("shear_modulus", "density"))
        sizes = measure(modulus, "stress"), measure(density, "mass / length^3")
        found[name] = Solid(Material(*sizes, of["poisson_ratio"]), of["source"])
    return found


@checking
def find_material(name: str) -> Material:
    """Return a solid that is known by name, in SI units.

    A scene made of it is in SI units.  docs/commands.md, "Solids", says where the
    numbers come from; replace them by those of your own specimen.

    Parameters
    ----------
    name : str
        "steel", "aluminium", "pmma", "homalite" or "granite"; case does not matter.

    Raises
    ------
    SceneError
        If there is no such solid; the message lists all solids.

    Examples
    --------
    >>> from semianalytic import find_material
    >>> round(find_material("pmma").shear_speed)
    1346
    """
    return find_solid(name).material


def find_solid(name: object) -> Solid:
    """Return a solid with the source of its numbers; raise SceneError if there is none."""
    solid = solids().get(name.strip().lower()) if isinstance(name, str) else None
    if solid is None:
        raise SceneError(f"material must be one of {', '.join(solids())}, got {shown(name)}.")
    return solid
