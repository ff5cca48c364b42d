"""Real solids to begin with, in SI units, each with the source of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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


def _solid(shear_modulus: str, density: str, poisson_ratio: float, source: str) -> Solid:
    material = Material(
        measure(shear_modulus, "stress"), measure(density, "mass / length^3"), poisson_ratio
    )
    return Solid(material, source)


SOLIDS: Mapping[str, Solid] = {
    "steel": _solid(
        "80 GPa",
        "7860 kg/m^3",
        0.29,
        "structural steel: upper end of 75 to 80 GPa, 0.27 to 0.30 in Gere, Mechanics of "
        "Materials; density from Halliday, Resnick and Walker, Fundamentals of Physics",
    ),
    "aluminium": _solid(
        "26 GPa",
        "2710 kg/m^3",
        0.33,
        "alloy 6061-T6: Gere, Mechanics of Materials; density from Halliday, Resnick and Walker, "
        "Fundamentals of Physics",
    ),
    "pmma": _solid(
        "2.12 GPa",
        "1170 kg/m^3",
        0.336,
        "under fast loading, from wave speeds of 1345 and 2705 m/s: Svetlizky and Fineberg, Nature "
        "509, 205 (2014)",
    ),
    "homalite": _solid(
        "1.9 GPa",
        "1230 kg/m^3",
        0.34,
        "Homalite 100 under fast loading, by ultrasound: Samudrala and Rosakis (2003), in the "
        "table at authors.library.caltech.edu/50847",
    ),
    "granite": _solid(
        "16.3 GPa",
        "2650 kg/m^3",
        0.333,
        "Quincy granite in place, at a few atmospheres, from wave speeds of 2480 and 4960 m/s: "
        "Leet and Ewing, Physics 2, 160 (1932); pressure closes cracks and raises the modulus",
    ),
}


@checking
def find_material(name: str) -> Material:
    """Return a solid that is known by name, in SI units.

    A scene that is made of it is one in SI units.  docs/commands.md, "Solids", says where the
    numbers come from; replace them by those of your own specimen.

    Parameters
    ----------
    name : str
        "steel", "aluminium", "pmma", "homalite" or "granite"; case does not matter.

    Raises
    ------
    SceneError
        If there is no such solid; the message lists those there are.

    Examples
    --------
    >>> from semianalytic import find_material
    >>> round(find_material("pmma").shear_speed)
    1346
    """
    return find_solid(name).material


def find_solid(name: object) -> Solid:
    """Return a solid with the source of its numbers; raise SceneError if there is none."""
    solid = SOLIDS.get(name.strip().lower()) if isinstance(name, str) else None
    if solid is None:
        raise SceneError(f"material must be one of {', '.join(SOLIDS)}, got {shown(name)}.")
    return solid
