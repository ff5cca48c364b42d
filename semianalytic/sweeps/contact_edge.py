"""Slip rate and stress intensity of many solutions at the contact edge, evaluated together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from semianalytic.cut.load import common_load, per_set, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import RayleighFamily, rayleigh_family
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.halfplane.rules import rule_for
from semianalytic.halfplane.stuck import stress_intensity
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Tractions
from semianalytic.selfsimilar.derivatives.varied import edges_of_zones
from semianalytic.selfsimilar.solution import Solution
from semianalytic.sweeps import tuning


def at_contact_edge(solutions: Sequence[Solution]) -> tuple[Array, Array]:
    """Return slip rate and stress intensities at the contact edge of solutions of one load.

    Parameters
    ----------
    solutions : (n,) sequence
        Solutions of scenes that differ in friction and Poisson ratio alone.

    Returns
    -------
    slip_rate : (n,) array
        Relative slip rate at x -> 0+ [length / time], as `Solution.edge_slip_rate`.
    intensity : (n, 2) array
        Stress intensities at unit time [stress sqrt(length)], as `Solution.stress_intensity`.
    """
    rate, intensity = np.zeros(len(solutions)), np.zeros((len(solutions), 2))
    # Answers of `Solution` one by one cost a set of panels each; solutions on like panels share
    # them.
    like: dict[tuple, list[int]] = {}
    for i, solution in enumerate(solutions):
        if _shares(solution):
            like.setdefault(_key(solution), []).append(i)
        else:
            rate[i], intensity[i] = solution.edge_slip_rate, solution.stress_intensity(1.0)
    for places in like.values():
        some = [solutions[i] for i in places]
        family = rayleigh_family(np.array([s.scene.material.poisson_ratio for s in some]))
        for part in _batches(some, family):
            chosen = [some[j] for j in part]
            at = np.array(places)[part]
            rate[at], intensity[at] = _together(chosen, family.chosen(part))
    return rate, intensity


def _shares(solution: Solution) -> bool:
    """Return whether the fields of a solution can be evaluated along with those of others."""
    scene, load = solution.scene, solution.profile.fields.load
    coulomb = isinstance(scene.friction, float) and scene.shear_mode == "II"
    # Families of solids have tables for loads that come everywhere at once, and no opening.
    return coulomb and not (load.frictionless or load.opened or load.slowness)


def _key(solution: Solution) -> tuple:
    """Return what solutions on common panels share: kinds of zones, sides of fronts and cuts."""
    fields = solution.profile.fields
    kinds = tuple(
        (zone.sense, zone.inward, zone.held, zone.left is None, zone.right is None)
        for zone in fields.zones
    )
    places = []
    for p in edges_of_zones(solution.profile):
        below = (p.first_below(cut) for cut in fields.factors.cuts)
        places.append((p.first[2] > 0, p.first[3] > 0, *below))
    return (*kinds, *places, len(fields.factors.cuts))


def _batches(solutions: Sequence[Solution], family: RayleighFamily) -> Iterator[np.ndarray]:
    """Yield groups of solutions of one key, as many as fill the cache, with similar panels."""
    tolerance = [solution.profile.fields.rule.tolerance for solution in solutions]
    gap = [
        min((abs(p.first[3]) for p in edges_of_zones(solution.profile)), default=1.0)
        for solution in solutions
    ]
    digits = 2 - np.log(tolerance)
    # The count of nodes of `Plane._batches`: narrow gaps and fine rules need long panels.
    nodes = digits * (2 * digits - np.log(np.minimum(gap, 1.0)))
    panels = len(edges_of_zones(solutions[0].profile)) + 2
    hiding = family.hiding[: len(solutions)]
    for kind in np.unique(hiding):
        some = np.flatnonzero(hiding == kind)
        some = some[np.argsort(nodes[some], kind="stable")]
        size = np.cumsum(panels * nodes[some]) / tuning.PLANE_BATCH
        yield from np.split(some, np.flatnonzero(np.diff(size.astype(int))) + 1)


def _together(solutions: Sequence[Solution], family: RayleighFamily) -> tuple[Array, Array]:
    """Return slip rates (k,) and intensities (k, 2) of solutions that may share panels."""
    scenes = [solution.scene for solution in solutions]
    unit = scaled_load(scenes[0])[1]
    every = [solution.profile.fields for solution in solutions]
    zones = tuple(
        replace(
            same[0],
            left=_column([part.left for part in same]),
            right=_column([part.right for part in same]),
        )
        for same in zip(*(fields.zones for fields in every), strict=True)
    )
    rule = rule_for(min(fields.rule.tolerance for fields in every))
    profile = Profile(ZoneFields(family, common_load(scenes, unit), zones, rule))
    ones = Tractions(1.0, 1.0)
    unit_step = np.array([stress_intensity(s.material, ones, 1.0) for s in scenes])
    # The sum with 0.0 turns -0.0 into 0.0.
    mode_one = scenes[0].superposition.taken_off.pressure * unit_step[:, 0] + 0.0
    if not profile.edge_slips:
        sheared = unit * profile.edge_intensity * unit_step[:, 1] + 0.0
        return np.zeros(len(scenes)), np.stack([mode_one, sheared], axis=1)
    value = profile.rate_starts[-1] + profile.rate_integral.totals[-1]
    over = np.array([2 * unit / scene.material.shear_impedance for scene in scenes])
    friction = per_set(np.array([[scene.coefficient] for scene in scenes]))
    # At a slipping edge the traction is s f p, and so are the singular parts: K_II = s f K_I.
    held = profile.panels.sense[-1] * friction * mode_one + 0.0
    return over * value, np.stack([mode_one, held], axis=1)


def _column(points: Sequence[CutPoints | None]) -> CutPoints | None:
    """Return the points of several sets, (k, 1); None where they are an end of the cut."""
    parts = [point.parts for point in points if point is not None]
    return CutPoints(np.stack(parts, axis=1)) if parts else None
