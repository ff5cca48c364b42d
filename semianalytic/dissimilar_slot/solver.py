"""Solve a pair: find zones on a grid, place their edges, check the law of contact and correct."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.compliance import Compliance, compliance_of
from semianalytic.dissimilar.delay import fastest_delayed_growth
from semianalytic.dissimilar.growth import growing_waves
from semianalytic.dissimilar.pair import check_bodies
from semianalytic.dissimilar.thresholds import LEAST_FRICTION, growth_threshold, stoneley_speed
from semianalytic.dissimilar_slot.admissible import largest_breach, violations
from semianalytic.dissimilar_slot.corrections import corrected, rearranged
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies, interface_of
from semianalytic.dissimilar_slot.densities.panels import rule_for
from semianalytic.dissimilar_slot.densities.profile import PairProfile
from semianalytic.dissimilar_slot.densities.zones import MovingZone, edges_of
from semianalytic.dissimilar_slot.grid import seen_on_grid, zones_seen
from semianalytic.dissimilar_slot.placement import PlacedZones, numerical_error, place, polished
from semianalytic.dissimilar_slot.solution import PairSolution, in_velocity
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve as solve_alike
from semianalytic.selfsimilar.statistics import Statistics

GRIDS = ((48, 1.0), (96, 1.0), (48, 0.7), (48, 0.4), (192, 1.0))
"""Nodes and share of friction of grids: one of 60 pairs needed a weaker one; the last may take 20
s."""
_LOCATING = 1e-5
"""Tolerance of the rule on which zones are looked for."""
_LOCATED = 1e-4
"""Change of an unknown that ends Newton's method in the search."""
_CANONICAL = 0.1
"""Tolerance of the canonical matrix over that of the rule."""
_LEFT_OUT = 1e-3
"""Speed over rtol, and over that of the slowest edge or wave, to which the law is checked."""
_MOVED_BY_LEFT_OUT = 20.0
"""Relative change of other edges by a zone at the contact edge that is left out, over the speed at
which the law fails without it: 1.5 to 9 in 10 pairs, whose zones are 2.3 to 4.4 times as fast."""


def refuses(scene: Scene) -> str | None:
    """Return why a scene of two solids is not solved exactly, or None.

    Whether its zones have an answer is known only when they are solved.
    """
    try:
        check_bodies(scene)
    except SceneError as error:
        return str(error).removeprefix("scene: ")
    return None


def solve(scene: Scene, *, rtol: float = 1e-8) -> PairSolution | Solution:
    """Solve a scene of two different bodies for slip, stick and opening on its interface.

    Parameters
    ----------
    scene : Scene
        A scene with a `lower_material`.
    rtol : float
        Wanted accuracy, between 1e-10 and 1e-2, of every quantity that
        `PairSolution.error_estimate` bounds.

    Returns
    -------
    PairSolution or Solution
        The second where the bodies are equal, or differ by less than a millionth.  Its `status` is
        "converged" if the error estimate is below rtol and the law of contact holds to rtol.

    Raises
    ------
    SceneError
        If rtol is out of range, the scene is of another kind, the interface slips in a sense in
        which sliding of these bodies is ill posed (the message says how fast waves grow), a
        Stoneley wave runs along the interface, or the contact opens under a viscous film.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> base, load = sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6)
    >>> scene = sa.Scene(gouge, 0.4, base, load, lower_material=rock)
    >>> answer = sa.solve(scene)
    >>> answer.status
    'converged'
    >>> answer.edge_speeds.round(1)  # of slip, in m/s; nearer to the slot the contact is open
    array([[  5.1, 903.6]])
    """
    rtol = checked_number(
        "rtol", rtol, "lie between 1e-10 and 1e-2", lambda given: 1e-10 <= given <= 1e-2
    )
    check_bodies(scene)
    compliance = compliance_of(*scene.bodies)
    return _of_one_solid(scene, compliance, rtol) if compliance.is_alike else coupled(scene, rtol)


def _of_one_solid(scene: Scene, compliance: Compliance, rtol: float) -> Solution:
    """Solve bodies that are alike as one, whose difference counts as an error."""
    found = solve_alike(replace(scene, lower_material=None), rtol=rtol)
    # At a contrast of 1e-5 slip rates at 40 points differ by 2 to 4 times as much.
    error = 4 * compliance.contrast
    if not error:
        return found
    estimate, status = found.error_estimate + error, found.status
    if status == "converged" and estimate > rtol:
        status = f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
    return replace(found, error_estimate=estimate, status=status)


def coupled(scene: Scene, rtol: float) -> PairSolution:
    """Solve a pair whose slip changes the pressure; parameters and errors are those of `solve`."""
    interface, unit = interface_of(scene)
    bonded = stoneley_speed(interface.compliance)
    if bonded is not None:
        raise SceneError(
            "scene: where these bodies stick, a wave runs along their interface at "
            f"{bonded * scene.material.shear_speed:.6g} (a Stoneley wave), at which tractions are "
            "infinite; this solver does not treat it: change a modulus or density "
            "(docs/dissimilar.md)."
        )
    clock = [perf_counter()]
    trial = _search(interface, rtol)
    clock.append(perf_counter())
    trial, estimate = _refined(trial, rtol)
    clock.append(perf_counter())
    profile = PairProfile(trial.placement.density)
    # Fields are known to rtol, and at zone edges the law compares them with the root of a distance.
    slowest = _slowest(trial.placement, rtol)
    lawful = trial.lawful and largest_breach(profile, slowest) <= 30.0 * rtol
    clock.append(perf_counter())
    density = trial.placement.density
    statistics = Statistics(
        newton_steps=trial.steps,
        zone_sets=trial.sets,
        unknowns=len(trial.placement.unknowns),
        nodes=density.unknowns,
        residual=density.residual,
        smallest_singular_value=density.smallest_singular_value,
        seconds=dict(zip(("zones", "edges", "check"), np.diff(clock).tolist(), strict=True)),
    )
    moving = slips, opens = in_velocity(trial.placement.zones, scene.material.shear_speed)
    if not any(zone.inner == 0 for zone in slips) and not any(zone.inner == 0 for zone in opens):
        estimate += _MOVED_BY_LEFT_OUT * _LEFT_OUT * rtol
    status = _status(lawful, estimate, statistics, rtol)
    # Zones that break the law are no approximation of the answer, however exact they are.
    estimate = estimate if lawful else np.inf
    return PairSolution(scene, *moving, status, estimate, statistics, profile, unit)


@dataclass(frozen=True)
class _Trial:
    """Zones that were tried, with the numbers of Newton steps and of zone sets."""

    placement: PlacedZones
    lawful: bool
    steps: int
    sets: int


def _slowest(placement: PlacedZones, rtol: float) -> float:
    """Return the slowness beyond which zones at the contact edge are left out."""
    # They move other edges by as little as their speed over that of the slowest edge or wave.
    placed = edges_of(placement.zones)
    return max([placement.density.interface.compliance.last, *placed]) / (_LEFT_OUT * rtol)


def _search(interface: LoadedBodies, rtol: float) -> _Trial:
    """Find zones that obey the law of contact on a loose rule, from one grid after the other."""
    # The canonical matrix is made once for a rule; zones come and go on it.
    canonical = glued(interface.compliance, _CANONICAL * _LOCATING)
    rule = rule_for(_LOCATING)
    steps = sets = 0
    for zones in _guesses(interface):
        for _ in range(8):  # sets of zones tried from one grid
            # The answers of 98 random pairs had three at most; placing 16 takes minutes.
            if len(zones) > 8:
                break
            check_well_posed(interface, zones)
            if interface.resistance and any(zone.open for zone in zones):
                raise SceneError(
                    "scene: the contact opens under a viscous film, which this solver does not "
                    "treat between different bodies; leave the viscosity out, or make the base "
                    "pressure larger (docs/dissimilar.md)."
                )
            placement = place(interface, canonical, zones, rule, _LOCATED)
            steps, sets = steps + placement.steps, sets + 1
            # Edges that cannot be placed suggest other zones.
            if not placement.converged:
                if (other := rearranged(placement)) is None:
                    break
                zones = other
                continue
            # A hundred times the rule's tolerance.
            broken = violations(PairProfile(placement.density), 1e-3, _slowest(placement, rtol))
            if not broken:
                return _Trial(placement, True, steps, sets)
            zones = corrected(placement.zones, broken)
    for sense in (1, -1):  # where slip of either sense has no answer, pivoting may find none
        check_well_posed(interface, (MovingZone(0.0, None, sense),))
    placement = place(interface, canonical, (), rule, _LOCATED)
    return _Trial(placement, False, steps, sets)


def _refined(trial: _Trial, rtol: float) -> tuple[_Trial, float]:
    """Refine edges and densities until the error estimate is below rtol; return both."""
    if not trial.lawful:
        return trial, np.inf
    # The estimate was 10 to 20 tolerances in 30 of 45 random pairs, and less in two of them.
    placement, steps, tolerance = trial.placement, trial.steps, 0.03 * rtol
    for _ in range(4):  # rules tried until the estimate is below rtol
        canonical = glued(placement.density.interface.compliance, _CANONICAL * tolerance)
        placement = polished(placement, canonical, rule_for(tolerance), tolerance)
        steps += placement.steps
        estimate = numerical_error(placement, tolerance)
        if not placement.converged or estimate <= rtol:
            break
        # The error falls about in proportion to the tolerance; half of rtol leaves room for its
        # scatter.
        tolerance *= max(min(0.5 * rtol / estimate, 0.3), 0.01)
    return replace(trial, placement=placement, steps=steps), estimate


def _guesses(interface: LoadedBodies) -> Iterator[Sequence[MovingZone]]:
    """Yield zones seen on one grid after the other (`GRIDS`)."""
    tried: list[Sequence[MovingZone]] = []
    for size, share in GRIDS:
        weaker = replace(interface, friction=share * interface.friction)
        try:
            zones = zones_seen(seen_on_grid(weaker, size))
        except ComputationError:
            continue
        if zones not in tried:
            tried.append(zones)
            yield zones


def check_well_posed(interface: LoadedBodies, zones: Sequence[MovingZone]) -> None:
    """Raise SceneError if the interface slips in a sense in which waves that run ahead grow."""
    for sense in {zone.sense for zone in zones}:
        friction = sense * interface.friction
        if interface.slip_phase(sense).is_regular(friction):
            continue
        ahead = [w for w in growing_waves(interface.compliance, friction) if w.velocity > 0]
        if not ahead:
            raise SceneError(
                f"scene: under friction {interface.friction:.4g} these bodies have no answer or "
                "several; lower it (docs/dissimilar.md)."
            )
        wave, compliance = ahead[0], interface.compliance
        limit, other = growth_threshold(compliance, sense), growth_threshold(compliance, -sense)
        ways = [f"lower it below {limit:.3g}"] if limit > LEAST_FRICTION else []
        if other > LEAST_FRICTION:  # slip of the other sense
            below = f" and lower it below {other:.3g}" if other < interface.friction else ""
            ways.append(f"exchange the bodies or reverse the load{below}")
        delayed = fastest_delayed_growth(interface.compliance, friction)
        share = delayed.rate if delayed else 0.0
        raise SceneError(
            f"scene: where the upper body slips towards {'+' if sense > 0 else '-'}x under "
            f"friction {interface.friction:.4g}, waves that run ahead grow by "
            f"{100 * np.expm1(wave.per_wavelength):.3g} % over every wavelength, however short, "
            f"and no answer exists: {''.join(f'{way}, or ' for way in ways)}let friction "
            f"follow pressure with a delay of some {share:.2g} of the time of interest "
            "(docs/dissimilar.md)."
        )


def _status(lawful: bool, estimate: float, statistics: Statistics, rtol: float) -> str:
    """Return "converged", or a sentence on what is unreliable."""
    if not lawful:
        return "no set of zones was found that obeys the law of contact everywhere"
    # 0.26 to 0.37 is usual, 0.05 with an edge next to a wave front.
    if statistics.smallest_singular_value < 1e-4:
        return (
            "the equations of the zones are nearly singular (smallest singular value "
            f"{statistics.smallest_singular_value:.1e})"
        )
    if estimate > rtol:
        return f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
    return "converged"
