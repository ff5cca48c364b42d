"""Whether a run of an interface and its finite elements agree, quantity by quantity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.bars import error_bar
from compare.comparison.judgement import MOTION
from compare.comparison.judging import BEYOND, LEAST_ERROR, WIDE, Comparison, beyond_limit
from compare.comparison.rows import (
    AGREES,
    DIFFERS,
    TELLING,
    UNRESOLVED,
    HasRows,
    Row,
    overall,
)
from compare.interfaces.lines import line_of
from fem.lines import LineSimulation, simulate_line
from fem.lines.march import planned_work, sample_times
from semianalytic import Interface, Run, solve
from semianalytic.engine.line import fitting_nodes, grid_of
from semianalytic.engine.tuning import LEAST_GAP, NODES
from semianalytic.interface.fields import at_nodes, sampled
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
NOTHING = 1e-9
"""Part of the slip, or of the strength, below which a gap or a traction counts as none."""
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
        Quantities compared, as L1 norms over all times and the contact.
    """

    run: Run
    simulations: tuple[LineSimulation, ...]
    rows: tuple[Row, ...]

    @property
    def verdict(self) -> str:
        """Verdict: "differs" if a row does; "agrees" if slip, slip rate or gap do and converge."""
        if self.having(DIFFERS):
            return DIFFERS
        deciding = [row for row in self.rows if row.kind in MOTION]
        if not all(row.converges for row in deciding):
            return UNRESOLVED
        return overall(row.verdict for row in deciding)


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
    """
    rows = tuple(_rows(done, simulations))
    return InterfaceJudgement(done, tuple(simulations), rows)


KINDS: Mapping[str, tuple[str, str]] = {
    "slip": ("slip", "length"),
    "slip_rate": ("slip rate", "length / time"),
    "gap": ("gap", "length"),
    "shear_traction": ("shear traction", "stress"),
    "pressure": ("pressure", "stress"),
}
"""Kind of the row and unit of each quantity; tractions are compared by their changes."""


def _rows(done: Run, simulations: list[LineSimulation]) -> Iterator[Row]:
    interface, count = done.interface, len(simulations[-1].x)
    between = not interface.contact.is_whole
    on = _common(simulations[0].touching[None].astype(float), count, between)[0] == 1
    x, spacing = done.x, interface.length / done.nodes
    pressure = interface.pressure
    base = {
        "shear_traction": sampled("interface: shear", interface.shear, x, spacing),
        "pressure": at_nodes("interface: pressure", pressure, x, done.touching, spacing),
    }
    least = _least_sizes(done)
    for name, (kind, unit) in KINDS.items():
        own = getattr(done, name) - base.get(name, 0.0)
        start = _whole(np.broadcast_to(base.get(name, 0.0), done.x.shape)[None], done)
        ran = _common(_whole(own, done), count, between)[:, on]
        meshed = [
            _common(getattr(one, name) - _common(start, len(one.x), between), count, between)[:, on]
            for one in simulations
        ]
        size = float(np.abs(ran).mean())
        if max(size, float(np.abs(meshed[0]).mean())) <= least[name]:
            continue
        # the estimate of pressure is relative to all of it, that of traction to its change
        whole = own + base[name] if name == "pressure" else own
        estimate = done.error_estimates.get(name, 0.0)
        doubt = estimate * float(np.abs(whole[:, done.touching]).mean())
        yield _row(kind, unit, ran, meshed, doubt, done.status)


def _least_sizes(done: Run) -> dict[str, float]:
    """Return the mean of each quantity up to which it is not compared.

    They are parts of the motion of the faces and of all tractions: rounding moves faces that rest,
    and a small gap decides nothing.
    """
    # slots are wider than contacts open
    fields = {name: np.abs(getattr(done, name)[:, done.touching]) for name in KINDS}
    motion = max(float(fields[name].mean()) for name in ("slip", "gap"))
    stress = max(float(fields[name].mean()) for name in ("shear_traction", "pressure"))
    return {
        "slip": NOTHING * motion,
        "gap": LEAST_GAP * motion,
        "slip_rate": NOTHING * motion / done.end_time,
        "shear_traction": NOTHING * stress,
        "pressure": NOTHING * stress,
    }


def _row(kind: str, unit: str, ran: Array, meshed: list[Array], doubt: float, status: str) -> Row:
    """Return the judged row of one quantity from its fields on common nodes."""
    size = float(np.abs(ran).mean())
    per = size or float(np.abs(meshed[0]).mean())

    def apart(one: Array, other: Array) -> float:
        return float(np.abs(one - other).mean()) / per

    error = error_bar(
        [apart(one, other) for one, other in pairwise(meshed)], LEAST_ERROR, most=LARGEST_ORDER
    )
    row = Row(
        f"{kind}, L1",
        kind,
        None,
        size,
        float(np.abs(meshed[0]).mean()),
        apart(meshed[0], ran),
        error.size + doubt / per,
        unit,
        relative=True,
        order=error.order,
        converges=error.converges,
    )
    if status != "done":
        return replace(row, obstacle=f"the run is {status}", converges=False)
    if not error.converges:
        comparison = Comparison(error, lambda: apart(meshed[1], ran), doubt / per)
        limited = beyond_limit(row, error, comparison)
        if limited is not None:
            return limited
        return replace(row, obstacle="the meshes do not converge; raise `mesh_nodes`")
    if row.verdict == UNRESOLVED:
        return replace(row, obstacle=BEYOND.format(row.alarm))
    if row.verdict == AGREES and row.bar is not None and row.bar > TELLING:
        return replace(row, obstacle=f"{WIDE}; raise `mesh_nodes`")
    return row


def _whole(values: Array, done: Run) -> Array:
    """Return fields (m, n) of a run on the whole period, mirrored where it computed one half."""
    if not done.interface.even:
        return values
    if done.interface.contact.is_whole:
        # nodes at 0 and length / 2 are their own mirror images
        return np.concatenate([values[:, :0:-1], values[:, :-1]], axis=1)
    return np.concatenate([values[:, ::-1], values], axis=1)


def _common(values: Array, count: int, between: bool) -> Array:
    """Return fields (m, n) at the nodes of a coarser grid of the same period, (m, count).

    Nodes of grids that lie between the ends of contacts do not coincide: means replace them.
    """
    times = values.shape[1] // count
    if not between:
        return np.asarray(values[:, ::times])
    return np.asarray(values.reshape(len(values), count, times).mean(axis=2))
