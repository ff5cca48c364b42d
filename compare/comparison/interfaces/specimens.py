"""Specimens of finite size by both methods, and by three meshes alone once their ends are felt."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from compare.comparison.bars import LEAST_ORDER, error_bar
from compare.comparison.case import EDGE_CELLS
from compare.comparison.documents import SCENE_DIMENSIONS, units_document
from compare.comparison.interfaces.case import UNITS, LineCase, line_case
from compare.comparison.judgement import Judgement
from compare.comparison.judging import DIVERGES, LEAST_ERROR
from compare.comparison.measures import ROUNDING
from compare.comparison.mesh_choice import RESOLVED_WITH
from compare.comparison.rows import Row
from fem import Specimen
from fem.lines import LineSimulation
from semianalytic import solve
from semianalytic.engine.stepping.line import fitting_nodes
from semianalytic.engine.stepping.tuning import NODES
from semianalytic.results.interruption import whole
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import history_document, scene_document
from semianalytic.scene.loading import Tractions

EARLY = 3
"""Squares of the coarsest mesh by which motion of a mesh is ahead of the first wave: a difference
of 1e-6 of the largest slip was up to 3 squares ahead in six specimens."""
SAMPLES, MOST_SAMPLES = 20, 400
"""Times at which the half-planes are compared, and most times of the whole simulation."""


BLOCK = {"material": SCENE_DIMENSIONS["material"]}
BLOCK |= dict.fromkeys(("height", "left", "right"), "length")
DIMENSIONS = {
    "scene": {**SCENE_DIMENSIONS, "upper": BLOCK, "lower": BLOCK},
    "finite_elements": {
        **{"end_time": "time", "element_size": "length", "time_step": "time"},
        "seconds": "s",
    },
    **{"largest_slip": "length", "largest_slip_rate": "length / time", "largest_gap": "length"},
}
"""Dimensions of the numbers of `specimen_document`."""


def compare_specimen(
    specimen: Specimen,
    end_time: float | None = None,
    *,
    size: float | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> Judgement:
    """Simulate a specimen on squares of a size, twice and four times it, and judge it.

    Until the ends of the bodies are felt on the contact, at `Judgement.case.until`, the march of
    the half-planes predicts it.  Later the three meshes judge one another: each field has to change
    from 2h to h by less than it does from 4h to 2h, as fields do that converge, and the traction of
    every node has to obey friction.  Errors are those of `compare`.
    """
    end_time = specimen.run.get("end_time") if end_time is None else end_time
    size = specimen.run.get("size") if size is None else size
    end_time, size = (
        checked_size("compare: end_time", end_time),
        checked_size("compare: size", size),
    )
    try:
        x, _ = specimen.nodes(4 * size)
    except SceneError as refused:
        reason = str(refused).removeprefix("simulate: ")
        raise SceneError(
            f"compare: its coarsest mesh has squares of 4 times {size:g}, and {reason}"
        ) from None
    on = x[specimen.shares(x)[0] > 0]
    fastest = max(block.material.longitudinal_speed for block in specimen.blocks)
    until = min(float(specimen.felt(on).min()) - EARLY * 4 * size / fastest, end_time)
    samples = int(np.ceil(SAMPLES * end_time / until)) if until > 0 else MOST_SAMPLES + 1
    if samples > MOST_SAMPLES:
        raise SceneError(
            "compare: the ends of the specimen send waves so early that half-planes describe it "
            "at no time; move the loads from the ends of the joint, or lower `size`."
        )
    given = {"samples": samples, **options}
    meshes = [specimen.simulated(end_time, size=size, progress=progress, **given)]
    meshes += [specimen.simulated(end_time, size=size * ratio, **given) for ratio in (2, 4)]
    return judge_specimen(specimen, meshes, until)


class SpecimenCase(LineCase):
    """The march of half-planes and simulations of a specimen until its ends are felt.

    Laws are checked in the whole simulations, which go on.
    """

    whole: tuple[LineSimulation, ...]

    @property
    def checked(self) -> LineSimulation:
        """Simulation in which laws are checked."""
        return self.whole[0]

    @property
    def later(self) -> str:
        """Words on the comparison after the time until which the run is compared; "" without."""
        end, said = self.checked.t[-1], ", when waves from the ends arrive"
        return f"{said}, then meshes with one another until {end:.4g}" if end > self.until else said

    def remedy(self, resolution: int) -> str:
        """Return the squares that may resolve a row, in words."""
        size = self.simulation.element_size * len(self.seen.x) / resolution
        return RESOLVED_WITH.format(f"`size` {size:.3g}")

    def rows(self) -> Iterator[Row]:
        """Rows against the half-planes, and of the meshes alone at later times."""
        yield from super().rows()
        for name in UNITS:
            yield from self._mesh_row(name)

    def _mesh_row(self, name: str) -> Iterator[Row]:
        """Yield the row of the change of a field from 2h to h, at nodes of the mesh of 4h."""
        later, coarsest = self.whole[0].t > self.until, self.whole[-1]
        elements = EDGE_CELLS if UNITS[name] == "stress" else 0
        away = (elements + 0.25) * (coarsest.x[1] - coarsest.x[0])
        on = coarsest.touching & ~self._beside_slots(coarsest.x, away)
        ends = coarsest.x[[0, -1]]
        on &= np.abs(coarsest.x[:, None] - ends).min(axis=1) > away
        values = []
        for step, numbers, run in zip((4, 2, 1), self.whole, self.runs, strict=True):
            own: Any = run
            in_place = getattr(own.line, name)[0] - getattr(own.interface, name)[0]
            values.append((getattr(numbers, name)[later] - in_place)[:, ::step][:, on])
        fine, half, coarse = values
        size = float(np.abs(fine).mean()) if fine.size else 0.0
        if not size > self.nothing(name.replace("_", " ")):
            return
        changes = [float(np.abs(a - b).mean()) / size for a, b in ((half, fine), (coarse, half))]
        error = error_bar(changes, LEAST_ERROR)
        kind = name.replace("_", " ")
        yield Row(
            name=f"{kind} after {self.until:.3g}, meshes",
            kind=kind,
            exact=None,
            at_nodes=float(np.abs(half).mean()),
            simulated=size,
            difference=changes[0],
            bar=changes[1] / 2**LEAST_ORDER + 3 * LEAST_ERROR,
            unit=self.unit(name)[1],
            relative=True,
            order=error.order,
            obstacle="" if error.converges else DIVERGES,
            converges=error.converges,
        )


def judge_specimen(specimen: Specimen, meshes: Sequence[LineSimulation], until: float) -> Judgement:
    """Judge simulations of a specimen on meshes of h, 2h and 4h, whose ends are felt at a time."""
    levels, ends = meshes[0].t <= until * (1 + ROUNDING), float(np.abs(specimen.joint).max())
    scene = specimen.half_planes(float(meshes[0].x[1] - meshes[0].x[0]))
    # beyond a period of this length no wave comes back
    scene = replace(scene, period=2 * ends + 4 * scene.fastest_speed * until)
    nodes, times = fitting_nodes(scene, NODES, 2), meshes[0].t[levels]
    done = whole(solve(scene, end_time=float(times[-1]), nodes=nodes, times=times.tolist()))
    names = ("t", *UNITS, "strength", "window", "window_slip")
    early = [replace(run, **{name: getattr(run, name)[levels] for name in names}) for run in meshes]
    case: Any = line_case(done, early, SpecimenCase)
    case.whole = tuple(meshes)
    return Judgement(case, tuple(case.rows()))


def specimen_document(specimen: Specimen, done: LineSimulation) -> dict[str, Any]:
    """A specimen and its simulation as dictionaries, lists, strings and numbers, for JSON."""
    scene = replace(specimen, base=specimen.base or Tractions(0.0, 0.0)).half_planes()
    parts = scene_document(scene)
    kept: dict[str, Any] = {
        key: parts[key] for key in ("friction", "friction_law", "load", "units") if key in parts
    }
    if specimen.base is not None:
        kept["base"] = parts["base"]
    for name, block in zip(("upper", "lower"), specimen.blocks, strict=True):
        kept[name] = {**asdict(block), "history": history_document(block.history)}
    ends = [[x if np.isfinite(x) else str(x) for x in p] for p in specimen.contact.intervals]
    kept["contact"] = {"intervals": ends}
    kept["history"] = history_document(specimen.history)
    kept["gauges"] = [list(place) for place in specimen.gauges]
    document: dict[str, Any] = {
        "scene": kept,
        "finite_elements": {
            "end_time": float(done.t[-1]),
            "element_size": float(done.x[1] - done.x[0]),
            "time_step": float(done.t[-1] / done.steps),
            **{name: getattr(done, name) for name in ("steps", "unknowns", "imbalance")},
            "seconds": done.seconds,
        },
        "largest_slip": float(np.abs(done.slip[:, done.touching]).max()),
        "largest_slip_rate": float(np.abs(done.slip_rate[:, done.touching]).max()),
        "largest_gap": float(done.gap[:, done.touching].max()),
    }
    document["units"] = units_document(document, DIMENSIONS, scene)
    return document
