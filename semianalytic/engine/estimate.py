"""Estimates of the error of a run, and whether its grid resolves what is to be followed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.checks import missed_slip, wrong_beside_slots
from semianalytic.engine.convergence import Tried, order_seen, safety
from semianalytic.engine.result import Run
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import LEAST_GAP, ZONE_NODES
from semianalytic.engine.stepping.window import doubt_of
from semianalytic.interface.fields import sampled
from semianalytic.interface.interface import Interface

Array = NDArray[np.float64]


def estimated(
    done: Run, half: Callable[[Interface], Run], rtol: float | None, coarser: Tried | None
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
    interface = done.interface
    coarse = half(interface)
    shorter, misplaced = coarse, done.contact_misfit / 2
    if misplaced and not coarse.is_interrupted:
        contact = interface.contact.shortened(interface.length, done.nodes, done.shift)
        cut = replace(interface, contact=contact)
        shorter = half(cut)
    if coarse.is_interrupted or shorter.is_interrupted:
        status = "interrupted in the estimate of its error: complete, without one"
        return replace(done, status=status), None
    between = not interface.contact.is_whole
    touching = coarse.touching
    if between:
        # a coarse node at the end of a contact may stand for a node of the slot as well
        touching = shorter.touching & touching & done.touching[::2] & done.touching[1::2]

    def thinned(values: Array) -> Array:
        pairs = (values[:, ::2] + values[:, 1::2]) / 2 if between else values[:, ::2]
        return np.asarray(pairs[:, touching])

    spacing = interface.length / done.nodes
    base = thinned(sampled("run: shear", interface.shear, done.x, spacing)[None])
    beside = wrong_beside_slots(done)
    shares, sizes = dict[str, float](), dict[str, float]()
    names = ["slip", "slip_rate", "shear_traction"]
    if done.interface.may_open:
        names += ["gap", "pressure"]
    for name in names:
        fine, other = thinned(getattr(done, name)), getattr(coarse, name)[:, touching]
        moved = getattr(shorter, name)[:, touching] - other
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
    slip, (zone, missed) = float(np.abs(thinned(done.slip)).sum()), missed_slip(done)
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
        needed = in_fours(interface.length * 4.0 / zone)
        status = (
            f"unresolved: the contact slips beside an edge over about {zone:.2g}, which nodes "
            f"{spacing:.2g} apart do not resolve; use {needed} nodes or more."
        )
    if status == "done" and errors[name] > largest:
        what = "slip" if name == "slip" else "the gap"
        status = f"unresolved: {what} may be off by {errors[name]:.1g} of itself; raise `nodes`."
    return replace(done, error_estimates=errors, status=status), tried


def deciding(done: Run, errors: Mapping[str, float]) -> str:
    """Return which error counts, that of slip or that of a gap which is not much smaller."""
    slip, gap = (float(np.abs(one[:, done.touching]).sum()) for one in (done.slip, done.gap))
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
    needed = nodes_for_contact(stepper.interface)
    if nodes < 0.999 * needed:
        narrow = stepper.interface.contact.narrowest(stepper.interface.length)
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
    bodies = (stepper.interface.material, stepper.interface.lower_material)
    zone = min(body.shear_modulus for body in bodies if body is not None) / weakening
    found = zone / stepper.grid.spacing
    if found >= ZONE_NODES:
        return "done"
    least = in_fours(stepper.interface.length * ZONE_NODES / zone)
    return (
        f"unresolved: the strength falls over {found:.2g} node distances of "
        f"{stepper.grid.spacing:.3g}; use {least} nodes or more."
    )
