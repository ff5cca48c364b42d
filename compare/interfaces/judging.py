"""Whether a run of an interface and its finite elements agree, quantity by quantity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar, error_bar
from compare.comparison.judging import LEAST_ERROR, Comparison, judged
from compare.comparison.measures import ROUNDING
from compare.comparison.quantities.local_rows import (
    BAND,
    EARLY,
    LOCAL_FLOOR,
    place_row,
)
from compare.comparison.quantities.own_rows import (
    BEYOND,
    MISMATCH,
    fields_of,
    own_row,
    refuse_unfinite,
)
from compare.comparison.rows import UNRESOLVED, HasRows, Row
from compare.interfaces.case import KINDS, LineCase
from compare.interfaces.lines import line_of
from fem.lines import LineSimulation, simulate_line
from fem.lines.march import planned_work, sample_times
from semianalytic import Interface, Run, solve
from semianalytic.engine.stepping.line import fitting_nodes, grid_of
from semianalytic.engine.stepping.pace import in_fours
from semianalytic.engine.stepping.tuning import NODES
from semianalytic.scene.checks import checked_count, checked_size, shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

USUAL_WORK = 2e9
"""Unknowns times steps of the finest mesh unless its nodes are given: about half a minute.  Half of
it halves the meshes of `steel-on-rubber` and `supershear`, twice of it doubles that of
`cattaneo`."""
COARSEST = 64
"""Fewest nodes of the finest mesh, so that the coarsest of the three has 16."""
LARGEST_ORDER = 1.0
"""Highest order of convergence that is believed.  Faces that are loaded suddenly start a part of a
step late, which is an error of first order in all slip that follows, however fast the rest of it
converges.  With 1.25, as for scenes, slip under rate-and-state friction was 1.0 to 1.2 bars off;
with half of this value bars are twice as long."""
LOCAL = 4.0
"""Error of a place on mesh or grid, over the largest change from 4h to 2h near it and a thousandth
of the largest value.  Of the places of 36 drawn interfaces none was beyond 3.4 times these; with
half of this value one in three of the interfaces had a place that is not known to be right."""
MESHES = 3
HALVINGS = 4
"""How often grids are halved from the nodes of the run to those of the coarsest mesh, with ends of
contacts that still fit: twice for three meshes, and twice more where the finest has a quarter of
the nodes of the run, as of `two-slots`."""


@dataclass(frozen=True, eq=False)
class InterfaceJudgement(HasRows[Row]):
    """A run of an interface held against finite elements on three meshes.

    Attributes
    ----------
    run : Run
        The run, with its error estimates, at the times of the simulations.
    simulations : tuple of LineSimulation
        From the finest mesh on; each has half as many nodes as the one before.
    rows : tuple of Row
        Fields as L1 norms over all times and the contact, fields at their worst place, and laws.
    """

    run: Run
    simulations: tuple[LineSimulation, ...]
    rows: tuple[Row, ...]

    def remedy(self, row: Row) -> str:
        """Return the mesh that would resolve a row; "" where none is known."""
        if row.verdict != UNRESOLVED or row.resolution is None:
            return ""
        return f"raise `mesh_nodes`, to {in_fours(row.resolution)} for one"


def compare_interface(
    interface: Interface,
    end_time: float,
    nodes: int | None = None,
    *,
    mesh_nodes: int | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> InterfaceJudgement:
    """Run an interface, simulate it with finite elements on three meshes, and judge both.

    Each quantity has an error bar: what the three meshes show of the error of the finest one
    (`compare.comparison.bars.error_bar`), and the error estimate of the run.  The finite elements
    share the description of the interface and its law of friction with the run, and nothing else.

    Parameters
    ----------
    interface : Interface
    end_time : float
        Last time [time].
    nodes : int, optional
        Nodes of the run; by default 512, or up to twice as many, so that ends of contacts lie
        midway between the nodes of all grids.
    mesh_nodes : int, optional
        Nodes of the finest mesh along the interface, a divisor of `nodes` and a multiple of 4; as
        many as about half a minute allows unless given.
    progress : callable, optional
        Called with (step, steps) of the finest mesh, which takes most of the time.
    **options
        Options of `run`.

    Returns
    -------
    InterfaceJudgement

    Raises
    ------
    SceneError
        If the interface or an option is not admissible, mean slip is held, or the simulation would
        take hours.
    ComputationError
        If a run or a simulation goes unstable.

    Examples
    --------
    >>> import semianalytic as sf
    >>> from compare.interfaces.judging import compare_interface
    >>> patch = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 1))
    >>> solid = sf.Material(1.0, 1.0, 0.25)
    >>> patched = sf.Interface(solid, sf.Coulomb(0.5), 8.0, loads=[patch])
    >>> compare_interface(patched, 1.0, nodes=128).verdict
    'agrees'
    """
    if not isinstance(interface, Interface):
        raise SceneError(f"compare: interface must be an Interface, got {shown(interface)}.")
    end_time = checked_size("compare: end_time", end_time)
    if nodes is None:
        nodes = fitting_nodes(interface, NODES, HALVINGS)
    finest = _mesh_nodes(interface, end_time, nodes, mesh_nodes)
    shift = grid_of(interface, nodes).shift
    lines = [line_of(interface, finest >> number, shift) for number in range(MESHES)]
    kept = {name: value for name, value in options.items() if name not in ("every", "frames")}
    # first the run, which refuses friction that has no answer
    done = solve(
        interface,
        end_time=end_time,
        nodes=nodes,
        **{**kept, "times": sample_times(end_time).tolist()},
    )
    simulations = [simulate_line(lines[0], end_time, progress=progress)]
    # each of the two others takes an eighth of the time of the one before
    simulations += [simulate_line(line, end_time) for line in lines[1:]]
    return judge_interface(done, simulations)


def _mesh_nodes(interface: Interface, end_time: float, nodes: int, given: int | None) -> int:
    """Return the nodes of the finest mesh, after a check that friction and mesh admit them."""
    nodes = checked_count("compare: nodes", nodes, COARSEST, "a whole number of at least")
    if given is not None:
        given = checked_count("compare: mesh_nodes", given, COARSEST, "a whole number of at least")
        if given % 4 or nodes % given:
            raise SceneError(
                f"compare: mesh_nodes must be a multiple of 4 that divides the {nodes} nodes of "
                f"the run, got {given}."
            )
        return given
    while nodes % 8 == 0 and nodes > COARSEST:
        if planned_work(line_of(interface, nodes), end_time) <= USUAL_WORK:
            break
        nodes //= 2
    return nodes


def judge_interface(done: Run, simulations: list[LineSimulation]) -> InterfaceJudgement:
    """Hold a run against simulations of the same interface on meshes of h, 2h and 4h.

    Parameters
    ----------
    done : Run
        With error estimates, at the times of the simulations; its nodes are a multiple of theirs.
    simulations : list of LineSimulation
        From the finest on.

    Raises
    ------
    DataFileError
        If a field of the run or of a simulation holds a value that is not finite.
    """
    refuse_unfinite("the run", done.x, done.t, fields_of(done, KINDS))
    for one in simulations:
        whose = f"the simulation of {one.nodes} nodes"
        refuse_unfinite(whose, one.x, one.t, fields_of(one, (*KINDS, "strength")))
        refuse_unfinite(whose, one.x, one.window[:, 1], {"slip": one.window_slip[:, 1]})
    return InterfaceJudgement(done, tuple(simulations), tuple(_rows(LineCase(done, simulations))))


def _rows(case: LineCase) -> Iterator[Row]:
    """Rows of each field over all times and nodes, then of its worst place, then of the laws."""
    places = []
    for name, (kind, unit) in KINDS.items():
        finest = case.simulations[0].nodes
        on = case.touching(finest)
        ran, meshed = case.ran(name, finest)[:, on], case.meshed(0, name, finest)[:, on]
        size = float(np.abs(ran).mean())
        if max(size, float(np.abs(meshed).mean())) <= case.least(name):
            continue
        # the estimate of pressure is relative to all of it, that of traction to its change
        whole = case.run.pressure[:, case.run.touching] if name == "pressure" else ran
        doubt = case.run.error_estimates.get(name, 0.0) * float(np.abs(whole).mean())
        yield _whole_row(case, name, kind, unit, doubt)
        places.append(_place_row(case, name, unit, doubt))
    yield from places
    yield from _law_rows(case)


def _whole_row(case: LineCase, name: str, kind: str, unit: str, doubt: float) -> Row:
    """Return the row of the L1 norms of a field over all times and all nodes of the contact."""
    counts = [one.nodes for one in case.simulations]
    if not case.run.interface.contact.is_whole:
        # as means that hold every node, for the nodes beside slots may be singular on any mesh
        counts = [counts[-1]] * len(counts)

    def apart(fine: Array, coarse: Array) -> float:
        return mean(fine - coarse) / per

    def mean(field: Array) -> float:
        return float(np.abs(field[:, case.touching(field.shape[1])]).mean())

    ran, meshed = case.ran(name, counts[0]), case.meshed(0, name, counts[0])
    size, simulated = mean(ran), mean(meshed)
    per = size or simulated
    changes = [
        apart(case.meshed(number, name, count), case.meshed(number + 1, name, count))
        for number, count in enumerate(counts[1:])
    ]
    row = Row(
        f"{kind}, L1", kind, None, size, simulated, apart(meshed, ran), None, unit, relative=True
    )

    def before() -> float:
        return apart(case.meshed(1, name, counts[1]), case.ran(name, counts[1]))

    error = error_bar(changes, LEAST_ERROR, most=LARGEST_ORDER)
    return judged(case, row, Comparison(error, before, doubt / per))


def _place_row(case: LineCase, name: str, unit: str, doubt: float) -> Row:
    """Return the row of the place and time at which a field is off by the most error bars.

    The bar of a place comes from the two coarser meshes alone, as in
    `compare.comparison.quantities.local_rows`.
    """
    fine, _, coarse = (one.nodes for one in case.simulations)
    ran, meshed = case.ran(name, fine), case.meshed(0, name, fine)
    middle = case.meshed(1, name, coarse)
    change = np.abs(middle - case.meshed(2, name, coarse))
    change = np.repeat(change, fine // coarse, axis=1)
    band = 2 * BAND * (fine // coarse) + 1
    change = scipy.ndimage.maximum_filter(change, (1, band), mode=("nearest", "wrap"))
    largest = float(np.abs(middle[:, case.touching(coarse)]).max(initial=0.0))
    share = doubt / max(float(np.abs(ran[:, case.touching(fine)]).mean()), np.finfo(float).tiny)
    bar = LOCAL * (change + LOCAL_FLOOR * largest) + min(share, 1.0) * largest + case.least(name)
    late = case.run.t >= (1 - ROUNDING) * EARLY * case.run.end_time
    shown = late[:, None] & case.touching(fine)
    row, at = place_row(name, unit, (ran, meshed), np.where(shown, bar, np.inf))
    finest = case.simulations[0]
    row = replace(row, place=f"x = {finest.x[at[1]]:.4g}, t = {finest.t[at[0]]:.4g}")
    return judged(case, row, Comparison(ErrorBar(float(bar[at]), None, np.inf, converges=True)))


def _law_rows(case: LineCase) -> Iterator[Row]:
    """Rows of what every correct simulation fulfils to rounding, over its largest values."""
    one = case.simulations[0]
    on, stress = one.touching, float(np.abs(one.strength).max(initial=0.0))
    excess = (np.abs(one.shear_traction) - one.strength)[:, on].max(initial=0.0)
    yield own_row(case, BEYOND, max(float(excess), 0.0) / (stress or 1.0), "largest strength")
    gained = np.diff(one.window_slip, axis=1)[:, 0] / np.diff(one.window)
    fastest = float(np.abs(gained).max(initial=0.0)) + case.least("slip_rate")
    off = float(np.abs(gained - one.slip_rate)[:, on].max(initial=0.0))
    yield own_row(case, MISMATCH, off / fastest, "largest slip rate")
