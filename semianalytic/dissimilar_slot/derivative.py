"""Derivatives of a solved pair with respect to a parameter of its bodies, friction or tractions.

The edges satisfy their conditions for every nearby value of a parameter.  The pair is differenced
between neighbours with edges of their own (`neighbours`), and the error is estimated from a second,
coarser difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.pair import PARAMETERS, TRACTIONS
from semianalytic.dissimilar_slot.densities.profile import GAP, NORMAL, OPENING, RATE, SHEAR, SLIP
from semianalytic.dissimilar_slot.densities.zones import edges_of
from semianalytic.dissimilar_slot.neighbours import Member, Varied, border, neighbours
from semianalytic.parameters.numbers import numbers_of
from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_word
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.derivatives.derivative import OpenDerivative, ZoneDerivative
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone, is_open, over_slowness

_TOLERANCE = 1e-11
"""Tolerance of the rule of neighbours."""


@checking_methods
@dataclass(frozen=True, eq=False)
class PairDerivative:
    """Derivatives of a solved pair with respect to one parameter, all others held.

    Fields broadcast over positions x > 0 [length] and times t [time], in units of the field per
    unit of the parameter, and hold for the present set of zones, whose edges move.

    Attributes
    ----------
    scene : Scene
    name : str
        "friction", "viscosity", "base_pressure", "base_shear", "load_pressure", "load_shear",
        "shear_modulus", "density" or "poisson_ratio" of the upper body, or the last three of the
        lower one with "lower_" before them.
    zones : tuple of ZoneDerivative
        From the contact edge outward, like `PairSolution.zones`.
    openings : tuple of OpenDerivative
    status : str
        "converged"; a sentence where zones are about to change, so that the derivative holds to one
        side only, or what to distrust in the solution.
    varied : Varied
        The pair and its neighbours.
    opened : tuple of OpenZone
        Open parts of the solution, where tractions stay zero.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> base, load = sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6)
    >>> scene = sa.Scene(gouge, 0.4, base, load, lower_material=rock)
    >>> by_friction = sa.solve(scene).derivative("friction")
    >>> [round(zone.outer) for zone in by_friction.zones]  # m/s per unit of friction
    [-2108]
    """

    scene: Scene
    name: str
    zones: tuple[ZoneDerivative, ...]
    openings: tuple[OpenDerivative, ...]
    status: str
    varied: Varied
    opened: tuple[OpenZone, ...]

    def __repr__(self) -> str:
        speeds = ", ".join(f"{zone.inner:.4g} and {zone.outer:.4g}" for zone in self.zones)
        zones = f"edges move by {speeds}" if self.zones else "no slip"
        return f"<PairDerivative with respect to {self.name}: {zones}; {self.status}>"

    def _evaluate(self, x: ArrayLike, t: ArrayLike, row: int) -> Array:
        return over_slowness(
            self.scene.material.shear_speed, x, t, lambda v: self.varied.fields(v)[row]
        )

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the relative slip rate [length / time per unit of the parameter].

        It grows without bound towards edges where the slip rate has a root.

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._evaluate(x, t, RATE)

    def gap_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the rate of opening [length / time per unit]; raises as `slip_rate`."""
        return self._evaluate(x, t, OPENING)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the relative slip [length per unit]; raises as `slip_rate`."""
        return np.asarray(x, dtype=float) * self._evaluate(x, t, SLIP)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the gap [length per unit], 0 where closed; raises as `slip_rate`."""
        gap = np.asarray(x, dtype=float) * self._evaluate(x, t, GAP)
        return np.where(is_open(self.opened, x, t), gap, 0.0)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the total shear traction [stress per unit]; raises as `slip_rate`."""
        return self._traction(x, t, SHEAR, "base_shear")

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Derivative of the contact pressure [stress per unit]; raises as `slip_rate`."""
        return self._traction(x, t, NORMAL, "base_pressure")

    def _traction(self, x: ArrayLike, t: ArrayLike, row: int, base: str) -> Array:
        before = np.asarray(t, dtype=float) < 0
        # Before the load there is the base alone.
        values = np.where(before, float(self.name == base), self._evaluate(x, t, row))
        return np.where(is_open(self.opened, x, t), 0.0, values)

    @property
    def edge_slip_rate(self) -> float:
        """Derivative of the relative slip rate at the contact edge [length / time per unit]."""
        return self.varied.at_edge

    @cached_property
    def error_estimate(self) -> float:
        """Estimate of the error of edges and fields, relative to their largest derivative.

        It holds further than 0.03 of the slowest wave speed from edges and fronts, and takes a
        second, coarser derivative, which is computed on first access.
        """
        fine = self.varied
        coarse = neighbours(fine.own, self.name, 10.0 * _TOLERANCE, 0.7 * fine.step)
        worst = _share(fine.edges, coarse.edges)
        scene, marks = self.scene, np.array(fine.own.marks)
        slowest = fine.own.profile.density.interface.compliance.last
        velocity = np.linspace(0.0, 1.1 / marks[0], 202)[1:-1]
        apart = np.abs(velocity[:, None] - 1 / marks).min(axis=1) * slowest
        v = 1 / velocity[apart > 0.03]  # clear of edges and fronts, over the slowest wave speed
        finer, other = fine.fields(v), coarse.fields(v)
        opened = is_open(self.opened, scene.material.shear_speed / v, 1.0)
        # Where it is open tractions are 0 whatever the parameter; what is left of them is rounding.
        finer[SHEAR:, opened] = other[SHEAR:, opened] = 0.0
        worst = max([worst, *(_share(*rows) for rows in zip(finer, other, strict=True))])
        return 1e-9 + 4.0 * worst


def _share(values: Array, other: Array) -> float:
    """Return the largest difference over the largest value."""
    largest = float(np.abs(values).max(initial=0.0))
    return float(np.abs(values - other).max(initial=0.0)) / largest if largest else 0.0


def differentiated(
    own: Member, name: str, known: tuple[tuple[SlipZone, ...], tuple[OpenZone, ...]], status: str
) -> PairDerivative:
    """Return the derivative of a solved pair with respect to one of `PARAMETERS`.

    It refuses other names and films that are not there; edges may fail at nearby values.
    """
    checked_word("derivative: name", name, PARAMETERS)
    if name == "viscosity" and not numbers_of(own.scene)[name].value > 0:
        raise SceneError(
            "derivative: with respect to viscosity the pair needs friction of a positive viscosity."
        )
    # Half and twice the step change derivatives by less than their estimates.
    varied = neighbours(own, name, _TOLERANCE, 2e-3 * _size(own, name))
    if status == "converged":
        status = border(varied, name) or status
    ends = edges_of(own.profile.density.zones)
    speed = own.scene.material.shear_speed
    rates = dict(zip(ends, varied.edges.tolist(), strict=True))

    def moved(velocity: float) -> float:
        """Return the derivative of the velocity of an edge, 0 at the contact edge."""
        if velocity == 0:
            return 0.0
        return rates[min(ends, key=lambda end: abs(speed / end - velocity))]

    zones, openings = known
    return PairDerivative(
        own.scene,
        name,
        tuple(ZoneDerivative(moved(zone.inner), moved(zone.outer), zone.sense) for zone in zones),
        tuple(OpenDerivative(moved(opening.inner), moved(opening.outer)) for opening in openings),
        status,
        varied,
        openings,
    )


def _size(own: Member, name: str) -> float:
    """Return the size of a parameter over which its step is taken."""
    value = abs(numbers_of(own.scene)[name].value)
    if name in TRACTIONS:
        return max(value, own.stress)
    if name.endswith("poisson_ratio"):
        return 0.25
    return value
