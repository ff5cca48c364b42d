"""Scenes that have an answer in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.reference.antiplane import antiplane_edge_speed, antiplane_slip_rate
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class KnownAnswer:
    """A slip rate that is known in closed form.

    Attributes
    ----------
    slip_rate : callable
        Relative slip rate at velocities x/t > 0 [length / time].
    edge_speed : float or None
        Outer edge of the only slip zone [length / time]; None if everything slips.
    """

    slip_rate: Callable[[Array], Array]
    edge_speed: float | None


def closed_form(scene: Scene) -> KnownAnswer:
    """Return the closed form of a scene under a step of shear, or under a sudden remote load.

    A remote load must make everything slip, f P_0 <= Q_0.  It is not checked that an in-plane shear
    step makes only one slip zone, slower than c_R.

    Raises
    ------
    SceneError
        If the scene is of another kind.
    """
    material, friction, (held, load) = scene.material, scene.friction, scene.superposition
    pressure, shear = load.pressure, load.shear
    plain = scene.is_step and scene.friction_law == CoulombFriction()
    if not plain or scene.front_slowness:
        raise SceneError("no closed form is known of this scene; see semianalytic.reference.")
    if scene.antiplane:
        return _antiplane_form(scene)
    if held == load and friction * pressure <= shear:
        return KnownAnswer(
            lambda speed: slip_rate_under_remote_shock(material, pressure, shear, friction, speed),
            None,
        )
    if pressure or held.shear or not shear:
        raise SceneError("no closed form is known of this scene; see semianalytic.reference.")
    if friction == 0:
        return KnownAnswer(lambda speed: slip_rate_without_friction(material, shear, speed), None)
    ratio = friction * held.pressure / shear
    return KnownAnswer(
        lambda speed: slip_rate_under_shear_step(material, shear, ratio, speed),
        edge_speed_under_shear_step(material, ratio),
    )


def _antiplane_form(scene: Scene) -> KnownAnswer:
    """Return the closed form of a step of antiplane shear under constant pressure."""
    material, (held, load) = scene.material, scene.superposition
    shear = load.shear
    if load.pressure or not shear or scene.far_slip_rate:
        raise SceneError("no closed form is known of this scene; see semianalytic.reference.")
    along = math.copysign(1, shear) * held.shear
    ratio = max(scene.friction * held.pressure - along, 0.0) / abs(shear)
    return KnownAnswer(
        lambda speed: antiplane_slip_rate(material, shear, ratio, speed),
        antiplane_edge_speed(material, ratio),
    )
