"""What is laid side by side: a prediction at the nodes of a simulation, and its coarser meshes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import OPENING, OPENING_KINDS, error_bar, observed_order
from compare.comparison.measures import NOTHING, is_nothing, norm, worn
from compare.comparison.rows import AGREES, ALARM, TELLING, UNRESOLVED, Row
from compare.comparison.scales import slip_rate_scale, stress_scale
from semianalytic import InterfaceHistory, Marched, Scene, Solution
from semianalytic.results.answer import Answer
from semianalytic.results.sampled import interpolated
from semianalytic.spacetime.resolution import Shortfall

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

NARROW = 4
"""Elements that a zone or a gap between zones takes to be seen for what it is."""
USUAL = 0.9
"""Part of the nodes and times that slip whose mesh differences are no larger than the usual one."""
LEAST_PEAK = 1e-4
"""Part of V₀ that is a peak at least, of which thresholds are parts."""
LEAST_ERROR = 5e-4
"""Relative error of a field below which no mesh difference is believed: where all meshes slide at
friction alike, one node beside a front is all that differs."""
FIELD_FLOOR = 0.05
"""Elements by which nodes alone leave the jumps of a field open, whatever mesh differences say."""
EDGE_CELLS = 4
"""Elements next to the edge that are left out where fields can be singular."""

Profile = Callable[["Simulation"], Array]
"""A field along the contact (n,) at the end of a run."""
Reading = Callable[[InterfaceHistory], float | None]
"""A number read off a history, or that it is not there."""


@dataclass(frozen=True, eq=False)
class Case:
    """A prediction and a simulation, ready to be read.

    Attributes
    ----------
    prediction : Answer
    simulation : Simulation
        With its companions.
    at_nodes : InterfaceHistory
        The prediction at the nodes and stored times of the simulation.
    doubted : InterfaceHistory or None
        The same of the prediction's own companion, where it was marched.
    """

    prediction: Answer
    simulation: Simulation
    at_nodes: InterfaceHistory
    doubted: InterfaceHistory | None

    @cached_property
    def worn_at_nodes(self) -> tuple[Array, Array]:
        """|slip| accumulated [length] and frictional work per area [stress length] by the
        prediction until the end, (n,) each; its own where it has it, or summed over the times."""
        return worn_by(self.prediction, self.at_nodes)

    @property
    def scene(self) -> Scene:
        """Of the simulation."""
        return self.simulation.scene

    @property
    def seen(self) -> InterfaceHistory:
        """What was simulated."""
        return self.simulation.interface

    @cached_property
    def coarser(self) -> tuple[Simulation, ...]:
        """The same run at element sizes 2h, 4h, ..."""
        return tuple(_companions(self.simulation))

    @property
    def pairs(self) -> Iterator[tuple[InterfaceHistory, InterfaceHistory]]:
        """What each mesh shows and what the next coarser one does, from the finest on."""
        return pairwise([self.seen, *(run.interface for run in self.coarser)])

    @property
    def end_time(self) -> float:
        """T [time]."""
        return float(self.seen.t[-1])

    @property
    def length(self) -> float:
        """c_t T [length]."""
        return self.scene.material.shear_speed * self.end_time

    @property
    def rate(self) -> float:
        """V₀ [length / time]."""
        return slip_rate_scale(self.scene)

    @property
    def stress(self) -> float:
        """τ₀ [stress]."""
        return stress_scale(self.scene)

    @cached_property
    def largest_rate(self) -> float:
        """Largest slip rate of the simulation beyond the elements at the edge, that thresholds are
        parts of; never as small as rounding."""
        shown = self.seen.x > EDGE_CELLS * self.simulation.element_size
        seen = float(np.abs(self.seen.slip_rate[:, shown]).max(initial=0.0))
        return max(seen, LEAST_PEAK * self.rate)

    @cached_property
    def largest_gap(self) -> float:
        """Largest gap of the simulation, that thresholds are parts of; never as small as rounding
        [length]."""
        return max(float(self.seen.gap.max()), LEAST_PEAK * self.rate * self.end_time)

    @cached_property
    def opens(self) -> bool:
        """Whether the contact opens anywhere, predicted or simulated."""
        return bool(self.at_nodes.gap.any() or self.seen.gap.any())

    @property
    def slips(self) -> bool:
        """Whether any slip is predicted at the nodes."""
        return not is_nothing(self.at_nodes.slip_rate, self.rate)

    def narrow(self, start: float = 0.0) -> NDArray[np.bool_]:
        """Nodes and times at which slip is predicted beyond a position, in too few nodes, (m, n).

        That is less than `NARROW` in a row that slip one way at that time.
        """
        beyond = np.where(self.seen.x > start, self.at_nodes.slip_rate, 0.0)
        narrow = np.zeros(beyond.shape, dtype=bool)
        for sense in (1, -1):
            slips = sense * beyond > NOTHING * self.rate
            narrow |= slips & ~scipy.ndimage.binary_opening(slips, np.ones((1, NARROW), dtype=bool))
        return narrow

    @property
    def error_estimate(self) -> float:
        """What an exact solution says of itself, relative; 0 of what has a companion instead."""
        return self.prediction.error_estimate if isinstance(self.prediction, Solution) else 0.0

    @property
    def caution(self) -> str:
        """What the simulation or a march is too coarse for, as a sentence; "" if nothing."""
        reasons = [shortfall.reason for shortfall in self.shortfalls]
        return self.simulation.caution or "; ".join(f"the march: {reason}" for reason in reasons)

    @property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """What a march is too coarse for."""
        return self.prediction.shortfalls if isinstance(self.prediction, Marched) else ()

    def rate_bar(self, start: float, end: float) -> float:
        """Error bar of slip rate between two positions [length / time], over all times.

        At least that of most of what slips: where all meshes stick, they may all be wrong.
        """
        changes = []
        for fine, coarse in self.pairs:
            x, t = np.broadcast_arrays(fine.x, fine.t[:, None])
            change = np.abs(fine.slip_rate - interpolated(coarse, "slip_rate", x, t))
            slips = np.abs(fine.slip_rate) > NOTHING * self.rate
            usual = float(np.quantile(change[slips], USUAL)) if slips.any() else 0.0
            inside = (fine.x > start) & (fine.x < end)
            changes.append(max(usual, float(change[:, inside].max(initial=0.0))))
        return error_bar("slip rate", changes)

    def resolution_for(self, width: float) -> int:
        """Node distances per c_t T at which a width [length] is as many elements as it takes."""
        return math.ceil(NARROW * self.length / width)

    def value_row(
        self,
        name: str,
        kind: str,
        read: Reading,
        *,
        exact: float | None = None,
        floor: float = 0.0,
        unit: str = "1",
        size: float | None = None,
    ) -> Row | None:
        """A row of one number; None where neither answer has it.

        Parameters
        ----------
        name, kind, unit : str
        read : callable
            The number in a history, in `unit`.
        exact : float, optional
            What the prediction itself says of it.
        floor : float
            What nodes and steps alone leave open at the element size of the simulation.
        size : float, optional
            Of what is to be told apart from nothing: a bar wider than half of it is unresolved.
        """
        at_nodes, simulated = read(self.at_nodes), read(self.seen)
        if at_nodes is None and simulated is None:
            return None
        changes = mesh_changes([simulated, *(read(run.interface) for run in self.coarser)])
        bar = error_bar(kind, changes) + floor if changes else None
        if simulated is None and self.coarser and read(self.coarser[0].interface) is None:
            bar = floor  # it is on none of the meshes
        if bar is not None and self.doubted is not None and at_nodes is not None:
            doubted = read(self.doubted)
            bar = None if doubted is None else bar + abs(at_nodes - doubted)
        row = Row(
            name,
            kind,
            exact,
            at_nodes,
            simulated,
            None if at_nodes is None or simulated is None else simulated - at_nodes,
            bar,
            unit,
            order=observed_order(changes),
        )
        return self.judged(row, size)

    def profile_row(
        self,
        name: str,
        kind: str,
        predicted: Array,
        read: Profile,
        reach: tuple[float, float],
        *,
        exact: float | None = None,
        unseen: float = 0.0,
        scale: tuple[float, str],
        smooth: bool = False,
    ) -> Row:
        """A row of the L1 norms of a field along the contact; its relative error and bar.

        Where the prediction is nothing, below 1e-6 of its scale, the largest values stand in for
        norms, and differences are in the scale.

        Parameters
        ----------
        name, kind : str
        predicted : (n,) or (2, n) array
            The prediction at the nodes, and what its own companion says.
        read : callable
            The field along the contact in a run.
        reach : (float, float)
            Positions between which it is compared [length].
        exact : float, optional
            Norm of the prediction itself, in `unit`.
        unseen : float
            Norm of what is too narrow for the mesh in the prediction, over the scale.
        scale : float and str
            What values are divided by, and its name.
        smooth : bool
            Whether the field has no fronts, and meshes are compared at the nodes of the coarser:
            between those a straight line is further off than its ends.
        """
        low, high = reach
        value, unit = scale
        runs = [self.simulation, *self.coarser]
        places = [(run.interface.x >= low) & (run.interface.x <= high) for run in runs]
        fields = [read(run) / value for run in runs]
        x, shown = self.seen.x, places[0]
        expected, *doubted = np.atleast_2d(predicted) / value
        nothing = float(np.abs(expected[shown]).max(initial=0.0)) <= NOTHING

        def size(field: Array, at: Array) -> float:
            if nothing:
                return float(np.abs(field).max(initial=0.0))
            return norm(field, at / self.length, 1)

        changes = []
        for pair in pairwise(range(len(runs))):
            of, to = pair[::-1] if smooth else pair
            at = runs[of].interface.x[places[of]]
            other = np.interp(at, runs[to].interface.x, fields[to])
            changes.append(size(fields[of][places[of]] - other, at))
        whole = size(expected[shown], x[shown])
        per = 1.0 if nothing else whole
        factor = OPENING if self.opens and kind in OPENING_KINDS else 1.0
        bar = (factor * error_bar(kind, changes) + unseen) / per if changes else None
        if bar is not None:
            bar += NOTHING
            if not nothing:
                bar += LEAST_ERROR + self.error_estimate
                cell = self.simulation.element_size / self.length
                bar += FIELD_FLOOR * cell * float(np.ptp(fields[0][shown])) / per
            bar += sum(size((other - expected)[shown], x[shown]) / per for other in doubted)
        row = Row(
            f"{name}, largest" if nothing else f"{name}, L1",
            kind,
            exact,
            whole,
            size(fields[0][shown], x[shown]),
            size((fields[0] - expected)[shown], x[shown]) / per,
            bar,
            unit if nothing else f"{unit} c_t T",
            relative=not nothing,
            order=observed_order(changes),
        )
        return self.judged(row, None if nothing else 1.0)

    def unseen_norm(self, field: Array, reach: tuple[float, float]) -> float:
        """L1 norm of a part of the prediction at the nodes that is too narrow for the mesh."""
        shown = (self.seen.x >= reach[0]) & (self.seen.x <= reach[1])
        return norm(field[shown], self.seen.x[shown] / self.length, 1)

    def judged(self, row: Row, size: float | None) -> Row:
        """The row, unresolved if the mesh cannot tell: no coarser mesh, or a bar too wide."""
        if self.caution and row.kind not in ("arrival", "pressure"):
            times = max((shortfall.times for shortfall in self.shortfalls), default=0.0)
            finer = math.ceil(times * self.simulation.resolution) or None
            return replace(row, obstacle=self.caution, resolution=finer)
        if row.bar is None:
            reason = "coarser meshes do not show it" if self.coarser else "no coarser mesh was run"
            return replace(
                row,
                obstacle=f"{reason}, so that it has no error bar",
                resolution=2 * self.simulation.resolution,
            )
        if abs(row.difference or 0.0) > row.bar and row.verdict == UNRESOLVED:
            return replace(
                row,
                obstacle=f"it is beyond its error bar, but by less than {ALARM:g} times",
                resolution=2 * self.simulation.resolution,
            )
        if math.isinf(row.bar):
            return replace(row, obstacle="the prediction has not converged")
        if row.verdict == AGREES and size and row.bar > TELLING * size:
            growth = row.bar / (TELLING * size)
            return replace(
                row,
                obstacle=f"its error bar is more than {TELLING:g} of what is compared",
                resolution=math.ceil(growth * self.simulation.resolution),
            )
        return row


def worn_by(answer: Answer, at_nodes: InterfaceHistory) -> tuple[Array, Array]:
    """|slip| accumulated and frictional work per area by an answer until the end, at nodes."""
    return own_wear(answer, at_nodes.x, float(at_nodes.t[-1])) or worn(at_nodes)


def own_wear(answer: Answer, x: Array, end: float) -> tuple[Array, Array] | None:
    """The same at positions until a time, (n,) each, by an answer that has summed it itself."""
    if isinstance(answer, Solution):
        return answer.path(x, end), answer.work_density(x, end)
    if isinstance(answer, Marched):
        own = answer.interface.x
        fields = answer.final_path, answer.final_work_density
        path, work = (np.interp(x, own, field) for field in fields)
        return path, work
    return None


def _companions(simulation: Simulation) -> Iterator[Simulation]:
    """Of a simulation, from fine to coarse."""
    companion = simulation.companion
    while companion is not None:
        yield companion
        companion = companion.companion


def mesh_changes(values: list[float | None]) -> list[float]:
    """Differences from mesh to mesh, from the finest on, as far as all show the value."""
    changes = []
    for fine, coarse in pairwise(values):
        if fine is None or coarse is None:
            break
        changes.append(fine - coarse)
    return changes
