"""A pair from a scene and the material of its lower body, and from files that describe both."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from os import PathLike, fspath
from typing import Any

from semianalytic.dissimilar.pair import Pair
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, ViscousFriction
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import find_blocks
from semianalytic.scene.loads import Step
from semianalytic.scene.scene import SLOT, Material, Scene, Tractions


def find_pair(source: str | PathLike[str]) -> Pair:
    """Find a scene by name or file, and return it as a pair, with the lower body of its file.

    Parameters
    ----------
    source : str or path
        As for `find_scene`; a file may describe the lower body in ``[lower_material]``, which is
        that of the upper one otherwise.

    Returns
    -------
    Pair

    Raises
    ------
    SceneError
        For the reasons given at `find_scene`, or if the scene is none that `solve_pair` takes: in
        plane, with a step of tractions on the slot faces, and Coulomb or viscous friction.

    Examples
    --------
    >>> import semianalytic as sa
    >>> alike = sa.find_pair("preloaded")
    >>> alike.upper == alike.lower, alike.friction
    (True, 0.3)
    """
    if not isinstance(source, str | PathLike):
        raise SceneError(
            f"find_pair: give the name of a scene or the path of a TOML file, got {shown(source)}."
        )
    scene, lower = find_blocks(fspath(source))
    return pair_of(scene, lower or scene.material)


def pair_of(scene: Scene, lower: Material) -> Pair:
    """Return a scene with another lower body as a pair.

    Raises
    ------
    SceneError
        If it is none that `solve_pair` takes; the message says what else knows two bodies.
    """
    for wrong in _wrong(scene):
        raise SceneError(
            f"{wrong}: between different bodies the exact solver knows plane strain, a step of "
            "tractions on the slot faces, and Coulomb or viscous friction; simulate the scene, "
            "slipfront simulate, or march the interface, slipfront run (docs/dissimilar.md)."
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
    """Yield what of a scene `solve_pair` does not take."""
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
