"""The case of a comparison: a prediction at the nodes of a simulation, and its coarser meshes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import scipy

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER
from compare.comparison.fields.fronts import jump_times
from compare.comparison.measures import EARLY, NOTHING, is_nothing, norm, within, worn
from compare.comparison.mesh_choice import QUIETING, Feature, Prices, short_waves_grow
from compare.comparison.rows import BEYOND
from compare.comparison.scales import contact_fronts, slip_rate_scale, stress_scale
from semianalytic import Marched, Scene, Solution
from semianalytic.engine.resolution import Shortfall
from semianalytic.results.answer import Answer, method_of
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated
from semianalytic.scene.arrays import Array, Mask

if TYPE_CHECKING:
    from fem import Simulation


UNSEEN = 5
"""Least width, in elements or nodes in a row, at which norms count a zone, an opening or a gap as
seen, from the same measurements."""
FIELDS = ("slip_rate", "slip", "shear_traction", "pressure", "gap")
LEAST_PEAK = 1e-4
"""Least value of the peaks to which thresholds are relative, over V₀ or, for gaps, V₀ T."""
MOST_NODES, GROWN = 0.75, 0.9
"""Part of the slipping nodes that have at most the roughness from which growing waves follow, so
that one wrong node does not, and part of the end time from which on it is measured.  Halving the
elements takes it to 0.2 to 0.75 of its value in 20 of 30 drawn pairs, to 1.1 times that in two
with narrow openings, to 1.3 to 16 times in six whose waves grow; over all times one has 0.97."""
EDGE_CELLS = 4
"""Number of elements next to the edge that are left out where fields can be singular."""


WHOLE_STEPS = 1e-6
"""Tolerance for rounding between times of levels and of the ends of windows, in steps, and between
sizes of meshes."""


@dataclass(frozen=True, eq=False)
class Case:
    """A prediction and a simulation, ready to be compared.

    The simulation has its companions; `at_nodes` is the prediction at its nodes and stored times,
    and `doubted` the prediction's companion there, from which its error is estimated, if any.
    """

    prediction: Answer
    simulation: Simulation
    at_nodes: InterfaceHistory
    doubted: InterfaceHistory | None
    rate_order: ClassVar = LARGEST_ORDER
    """Highest order of convergence that is believed of slip rates without later jumps of loads."""
    local: ClassVar = 1.0
    """Error of a place over that which coarser meshes let expect of it."""
    early: ClassVar = EARLY
    """Initial part of the run, over the end time, in which places are left out."""
    beside_motion: ClassVar = math.inf
    """How many times as much it may be next to ends of slip or of openings."""

    @cached_property
    def worn_at_nodes(self) -> tuple[Array, Array]:
        """Predicted accumulated |slip| [length] and frictional work per area [stress length] at the
        end, (n,) each: the prediction's own where it has them, else summed over the times."""
        path, work = (worn_of(part, self.prediction, self.at_nodes) for part in (0, 1))
        return path, work

    @property
    def scene(self) -> Scene:
        """Scene of the simulation."""
        return self.simulation.scene

    @property
    def fastest_speed(self) -> float:
        """Speed of the first wave in the faster body [length / time]."""
        return self.scene.fastest_speed

    @property
    def fronts(self) -> dict[str, float]:
        """Speeds of the signals along the contact [length / time], by name."""
        return contact_fronts(self.scene)

    @property
    def seen(self) -> InterfaceHistory:
        """History of the interface in the simulation."""
        return self.simulation.interface

    @cached_property
    def coarser(self) -> tuple[Simulation, ...]:
        """Companions of the simulation: the same run at element sizes 2h, 4h, ..."""
        return tuple(companions_of(self.simulation))

    @cached_property
    def runs(self) -> tuple[Simulation, ...]:
        """The simulation and its coarser meshes."""
        return (self.simulation, *self.coarser)

    @cached_property
    def expected(self) -> tuple[InterfaceHistory, ...]:
        """Prediction at the nodes and times of each run, as far as the finest mesh reaches."""
        reach = float(self.seen.x[-1])
        coarser = (
            self.prediction.history(
                run.interface.x[within(run.interface.x, 0.0, reach)], run.interface.t
            )
            for run in self.coarser
        )
        return (self.at_nodes, *coarser)

    @property
    def companion(self) -> Answer | None:
        """Companion by which a prediction estimates its own error; None without one."""
        return getattr(self.prediction, "companion", None)

    @property
    def pairs(self) -> Iterator[tuple[InterfaceHistory, InterfaceHistory]]:
        """Pairs of the histories of a mesh and of the next coarser one, from the finest on."""
        return pairwise([self.seen, *(run.interface for run in self.coarser)])

    @property
    def end_time(self) -> float:
        """End time T [time]."""
        return float(self.seen.t[-1])

    @property
    def length(self) -> float:
        """Reference length c_t T [length]."""
        return self.scene.material.shear_speed * self.end_time

    @property
    def rate(self) -> float:
        """Reference slip rate V₀ [length / time]."""
        return slip_rate_scale(self.scene)

    @property
    def stress(self) -> float:
        """Reference stress τ₀ [stress]."""
        return stress_scale(self.scene)

    @property
    def scales(self) -> bool:
        """Whether loads are self-similar, and meshes and steps of coarser runs twice as large: they
        are then this one until a part of its end time, in other units."""
        if not self.scene.is_self_similar or self.simulation.mesh != "squares":
            return False
        sizes = [np.array([run.element_size, run.time_step]) for run in self.runs]
        return all(np.allclose(b, 2 * a, WHOLE_STEPS, 0.0) for a, b in pairwise(sizes))

    @cached_property
    def window(self) -> float:
        """Time over which slip rates are averaged where meshes are compared [time]: the window of
        the coarsest mesh, because shorter means would differ from mesh to mesh."""
        return max(run.rate_window for run in self.runs)

    def mean_rate(self, history: InterfaceHistory, t: Array) -> Array:
        """Mean slip rate of a history over the windows that end at times t (m,), (m, n)."""
        x, t = np.broadcast_arrays(history.x, t[:, None])
        if not self.window:
            return interpolated(history, "slip_rate", x, t)
        ends = (interpolated(history, "slip", x, at) for at in (t, np.maximum(t - self.window, 0)))
        late, early = ends
        return np.asarray((late - early) / np.minimum(self.window, t))

    @cached_property
    def strength_changes(self) -> tuple[Array, ...]:
        """Changes from mesh to mesh of the frictional strength where the contact slips, over τ₀,
        (m, n) each at the nodes and times of the coarser mesh.

        The slip rate over V₀ is the traction that the waves bring less the strength, both over τ₀.
        It therefore has the error of the strength, even where its own change from mesh to mesh is
        small by chance.  The elements of the coarser mesh next to the edge are left out, because
        the pressure can be singular there.
        """
        changes = []
        for (fine, coarse), run in zip(self.pairs, self.coarser, strict=True):
            x, t = np.broadcast_arrays(coarse.x, coarse.t[:, None])
            pressure = np.abs(interpolated(fine, "pressure", x, t) - coarse.pressure)
            slips = np.abs(coarse.slip_rate) > NOTHING * self.rate
            slips &= beyond_edge(coarse.x, run)
            changes.append(self.scene.coefficient * np.where(slips, pressure, 0.0) / self.stress)
        return tuple(changes)

    @cached_property
    def largest_rate(self) -> float:
        """Largest slip rate of the simulation beyond the elements at the edge [length / time], to
        which thresholds are relative; never as small as rounding errors."""
        shown = beyond_edge(self.seen.x, self.simulation)
        seen = float(np.abs(self.seen.slip_rate[:, shown]).max(initial=0.0))
        return max(seen, LEAST_PEAK * self.rate)

    @cached_property
    def largest_gap(self) -> float:
        """Largest gap of the simulation [length], to which thresholds are relative; never as small
        as rounding errors."""
        return max(float(self.seen.gap.max()), LEAST_PEAK * self.rate * self.end_time)

    @cached_property
    def opens(self) -> bool:
        """Whether the contact opens anywhere, predicted or simulated."""
        return bool(self.at_nodes.gap.any() or self.seen.gap.any())

    @property
    def slips(self) -> bool:
        """Whether any slip is predicted at the nodes."""
        return not is_nothing(self.at_nodes.slip_rate, self.rate)

    @property
    def rests(self) -> bool:
        """Whether nothing moves, neither predicted nor simulated."""
        moves = self.slips or self.opens
        return not moves and is_nothing(self.seen.slip_rate, self.rate)

    @cached_property
    def narrow(self) -> Mask:
        """Nodes and times at which slip is predicted in fewer than `UNSEEN` nodes in a row that
        slip one way at that time, (m, n)."""
        least, rate = NOTHING * self.rate, self.at_nodes.slip_rate
        return too_narrow(rate > least) | too_narrow(rate < -least)

    @cached_property
    def narrow_gaps(self) -> Mask:
        """Nodes and times at which no slip is predicted, in gaps between zones that contain fewer
        than `UNSEEN` nodes, (m, n)."""
        slips = np.abs(self.at_nodes.slip_rate) > NOTHING * self.rate
        beside = np.pad(slips, ((0, 0), (1, 1)), constant_values=False)
        inner = np.logical_and(
            np.maximum.accumulate(beside, axis=1),
            np.maximum.accumulate(beside[:, ::-1], axis=1)[:, ::-1],
        )[:, 1:-1]
        return too_narrow(~slips & inner)

    def showing(self, name: str, levels: slice) -> int:
        """Return how many coarser meshes, from 2h on, show how fast slip is, or how wide gaps are.

        A mesh on which a zone or an opening has fewer than `UNSEEN` nodes in a row shows that it is
        there and no more: such gaps are half of the exact one, and slip rates change with no order.
        """
        least, count = NOTHING * self.rate if name == "slip_rate" else 0.0, 0
        for answer in self.expected[1:]:
            moves = np.abs(getattr(answer, name)[levels]) > least
            if moves.any() and not _in_rows(moves):
                break
            count += 1
        return count

    @cached_property
    def shows_motion(self) -> bool:
        """Whether a coarser mesh has `UNSEEN` nodes in a row of what slips or opens, if any does.

        Changes from mesh to mesh are small by chance where each has a node or two of it.
        """
        least = NOTHING * self.rate
        finest, *others = ((np.abs(e.slip_rate) > least) | (e.gap > 0) for e in self.expected)
        return not others or not finest.any() or any(map(_in_rows, others))

    @property
    def error_estimate(self) -> float:
        """Relative error estimate of an exact solution; 0 for any other prediction."""
        exact = method_of(self.prediction) == "self-similar"
        return float(getattr(self.prediction, "error_estimate", 0.0)) if exact else 0.0

    @cached_property
    def amplified(self) -> str:
        """Sentence that errors of this mesh grow with its fineness; "" if they do not.

        Short waves may grow along an interface that slides between different bodies, or under
        friction that falls with slip rate, in proportion to their wave number.  They do so on this
        mesh if slip rates, or pressures, are rougher on it than on that of 2h.
        """
        if len(self.runs) < 2 or not short_waves_grow(self.scene):
            return ""
        different = self.scene.bodies[0] != self.scene.bodies[1]
        fields = ("slip_rate", "pressure") if different else ("slip_rate",)
        rougher = max(self._rougher(name) for name in fields)
        if rougher <= 1:
            return ""
        why = "these bodies slip" if different else "friction falls with slip rate"
        return (
            f"{BEYOND}waves of a few elements grow while {why}: this mesh "
            f"is {rougher:.2g} times as rough as that of 2h; raise `damping`, to 0.2 say, "
            "which damps them"
        )

    def _rougher(self, name: str) -> float:
        """Return how much rougher a field is on this mesh than on that of 2h: by mean second
        differences from node to node at the end, at most nodes that slip; 0 if it is smooth."""
        rough = []
        for history in (run.interface for run in self.runs[:2]):
            late = history.t >= GROWN * history.t[-1]
            slips = np.asarray((np.abs(history.slip_rate[late]) > NOTHING * self.rate).any(axis=0))
            bends = np.abs(np.diff(getattr(history, name)[late], 2, axis=1)).mean(axis=0)
            rough.append(np.quantile(bends[slips[1:-1]], MOST_NODES) if slips[1:-1].any() else 0.0)
        return float(rough[0] / rough[1]) if rough[1] else 0.0

    def norm_of(self, field: Array, reach: tuple[float, float]) -> float:
        """L1 norm of a field at the nodes of the simulation between two positions, over c_t T."""
        shown = within(self.seen.x, *reach)
        return norm(field[shown], self.seen.x[shown] / self.length, 1)

    def nothing(self, kind: str) -> float:
        """Return the largest value of a kind of field that counts as nothing, in its unit."""
        return NOTHING

    def largest_order(self, kind: str) -> float:
        """Return the highest order of convergence that is believed of a kind of field.

        Faces that are loaded suddenly start a part of a step late, which is an error of first order
        in all that follows but slip rates: with 1.25, slip under rate-and-state friction was 1.0 to
        1.2 bars off.  Ahead of an edge of slip the shear traction bends like a square root: that of
        `ramp` shows 1.24, and comes nearer to the march with orders of 0.56 and 0.8.  Where a load
        jumps after t = 0 slip rates jump at its fronts within the contact, which meshes smear over
        an element: of first order as well, 1.39 on the meshes of `pulse`.  Damping spreads fronts
        on slot faces over a length that goes like the root of the elements.
        """
        if kind == "slot" and self.simulation.damping >= QUIETING:
            return LEAST_ORDER
        scene = self.prediction.scene
        histories = () if scene.on_line else scene.acting_histories.values()
        jumps = [at for history in histories for at, _ in history.pieces.jumps]
        late = scene.jumps if scene.on_line else [at for at in jumps if at > 0]
        return 1.0 if late or kind != "slip rate" else self.rate_order

    def compared(self, name: str, number: int) -> Mask:
        """Return the nodes of a run, by number, at which a field is compared over time: beyond the
        elements at the edge, as far as the simulation was recorded."""
        x = self.runs[number].interface.x
        return beyond_edge(x, self.simulation) & within(x, 0.0, float(self.seen.x[-1]))

    def size(self, values: Array, x: Array, t: Array | None) -> float:
        """Return the L1 norm of a field over places, (n,), and times, (m, n), if given, over c_t T
        and T."""
        return norm(values, x / self.length, 1, None if t is None else t / self.end_time)

    def unit(self, name: str) -> tuple[float, str, str]:
        """Return divisor and unit of a field, and the unit of its norm over places and times."""
        if name in ("slip", "gap"):
            return self.rate * self.end_time, "V₀ T", "V₀ c_t T³"
        return (self.rate, "V₀", "V₀ c_t T²") if name == "slip_rate" else (self.stress, "τ₀", "")

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the fields that are compared place by place."""
        return (*FIELDS[:-1], *(["gap"] if self.opens else []))

    def place(self, level: int, node: int) -> str:
        """Return the words for a place and a time of the simulation."""
        x, t = self.seen.x[node] / self.length, self.seen.t[level] / self.end_time
        return f"x = {x:.3f} c_t T, t = {t:.3f} T"

    @property
    def shear_speed(self) -> float:
        """Shear wave speed of the upper body [length / time]."""
        return self.scene.material.shear_speed

    def beside_fronts(self, width: float) -> Mask:
        """Mask of the nodes and times, (m, n), within a width of the edge and of fronts that the
        loads send out."""
        seen, scene = self.seen, self.scene
        beside = np.broadcast_to(seen.x < width, seen.slip.shape).copy()
        for start in {0.0, *jump_times(scene, width / self.shear_speed)}:  # t = 0 even without jump
            for speed in self.fronts.values():
                beside |= np.abs(seen.x - speed * (seen.t[:, None] - start)) < width
        return beside

    @property
    def caution(self) -> str:
        """Warning of what the simulation or the march is too coarse for; "" if there is nothing."""
        reasons = [shortfall.reason for shortfall in self.shortfalls]
        return self.simulation.caution or "; ".join(f"the march: {reason}" for reason in reasons)

    @property
    def finer(self) -> int:
        """Resolution of a mesh twice as fine."""
        return 2 * self.simulation.resolution

    @property
    def needed(self) -> int | None:
        """Resolution with which a march would not be too coarse; None if it is not."""
        times = max((shortfall.times for shortfall in self.shortfalls), default=0.0)
        return math.ceil(times * self.simulation.resolution) or None

    def remedy(self, resolution: int) -> str:
        """Return what such a resolution may do and what it takes, in words."""
        run = self.simulation
        options = {name: getattr(run, name) for name in ("damping", "mesh")}
        prices = Prices(run.scene, run.end_time, options=options)
        return prices.unseen(Feature("", resolution)).advice

    @property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """Shortfalls of a marched prediction: what its nodes are too coarse for."""
        return getattr(self.prediction, "shortfalls", ())


def beyond_edge(x: Array, run: Simulation) -> Mask:
    """Mask of the positions (n,) that are beyond the elements of a run next to the edge.

    The limit is a quarter of an element further out, where neither this mesh nor one of half its
    element size has a node, so that rounding does not decide.
    """
    return np.asarray(x > (EDGE_CELLS + 0.25) * run.element_size)


def too_narrow(parts: Mask, least: int = UNSEEN) -> Mask:
    """Mask of the parts that fewer than so many nodes in a row belong to, (m, n)."""
    return parts & ~scipy.ndimage.binary_opening(parts, np.ones((1, least), dtype=bool))


def _in_rows(moves: Mask) -> bool:
    """Whether any nodes are set that are not `too_narrow`."""
    return bool((moves & ~too_narrow(moves)).any())


def worn_of(part: int, answer: Answer, at_nodes: InterfaceHistory) -> Array:
    """Accumulated |slip| (part 0) or frictional work per area (1) of an answer at the end of its
    history, at nodes: its own where it has them, else summed over the times."""
    own = own_wear(answer, at_nodes.x, float(at_nodes.t[-1]), part)
    return worn(at_nodes)[part] if own is None else own


def own_wear(answer: Answer, x: Array, end: float, part: int) -> Array | None:
    """Accumulated |slip| (part 0) or frictional work per area (1) at positions until a time, (n,),
    as the answer itself has summed it; None if it has not."""
    if isinstance(answer, Solution):
        return (answer.path, answer.work_density)[part](x, end)
    if isinstance(answer, Marched):
        fields = answer.final_path, answer.final_work_density
        return np.interp(x, answer.interface.x, fields[part])
    return None


def companions_of(simulation: Simulation) -> Iterator[Simulation]:
    """Companions of a simulation, from fine to coarse."""
    companion = simulation.companion
    while companion is not None:
        yield companion
        companion = companion.companion
