"""Steps of `slipfront compare` for interfaces: run one, simulate it on three meshes, and judge."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from compare.comparison.interfaces.case import line_case
from compare.comparison.judgement import Judgement
from compare.comparison.mesh_choice import QUIETING
from fem.lines import Line, LineSimulation, simulate_line
from fem.lines.march import DAMPING, planned_work, sample_times
from semianalytic import Marched, Scene, solve
from semianalytic.engine.stepping.acting import ActingLoads
from semianalytic.engine.stepping.fronts import acting_loads
from semianalytic.engine.stepping.line import fitting_nodes, grid_of, with_period
from semianalytic.engine.stepping.tuning import NODES
from semianalytic.results.interruption import whole
from semianalytic.scene.checks import checked_count, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.line.fields import at_nodes

Progress = Callable[[int, int], None]

USUAL_WORK = 2e9
"""Unknowns times steps of the finest mesh of an interface unless its nodes are given: about half a
minute.  Half of it halves the meshes of `steel-on-rubber` and `supershear`, twice of it doubles
that of `cattaneo`."""
COARSEST = 64
"""Fewest nodes of that mesh, so that the coarsest of the three has 16."""
MESHES = 3
HALVINGS = 4
"""How often grids are halved from the nodes of the run to those of the coarsest mesh, with ends of
contacts that still fit: twice for three meshes, and twice more where the finest has a quarter of
the nodes of the run, as of `two-slots`."""


def judge_interface(done: Marched, simulations: Sequence[LineSimulation]) -> Judgement:
    """Judge a run by simulations of the same interface on meshes of h, 2h and 4h.

    The run has a companion, and times of the simulations; its nodes are a multiple of theirs.
    Values that are not finite raise DataFileError.
    """
    case = line_case(done, simulations)
    return Judgement(case, tuple(case.rows()))


def compare_interface(
    scene: Scene,
    end_time: float,
    nodes: int | None = None,
    *,
    mesh_nodes: int | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Judgement:
    """Run an interface, simulate it with finite elements on three meshes, and judge both.

    Each quantity has an error bar: what the three meshes show of the error of the finest one
    (`compare.comparison.bars.error_bar`), and how far the run is from its companion on half of the
    nodes.  The finite elements share the description of the interface and its law of friction with
    the run, and nothing else.
    Nodes are those of the run, by default 512, or up to twice as many, so that ends of contacts lie
    midway between the nodes of all grids.  `mesh_nodes`, those of the finest mesh, divide them and
    are a multiple of 4, as many as about half a minute allows unless given.  `progress` is called
    with (step, steps) of the finest mesh, which takes most of the time; options are those of `run`.
    Errors are those of `compare`.
    """
    end_time = checked_size("compare: end_time", end_time)
    scene = with_period(scene, end_time)
    if nodes is None:
        nodes = fitting_nodes(scene, NODES, HALVINGS)
    finest = _mesh_nodes(scene, end_time, nodes, mesh_nodes)
    shift = grid_of(scene, nodes).shift
    lines = [line_of(scene, finest >> number, shift) for number in range(MESHES)]
    kept = {name: value for name, value in options.items() if name not in ("every", "frames")}
    kept["times"] = sample_times(end_time).tolist()
    # first the run, which refuses friction that has no answer
    done = whole(solve(scene, end_time=end_time, nodes=nodes, **kept))
    # waves of a few elements may grow on meshes even where friction admits none
    damping = DAMPING if scene.lower_material in (None, scene.material) else QUIETING
    simulations = [simulate_line(lines[0], end_time, damping=damping, progress=progress)]
    # each of the two others takes an eighth of the time of the one before
    simulations += [simulate_line(line, end_time, damping=damping) for line in lines[1:]]
    return judge_interface(done, simulations)


def _mesh_nodes(scene: Scene, end_time: float, nodes: int, given: int | None) -> int:
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
        if planned_work(line_of(scene, nodes), end_time) <= USUAL_WORK:
            break
        nodes //= 2
    return nodes


def line_of(scene: Scene, nodes: int, shift: float | None = None) -> Line:
    """Return what finite elements have to know of an interface, at the nodes that `run` has.

    Nodes are those of the whole period, on all of which even interfaces are simulated; they are
    moved by a shift [length], by default what suits the ends of contacts.  A prescribed mean slip,
    which no body does, adhesion, and fields without a value at a node raise SceneError.
    """
    if scene.held != math.inf:
        raise SceneError(
            "simulate: finite elements have no stiffness for the mean slip; leave out "
            "`held` (docs/engine.md)."
        )
    if scene.adhesion is not None:
        raise SceneError(
            "simulate: finite elements have no adhesion; leave it out to compare (docs/engine.md)."
        )
    # Even interfaces are simulated on all of the line.
    grid = replace(grid_of(scene, nodes, shift), even=False)
    x, spacing = grid.x, grid.spacing
    touching = scene.contact.touches(x)
    on = x[touching]
    law = scene.law.on(on, spacing)
    pressure = at_nodes("scene: pressure", scene.base.pressure, x, touching, spacing)
    shear = sampled("scene: shear", scene.base.shear, x, spacing)
    loads = acting_loads(scene)
    rate = np.abs(sampled("scene: rate", scene.rate, on))
    state = np.asarray(law.start(pressure[touching], shear[touching], rate), dtype=float)
    return Line(
        upper=scene.material,
        lower=scene.bodies[1],
        length=scene.period,
        x=x,
        touching=touching,
        friction=law,
        state=state,
        shear=ActingLoads("shear", shear, loads, x, touching),
        pressure=ActingLoads("pressure", pressure, loads, x, touching),
        opens=scene.may_open,
        antiplane=scene.mode == "antiplane",
        plate_rate=scene.plate_rate,
    )
