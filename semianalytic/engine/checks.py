"""What a grid shows of an interface: its contact, its symmetry, and what is off beside slots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.grid_edge import zone_beside_edge
from semianalytic.engine.result import Run
from semianalytic.engine.stepping.tuning import BESIDE_EDGE_ERROR
from semianalytic.interface.fields import at_nodes, sampled
from semianalytic.interface.interface import Interface

Array = NDArray[np.float64]


def too_short(interface: Interface, time: float) -> str:
    """Return that a period is too short at a time, or nothing.

    The contact of a half-line ends where its period does, and waves from there run back.
    """
    end, speed = interface.length / 2, interface.fastest
    if not interface.contact.ends_with_period or speed * time <= end:
        return ""
    return (
        f"unresolved: the contact ends with the period, at |x| = {end:.3g}, from where waves reach "
        f"x = 0 at t = {end / speed:.3g}; use a `length` of {4 * speed * time:.3g} or more, or end "
        "before that."
    )


def _beside_slots(done: Run) -> NDArray[np.bool_]:
    """Return which nodes of the contact have a node of a slot beside them, (n,)."""
    left, right = np.roll(done.touching, 1), np.roll(done.touching, -1)
    if done.interface.even:
        left[0] = right[-1] = True  # mirror images of themselves
    return np.asarray(done.touching & ~(left & right))


def wrong_beside_slots(done: Run) -> dict[str, float]:
    """Return errors of traction and pressure beside slots, summed over edges and frames [stress].

    Where they are singular, nodes are off there by the same part on any grid, of which the
    difference of two grids shows little (`BESIDE_EDGE_ERROR`).
    """
    interface, first = done.interface, _beside_slots(done)
    x, spacing = done.x, interface.length / done.nodes
    base, pressed = (
        at_nodes(f"interface: {name}", getattr(interface, name), x, done.touching, spacing)[first]
        for name in ("shear", "pressure")
    )
    shear, pressure = done.shear_traction[:, first], done.pressure[:, first]
    off = BESIDE_EDGE_ERROR * np.abs(pressure - pressed)
    # Where it slips, traction follows pressure.
    ratio = np.divide(np.abs(shear), pressure, out=np.zeros_like(shear), where=pressure > 0)
    slips = done.slip_rate[:, first] != 0
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
    interface, touching = done.interface, done.touching
    if not interface.law.has_threshold or touching.all():
        return 0.0, 0.0
    first = np.flatnonzero(_beside_slots(done))
    spacing, x = interface.length / done.nodes, done.x
    base = sampled("run: shear", interface.shear, x, spacing)[first]
    law = interface.law.on(x[touching], spacing)
    bodies = (interface.material, interface.lower_material or interface.material)
    plane = [1.0 if interface.mode == "antiplane" else 1 - body.poisson_ratio for body in bodies]
    moduli = [body.shear_modulus for body in bodies]
    compliance = sum(share / modulus for share, modulus in zip(plane, moduli, strict=True)) / 2
    place = np.searchsorted(np.flatnonzero(touching), first)
    still = np.zeros(int(touching.sum()))
    zones = areas = 0.0
    for frame in range(len(done.t)):
        felt, state = done.felt_pressure[frame, touching], done.state[frame, touching]
        strength = law.strength(felt, still, state)[place]
        change = done.shear_traction[frame, first] - base
        room = strength - np.sign(change) * base
        sticks = (done.slip[frame, first] == 0) & (room > 0) & (done.gap[frame, first] <= 0)
        zone, area = zone_beside_edge(np.abs(change[sticks]), room[sticks], spacing, compliance)
        zones, areas = max(zones, float(zone.max(initial=0.0))), areas + float(area.sum())
    return zones, areas
