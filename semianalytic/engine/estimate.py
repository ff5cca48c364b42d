"""Estimates of the error of a run, and whether its grid resolves what is to be followed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.beside_edges import EdgeNodes, film_share
from semianalytic.engine.convergence import MEMORY_SAFETY, NARROW, Tried, order_seen, safety
from semianalytic.engine.marched import Marched
from semianalytic.engine.resolution import missed_zone, rounded_up
from semianalytic.engine.stepping.line import fitting_nodes, grid_of
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import LEAST_GAP, LEAST_ZONE, ZONE_NODES
from semianalytic.engine.stepping.window import doubt_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.scene import Scene

LEAST_RATE_ERROR, LEAST_TRACTION_ERROR = 0.3, 0.1
"""Least error of slip rate, over that of slip, and of traction that follows slip rate, over that of
slip rate: at few stored times two grids may agree by chance, as 2 of 200 did."""


def estimated(
    done: Marched, half: Callable[[Scene], Marched], rtol: float | None, coarser: Tried | None
) -> tuple[Marched, Tried | None]:
    """Return a run with estimates of its error, and how far runs of half the nodes are from it.

    There is one, and another whose contacts are shorter where the grid displaces their ends;
    `half` runs an interface on half its nodes, at its frames.  The second result is None if they
    were interrupted.  A run of fewer nodes, `coarser`, shows the order of convergence.
    """
    scene, known, spacing = done.scene, done.interface, done.scene.period / done.nodes
    coarse = half(scene)
    shorter, ends = coarse, done.contact_misfit
    barriers = scene.law.barrier_misfit(known.x[known.touching], spacing)
    misplaced = max(ends, barriers) / 2
    if misplaced and not coarse.is_interrupted:
        cut = replace(scene, contact=scene.contact.shortened(scene.period, done.nodes, done.shift))
        if barriers:
            cut = replace(cut, friction=scene.law.with_wider_barriers(2 * spacing))
        shorter = half(cut)
    if coarse.is_interrupted or shorter.is_interrupted:
        status = "interrupted in the estimate of its error: complete, without one"
        return replace(done, status=status), None
    between = not scene.contact.is_whole
    touching = coarse.interface.touching
    if between:
        # a coarse node at the end of a contact may stand for a node of the slot as well
        touching = touching & shorter.interface.touching
        touching &= known.touching[::2] & known.touching[1::2]

    def thinned(values: Array) -> Array:
        pairs = (values[:, ::2] + values[:, 1::2]) / 2 if between else values[:, ::2]
        return np.asarray(pairs[:, touching])

    base = thinned(sampled("scene: shear", scene.base.shear, known.x, spacing)[None])
    beside = EdgeNodes(done)
    rates = np.concatenate([thinned(known.slip_rate), coarse.interface.slip_rate[:, touching]])
    zones = _zones(np.abs(thinned(known.slip)).sum(axis=0), rates.any(axis=0))
    shares, sizes = dict[str, float](), dict[str, float]()
    names = ["slip", "slip_rate", "shear_traction"]
    if done.scene.may_open:
        names += ["gap", "pressure"]
    for name in names:
        fine, other = (
            thinned(getattr(known, name)),
            getattr(coarse.interface, name)[:, touching],
        )
        moved = getattr(shorter.interface, name)[:, touching] - other
        # Against the base, whichever frames are stored: a sudden load has come at the first.
        scale = np.abs(fine - base if name == "shear_traction" else fine).sum(axis=0)
        apart = (np.abs(fine - other) + misplaced * np.abs(moved)).sum(axis=0)
        # where the finer grid has nothing and the coarser one something, the error is all of it
        sizes[name] = max(float(scale.sum()), float(apart.sum()))
        shares[name] = float(apart.sum()) / sizes[name] if sizes[name] else 0.0
        if name in ("slip", "slip_rate"):
            # One of two edges may be far off though most slip is next to the other one.
            sums = ((float(apart[nodes].sum()), float(scale[nodes].sum())) for nodes in zones)
            shares[name] = max(
                shares[name], 0.0, *(off / max(size, off) for off, size in sums if off)
            )
    tried = Tried(done.nodes, shares[deciding(done, shares)])
    order = None if coarser is None else order_seen(coarser, tried)
    # ends that lie elsewhere are known less well than zones on few nodes
    narrow = misplaced > 0.025 or any(len(nodes) < NARROW for nodes in zones)
    of_slip = "narrow" if narrow else "wide"
    # `thinned` has every other node, or the mean of two.
    errors = {
        name: safety(order, of_slip if "slip" in name else "line") * share
        + (beside.wrong.get(name, 0.0) / 2 / sizes[name] if sizes[name] else 0)
        for name, share in shares.items()
    }
    errors["slip_rate"] = max(errors["slip_rate"], LEAST_RATE_ERROR * errors["slip"])
    if not scene.law.has_threshold:
        least = LEAST_TRACTION_ERROR * errors["slip_rate"]
        errors["shear_traction"] = max(errors["shear_traction"], least)
    (zone, slid), (parted, relieved) = beside.missed_slip, beside.missed_opening
    # `thinned` has every other node
    missed, parted = slid / (2 * spacing), parted / (2 * spacing)
    slip = float(np.abs(thinned(known.slip)).sum())
    unseen = [("gap", parted / (sizes["gap"] + parted))] if parted else []
    for share in (missed / (slip + missed) if missed else 0.0, relieved):
        unseen += [("slip", share), ("slip_rate", share)]
    for name, share in unseen:
        errors[name] += share * (1 - min(errors[name], 1.0))
    largest = 0.5 if rtol is None else rtol
    status, name = done.status, deciding(done, errors)
    if status == "done" and missed > largest * (slip + missed):
        # Slip at a slot that is pushed is 7, 1.6 and 0.4 % off with 2, 4 and 8 nodes on it.
        needed = in_fours(scene.period * 4.0 / zone)
        status = (
            f"unresolved: the contact slips next to an edge over about {zone:.2g}, which nodes "
            f"{spacing:.2g} apart do not resolve; use {needed} nodes or more."
        )
    if status == "done" and errors[name] > largest:
        what = "slip" if name == "slip" else "the gap"
        status = f"unresolved: {what} may be off by {errors[name]:.1g} of itself; raise `nodes`."
    return replace(done, error_estimates=errors, status=status, companion=coarse), tried


def _zones(slip: Array, moves: Any) -> list[NDArray[np.intp]]:
    """Return the nodes of each row of nodes that move, but of those with little slip (k,)."""
    nodes = np.flatnonzero(moves)
    rows = np.split(nodes, np.flatnonzero(np.diff(nodes) > 1) + 1)
    sums = [float(slip[row].sum()) for row in rows]
    return [row for row, own in zip(rows, sums, strict=True) if own > LEAST_ZONE * max(sums)]


def deciding(done: Marched, errors: Mapping[str, float]) -> str:
    """Return which error counts, that of slip or that of a gap which is not much smaller."""
    known = done.interface
    slip, gap = (float(np.abs(rows[:, known.touching]).sum()) for rows in (known.slip, known.gap))
    larger = errors.get("gap", 0.0) > errors["slip"]
    return "gap" if larger and gap > LEAST_GAP * slip else "slip"


def unresolved(
    stepper: Stepper, pressure: Array, state: Array, fastest: float, needed: float
) -> str:
    """Return "done", or why the grid cannot follow the loads, or the law at the largest pressures
    and rate; `needed` are the nodes that histories of loads need."""
    nodes = stepper.grid.nodes
    if nodes < 0.999 * needed:
        remedy = "smooth it or the samples that lie close together"
        if needed < math.inf:
            remedy = f"use {in_fours(needed)} nodes or more, or smooth it"
        return f"unresolved: the history of a load turns faster than {nodes} nodes follow; {remedy}"
    if stepper.pair is not None:
        doubt = doubt_of(stepper.pair, stepper.law, pressure, state, fastest, stepper.grid.spacing)
        if doubt:
            return f"unresolved: {doubt}"
    needed = nodes_for_contact(stepper.scene)
    if nodes < 0.999 * needed:
        narrow = stepper.scene.contact.narrowest(stepper.scene.period)
        return (
            f"unresolved: a contact or slot of width {narrow:.3g} has "
            f"{narrow / stepper.grid.spacing:.2g} nodes; use {in_fours(needed)} nodes or more."
        )
    weakening = stepper.law.weakening(pressure)
    if stepper.unilateral is not None and stepper.unilateral.adhesion is not None:
        bonds = stepper.unilateral.adhesion
        weakening = max(weakening, float(np.max(bonds.strength / bonds.length)))
    if not weakening > 0:
        return "done"
    bodies = (stepper.scene.material, stepper.scene.lower_material)
    zone = min(body.shear_modulus for body in bodies if body is not None) / weakening
    found = zone / stepper.grid.spacing
    if found >= ZONE_NODES:
        return "done"
    least = in_fours(stepper.scene.period * ZONE_NODES / zone)
    return (
        f"unresolved: the strength falls over {found:.2g} node distances of "
        f"{stepper.grid.spacing:.3g}; use {least} nodes or more."
    )


def too_short(scene: Scene, time: float) -> str:
    """Return that a period is too short at a time, or nothing.

    The contact of a half-line ends where its period does, and waves from there run back.
    """
    end, speed = scene.period / 2, scene.fastest_speed
    if not scene.contact.ends_with_period or speed * time <= end:
        return ""
    return (
        f"unresolved: the contact ends with the period, at |x| = {end:.3g}, from where waves reach "
        f"x = 0 at t = {end / speed:.3g}; use a `period` of {4 * speed * time:.3g} or more, or end "
        "before that."
    )


def judged(marched: Marched) -> Marched:
    """Return a march next to a slot with the estimate of its error, and whether it is resolved."""
    errors = {} if marched.companion is None else {"slip_rate": _slot_error(marched)}
    marched = replace(marched, error_estimates=errors)
    found, caution = marched.shortfalls, ""
    if found:
        reasons = "; ".join(shortfall.reason for shortfall in found)
        times = rounded_up(max(shortfall.times for shortfall in found))
        caution = f"{reasons}; raise `nodes` {times} times, or shorten `length` as much"
    return replace(marched, caution=caution, status="unresolved" if caution else "resolved")


def _slot_error(marched: Any) -> float:
    """Return 1.25 times the difference of march and companion, over the slip rate.

    It is less if a higher than the first order was seen.
    """
    known = marched.checkpoint
    apart = known.departure
    # Without slip the ratio is 0 / 0.  That is no error where the edge sticks in the continuum as
    # well, and a total one where K_II exceeds f K_I and the grid misses the zone.
    if apart.slip_rate == 0:
        return math.inf if apart.difference or missed_zone(marched) is not None else 0.0
    # Both marches share the error of the memory's transform, which their difference does not show.
    factor, companion = safety(known.order, "slot"), marched.companion
    of_grids = factor * apart.share + MEMORY_SAFETY * known.layout.kernel.error
    # Errors are relative to the true slip rate, which is less than that of the march by about as
    # much, with the same factor, as the companion slips more.
    marches = (marched, companion or marched)
    own, coarser = (float(march.totals.accumulated_slip[-1]) for march in marches)
    over = factor * max(coarser / own - 1.0, 0.0) if own else 0.0
    return (of_grids + film_share(marched) + marched._hidden) * (1.0 + over)


def line_caution(scene: Scene, nodes: int, end_time: float) -> str:
    """Return what limits the accuracy along a line and can be changed; empty if there is nothing.

    A grid knows ends of contacts midway between its nodes.  It is moved to have them there
    (`Marched.shift`), and displaces those that lie elsewhere still: the error of slip is then that
    of a contact which is longer or shorter.
    """
    contact, length = scene.contact, scene.period
    run_through = scene.fastest_speed * end_time
    if contact.ends_with_period and run_through > length / 4:
        free = max(length / 2 - run_through, 0.0)
        return (
            f"the contact ends with the period, and waves from there have arrived beyond |x| = "
            f"{free:.3g}; raise `period` to {4 * run_through:.3g}"
        )
    misfit = contact.misfit(length, nodes, grid_of(scene, nodes).shift)
    # Slip of a punch of 102 nodes is off by 0.1 % with ends in their places, by 2, 4 and 12 % with
    # 0.1, 0.2 and 0.5 of a node distance.
    if misfit < 0.05:
        return ""
    fitting = fitting_nodes(scene, nodes, 1)
    remedy = f"choose {fitting} nodes"
    if contact.misfit(length, fitting, grid_of(scene, fitting).shift) > misfit / 2:
        remedy = "choose a period of which the ends are simple fractions"
    return (
        f"an end of a contact lies {misfit:.2g} node distances from where the grid has it; {remedy}"
    )
