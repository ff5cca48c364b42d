"""Scenes of two different solids that the exact solver takes, and how the solids may differ."""

from __future__ import annotations

from collections.abc import Iterator

from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.loads import Step
from semianalytic.scene.scene import SLOT, Material, Scene, Tractions

LARGEST_CONTRAST = 1e5
"""Largest ratio of moduli or densities; at 1e4 the canonical matrix keeps nine digits."""

TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
_OF_BODIES = ("shear_modulus", "density", "poisson_ratio")
PARAMETERS = (
    "friction",
    "viscosity",
    *TRACTIONS,
    *_OF_BODIES,
    *(f"lower_{name}" for name in _OF_BODIES),
)
"""Parameters of two bodies with respect to which there are derivatives; those of a body without
"lower_" are of the upper one."""


def check_bodies(scene: Scene) -> None:
    """Raise SceneError unless a scene of two different solids is solved exactly.

    The message says what to change, or what else takes the scene.
    """
    for wrong in _wrong(scene):
        raise SceneError(
            f"{wrong}: between different bodies the exact solver takes plane strain, a step of "
            "tractions on the slot faces, and Coulomb or viscous friction; simulate the scene, "
            "slipfront simulate, or march an interface (docs/dissimilar.md)."
        )
    if not scene.coefficient > 0:
        raise SceneError(
            "scene: between different bodies friction must be positive, got "
            f"{scene.coefficient:.6g}."
        )
    check_contrast(*scene.bodies, LARGEST_CONTRAST)
    if not scene.base.pressure > 0:
        raise SceneError(
            "scene: between different bodies base pressure must be positive, for nothing else "
            f"holds them together far ahead of the waves, got {scene.base.pressure}."
        )
    strength = scene.coefficient * scene.base.pressure
    # A base exactly at friction lets slip run ahead of all waves, a case that is solved for
    # identical bodies alone.
    if not abs(scene.base.shear) < strength:
        raise SceneError(
            "scene: between different bodies the interface would slide as a whole; lower the base "
            f"shear below friction times base pressure, {strength:.6g}, got "
            f"{scene.base.shear:.6g}."
        )


def _wrong(scene: Scene) -> Iterator[str]:
    """Yield what of a scene is not solved between two bodies."""
    if scene.antiplane:
        yield 'mode = "antiplane"'
    if not isinstance(scene.load, Tractions):
        yield "the load is a wave or moves"
    if scene.load_on != SLOT:
        yield f'load_on = "{scene.load_on}"'
    for name in ("pressure_history", "shear_history"):
        if getattr(scene, name) != Step():
            yield name
    if not (type(scene.law) is Coulomb and scene.law.keeps_similarity):
        yield f"friction is {scene.friction}"


def check_contrast(upper: Material, lower: Material, largest: float) -> None:
    """Raise SceneError if moduli or densities differ by more than a factor of `largest`."""
    for name in ("shear_modulus", "density"):
        ratio = getattr(upper, name) / getattr(lower, name)
        if not 1 / largest <= ratio <= largest:
            raise SceneError(
                f"scene: {name} of the two bodies must not differ by more than a factor of "
                f"{largest:g}, got {max(ratio, 1 / ratio):.3g}."
            )
