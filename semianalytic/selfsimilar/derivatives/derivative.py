"""Derivatives of a solution with respect to a parameter of its scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.derivatives.error import difference_error
from semianalytic.selfsimilar.derivatives.parameters import (
    border,
    changes,
    parameter,
    starts_at_front,
)
from semianalytic.selfsimilar.derivatives.variation import Surroundings
from semianalytic.selfsimilar.derivatives.varied import VariedProfile, edges_of_zones
from semianalytic.selfsimilar.zones.motion import over_slowness


@dataclass(frozen=True)
class ZoneDerivative:
    """Derivatives of the edge velocities of a slip zone with respect to a parameter.

    Attributes
    ----------
    inner, outer : float
        Derivatives of the velocities of its edges [length / time per unit of the parameter]; 0 at
        the contact edge and ahead of all waves.
    sense : int
        Sense of slip in the zone.

    Examples
    --------
    The edge velocity c_t / ((1 - nu) (1 + chi_b)^2) has the derivative -0.375 with respect to
    friction here:

    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 1.0, base, load))
    >>> (zone,) = solution.derivative("friction").zones
    >>> round(zone.outer, 6), zone.sense
    (-0.375, 1)
    """

    inner: float
    outer: float
    sense: int


@dataclass(frozen=True)
class OpenDerivative:
    """Derivatives of the edge velocities of an opening with respect to a parameter.

    Attributes
    ----------
    inner, outer : float
        Derivatives of the velocities of its edges [length / time per unit of the parameter]; 0 at
        the contact edge.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(-1.0, 0.5)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 0.3, base, load))
    >>> (opening,) = solution.derivative("base_pressure").openings
    >>> round(opening.outer, 6)
    -0.1875
    """

    inner: float
    outer: float


@checking_methods
@dataclass(frozen=True, eq=False)
class Derivative:
    """Derivatives of a solution with respect to one parameter of its scene, all others fixed.

    Fields broadcast over positions x > 0 [length] and times t [time], in units of the field per
    unit of the parameter. They hold for the present set of zones, whose edges move.

    Attributes
    ----------
    scene : Scene
    name : str
        The parameter: one of "friction", "poisson_ratio", "base_pressure", "base_shear",
        "load_pressure", "load_shear" and "viscosity"; of an incident wave "angle" (per degree),
        and "wave_velocity" or "wave_stress", whichever it has; of a moving load "load_speed".
    zones : tuple of ZoneDerivative
        From the contact edge outward, like `Solution.zones`.
    openings : tuple of OpenDerivative
        From the contact edge outward, like `Solution.openings`.
    status : str
        "converged"; a sentence where zones are about to change, so that the derivative is valid on
        one side only, or on what is unreliable in the solution.
    varied : VariedProfile
        The fields over slowness, in units b = mu = 1 and `stress`.
    stress : float
        Unit of stress of `varied`.
    surroundings : Surroundings
        Neighbouring sets of zones of the solution.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions, solve
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 1.0)
    >>> solution = solve(Scene(Material(1.0, 1.0, 1 / 3), 1.0, base, load))
    >>> by_friction = solution.derivative("friction")
    >>> by_friction.status
    'converged'
    >>> round(float(by_friction.slip_rate(0.2, 1.0)), 6)
    -0.392153
    """

    scene: Scene
    name: str
    zones: tuple[ZoneDerivative, ...]
    status: str
    varied: VariedProfile
    stress: float
    surroundings: Surroundings

    @cached_property
    def error_estimate(self) -> float:
        """Error estimate of edges, slip rate, slip and tractions, for the present set of zones.

        It is relative to their largest derivative. If that is smaller, it is relative to c_t and
        the largest values of the fields, over the value of the parameter (over 1, or the unit of
        stress, if that is 0). It applies to points further than 0.03 c_t from zone edges and from
        wave fronts, where derivatives are infinite or nearly so. It requires a second, coarser
        derivative, which is computed on first access.
        """
        fine = self.varied
        companion = self.surroundings.companion
        coarse = VariedProfile(companion.profile, companion.variation(fine.variation.rates))
        return difference_error(fine, coarse, self._size)

    @property
    def _size(self) -> float:
        """Value of the parameter, over which `varied` counts; if 0, 1 or the unit of stress."""
        tractions = ("base_pressure", "base_shear", "load_pressure", "load_shear", "wave_stress")
        unit = self.stress if self.name in tractions else 1.0
        return abs(parameter(self.scene, self.name)) or unit

    def __repr__(self) -> str:
        speeds = ", ".join(f"{zone.inner:.4g} and {zone.outer:.4g}" for zone in self.zones)
        zones = f"edges move by {speeds}" if self.zones else "no slip"
        return f"<Derivative with respect to {self.name}: {zones}; {self.status}>"

    def _evaluate(self, x: ArrayLike, t: ArrayLike, field: Callable[[Array], Array]) -> Array:
        return over_slowness(self.scene.material.shear_speed, x, t, field)

    @property
    def _rate_unit(self) -> float:
        return 2 * self.stress / self.scene.material.shear_impedance

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the relative slip rate [length / time per unit of the
        parameter].

        It is plus or minus infinity at edges where the slip rate has a square root.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._rate_unit * self._evaluate(x, t, self.varied.slip_rate)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the relative slip [length per unit of the parameter].

        Raises what `slip_rate` raises.
        """
        time = np.asarray(t, dtype=float)
        return self._rate_unit * time * self._evaluate(x, t, self.varied.slip_over_time)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the total shear traction [stress per unit of the parameter].

        It is plus or minus infinity at edges near which the traction has a square root. Raises
        what `slip_rate` raises.
        """
        ahead = self._ahead("shear", x, t)
        held = self.varied.variation.rates.base_shear
        change = self._evaluate(x, t, lambda u: self.varied.traction(u) - held)
        return ahead + self.stress * change

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the contact pressure [stress per unit of the parameter].

        Raises what `slip_rate` raises.
        """
        ahead = self._ahead("pressure", x, t)
        # The profile counts the base as in place; before t = 0 a remote load is not.
        held = self.varied.variation.rates.base_pressure
        change = self._evaluate(x, t, lambda u: self.varied.pressure(u) - held)
        return ahead + self.stress * change

    def _ahead(self, kind: str, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of a traction where no wave has arrived; its front is left out."""
        before = float(self.name == f"base_{kind}")
        after = self.stress * getattr(self.varied.variation.rates, f"base_{kind}")
        lag = np.asarray(t, dtype=float) - self.scene.front_slowness * np.asarray(x, dtype=float)
        return np.where(lag < 0, before, after)

    @property
    def openings(self) -> tuple[OpenDerivative, ...]:
        """Derivatives of the open parts of the contact, from the contact edge outward."""
        opened = self.varied.profile.fields.load.opened
        if opened is None:
            return ()
        unit, ends = self.scene.material.shear_speed, (opened.zone.right, opened.zone.left)
        inner, outer = (0.0 if end is None else unit * self.varied.edge_moved(end) for end in ends)
        return (OpenDerivative(inner, outer),)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the gap [length per unit of the parameter], 0 where closed.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite; and in antiplane shear, where
            the panels have no nodes on either side of the Rayleigh front: the gap is that of the
            same scene in plane strain.
        """
        time = np.asarray(t, dtype=float)
        return self._rate_unit * time * self._of_gap(x, t, VariedProfile.slip_over_time)

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the derivative of the rate of the gap [length / time per unit of the parameter].

        It is plus or minus infinity at edges where the rate has a square root. Raises what `gap`
        raises.
        """
        return self._rate_unit * self._of_gap(x, t, VariedProfile.slip_rate)

    def _of_gap(
        self, x: ArrayLike, t: ArrayLike, field: Callable[[VariedProfile, Array], Array]
    ) -> Array:
        normal, opened = self.varied.normal, self.varied.profile.fields.load.opened
        if normal is None or opened is None:
            return self._evaluate(x, t, np.zeros_like)
        if not self.varied.profile.fields.factors.has_rayleigh_wave:
            raise SceneError(
                "derivative: in antiplane shear the gap is that of the same scene in plane strain; "
                'take its derivative with mode="in-plane".'
            )
        start, end = opened.zone.left, opened.zone.right
        first, last = 0.0 if start is None else start.v[0], np.inf if end is None else end.v[0]

        def inside(u: Array) -> Array:
            return np.where((u >= first) & (u <= last), field(normal, u), 0.0)

        return self._evaluate(x, t, inside)

    @property
    def edge_slip_rate(self) -> float:
        """Derivative of the relative slip rate at the contact edge, x -> 0+ [length / time per
        unit]."""
        return self._rate_unit * self.varied.edge_slip_rate


def differentiated(
    solved: tuple[Scene, Surroundings, float],
    speeds: tuple[tuple[float, float, int], ...],
    status: str,
    name: str,
) -> Derivative:
    """Return the derivative of a solved scene with respect to one of `parameters.PARAMETERS`.

    The solver solves the scene, neighbouring sets of the zones of its solution, and their unit of
    stress; speeds (inner, outer, sense) and status are those of the solution.  Errors are those of
    `Solution.derivative`.
    """
    scene, surroundings, stress = solved
    profile = surroundings.profile
    rates = changes(scene, profile, stress, name)
    varied = VariedProfile(profile, surroundings.variation(rates))
    if status == "converged":
        status = border(scene, profile, name) or status
    zones = _zones(scene, varied, speeds)
    return Derivative(scene, name, zones, status, varied, stress, surroundings)


def _zones(
    scene: Scene, varied: VariedProfile, speeds: Sequence[tuple[float, float, int]]
) -> tuple[ZoneDerivative, ...]:
    """Return the derivatives of zones (inner, outer, sense), from the contact edge outward."""
    fields, unit = varied.profile.fields, scene.material.shear_speed
    speeds_of = [float(unit / edge.v[0]) for edge in edges_of_zones(varied.profile)]
    known = dict(zip(speeds_of, varied.edges_moved().tolist(), strict=True))
    known |= {0.0: 0.0, np.inf: 0.0, scene.fastest_speed: 0.0}
    if starts_at_front(varied.profile):  # the edge of a strip that no difference sees
        known |= {outer: 0.0 for _, outer, _ in speeds[-1:]}
    if scene.fastest_speed > unit:
        known[scene.fastest_speed] = varied.edge_moved(fields.factors.front_a)
    # The strip that sticks behind the front has a width like the 2/3 power of the excess; under a
    # step of pressure like its square.
    excess = varied.variation.rates.front_excess
    if excess and not fields.load.load_pressure:
        known[scene.fastest_speed] = float(np.copysign(np.inf, excess * fields.zones[0].sense))

    def moved(speed: float) -> float:
        if speed not in known:  # where the sense of free slip changes
            u = np.array([unit / speed])
            known[speed] = -varied.moved_root(u)[0] / u[0] ** 2
        return unit * float(known[speed])

    return tuple(
        ZoneDerivative(moved(inner), moved(outer), sense) for inner, outer, sense in speeds
    )
