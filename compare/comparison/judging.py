"""Rows of numbers and of fields with their error bars, judged: agree, differ or unresolved."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from compare.comparison.bars import (
    LARGEST_ORDER,
    LEAST_ORDER,
    SAFETY,
    ErrorBar,
    error_bar,
    slowest_bar,
)
from compare.comparison.case import Case
from compare.comparison.measures import NOTHING, norm, within
from compare.comparison.rows import AGREES, BEYOND, DIFFERS, TELLING, UNRESOLVED, Row
from semianalytic.results.answer import Answer
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated

Array = NDArray[np.float64]

LEAST_ERROR = 2e-4
"""Relative error of a field below which no mesh difference is believed.  Where all meshes slide at
the same frictional traction, they differ only at a node beside a front.  Of the rows measured,
those of pressure and slip that are this close to the prediction are up to 5 times as far from it as
meshes change; with half this value none was beyond 1.5 bars."""

USUAL = 0.9
"""Part of the slipping nodes and times whose mesh differences are at most the usual one."""

BY_LITTLE = BEYOND + "by less than {:g} times"
NO_BAR = "no coarser mesh shows it, so that it has no error bar"
WIDE = f"its error bar is more than {TELLING:g} of what is compared"
"""Obstacles of rows that meshes do not decide although they do not move apart."""

Reading = Callable[[InterfaceHistory], float | None]
"""Function that reads a number off a history; None where the history does not have it."""
Expected = Callable[[Answer, InterfaceHistory], Array]
"""Function that returns a field of an answer along the contact at the end, (n,), given the history
of the answer at nodes."""


class Meshes(Protocol):
    """What a row has to know of a comparison: how fine its meshes are, and what spoils it.

    Attributes
    ----------
    finer : int
        Resolution, or number of nodes, of a mesh twice as fine.
    caution : str
        What simulation or prediction are too coarse for; "" if there is nothing.
    needed : int or None
        Resolution with which they would not be, where known.
    amplified : str
        Why errors grow on this mesh so that nothing differs for certain; "" if they do not.
    """

    @property
    def finer(self) -> int: ...
    @property
    def caution(self) -> str: ...
    @property
    def needed(self) -> int | None: ...
    @property
    def amplified(self) -> str: ...


@dataclass(frozen=True)
class Comparison:
    """Changes from mesh to mesh and other uncertainties, from which a row is judged.

    Attributes
    ----------
    error : ErrorBar or None
        None where coarser meshes do not show the quantity.
    before : callable
        Returns |difference| of the next coarser mesh from the prediction, in the unit of the row's
        own difference; infinite where that is unknown.  Called only where the meshes do not
        converge.
    added : float
        Part of the bar that does not come from meshes: the error of the prediction, or features
        too narrow for the mesh.
    """

    error: ErrorBar | None
    before: Callable[[], float] = lambda: math.inf
    added: float = 0.0


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

    Parameters
    ----------
    case : Case
    name, kind, unit : str
    read : callable
        Reads the number off a history, in `unit`.
    exact : float, optional
        Value of the prediction itself, apart from the nodes.
    floor : float
        Uncertainty due to nodes and steps alone at the element size of the simulation.
    reach : float
        Largest distance between readings of the same feature on two meshes; a reading of a coarser
        mesh that is farther off belongs to another feature.
    unseen : float
        Change of the value that parts of the prediction too narrow for the mesh may cause.
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

    row = Row(
        name,
        kind,
        exact,
        at_nodes,
        simulated,
        None if at_nodes is None or simulated is None else simulated - at_nodes,
        None,
        unit,
    )
    if at_nodes is None and simulated is None:
        reason = "neither the nodes of this mesh nor the simulation show it"
        return replace(row, obstacle=reason, resolution=2 * case.simulation.resolution)
    return judged(case, row, Comparison(error, before, doubt + unseen))


def profile_row(
    case: Case,
    name: str,
    kind: str,
    expect: Expected,
    read: Callable[[int], Array],
    reach: tuple[float, float],
    *,
    exact: float | None = None,
    unseen: float = 0.0,
    scale: tuple[float, str],
    smooth: bool = False,
    driven: Callable[[int], Array] | None = None,
    most: int = 2,
) -> Row:
    """Return the row of the L1 norms of a field along the contact, its relative error and its bar.

    Where the prediction is below 1e-6 of its scale everywhere, the largest values replace norms,
    and differences are in units of the scale.

    Parameters
    ----------
    case : Case
    name, kind : str
    expect : callable
        Returns the prediction at nodes.
    read : callable
        Returns the field along the contact in a run by number: 0 is the simulation, 1 the run at
        2h, ...
    reach : (float, float)
        Positions between which the field is compared [length].
    exact : float, optional
        Norm of the prediction itself, in `unit`.
    unseen : float
        Norm of the parts of the prediction that are too narrow for the mesh, over the scale.
    scale : float and str
        Divisor of the values, and its name.
    smooth : bool
        Whether the field has no fronts, so that meshes are compared at the nodes of the coarser
        one, between which linear interpolation is less accurate than at its ends.
    driven : callable, optional
        Returns the change of the field, over the scale and at the nodes of a run, that the change
        of strength from mesh to mesh causes: 0 from 2h to h, 1 from 4h to 2h.  It is added to the
        change of the field.
    most : int
        Changes from mesh to mesh that are used, from the finest on; fewer where coarser meshes show
        too little, and without any the row has no bar.
    """
    low, high = reach
    value, unit = scale
    runs = case.runs
    places = [within(run.interface.x, low, high) for run in runs]
    fields = [read(number) / value for number in range(len(runs))]
    x, shown = case.seen.x, places[0]
    expected = expect(case.prediction, case.at_nodes) / value
    nothing = float(np.abs(expected[shown]).max(initial=0.0)) <= NOTHING

    def size(field: Array, at: Array) -> float:
        if nothing:
            return float(np.abs(field).max(initial=0.0))
        return norm(field, at / case.length, 1)

    own, changes = [], []
    for pair in pairwise(range(min(len(runs), most + 1))):
        of, to = pair[::-1] if smooth else pair
        at = runs[of].interface.x[places[of]]
        other = np.interp(at, runs[to].interface.x, fields[to])
        change = np.abs(fields[of][places[of]] - other)
        own.append(size(change, at))
        if driven is not None and not nothing:  # largest values at fronts do not converge
            change += driven(of)[places[of]]
        changes.append(size(change, at))
    whole = size(expected[shown], x[shown])
    per = 1.0 if nothing else whole
    added = unseen / per
    if case.companion is not None and case.doubted is not None:
        other = expect(case.companion, case.doubted) / value
        added += size((other - expected)[shown], x[shown]) / per

    def before() -> float:
        there = expect(case.prediction, case.expected[1]) / value
        at = case.expected[1].x
        inside = within(at, low, high)
        return size((fields[1][: len(at)] - there)[inside], at[inside]) / per

    row = Row(
        f"{name}, largest" if nothing else f"{name}, L1",
        kind,
        exact,
        whole,
        size(fields[0][shown], x[shown]),
        size((fields[0] - expected)[shown], x[shown]) / per,
        None,
        unit if nothing else f"{unit} c_t T",
        relative=not nothing,
    )
    error = field_bar(case, changes, per, nothing)
    if error is not None and not error.converges and driven is not None:
        # a pressure that is singular at the edge converges with order 1/2 at best; a field that
        # converges by itself must not be rejected for that
        alone = field_bar(case, own, per, nothing)
        if alone is not None and alone.converges:
            error = slowest_bar(error, [change / per for change in changes], _floor(case, nothing))
    return judged(case, row, Comparison(error, before, added))


def field_bar(
    case: Case,
    changes: Sequence[float],
    per: float,
    nothing: bool,
    most: float = LARGEST_ORDER,
) -> ErrorBar | None:
    """Error bar of norms of a field over the norm of the prediction, or of largest values.

    Largest values replace norms where nothing is predicted.

    Parameters
    ----------
    case : Case
    changes : sequence of float
        Norms of the differences from mesh to mesh.
    per : float
        Norm of the prediction.
    nothing : bool
        Whether nothing is predicted, so that values are no norms.
    most : float
        Largest order of convergence that is believed.
    """
    if not changes:
        return None
    return error_bar([change / per for change in changes], _floor(case, nothing), most=most)


def _floor(case: Case, nothing: bool) -> float:
    """Least uncertainty of a field, whatever the meshes show, over the norm of the prediction."""
    return NOTHING + (0.0 if nothing else LEAST_ERROR + case.error_estimate)


def judged(case: Meshes, row: Row, comparison: Comparison) -> Row:
    """Return a row with its bar and its verdict: unresolved if meshes or a march cannot decide."""
    error, finer = comparison.error, case.finer
    if error is not None:
        bar = error.size + comparison.added
        row = replace(row, bar=bar, order=error.order, converges=error.converges)
    if case.caution and row.kind not in ("arrival", "pressure"):
        return replace(row, obstacle=case.caution, resolution=case.needed)
    if error is None or row.bar is None:
        return replace(row, obstacle=NO_BAR, resolution=finer)
    if math.isinf(row.bar):
        return replace(row, obstacle="the prediction has not converged")
    held = row if error.converges else _diverging(row, error, comparison, finer)
    if held.verdict == DIFFERS and case.amplified and row.kind not in ("arrival", "law"):
        return replace(held, obstacle=case.amplified)
    if not error.converges:
        return held
    if row.verdict == UNRESOLVED:
        return replace(row, obstacle=BY_LITTLE.format(row.alarm), resolution=finer)
    # what is nothing at the nodes has no size that a bar could be held against
    if row.verdict == AGREES and row.size > NOTHING and row.bar > TELLING * row.size:
        growth = row.bar / (TELLING * row.size)
        return replace(
            row,
            obstacle=WIDE,
            resolution=math.ceil(growth * finer / 2),
        )
    return row


def _diverging(row: Row, error: ErrorBar, comparison: Comparison, finer: int) -> Row:
    """Judge a row whose meshes do not converge, which never agrees."""
    limited = beyond_limit(row, error, comparison)
    if limited is not None:
        return limited
    reason = (
        f"the meshes do not converge: it changes from 2h to h by more than {2**-LEAST_ORDER:.2g} "
        "of what it does from 4h to 2h"
    )
    return replace(row, obstacle=reason, resolution=finer)


def beyond_limit(row: Row, error: ErrorBar, comparison: Comparison) -> Row | None:
    """Return a row whose meshes do not converge as one that differs; None if it does not.

    It differs where the finest mesh is off by more than the coarser ones allow any finer mesh to
    be, and by more than the next coarser mesh itself.  Then the finest run or the prediction is at
    fault.  Where the finer mesh is closer to the prediction, the row is unresolved.
    """
    limited = replace(row, bar=min(error.size, error.limit) + comparison.added)
    off = math.inf if row.difference is None else abs(row.difference)
    return limited if limited.verdict == DIFFERS and off > comparison.before() else None


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
