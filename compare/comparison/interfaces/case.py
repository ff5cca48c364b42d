"""The case of an interface: its run and its simulations on three meshes, at the same places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.case import Case
from compare.comparison.interfaces.nodes import (
    UNITS,
    LineMesh,
    check_lines,
    field_at,
    history_of,
    nothing_of,
    places,
    touching,
)
from compare.comparison.measures import ROUNDING
from compare.comparison.quantities.history_rows import map_row
from compare.comparison.quantities.local_rows import (
    BAND,
    EARLY,
    LOCAL_FLOOR,
    beside_changes,
    motion,
    place_row,
)
from compare.comparison.quantities.own_rows import BEYOND, MISMATCH, own_row
from compare.comparison.rows import Row
from fem.lines import LineSimulation
from semianalytic import Run
from semianalytic.engine.pace import in_fours
from semianalytic.results.interface_history import InterfaceHistory

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LARGEST_ORDER = 1.0
"""Highest order of convergence that is believed.  Faces that are loaded suddenly start a part of a
step late, which is an error of first order in all slip that follows, however fast the rest of it
converges.  With 1.25, as for scenes, slip under rate-and-state friction was 1.0 to 1.2 bars off;
with half of this value bars are twice as long."""
BESIDE = 3.0
"""How many times as much it may be beside ends of slip or of openings."""
LOCAL = 4.0
"""Error of a place on mesh or grid, over the largest change from 4h to 2h near it and a thousandth
of the largest value.  Of the places of 36 drawn interfaces none was beyond 3.4 times these; with
half of this value one in three of the interfaces had a place that is not known to be right."""


@dataclass(frozen=True, eq=False)
class LineCase(Case):
    """A run and simulations of the same interface, ready to be compared.

    Attributes
    ----------
    run : Run
    simulations : tuple of LineSimulation
        From the finest mesh on.
    """

    run: Run
    simulations: tuple[LineSimulation, ...]
    amplified, needed, error_estimate = "", None, 0.0

    @property
    def caution(self) -> str:
        """Why the run decides nothing; "" if it does."""
        return "" if self.run.status == "done" else f"the run is {self.run.status}"

    @cached_property
    def expected(self) -> tuple[InterfaceHistory, ...]:
        """The run at the places of each mesh."""
        done = self.run
        return tuple(history_of(done, done, one.interface.x) for one in self.runs)

    def compared(self, number: int) -> Mask:
        """Return the places of a mesh that stand for nothing but contact in all answers."""
        count, done = len(self.runs[number].interface.x), self.run
        fine = [one for one in self.simulations if one.nodes >= count]
        return touching([done, *fine], done, count)

    def size(self, values: Array, x: Array, t: Array) -> float:
        """Return the mean of a field over places and times."""
        return float(np.abs(values).mean())

    def unit(self, name: str) -> tuple[float, str, str]:
        """Return divisor and unit of a field, and the unit of its mean."""
        return 1.0, UNITS[name], UNITS[name]

    def nothing(self, kind: str) -> float:
        """Return the mean of a kind of field up to which it is not compared."""
        return nothing_of(self.run, kind.replace(" ", "_"))

    def remedy(self, resolution: int) -> str:
        """Return the nodes that would resolve a row."""
        return f"raise `mesh_nodes`, to {in_fours(resolution)} for one"

    @cached_property
    def moving(self) -> list[str]:
        """Names of the fields that are more than nothing, in the run or simulated."""
        answers, on = (self.at_nodes, self.seen), self.compared(0)

        def mean(name: str) -> float:
            return max(float(np.abs(getattr(one, name)[:, on]).mean()) for one in answers)

        return [name for name in UNITS if mean(name) > self.nothing(name)]

    @property
    def rests(self) -> bool:
        """Whether nothing slips or opens, neither in the run nor simulated."""
        return not {"slip", "slip_rate", "gap"}.intersection(self.moving)

    def rows(self) -> Iterator[Row]:
        """Rows of all fields over space and time, at their worst places, and of laws."""
        done, places = self.run, []
        for name in self.moving:
            size = float(np.abs(getattr(self.at_nodes, name)[:, self.compared(0)]).mean())
            # the estimate of pressure is relative to all of it, that of traction to its change
            whole = np.abs(done.pressure[:, done.touching]).mean() if name == "pressure" else size
            doubt = done.error_estimates.get(name, 0.0) * float(whole)
            unsure = np.full_like(self.seen.slip, doubt)
            yield map_row(self, name, unsure, smooth=True, order=LARGEST_ORDER)
            if self._places[0].any():
                places.append(self._place_row(name, doubt / (size or 1.0)))
        yield from places
        yield from self._law_rows()

    @property
    def _band(self) -> tuple[int, int]:
        """Numbers of times and nodes of a band around a place, on both sides together."""
        return 1, 2 * BAND * (self.simulations[0].nodes // self.simulations[-1].nodes) + 1

    @cached_property
    def _places(self) -> tuple[Mask, Mask]:
        """Masks of the times and nodes, (m, n), that are compared one by one, which are neither
        early nor where grids differ on an end of a contact, and of those beside ends of slip."""
        done, (finest, middle, coarsest) = self.run, self.simulations
        fastest, widest = (
            max(float(np.abs(getattr(middle, name)).max()), self.nothing(name))
            for name in ("slip_rate", "gap")
        )
        answers: tuple[Run | LineSimulation, ...] = (done, middle, coarsest)
        motions, on = [], [touching([finest], done, finest.nodes)]
        for one in answers:
            nodes = min(one.nodes, finest.nodes)
            rate, gap = (field_at(one, name, done, nodes) for name in ("slip_rate", "gap"))
            sense = motion(rate, gap, fastest, widest)
            motions.append(np.repeat(sense, finest.nodes // nodes, axis=1))
            on.append(np.repeat(touching([one], done, nodes), finest.nodes // nodes))
        both = np.all(on, axis=0)
        apart = scipy.ndimage.maximum_filter(np.any(on, axis=0) & ~both, self._band[1], mode="wrap")
        late = finest.t >= (1 - ROUNDING) * EARLY * self.end_time
        return late[:, None] & both & ~apart, beside_changes(motions, self._band, "wrap")

    def _place_row(self, name: str, share: float) -> Row:
        """Row of the place and time at which a field is off by the most error bars.

        Its bar comes from the two coarser meshes alone, as those of scenes.
        """
        done, (finest, middle, coarsest) = self.run, self.simulations
        fine, coarse = finest.nodes, coarsest.nodes
        ran, meshed = (field_at(one, name, done, fine) for one in (done, finest))
        known, coarser = (field_at(one, name, done, coarse) for one in (middle, coarsest))
        change = np.repeat(np.abs(known - coarser), fine // coarse, axis=1)
        change = scipy.ndimage.maximum_filter(change, self._band, mode=("nearest", "wrap"))
        largest = float(np.abs(known[:, touching(self.simulations, done, coarse)]).max(initial=0.0))
        bar = LOCAL * (change + LOCAL_FLOOR * largest) + min(share, 1.0) * largest
        shown, beside = self._places
        bar = np.where(beside, BESIDE, 1.0) * bar + self.nothing(name)

        def where(level: int, node: int) -> str:
            return f"x = {finest.x[node]:.4g}, t = {finest.t[level]:.4g}"

        return place_row(self, name, UNITS[name], (ran, meshed), (bar, shown), where)

    def _law_rows(self) -> Iterator[Row]:
        """Rows of what every correct simulation fulfils to rounding, over its largest values."""
        one = self.simulations[0]
        on, stress = one.touching, float(np.abs(one.strength).max(initial=0.0))
        excess = (np.abs(one.shear_traction) - one.strength)[:, on].max(initial=0.0)
        yield own_row(self, BEYOND, max(float(excess), 0.0) / (stress or 1.0), "largest strength")
        gained = np.diff(one.window_slip, axis=1)[:, 0] / np.diff(one.window)
        fastest = float(np.abs(gained).max(initial=0.0)) + self.nothing("slip_rate")
        off = float(np.abs(gained - one.slip_rate)[:, on].max(initial=0.0))
        # slip at a time lies between those at the ends of its window, but for a return meanwhile
        middle, passed = one.window_slip.mean(axis=1), np.diff(one.window)
        beyond = (np.abs(one.slip - middle) / passed)[:, on].max(initial=0.0) - fastest
        yield own_row(self, MISMATCH, max(off, float(beyond)) / fastest, "largest slip rate")


def line_case(done: Run, simulations: Sequence[LineSimulation]) -> LineCase:
    """Return the case of a run and of simulations on meshes of h, 2h and 4h.

    Nodes of grids that lie between the ends of contacts do not coincide, and those beside slots may
    be singular on any mesh: there, means over the elements of the coarsest mesh are compared.
    """
    check_lines(done, simulations)
    prediction: Any = done
    mesh: Any = None
    for one in reversed(simulations):
        count = one.nodes if done.interface.contact.is_whole else simulations[-1].nodes
        history = history_of(one, done, places(one, done, count))
        mesh = LineMesh(history, one.nodes, mesh)
        at_nodes = history_of(done, done, history.x)
    return LineCase(prediction, mesh, at_nodes, None, done, tuple(simulations))
