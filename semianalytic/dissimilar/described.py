"""A pair from a scene and the material of its lower body, and as its file has it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from semianalytic.dissimilar.pair import Pair
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, ViscousFriction
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.loads import Step
from semianalytic.scene.scene import SLOT, Material, Scene, Tractions


def pair_of(scene: Scene, lower: Material) -> Pair:
    """Return a scene with another lower body as a pair.

    Raises
    ------
    SceneError
        If it is not solved between two bodies; the message says what else knows them.
    """
    for wrong in _wrong(scene):
        raise SceneError(
            f"{wrong}: between different bodies the exact solver knows plane strain, a step of "
            "tractions on the slot faces, and Coulomb or viscous friction; simulate the scene, "
            "slipfront simulate, or march an interface (docs/dissimilar.md)."
        )
    assert isinstance(scene.load, Tractions)
    return Pair(
        scene.material,
        lower,
        scene.friction,
        scene.base,
        scene.load,
        scene.friction_law,
        scene.units,
    )


def pair_document(pair: Pair) -> dict[str, Any]:
    """Return a pair as plain dictionaries, as its TOML file has it."""
    return scene_document(pair.alike) | {"lower_material": asdict(pair.lower)}


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
    if not isinstance(scene.friction_law, CoulombFriction | ViscousFriction):
        yield f"friction_law is {type(scene.friction_law).__name__}"
