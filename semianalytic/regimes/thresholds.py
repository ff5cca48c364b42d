"""Boundaries between slip regimes over (nu, chi), each the root of one scalar function.

Two loadings of unit shear, Q_0 = 1: "preload" holds the pressure P_b = 1 before a step of shear,
"remote" is a sudden uniform load of pressure P_0 = 1 and shear.  In both the friction coefficient
is chi.  Lengths of slowness are in units of b = 1/c_t.

A zone that grows from the contact edge has one unknown, its front; for a given front the balance
of tractions there is linear in chi.  So the curves are traced along the front, not along chi.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq, root

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_word
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.loading import REMOTE, SLOT, Tractions
from semianalytic.scene.scene import Material, Scene
from semianalytic.selfsimilar.solver import solve
from semianalytic.selfsimilar.zones.tuning import NARROWEST_GAP

Loading = Literal["preload", "remote"]

_TRACTIONS = {
    "preload": (Tractions(1.0, 0.0), Tractions(0.0, 1.0), SLOT),
    "remote": (Tractions(0.0, 0.0), Tractions(1.0, 1.0), REMOTE),
}
"""Base, load and the place where it acts."""
SLOW_FRONTS = (math.log(1e-6), math.log(1e6))
"""Logarithms of v - c for fronts between c_R and nearly 0."""
NEGLIGIBLE = 5e-4
"""Friction past a threshold whose new zone is left out: others shift by less than 1e-8."""
RULE = rule_for(1e-12)
"""Rule of all thresholds: the traction at a front is right to 40 times its tolerance at worst."""
_PAST_FRONTS = (-15.0, 3.0)
"""Unknowns of `past_rayleigh` for fronts from close to c_l to close to c_t."""
_VISCOUS_FRONTS = (-25.0, 25.0)
"""The same, from c_l to c_t, under viscous friction."""
_BESIDE = 1e-6
"""Distance from c at which the logarithm is read: what is left of V is O(1e-12)."""


@dataclass(frozen=True)
class OneZone:
    """A zone from the contact edge to one front, with the friction that balances the front.

    Attributes
    ----------
    chi : float
        Friction over load; negative where no friction balances the front.
    profile : Profile
        Fields for that friction.
    """

    chi: float
    profile: Profile


@dataclass(frozen=True)
class RayleighLogarithm:
    """The logarithm V = level + residue ln|v - c| in a zone that covers c_R, in Q_0 / (mu b)."""

    level: float
    residue: float

    @property
    def log_half_width(self) -> float:
        """Return ln of the half-width [b] of the strip in which V < 0; residue > 0."""
        return -self.level / self.residue


def scene_of(loading: Loading, poisson_ratio: float, chi: float) -> Scene:
    """Return the scene of a loading in units mu = rho = Q_0 = 1 and unit pressure.

    Raises
    ------
    SceneError
        If the Poisson ratio is not in (-1, 0.5) or chi < 0.
    """
    base, load, place = _TRACTIONS[checked_word("loading", loading, _TRACTIONS)]
    return Scene(Material(1.0, 1.0, poisson_ratio), chi, base, load, load_on=place)


def load_of(loading: Loading, chi: float, viscosity: float = 0.0) -> Load:
    """Return the load of a scene in its own units, for a viscosity [rho c_t / 2]."""
    held, off = scene_of(loading, 0.0, 0.0).superposition
    tractions = (held.pressure, held.shear, off.pressure, off.shear)
    return Load(chi, *tractions, far_slip_rate=0.0, resistance=viscosity or None)


def one_zone(
    loading: Loading, poisson_ratio: float, front: CutPoints, viscosity: float = 0.0
) -> OneZone:
    """Return friction and fields for one zone from the contact edge to a front.

    The front is at a slowness (1,), and slip meets a viscosity [rho c_t / 2].
    """
    factors = rayleigh_factors(poisson_ratio)
    zones = (Zone(front, None, 1),)

    def fields(chi: float, tail: bool) -> ZoneFields:
        return ZoneFields(factors, load_of(loading, chi, viscosity), zones, RULE, tail)

    without, unit = (float(fields(chi, False).mismatch()[0]) for chi in (0.0, 1.0))
    chi = without / (without - unit)
    return OneZone(chi, Profile(fields(chi, True)))


def past_rayleigh(poisson_ratio: float, unknown: float) -> CutPoints:
    """Return a front between c_t and c_l; its unknown runs from -inf at c_l to inf at c_t."""
    factors = rayleigh_factors(poisson_ratio)
    width = 1 - factors.a
    distance = width / (1 + math.exp(min(abs(unknown), 700.0)))  # e^710 overflows
    return factors.beside("a", [distance]) if unknown < 0 else factors.beside("b", [-distance])


def rayleigh_logarithm(zone: OneZone) -> RayleighLogarithm:
    """Return level and residue of V at c_R in a zone whose front runs ahead of the shear wave."""
    profile = zone.profile
    panel = max(range(len(profile.panels.left)), key=lambda i: abs(profile.residue(i)))
    residue = profile.residue(panel)
    rate = profile.slip_rate(profile.fields.factors.c + np.array([-_BESIDE, _BESIDE]))
    return RayleighLogarithm(float(np.mean(rate)) - residue * math.log(_BESIDE), residue)


def edge_threshold_alone(poisson_ratio: float) -> float:
    """Return the friction above which the edge of a stuck, remotely loaded interface sticks.

    It is sqrt(b/a), where K_II = f K_I of (3.13), (3.16); the article says 1 (3.17)-(3.19).

    Raises
    ------
    SceneError
        If the Poisson ratio is not in (-1, 0.5), as of all functions here.
    """
    return rayleigh_factors(poisson_ratio).a ** -0.5


def front_threshold_stuck(poisson_ratio: float) -> float:
    """Return the friction below which the shear front of a stuck, remotely loaded interface slips.

    It is (1 + q*(b)) / (1 + p*(b)), with the stuck tractions of (3.10), (3.14).
    """
    shear, pressure = (stuck_traction(poisson_ratio, mode) for mode in ("II", "I"))
    return float((1 + shear(1.0)) / (1 + pressure(1.0)))


def opening_threshold(poisson_ratio: float) -> float:
    """Return the ratio P_b / P_0 below which the contact opens ahead of a sudden pressure P_0.

    It is -p*(c): the pressure of a closed contact is least at the Rayleigh front, where it falls by
    this fraction of the step.  Under pressure put on the slot, P_0 < 0, the contact edge opens at
    once, whatever the base.

    Errors are those of `edge_threshold_alone`.
    """
    return -float(stuck_traction(poisson_ratio, "I").at_rayleigh_front)


def crossing_poisson_ratio() -> float:
    """Return the Poisson ratio below which the shear front slips before the contact edge."""
    return float(brentq(lambda nu: edge_threshold_alone(nu) - front_threshold_stuck(nu), -0.6, 0.0))


def _front_excess(zone: OneZone) -> float:
    """Return shear traction less friction at the shear front, ahead of a zone slower than c_R."""
    profile = zone.profile
    panel = next(i for i, at in enumerate(profile.panels.left) if at.from_b[0] == 0)
    bound = zone.chi * (profile.fields.load.base_pressure + profile.pressure_change(np.ones(1))[0])
    return float(profile.traction_at_nodes[panel][0] - bound)


def nucleation_alone(loading: Loading, poisson_ratio: float, viscosity: float = 0.0) -> OneZone:
    """Return the zone from the edge that has just brought the shear front to its bound."""
    factors = rayleigh_factors(poisson_ratio)

    def zone(log_distance: float) -> OneZone:
        front = factors.beside("c", [math.exp(log_distance)])
        return one_zone(loading, poisson_ratio, front, viscosity)

    return zone(brentq(lambda z: _front_excess(zone(z)), *SLOW_FRONTS, xtol=1e-12))


def nucleation(loading: Loading, poisson_ratio: float, viscosity: float = 0.0) -> float:
    """Return the friction below which the interface slips at the shear front.

    The viscosity is in units of rho c_t / 2, the traction of a plane shear wave per relative slip
    rate.

    The traction ahead of a slow zone peaks exactly at the shear front, so this is where that
    peak meets the bound; where the front breaks first, it is the peak of the stuck interface.
    """
    if loading == "remote":
        front = front_threshold_stuck(poisson_ratio)
        if front >= edge_threshold_alone(poisson_ratio):
            return front
    return nucleation_alone(loading, poisson_ratio, viscosity).chi


def edge_threshold(poisson_ratio: float) -> float:
    """Return the friction below which the contact edge slips under a remote load.

    It is sqrt(b/a) unless slip at the shear front comes first and loads the edge further.  Just
    past the Poisson ratio at which it does, the zone there is tiny and shifts the threshold by <
    1e-8.

    Raises
    ------
    ComputationError
        If Newton's method fails.
    """
    alone, most = edge_threshold_alone(poisson_ratio), front_threshold_stuck(poisson_ratio)
    if most < alone + NEGLIGIBLE:
        return alone
    factors = rayleigh_factors(poisson_ratio)

    def residual(unknowns: Array) -> Array:
        healed, front, chi = unknowns
        zones = (Zone(past_rayleigh(poisson_ratio, front), before_rayleigh(factors, healed), 1),)
        fields = ZoneFields(factors, load_of("remote", chi), zones, RULE)
        edge = Profile(fields).edge_intensity / (chi * math.sqrt(factors.a)) - 1
        return np.append(fields.mismatch(), edge)

    zone = solve(scene_of("remote", poisson_ratio, alone), rtol=1e-6).zones[-1]
    start = [*front_zone_unknowns(poisson_ratio, zone.inner, zone.outer), alone]
    return float(rooted(residual, start)[-1])


def gap_threshold(loading: Loading, poisson_ratio: float) -> float | None:
    """Return the friction below which double precision does not resolve the stick gap at c_R.

    The logarithm at c_R in a zone that covers it always reverses V, so a gap always exists; it
    narrows like exp(-level / residue).  None if it never gets as narrow as `NARROWEST_GAP`.
    """

    def excess(unknown: float) -> float:
        zone = one_zone(loading, poisson_ratio, past_rayleigh(poisson_ratio, unknown))
        return rayleigh_logarithm(zone).log_half_width - math.log(NARROWEST_GAP)

    if excess(_PAST_FRONTS[0]) > 0:
        return None
    unknown = brentq(excess, *_PAST_FRONTS, xtol=1e-12)
    return one_zone(loading, poisson_ratio, past_rayleigh(poisson_ratio, unknown)).chi


def before_rayleigh(factors: RayleighFactors, unknown: float) -> CutPoints:
    """Return an edge between c_R and c_t; its unknown runs from -inf at c_R to inf at c_t."""
    width = factors.c - 1
    if unknown < 0:
        return factors.beside("c", [-width / (1 + math.exp(-unknown))])
    return factors.beside("b", [width / (1 + math.exp(unknown))])


def front_zone_unknowns(poisson_ratio: float, healed: float, front: float) -> tuple[float, float]:
    """Return the unknowns of a zone around the shear front from the speeds [c_t] of its edges."""
    factors = rayleigh_factors(poisson_ratio)
    u, v = 1 / healed, 1 / front
    return math.log((factors.c - u) / (u - 1)), math.log((v - factors.a) / (1 - v))


def rooted(residual: Callable[[Array], Array], start: Sequence[float]) -> Array:
    """Return a root of a system of equations near a start."""
    result = root(residual, start, options={"xtol": 1e-11, "factor": 0.1})  # small first steps
    if not np.abs(result.fun).max() < 1e-8:
        raise ComputationError(f"a regime boundary was not found: {result.message}")
    return result.x


def viscous_closing(poisson_ratio: float, viscosity: float) -> float | None:
    """Return the friction f P_b / Q_0 below which one zone covers c_R under a step of shear.

    With a resistance eta the slope of slip rate at c_R is given by the pressure, which is least
    there: V' = 0, and V has a minimum at c_R in a zone that covers it.  The gap closes where it is
    0.  There is no such friction without viscosity, where a small viscosity leaves a gap however
    low friction is, or, for any viscosity, where the stuck traction at c_R opposes the load.  As
    viscosity grows the friction tends to that traction, q*(c).

    Returns
    -------
    float or None
        None if the gap never closes.
    """
    front_c = rayleigh_factors(poisson_ratio).front_c

    def least_rate(unknown: float) -> float:
        zone = one_zone("preload", poisson_ratio, past_rayleigh(poisson_ratio, unknown), viscosity)
        return float(zone.profile.slip_rate_at(front_c)[0])

    if not viscosity or least_rate(_VISCOUS_FRONTS[0]) <= 0:
        return None
    unknown = brentq(least_rate, *_VISCOUS_FRONTS, xtol=1e-12)
    front = past_rayleigh(poisson_ratio, float(unknown))
    return one_zone("preload", poisson_ratio, front, viscosity).chi


def closing_limit(poisson_ratio: float) -> float:
    """Return q*(c), the stuck traction at c_R over the step, to which `viscous_closing` tends."""
    factors = rayleigh_factors(poisson_ratio)
    return float(stuck_traction(poisson_ratio, "II")(np.array(factors.c)))


def closing_poisson_ratio() -> float:
    """Return the Poisson ratio below which no viscosity closes the gap, q*(c) = 0."""
    return float(brentq(closing_limit, -0.5, 0.0, xtol=1e-12))
