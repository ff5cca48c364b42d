"""Estimates of the error of a run, and whether its grid resolves what is to be followed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.grid_edge import zone_beside_edge
from semianalytic.engine.convergence import Tried, order_seen, safety
from semianalytic.engine.result import Run
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import BESIDE_EDGE_ERROR, LEAST_GAP, ZONE_NODES
from semianalytic.engine.stepping.window import doubt_of
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.line.fields import at_nodes
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


def estimated(
    done: Run, half: Callable[[Scene], Run], rtol: float | None, coarser: Tried | None
) -> tuple[Run, Tried | None]:
    """Return a run with estimates of its error, and how far runs of half the nodes are from it.

    There is one, and another whose contacts are shorter where the grid displaces their ends.  The
    second result is None if they were interrupted.

    Parameters
    ----------
    done : Run
        The run.
    half : function
        Runs an interface on half its nodes, at its frames.
    rtol : float, optional
        Wanted error.
    coarser : Tried, optional
        A run of fewer nodes, from which the order of convergence is seen.
    """
    scene = done.scene
    coarse = half(scene)
    shorter, misplaced = coarse, done.contact_misfit / 2
    if misplaced and not coarse.is_interrupted:
        contact = scene.contact.shortened(scene.period, done.nodes, done.shift)
        cut = replace(scene, contact=contact)
        shorter = half(cut)
    if coarse.is_interrupted or shorter.is_interrupted:
        status = "interrupted in the estimate of its error: complete, without one"
        return replace(done, status=status), None
    between = not scene.contact.is_whole
    touching, known = coarse.interface.touching, done.interface
    if between:
        # a coarse node at the end of a contact may stand for a node of the slot as well
        touching = touching & shorter.interface.touching
        touching &= known.touching[::2] & known.touching[1::2]

    def thinned(values: Array) -> Array:
        pairs = (values[:, ::2] + values[:, 1::2]) / 2 if between else values[:, ::2]
        return np.asarray(pairs[:, touching])

    spacing = scene.period / done.nodes
    base = thinned(sampled("run: shear", scene.base.shear, done.interface.x, spacing)[None])
    beside = wrong_beside_slots(done)
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
        scale = fine - base if name == "shear_traction" else fine
        apart = float((np.abs(fine - other) + misplaced * np.abs(moved)).sum())
        # where the finer grid has nothing and the coarser one something, the error is all of it
        sizes[name] = max(float(np.abs(scale).sum()), apart)
        shares[name] = apart / sizes[name] if sizes[name] else 0.0
    tried = Tried(done.nodes, shares[deciding(done, shares)])
    factor = safety(None if coarser is None else order_seen(coarser, tried))
    errors = {}
    for name, share in shares.items():
        # `thinned` has every other node, or the mean of two.
        off = beside.get(name, 0.0) / 2
        errors[name] = factor * share + (off / sizes[name] if off else 0.0)
    largest = 0.5 if rtol is None else rtol
    slip, (zone, missed) = float(np.abs(thinned(done.interface.slip)).sum()), missed_slip(done)
    # `thinned` has every other node, or the mean of two.
    missed = missed / (2 * spacing)
    # A contact that sticks up to 2e-7 node distances beside an edge asked for 1e10 nodes.
    if zone < 1e-5 * spacing:
        missed = 0.0
    if missed > 0:
        share = missed / (slip + missed)
        for name in ("slip", "slip_rate"):
            errors[name] += share * (1 - errors[name])
    status, name = done.status, deciding(done, errors)
    if status == "done" and missed > largest * (slip + missed):
        # Slip at a slot that is pushed is 7, 1.6 and 0.4 % off with 2, 4 and 8 nodes on it.
        needed = in_fours(scene.period * 4.0 / zone)
        status = (
            f"unresolved: the contact slips beside an edge over about {zone:.2g}, which nodes "
            f"{spacing:.2g} apart do not resolve; use {needed} nodes or more."
        )
    if status == "done" and errors[name] > largest:
        what = "slip" if name == "slip" else "the gap"
        status = f"unresolved: {what} may be off by {errors[name]:.1g} of itself; raise `nodes`."
    return replace(done, error_estimates=errors, status=status, companion=coarse), tried


def deciding(done: Run, errors: Mapping[str, float]) -> str:
    """Return which error counts, that of slip or that of a gap which is not much smaller."""
    known = done.interface
    slip, gap = (float(np.abs(one[:, known.touching]).sum()) for one in (known.slip, known.gap))
    larger = errors.get("gap", 0.0) > errors["slip"]
    return "gap" if larger and gap > LEAST_GAP * slip else "slip"


def unresolved(
    stepper: Stepper, pressure: Array, state: Array, fastest: float, needed: float
) -> str:
    """Return "done", or why the grid cannot follow the loads, or the law at the largest pressures
    and rate; `needed` are the nodes that histories of loads need."""
    nodes = stepper.grid.nodes
    if nodes < 0.999 * needed:
        remedy = "smooth it or the samples that lie beside each other"
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


def _beside_slots(done: Run) -> NDArray[np.bool_]:
    """Return which nodes of the contact have a node of a slot beside them, (n,)."""
    left, right = np.roll(done.interface.touching, 1), np.roll(done.interface.touching, -1)
    if done.scene.even:
        left[0] = right[-1] = True  # mirror images of themselves
    return np.asarray(done.interface.touching & ~(left & right))


def wrong_beside_slots(done: Run) -> dict[str, float]:
    """Return errors of traction and pressure beside slots, summed over edges and frames [stress].

    Where they are singular, nodes are off there by the same part on any grid, of which the
    difference of two grids shows little (`BESIDE_EDGE_ERROR`).
    """
    scene, first = done.scene, _beside_slots(done)
    x, spacing = done.interface.x, scene.period / done.nodes
    base, pressed = (
        at_nodes(name, getattr(scene.base, name), x, done.interface.touching, spacing)[first]
        for name in ("shear", "pressure")
    )
    shear, pressure = done.interface.shear_traction[:, first], done.interface.pressure[:, first]
    off = BESIDE_EDGE_ERROR * np.abs(pressure - pressed)
    # Where it slips, traction follows pressure.
    ratio = np.divide(np.abs(shear), pressure, out=np.zeros_like(shear), where=pressure > 0)
    slips = done.interface.slip_rate[:, first] != 0
    stuck = BESIDE_EDGE_ERROR * np.abs(shear - base)
    return {
        "pressure": float(off.sum()),
        "shear_traction": float(np.where(slips, ratio * off, stuck).sum()),
    }


def missed_slip(done: Run) -> tuple[float, float]:
    """Return the longest slip beside stuck edges of a contact, and the area of all, over frames.

    The first node beside an edge may stick on any grid that is too coarse, and slip that is zero on
    two grids does not differ.
    """
    scene, touching = done.scene, done.interface.touching
    if not scene.law.has_threshold or touching.all():
        return 0.0, 0.0
    first = np.flatnonzero(_beside_slots(done))
    spacing, x = scene.period / done.nodes, done.interface.x
    base = sampled("run: shear", scene.base.shear, x, spacing)[first]
    law = scene.law.on(x[touching], spacing)
    bodies = (scene.material, scene.lower_material or scene.material)
    plane = [1.0 if scene.mode == "antiplane" else 1 - body.poisson_ratio for body in bodies]
    moduli = [body.shear_modulus for body in bodies]
    compliance = sum(share / modulus for share, modulus in zip(plane, moduli, strict=True)) / 2
    place = np.searchsorted(np.flatnonzero(touching), first)
    still = np.zeros(int(touching.sum()))
    zones = areas = 0.0
    for frame in range(len(done.interface.t)):
        felt, state = (
            done.interface.felt_pressure[frame, touching],
            done.interface.state[frame, touching],
        )
        strength = law.strength(felt, still, state)[place]
        change = done.interface.shear_traction[frame, first] - base
        room = strength - np.sign(change) * base
        sticks = (
            (done.interface.slip[frame, first] == 0)
            & (room > 0)
            & (done.interface.gap[frame, first] <= 0)
        )
        zone, area = zone_beside_edge(np.abs(change[sticks]), room[sticks], spacing, compliance)
        zones, areas = max(zones, float(zone.max(initial=0.0))), areas + float(area.sum())
    return zones, areas
