"""Rows of numbers and of fields with their error bars, judged: agree, differ or unresolved."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from compare.comparison.bars import LEAST_ORDER, SAFETY, ErrorBar, error_bar, slowest_bar
from compare.comparison.case import UNSEEN, Case
from compare.comparison.measures import NOTHING, within
from compare.comparison.rows import AGREES, AWAY, BASIC, BEYOND, DIFFERS, TELLING, UNRESOLVED, Row
from semianalytic.results.answer import Answer
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated
from semianalytic.scene.arrays import Array, Mask

LEAST_ERROR = 2e-4
"""Relative error of a field below which no mesh difference is believed.  Where all meshes slide at
the same frictional traction, they differ only at a node next to a front.  Among the rows measured,
those of pressure and slip that are this close to the prediction are up to 5 times as far from it as
meshes change; with half this value none was beyond 1.5 bars."""

SMEARED = 1.75
"""How many times as far off as on the mesh at 2h a field may be whose fronts meshes smear and which
decides nothing.  Right motion of the slot face was up to 1.54 times as far off on a mesh of 40
elements; under loads wrong by 1.6 to 4 bars it was from 1.99 times on."""

USUAL = 0.9
"""Part of the slipping nodes and times whose mesh differences are at most the usual one."""

BY_LITTLE = BEYOND + "by less than {:g} times"
DIVERGES = (
    f"the meshes do not converge: it changes from 2h to h by more than {2**-LEAST_ORDER:.2g} of "
    "what it does from 4h to 2h"
)
NO_BAR = "no coarser mesh shows it, so that it has no error bar"
FEW = f"no coarser mesh has {UNSEEN} nodes of it in a row, so that it has no error bar"
UNSHOWN = f"{BEYOND}no coarser mesh has {UNSEEN} nodes of it in a row"
WIDE = f"its error bar is more than {TELLING:g} of what is compared"
"""Obstacles of rows that meshes do not decide although they do not move apart."""

BY_CHANCE = 4.0
"""Bars up to which a row of what no coarser mesh shows does not differ: of 60 pairs, moving loads
and histories with zones of so few nodes four were up to 2.4 bars off."""

Reading = Callable[[InterfaceHistory], float | None]
"""Function that reads a number off a history; None where the history does not have it."""
Expected = Callable[[Answer, InterfaceHistory], Array]
"""Function that returns a field of an answer along the contact at the end, (n,), given the history
of the answer at nodes."""


def value_row(
    case: Case,
    name: str,
    kind: str,
    read: Reading,
    *,
    exact: float | None = None,
    floor: float = 0.0,
    unit: str = "1",
    reach: float = math.inf,
    unseen: float = 0.0,
) -> Row | None:
    """Return the row of one number; None where neither answer has it, or both have 0.

    `read` reads the number off a history, in `unit`, and `exact` is that of the prediction apart
    from nodes.  `floor` is the uncertainty due to nodes and steps alone at the element size of the
    simulation.  A reading of a coarser mesh that is farther off than `reach` belongs to another
    feature.  `unseen` is the change that parts of the prediction too narrow for the mesh may cause.
    """
    at_nodes, simulated = read(case.at_nodes), read(case.seen)
    if at_nodes == simulated and not simulated and not exact:
        return None
    values = [simulated, *(read(run.interface) for run in case.coarser)]
    nowhere = simulated is None and len(values) > 1 and values[1] is None
    changes = mesh_changes(values, reach)
    error = error_bar(changes, floor) if changes else None
    if nowhere:
        error = ErrorBar(floor, None, math.inf, converges=True)  # the two finest meshes lack it
    doubt = 0.0
    if case.doubted is not None and at_nodes is not None:
        doubted = read(case.doubted)
        doubt = math.inf if doubted is None else abs(at_nodes - doubted)

    def before() -> float:
        expected, value = read(case.expected[1]), values[1]
        return math.inf if expected is None or value is None else abs(value - expected)

    difference = None if at_nodes is None or simulated is None else simulated - at_nodes
    row = Row(name, kind, exact, at_nodes, simulated, difference, None, unit)
    if at_nodes is None and simulated is None:
        reason = "neither the nodes of this mesh nor the simulation show it"
        return replace(row, obstacle=reason, resolution=2 * case.simulation.resolution)
    return judged(case, row, error, before, doubt + unseen)


@dataclass(frozen=True)
class Compared:
    """A field of both answers at the nodes of each mesh: at the end, (n,), or over time, (k, n).

    Runs are numbered: 0 is the simulation, 1 the run at 2h, ...  Each has positions of nodes
    [length], a mask of those that are compared, and times t [time] unless the field is one at the
    end.  `simulated` returns the field of one run at the nodes and times of another one, given both
    numbers; `predicted` the prediction at those of run 0 or 1, as far as it reaches; `doubted` is
    the prediction's companion at those of run 0, if any.
    """

    x: Sequence[Array]
    shown: Sequence[Mask]
    simulated: Callable[[int, int], Array]
    predicted: Callable[[int], Array]
    doubted: Array | None = None
    t: Sequence[Array] | None = None


def field_row(
    case: Case,
    name: str,
    kind: str,
    field: Compared,
    scale: tuple[float, str, str],
    *,
    exact: float | None = None,
    unseen: float = 0.0,
    driven: Callable[[int], Array] | None = None,
    meshes: int = 2,
    showing: int = 2,
    jumps: bool = False,
) -> Row:
    """Return the row of the norms of a field, its relative error and its bar.

    A row that is off by more on this mesh than on that of 2h, and by more than what is uncertain
    on any mesh, is unresolved: the simulation does not converge to the prediction, whatever its
    meshes show of each other.  Where the prediction is nothing everywhere, the largest values
    replace norms, and differences are in units of the field.

    `scale` is the divisor of the values, its name, and the unit of norms; `exact` the norm of the
    prediction itself, `unseen` that of its parts too narrow for the mesh.  Meshes are compared at
    the nodes of the coarser one, between which interpolation has an error of its own; at those of
    the finer one where these show no convergence, or where a field `jumps` at fronts, which lie
    between nodes.  `driven` returns the change of the field, over its divisor, that the change of
    strength from mesh to mesh causes at the nodes and times of the coarser one, 0 from 2h to h and
    1 from 4h to 2h; it is added to the change of the field.  So many changes from mesh to mesh as
    there are other `meshes` are used, from the finest on, and where they do not converge only those
    of meshes that are `showing` how large the field is; without any the row has no bar.
    """
    value, unit, unit_of_norm = scale
    places = [x[shown] for x, shown in zip(field.x, field.shown, strict=True)]

    @cache
    def at(number: int, of: int) -> Array:
        """Return the field of a run at the places and times of a run."""
        moved = partial(np.interp, places[of], field.x[number])
        return np.apply_along_axis(moved, -1, field.simulated(number, of)) / value

    def shown(values: Array, of: int) -> Array:
        return values[..., field.shown[of][: values.shape[-1]]] / value

    predicted = shown(field.predicted(0), 0)
    nothing = float(np.abs(predicted).max(initial=0.0)) <= case.nothing(kind)

    def size(values: Array, of: int) -> float:
        if nothing:
            return float(np.abs(values).max(initial=0.0))
        t = None if field.t is None else field.t[of]
        return case.size(values, places[of][: values.shape[-1]], t)

    whole = size(predicted, 0)
    per = 1.0 if nothing else whole
    finest = range(len(case.runs))[:2]
    largest = [float(np.abs(at(number, number)).max(initial=0.0)) for number in finest]
    if largest[0] > case.nothing(kind) >= largest[-1]:
        meshes = 0  # a mesh on which nothing moves gives no speed
    numbers = range(min(len(case.runs) - 1, meshes))
    more = [0.0 for _ in numbers]
    if driven is not None and not nothing:  # largest values at fronts do not converge
        more = [size(driven(n)[..., field.shown[n + 1]], n + 1) / per for n in numbers]
    floor, most = case.nothing(kind) if nothing else least_error(case), case.largest_order(kind)
    for to in (0,) if jumps else (1, 0):
        own = [size(at(n, n + to) - at(n + 1, n + to), n + to) / per for n in numbers]
        changes = [sum(both) for both in zip(own, more, strict=True)]
        error = error_bar(changes, floor, most=most, norm=not nothing) if changes else None
        if error is None or error.converges:
            break
    added = unseen / per
    if field.doubted is not None:
        added += size(shown(field.doubted, 0) - predicted, 0) / per
    measure, unit = ("largest", unit) if nothing else ("L1", unit_of_norm)
    values = exact, whole, size(at(0, 0), 0), size(at(0, 0) - predicted, 0) / per, None
    row = Row(f"{name}, {measure}", kind, *values, unit, relative=not nothing)
    if error and not error.converges and not nothing and showing < len(changes):
        if not showing:
            return replace(row, obstacle=FEW, resolution=case.finer)
        error = error_bar(changes[:showing], floor)
    # a pressure that is singular at the edge converges with order 1/2 at best; a field that
    # converges by itself must not be rejected for that
    if error and not error.converges and driven is not None and error_bar(own, floor).converges:
        error = slowest_bar(error, changes, floor)

    def before() -> float:
        there = shown(field.predicted(1), 1)
        return size(at(1, 1)[..., : there.shape[-1]] - there, 1) / per

    row = judged(case, row, error, before, added)
    if row.verdict == DIFFERS or row.obstacle in (WIDE, NO_BAR) or case.caution:
        return row
    off, was = abs(row.difference or 0.0), before()
    if off <= (1.0 if kind in BASIC else SMEARED) * was + added + floor:
        return row
    here, there = row.shown_shares(off, was)
    reason = f"{AWAY}off by {here} here and by {there} with 2h"
    return replace(row, obstacle=reason, resolution=case.finer)


def profile_row(
    case: Case,
    name: str,
    kind: str,
    expect: Expected,
    read: Callable[[int], Array],
    reach: tuple[float, float],
    *,
    scale: tuple[float, str],
    **how: Any,
) -> Row:
    """Return the row of a field along the contact at the end, between two positions.

    `expect` returns the prediction at nodes, `read` the field of a run by its number; the field is
    compared between both ends of `reach` [length], over `scale`; `how` as for `field_row`.
    """
    x = [run.interface.x for run in case.runs]
    low, high = reach[0], min(reach[1], float(case.seen.x[-1]))
    field = Compared(
        x,
        [within(places, low, high) for places in x],
        lambda number, of: read(number),
        lambda of: expect(case.prediction, case.expected[of]),
        expect(case.companion, case.doubted)
        if case.companion is not None and case.doubted is not None
        else None,
    )
    return field_row(case, name, kind, field, (*scale, f"{scale[1]} c_t T"), **how)


def least_error(case: Case) -> float:
    """Least uncertainty of a field, whatever the meshes show, over the norm of the prediction."""
    return NOTHING + LEAST_ERROR + case.error_estimate


def judged(
    case: Case,
    row: Row,
    error: ErrorBar | None,
    before: Callable[[], float] = lambda: math.inf,
    added: float = 0.0,
) -> Row:
    """Return a row with its bar and its verdict: unresolved if meshes or a march cannot decide.

    Coarser meshes that do not show the quantity give no error.  `before`, which is called only
    where meshes do not converge, returns |difference| of the next coarser mesh from the prediction
    in the unit of the row's own, infinite where unknown.  `added` is the part of the bar that does
    not come from meshes: the error of the prediction, or features too narrow for the mesh.
    """
    finer = case.finer
    if error is not None:
        bar = error.size + added
        row = replace(row, bar=bar, order=error.order, converges=error.converges)
    if case.caution and row.kind not in ("arrival", "pressure"):
        return replace(row, obstacle=case.caution, resolution=case.needed)
    if error is None or row.bar is None:
        return replace(row, obstacle=NO_BAR, resolution=finer)
    if math.isinf(row.bar):
        return replace(row, obstacle="the prediction has not converged")
    held = row
    if not error.converges:
        # Off by more than coarser meshes allow any finer one to be, and by more than the next
        # coarser mesh itself, the finest run or the prediction is at fault.
        limited = replace(row, bar=min(error.size, error.limit) + added)
        off = math.inf if row.difference is None else abs(row.difference)
        differs = limited.verdict == DIFFERS and off > before()
        held = limited if differs else replace(row, obstacle=DIVERGES, resolution=finer)
    if held.verdict == DIFFERS and row.kind not in ("arrival", "law"):
        if case.amplified:
            return replace(held, obstacle=case.amplified)
        if held.over_bar < BY_CHANCE and not case.shows_motion:
            return replace(held, obstacle=UNSHOWN, resolution=finer)
    if not error.converges:
        return held
    if row.verdict == UNRESOLVED:
        return replace(row, obstacle=BY_LITTLE.format(row.alarm), resolution=finer)
    # what is nothing at the nodes has no size to compare a bar with
    if row.verdict == AGREES and row.size > NOTHING and row.bar > TELLING * row.size:
        growth = row.bar / (TELLING * row.size)
        return replace(row, obstacle=WIDE, resolution=math.ceil(growth * finer / 2))
    return row


def mesh_changes(values: Sequence[float | None], reach: float = math.inf) -> list[float]:
    """Differences from mesh to mesh, from the finest on, as long as all meshes show the value.

    A value that is farther than `reach` from that of the finest mesh belongs to another feature.
    """
    changes: list[float] = []
    for fine, coarse in pairwise(values):
        if fine is None or coarse is None or values[0] is None:
            break
        if abs(coarse - values[0]) > reach:
            break
        changes.append(fine - coarse)
    return changes


def rate_bar(case: Case, start: float, end: float) -> float:
    """Error bar of slip rate between two positions [length / time], over all times.

    It is at least that of most slipping nodes, because all meshes may be wrong where all stick.
    """
    changes = []
    for fine, coarse in case.pairs:
        x, t = np.broadcast_arrays(fine.x, fine.t[:, None])
        change = np.abs(fine.slip_rate - interpolated(coarse, "slip_rate", x, t))
        slips = np.abs(fine.slip_rate) > NOTHING * case.rate
        usual = float(np.quantile(change[slips], USUAL)) if slips.any() else 0.0
        inside = (fine.x > start) & (fine.x < end)
        changes.append(max(usual, float(change[:, inside].max(initial=0.0))))
    # largest values at jumps do not converge: take what first order would leave of either change
    return SAFETY * max(change / 2**coarser for coarser, change in enumerate(changes))
