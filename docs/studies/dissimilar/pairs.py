"""Pairs of solids that are met, pairs drawn at random, and scenes of a slot between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from semianalytic import CoulombFriction, Material, Pair, Tractions, ViscousFriction

NAMED: Mapping[str, tuple[Material, Material]] = {
    "gouge on rock": (Material(12e9, 2300.0, 0.25), Material(30e9, 2700.0, 0.25)),
    "aluminium on steel": (
        Material(70e9 / 2.66, 2700.0, 0.33),
        Material(210e9 / 2.6, 7800.0, 0.30),
    ),
    "PMMA on aluminium": (Material(3.2e9 / 2.7, 1180.0, 0.35), Material(70e9 / 2.66, 2700.0, 0.33)),
    "brake pad on cast iron": (Material(1.2e9, 2500.0, 0.25), Material(45e9, 7200.0, 0.26)),
    "rubber on steel": (Material(0.01e9 / 2.98, 1100.0, 0.49), Material(210e9 / 2.6, 7800.0, 0.30)),
}
"""Upper and lower body [Pa, kg/m^3]; the slower one is the upper."""


def of_contrast(ratio: float, poisson_ratio: float = 0.25) -> tuple[Material, Material]:
    """Two bodies of one density and Poisson ratio, the lower one faster by a ratio."""
    return Material(1.0, 1.0, poisson_ratio), Material(ratio**2, 1.0, poisson_ratio)


def random_pair(rng: np.random.Generator) -> Pair:
    """Two solids with speeds within a factor of 2.5 and a load that makes them slip or part."""
    upper, lower = rng.uniform(-0.1, 0.45, 2)
    ratio, density = np.exp(rng.uniform(-0.9, 0.9)), np.exp(rng.uniform(-0.7, 0.7))
    friction = rng.uniform(0.05, 0.6)
    base = rng.uniform(-0.8, 0.8) * friction * (rng.random() < 0.4)
    kind, shear = rng.integers(0, 5), rng.normal() * rng.choice([0.3, 1.0])
    pressures = [0.0, rng.uniform(0, 1.5), -rng.uniform(0, 1.5), rng.normal(), 0.0]
    film = rng.random() < 0.15
    law = ViscousFriction(rng.uniform(0, 2)) if film else CoulombFriction()
    return Pair(
        Material(1.0, 1.0, upper),
        Material(ratio**2 * density, density, lower),
        friction,
        Tractions(1.0, base),
        Tractions(pressures[kind], shear),
        law,
    )


_SLOW, _STIFF = Material(1.0, 1.0, 0.25), Material(2.25, 1.0, 0.30)
_A = (Material(1.0, 1.0, 0.3), Material(1.7, 1.1, 0.2))
_C = (Material(1.0, 1.0, 0.25), Material(1.21, 1.0, 0.25))


def _scene(
    bodies: tuple[Material, Material],
    friction: float,
    base: float,
    load: tuple[float, float],
    film: float = 0.0,
) -> Pair:
    law = ViscousFriction(film) if film else CoulombFriction()
    return Pair(*bodies, friction, Tractions(base, 0.0), Tractions(*load), law)


SCENES: Mapping[str, Pair] = {
    "slip from the slot": _scene(_C, 0.2, 4.0, (0.5, -1.0)),
    "two zones": _scene(_C, 0.2, 1.1, (0.0, -1.0)),
    "slip and opening": _scene((_SLOW, _STIFF), 0.3, 1.5, (-1.0, 0.5)),
    "slip and opening, reversed": _scene((_SLOW, _STIFF), 0.3, 1.5, (-1.0, -0.5)),
    "film": _scene((_SLOW, _STIFF), 0.2, 1.0, (0.2, 1.0), 0.3),
    "detached slip": _scene((_SLOW, _STIFF), 0.4, 0.7, (5.5, -1.0)),
    "both senses": _scene((_SLOW, _STIFF), 0.3, 0.05, (1.0, 0.0)),
    "detached opening": _scene(_A, 0.1, 0.05, (1.0, -0.5)),
}
"""Scenes of a slot that between them have all kinds of zones."""
