"""How a solution changes with a parameter of its scene: everything on the interface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.load import Load
from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar import tuning
from semianalytic.selfsimilar.borders import border
from semianalytic.selfsimilar.motion import over_slowness
from semianalytic.selfsimilar.variation import Rates, Surroundings
from semianalytic.selfsimilar.varied import VariedProfile

PARAMETERS = (
    "friction",
    "poisson_ratio",
    "base_pressure",
    "base_shear",
    "load_pressure",
    "load_shear",
    "viscosity",
)
"""Of a scene, with respect to which there are derivatives."""


@dataclass(frozen=True)
class ZoneDerivative:
    """How fast the edges of a slip zone change with a parameter.

    Attributes
    ----------
    inner, outer : float
        Derivatives of the velocities of its edges [length / time per unit of the parameter]; 0 at
        the contact edge and ahead of all waves.
    sense : int
        That of the zone.
    """

    inner: float
    outer: float
    sense: int


@dataclass(frozen=True, eq=False)
class Derivative:
    """Derivatives of a solution with respect to one parameter of its scene, all else held.

    Fields broadcast over positions x > 0 [length] and times t [time], in units of the field per
    unit of the parameter.  They belong to the other fields of the solution as it is: zones that
    stay, edges that move.

    Attributes
    ----------
    scene : Scene
    name : str, the parameter: one of "friction", "poisson_ratio", "base_pressure", "base_shear",
        "load_pressure", "load_shear" and "viscosity"
    zones : tuple of ZoneDerivative, from the contact edge outward, as `Solution.zones`
    status : str
        "converged"; a sentence where zones are about to change, so that the derivative holds to
        one side only, or what to distrust in the solution.
    error_estimate : float
        Of edges, slip rate, slip and tractions, relative to their largest derivative or, where that
        is less, to c_t and the largest values of the fields over that of the parameter; at points
        further than 0.03 c_t from zone edges and from wave fronts: nearer they are infinite or
        nearly so.
    varied : VariedProfile
        The fields over slowness, in units b = mu = 1 and `stress`.
    stress : float
        Unit of stress of `varied`.
    """

    scene: Scene
    name: str
    zones: tuple[ZoneDerivative, ...]
    status: str
    error_estimate: float
    varied: VariedProfile
    stress: float

    def __repr__(self) -> str:
        speeds = ", ".join(f"{one.inner:.4g} and {one.outer:.4g}" for one in self.zones)
        zones = f"edges move by {speeds}" if self.zones else "no slip"
        return f"<Derivative with respect to {self.name}: {zones}; {self.status}>"

    def _evaluate(self, x: ArrayLike, t: ArrayLike, field: Callable[[Array], Array]) -> Array:
        return over_slowness(self.scene.material.shear_speed, x, t, field)

    @property
    def _rate_unit(self) -> float:
        return 2 * self.stress / self.scene.material.shear_impedance

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Of the relative slip rate [length / time per unit of the parameter].

        Plus or minus infinity at edges where the slip rate has a square root.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._rate_unit * self._evaluate(x, t, self.varied.slip_rate)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Of the relative slip [length per unit of the parameter]; raises as `slip_rate`."""
        time = np.asarray(t, dtype=float)
        return self._rate_unit * time * self._evaluate(x, t, self.varied.slip_over_time)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Of the total shear traction [stress per unit of the parameter]; raises as `slip_rate`.

        Plus or minus infinity at edges beside which it has a square root.
        """
        before = self.varied.variation.rates.base_shear
        change = self._evaluate(x, t, lambda u: self.varied.traction(u) - before)
        return self.stress * (before + change)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Of the contact pressure [stress per unit of the parameter]; raises as `slip_rate`."""
        before = self.varied.variation.rates.base_pressure
        change = self._evaluate(x, t, lambda u: self.varied.pressure(u) - before)
        return self.stress * (before + change)

    @property
    def edge_slip_rate(self) -> float:
        """Of the relative slip rate at the contact edge, x -> 0+ [length / time per unit]."""
        return self._rate_unit * self.varied.edge_slip_rate


@dataclass(frozen=True)
class Known:
    """Of a solution: its zones as (inner, outer, sense), its status and its error estimate."""

    zones: tuple[tuple[float, float, int], ...]
    status: str
    error_estimate: float


def differentiated(
    scene: Scene,
    surroundings: Surroundings,
    stress: float,
    known: Known,
    name: str,
) -> Derivative:
    """Derivative of a solved scene: surroundings of its zones in a unit of stress, and what is
    known of the solution.

    Raises
    ------
    SceneError
        If there is no such parameter or no derivative with respect to it in this scene.
    ComputationError
        If zones on either side of these, however near, have other panels.
    """
    profile = surroundings.profile
    rates = _rates(scene, profile.fields.load, stress, name)
    varied = VariedProfile(profile, surroundings.variation(rates))
    status = known.status
    if status == "converged":
        status = border(scene, profile, name) or status
    return Derivative(
        scene,
        name,
        _zones(scene, varied, known.zones),
        status,
        tuning.LEAST_DERIVATIVE_ERROR + tuning.DERIVATIVE_SHARE * known.error_estimate,
        varied,
        stress,
    )


def _rates(scene: Scene, load: Load, stress: float, name: str) -> Rates:
    """What a parameter of a scene changes of its load."""
    if name not in PARAMETERS:
        raise SceneError(f"derivative: name must be one of {', '.join(PARAMETERS)}, got {name!r}.")
    if load.opened is not None:
        raise SceneError(
            "derivative: parts of this contact are open; raise the base pressure until it stays "
            "closed, or difference two solutions (docs/limits.md)."
        )
    if load.linearised is not None:
        raise SceneError(
            "derivative: there is one for constant and viscous friction only; difference two "
            "solutions (docs/limits.md)."
        )
    if name == "friction" and scene.friction == 0:
        raise SceneError(
            "derivative: without friction the sense of slip is free, and friction of any size "
            "opens stick gaps; take a small positive friction."
        )
    if name == "viscosity" and load.resistance is None:
        raise SceneError(
            "derivative: with respect to viscosity the scene needs ViscousFriction of a positive "
            "viscosity."
        )
    if name == "viscosity":
        rates = Rates(resistance=2 / scene.material.shear_impedance)
    else:
        plain = name in ("friction", "poisson_ratio")
        rates = Rates(**{name: 1.0 if plain else 1 / stress})
    far = load.far_slip_rate
    if not far:
        return rates
    strength = rates.friction * load.base_pressure + load.friction * rates.base_pressure
    excess = rates.base_shear - np.sign(far) * strength - rates.resistance * far
    return replace(rates, far_slip_rate=float(excess / (1 + (load.resistance or 0.0))))


def _zones(
    scene: Scene, varied: VariedProfile, speeds: Sequence[tuple[float, float, int]]
) -> tuple[ZoneDerivative, ...]:
    """How the edges of zones (inner, outer, sense) move, from the contact edge outward."""
    fields, unit = varied.profile.fields, scene.material.shear_speed
    edges = [edge for zone in fields.zones for edge in (zone.left, zone.right) if edge is not None]
    known = {float(unit / edge.v[0]): varied.moved(edge)[0] / edge.v[0] ** 2 for edge in edges}
    known |= {0.0: 0.0, np.inf: 0.0, scene.fastest_speed: 0.0}
    if scene.fastest_speed > unit:
        known[scene.fastest_speed] = varied.moved(fields.factors.front_a)[0] / fields.factors.a**2

    def moved(speed: float) -> float:
        if speed not in known:  # where the sense of free slip changes
            u = np.array([unit / speed])
            known[speed] = varied.moved_root(u)[0] / u[0] ** 2
        return -unit * float(known[speed])

    return tuple(
        ZoneDerivative(moved(inner), moved(outer), sense) for inner, outer, sense in speeds
    )
