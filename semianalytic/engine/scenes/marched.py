"""The result of a space-time march: histories, totals, and the state from which it can go on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.beside_edges import film_error, hidden_openings
from semianalytic.engine.bodies.marched_bodies import MarchedAnswer, MarchedBodies
from semianalytic.engine.convergence import MEMORY_SAFETY, Departure, safety
from semianalytic.engine.resolution import (
    WEAKENING_NODES,
    ZONE_NODES,
    Shortfall,
    rounded_up,
    zone_at_edge,
)
from semianalytic.engine.scenes.nodes import ContactGrid
from semianalytic.engine.stepping.blocks import Reached
from semianalytic.memory.exponentials import Memory
from semianalytic.memory.line_memory import Past
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.questions import ONSET_SHARE, onsets_until
from semianalytic.results.sampled import SampledAnswer, Totals
from semianalytic.results.saved import read_answer
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.contact import process_zone
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]

SMALLEST = 1e-300
"""Least divisor of a relative error, where nothing slips."""


@dataclass(frozen=True, eq=False)
class Extremes:
    """Extremes over every step of a march, stored or not, at the observed nodes.

    Attributes
    ----------
    forward, reverse : (n,) arrays
        Largest slip rate so far, at least 0, and least one, at most 0 [length / time].
    onset : (n,) array
        Time at which slip began [time], inf where it did not: |V| passed 1 % of the largest |V|
        anywhere until then, interpolated linearly between the two levels around that time.
    """

    forward: Array
    reverse: Array
    onset: Array

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_levels(self, times: Sequence[float], rates: Array) -> Extremes:
        """Return the extremes with k more levels included.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates : (k + 1, n) array
            Slip rates at these [length / time].
        """
        forward = np.maximum(self.forward, rates[1:].max(axis=0))
        reverse = np.minimum(self.reverse, rates[1:].min(axis=0))
        # The threshold of a level uses only what was until then, so that a march that is continued
        # finds the same onsets.
        speeds = np.abs(rates)
        until = np.maximum.accumulate(speeds[1:].max(axis=1))
        threshold = ONSET_SHARE * np.maximum(until, float(self.slip_rate.max()))
        return Extremes(forward, reverse, onsets_until(self.onset, times, speeds, threshold))


@dataclass(frozen=True)
class MarchStatistics:
    """The cost of a march.

    Attributes
    ----------
    steps : int
        Number of time steps.
    nodes : int
        Number of nodes of the whole grid.
    poles : int
        Number of exponentials that carry the memory.
    memory_error : float
        Relative error of their transform.
    seconds : dict
        Seconds by stage: "setup" and "steps".
    """

    steps: int
    nodes: int
    poles: int
    memory_error: float
    seconds: dict[str, float]


@asked_in_units
@dataclass(frozen=True, eq=False)
class Marched(MarchedAnswer, SampledAnswer):
    """The slip history of an interface by the space-time solver; see `SampledAnswer`.

    `march` returns it.  Fields are known at the stored levels and interpolated linearly between
    them; where `every` is above 1, ask for values at the stored levels, `interface.t`.  Totals are
    known at every step.

    In the bodies the effect of load jumps on the stuck interface is exact.  The effects of slip,
    and of loads that rise and fall gradually, are as accurate as the march, and are smoothed over a
    hundredth of the distance that waves have travelled; they are refused where waves have come from
    beyond the observed contact.  Points at one time, or at one depth, share most of the work:
    100,000 at once take seconds.  See docs/spacetime.md, "Fields in the bodies".

    Attributes
    ----------
    scene : Scene
        The scene that was marched.
    interface : InterfaceHistory
        Fields at the observed nodes and stored levels.
    totals : Totals
        Totals of the observed contact, at t = 0 and after every step.
    latest : float
        Time to which the march can go on [time].
    step_ratio, damping, every : float, float, int
        Options of the march, which a continuation keeps.
    statistics : MarchStatistics
        Steps, nodes, poles and seconds.
    grid, memory, reached, past
        Grid, memory kernel, and the state and past slip from which a continuation starts.
    seen : Extremes
        Largest values and onset times of slip over all steps, stored or not.
    companion : Marched or None
        The same march on half the nodes in half the steps, to the same time.  The difference
        between the two indicates the error (see `error_of`).  It stores every other level.
    departure : Departure
        Difference from the companion.
    rtol : float or None
        The error that was asked for.
    order : float or None
        Order of convergence seen between this march and a coarser one, if `rtol` asked for both.
    entry : float
        Distance from the tip at which a load that comes along the slot begins [length], else 0.

    Examples
    --------
    >>> from semianalytic import Material, Pulse, Scene, Tractions, solve
    >>> solid = Material(shear_modulus=1.0, density=1.0, poisson_ratio=0.25)
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 0.5)
    >>> scene = Scene(solid, 0.2, base, load, shear_history=Pulse(duration=0.5))
    >>> run = solve(scene, end_time=1.0, nodes=128)
    >>> [zone.sense for zone in run.zones_at(0.4)]  # the upper side slips towards +x
    [1]
    >>> run.slip_rate([0.1, 0.2], [[0.2], [0.4]]).shape
    (2, 2)
    >>> run.stress(0.5, 0.5, 1.0).shape  # sigma_xx, sigma_yy, sigma_xy
    (3,)
    >>> bool(run.error_of(lambda one: one.max_slip(1.0)) < 0.1 * run.max_slip(1.0))
    True
    """

    method = "space-time"
    saved_as = "slipfront march 6"

    scene: Scene
    interface: InterfaceHistory
    totals: Totals
    latest: float
    step_ratio: float
    damping: float
    every: int
    statistics: MarchStatistics
    grid: ContactGrid
    memory: Memory
    reached: Reached
    past: Past
    seen: Extremes
    companion: Marched | None = None
    departure: Departure = field(default_factory=Departure)
    rtol: float | None = None
    entry: float = 0.0
    order: float | None = None

    @property
    def begins(self) -> float:
        """Time at which the load begins [time]: before 0 if it comes along the slot."""
        return -max(self.scene.front_slowness, 0.0) * self.entry

    @property
    def recorded_from(self) -> float:
        """First time of the record [time]: 0, or before it if waves of the load come earlier."""
        return self.begins if self.scene.front_too_slow else 0.0

    @property
    def end_time(self) -> float:
        """Time reached [time]."""
        return self.reached.time

    @property
    def error_estimate(self) -> float:
        """Estimate of the relative L1 error of the slip rate, meant as a bound.

        It estimates the integral of |error| over the observed contact and all time until the end,
        divided by that of |slip rate|, as 1.25 times the difference of march and companion, or less
        if a higher than the first `order` was seen.  It is nan without a companion, and inf where
        nothing slips though the edge must.  Under rate weakening no grid is fine enough, and it is
        no bound.
        """
        if self.companion is None:
            return math.nan
        apart = self.departure
        # Without slip the ratio is 0 / 0.  That is no error where the edge sticks in the continuum
        # as well, and a total one where K_II exceeds f K_I and the grid misses the zone.
        if apart.slip_rate == 0:
            return math.inf if apart.difference or self._missed_zone is not None else 0.0
        # Both marches share the error of the memory's transform, which their difference does not
        # show.
        of_grids = safety(self.order) * apart.share + MEMORY_SAFETY * self.memory.error
        return of_grids + self._of_film + self._hidden

    @cached_property
    def _of_film(self) -> float:
        """Error of the slip rate at the edge of a film, over all of it, at the stored levels."""
        rates, slope = self.interface.slip_rate, self.scene.law.steady_slope()
        if not slope or self.grid.observed == 1:
            return 0.0
        wrong = film_error(rates[:, 0], rates[:, 1], slope, self.scene.impedance)
        return float(wrong.sum() / max(np.abs(rates).sum(), SMALLEST))

    @cached_property
    def _hidden(self) -> float:
        """Force that openings which no node shows take off slip, over that which drives it."""
        scene, known, spacing = self.scene, self.interface, self.grid.spacing
        held, load = scene.superposition
        left = held.pressure - load.pressure * scene.pressure_history.value(known.t)
        shear, slips = known.shear_traction, known.slip_rate[:, 0] != 0
        force = hidden_openings(known.pressure[:, 0], left, shear[:, 0], spacing, 0.0)[1][slips]
        driving = spacing * np.abs(shear - held.shear).sum()
        return float(force.sum() / max(force.sum() + driving, SMALLEST))

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        """Return the times at which something begins at the nodes; slip is known at every step."""
        # `Extremes` knows this onset at every step; all others are read off the stored levels.
        at_every_step = of == "slip" and share == ONSET_SHARE
        return self.seen.onset if at_every_step else super()._onset(of, share)

    @cached_property
    def _missed_zone(self) -> Shortfall | None:
        """A slip zone at the edge that the grid does not resolve, or None."""
        # Any slip ever seen counts: a zone may have been on the grid and have healed since.
        slips = self.seen.slip_rate > 0
        least = ZONE_NODES * self.grid.spacing
        # The march's own record is asked first, because it costs nothing.
        if float(self.grid.x[slips].max(initial=0.0)) >= least:
            return None
        zone = zone_at_edge(self.scene, self.end_time)
        if not 0 < zone < least:
            return None
        return Shortfall(
            f"the edge slips over a length of about {zone:.2g}, which nodes "
            f"{self.grid.spacing:.2g} apart do not resolve",
            least / zone,
        )

    @property
    def _coarse_weakening(self) -> Shortfall | None:
        """Slip weakening on too few nodes, or None."""
        zone = process_zone(self.scene)
        nodes = zone / self.grid.spacing
        if nodes >= WEAKENING_NODES:
            return None
        return Shortfall(
            f"friction weakens within about {zone:.2g} of length, over {nodes:.2g} nodes where "
            f"{WEAKENING_NODES:g} resolve it",
            WEAKENING_NODES / nodes,
        )

    @cached_property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """The known reasons why the grid is too coarse; empty if there is none.

        These are slip at the edge over less than five nodes (which would otherwise look like no
        slip), slip weakening on too few nodes, and an error estimate above `rtol`, or above a half.
        """
        every = self._missed_zone, self._coarse_weakening, self._inaccurate
        return tuple(known for known in every if known is not None)

    @property
    def _inaccurate(self) -> Shortfall | None:
        """An error estimate above what was asked for, or None."""
        estimate = self.error_estimate
        # 420 random marches were off by at most 0.86 of their estimates, but for one at 0.75 that
        # missed almost all slip; 0.3 refuses one in forty more, mostly good ones.
        largest = 0.5 if self.rtol is None else self.rtol
        # nan (no companion) and inf (a missed zone, which has its own sentence) fail both sides.
        if not largest < estimate < math.inf:
            return None
        limit = "" if self.rtol is None else f", above the `rtol` of {self.rtol:.1e}"
        return Shortfall(
            f"the error of the slip rate is estimated as {estimate:.1e}{limit}", estimate / largest
        )

    @property
    def caution(self) -> str:
        """A sentence that says why the grid is too coarse and what would do; "" if it is not."""
        if not self.shortfalls:
            return ""
        reasons = "; ".join(shortfall.reason for shortfall in self.shortfalls)
        times = rounded_up(max(shortfall.times for shortfall in self.shortfalls))
        return f"{reasons}; raise `nodes` {times} times, or shorten `length` as much"

    @property
    def status(self) -> str:
        """The word "resolved", or "unresolved" where there is a `caution`."""
        return "unresolved" if self.caution else "resolved"

    @cached_property
    def _bodies(self) -> MarchedBodies:
        from semianalytic.engine.scenes.freed import bodies_beside_slot  # which takes a march

        return bodies_beside_slot(self)

    @property
    def final_path(self) -> Array:
        """Accumulated |slip| at the observed nodes until the end (n,) [length]."""
        return self.reached.state[: self.grid.observed]

    @property
    def final_work_density(self) -> Array:
        """Energy turned to heat at the observed nodes until the end, per area [stress length]."""
        return self.reached.work[: self.grid.observed]

    def __repr__(self) -> str:
        grid, estimate = self.grid, self.error_estimate
        error = "no error estimate" if math.isnan(estimate) else f"error estimate {estimate:.1e}"
        return (
            f"<Marched: to t = {self.end_time:.4g} in {self.statistics.steps} steps, "
            f"{grid.observed} nodes on 0 < x < {grid.observed * grid.spacing:.4g}; {self.status}, "
            f"{error}>"
        )

    @classmethod
    def load(cls, path: str | Path) -> Marched:
        """Read a march that `save` wrote.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file is missing, damaged or not a march.
        """
        return read_answer(path, cls.saved_as, cls, "a file of one", "march again")
