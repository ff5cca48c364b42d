"""Fronts that run along the line as they act on its nodes: tractions of waves and moving loads."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from semianalytic.dissimilar.bonded import bonded_tractions
from semianalytic.halfplane.hilbert import comes_back, transformed
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.material import Material
from semianalytic.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ActingFront(FrontLoad):
    """A front between the bodies of a scene, S f(t - p (x - at)).

    At nodes it rises over the time in which the front crosses a node distance, but not faster than
    in a step.

    Parameters
    ----------
    material : Material
        The solid, or that on y > 0.
    lower : Material, optional
        The one on y < 0 if it is another one.  The step of a wave is then that of the bonded line
        (`dissimilar.bonded`).

    Examples
    --------
    >>> from semianalytic import IncidentWave, Material
    >>> from semianalytic.engine.stepping.fronts import ActingFront
    >>> wave = IncidentWave("SH", angle=-30.0, stress=2.0)
    >>> front = ActingFront(wave, at=4.0, material=Material(1.0, 1.0, 0.25))  # it is at 4 - 2 t
    >>> front.traction([1.0, 3.0], 1.0).round(6) + 0.0
    array([ 0.      , -1.732051])
    """

    material: Material = field(kw_only=True)
    lower: Material | None = field(default=None, kw_only=True)

    @cached_property
    def slowness(self) -> float:
        """Slowness of the front along x [time / length]."""
        body = self.material
        if isinstance(self.front, IncidentWave) and self.front.from_ == "below":
            body = self.lower or body
        return self.front.slowness(body)

    @cached_property
    def amplitudes(self) -> dict[str, complex]:
        """Pressure and shear per unit of the history [stress].

        They are those of the uncut line, bonded where the bodies differ; those with an imaginary
        part exert that part of the Hilbert transform of the history (`dissimilar.bonded`).
        """
        if self.lower is not None and isinstance(self.front, IncidentWave):
            pressure, shear = bonded_tractions(self.front, self.material, self.lower)
            return {"pressure": pressure, "shear": shear}
        traction = self.front.tractions(self.material)
        return {"pressure": complex(traction.pressure), "shear": complex(traction.shear)}

    def traction(
        self,
        x: Any,
        t: float,
        after: bool = False,
        of: str = "shear",
        spread: tuple[float, float] = (0.0, 0.0),
    ) -> Array:
        """Return the shear, or the pressure, at positions x (n,) at a time, (n,) [stress].

        At a jump of a load that is everywhere at once this is the value before it, or the one
        `after` it.

        Parameters
        ----------
        x : (n,) array
        t : float
        after : bool
        of : str
            "shear" or "pressure".
        spread : (float, float)
            Node distance [length] and step [time] over which the load is averaged.
        """
        x = np.asarray(x, dtype=float)
        slowness, size = self.slowness, self.amplitudes[of]
        since = t - slowness * (x - self.at)
        half = max(abs(slowness) * spread[0], spread[1]) / 2 if slowness else 0.0
        if half > 0:
            factor = self.history.mean(since - half, since + half)
        else:
            factor = self.history.value(np.nextafter(since, np.inf) if after else since)
        if isinstance(self.front, MovingLoad) and self.front.speed > 0:
            factor = np.where(x < self.at, factor, 0.0)
        if size.imag:
            ahead = transformed(self.history, since - half, since + half)
            return np.asarray(size.real * factor + size.imag * ahead)
        return np.asarray(size.real * factor)


def acting_loads(scene: Scene) -> tuple[InterfaceLoad | ActingFront, ...]:
    """Return the loads of a scene, fronts between its bodies.

    Raises
    ------
    SceneError
        If a wave beyond a critical angle has a history that does not return to 0.
    """
    solids: dict[str, Any] = {"material": scene.material, "lower": scene.lower_material}
    loads = tuple(
        ActingFront(load.front, load.history, load.at, **solids)
        if isinstance(load, FrontLoad)
        else load
        for load in scene.loads
    )
    for load in loads:
        if not isinstance(load, ActingFront) or comes_back(load.history):
            continue
        if any(size.imag for size in load.amplitudes.values()):
            raise SceneError(
                f"load: {load.front} is beyond a critical angle, so that the wave runs "
                "along the interface ahead of the front; its history has to return to 0 by "
                "jumps and straight lines, as a rectangle, a triangle or a Table does."
            )
    return loads
