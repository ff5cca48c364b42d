"""The answer of a march: what happens on the interface, errors, and the fields in both bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.grid_edge import EdgeReading
from semianalytic.engine.beside_edges import EdgeNodes, hidden_force, read_edge
from semianalytic.engine.bodies.marched_bodies import MarchedBodies, bodies_on
from semianalytic.engine.bodies.motion import Motion
from semianalytic.engine.nodes import MarchCheckpoint
from semianalytic.engine.resolution import Shortfall, shortfalls_of
from semianalytic.engine.stepping.line import grid_of
from semianalytic.engine.stepping.state import Extremes
from semianalytic.results.answer import answer_dataset
from semianalytic.results.datasets import attributes
from semianalytic.results.gridded import AnswerInBodies
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.questions import ONSET_SHARE, added_up, onsets_until
from semianalytic.results.reading import SAMPLED_SAFETY
from semianalytic.results.sampled import SampledAnswer, Totals
from semianalytic.results.saved import read_answer
from semianalytic.scene.arguments import asked_in_units, floats_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.scene import Scene

MOST_OFF = 0.1
"""Largest error of the work of stored levels, over that of all steps, with which they add up."""
SAME_TIME = 1e-9
"""Part of the time of a rupture within which two nodes slip at once: far below a step."""


@asked_in_units
@dataclass(frozen=True, eq=False)
class Marched(AnswerInBodies, SampledAnswer):
    """Slip, tractions and gaps on an interface until the end of a march, with error estimates.

    Fields are known at the stored levels and interpolated linearly between them; totals, extremes
    and onsets are those of every step.

    Fields in the bodies follow from slip and opening of the whole line, and are as accurate as the
    march, smoothed over a hundredth of the distance that waves have travelled; next to a slot they
    are refused where waves have come from beyond the observed contact.  Points of one depth, or of
    one time, share most of the work.  See docs/spacetime.md, "Fields in the bodies".

    Attributes
    ----------
    scene : Scene
        The scene that was marched.
    nodes : int
        Nodes of one period of a line, or of the observed contact next to a slot.
    interface : InterfaceHistory
        Fields at the nodes and stored levels; on an even line x >= 0, next to a slot the observed
        contact alone.
    totals : Totals
        Totals of the contact, at the beginning and after every step.
    seen : Extremes
        Largest values and onset times of slip over all steps, stored or not.
    status : str
        Next to a slot "resolved", or "unresolved" where there is a `caution`; on a line "done",
        "unresolved: ...", "interrupted at t = ...", or "interrupted in the estimate of its error:
        ...", whose fields are complete.
    caution : str
        A sentence on what limits the accuracy and can be changed; empty if nothing does.
    checkpoint : MarchCheckpoint
        The state from which the march continues.
    error_estimates : mapping
        Estimated relative L1 errors of the slip rate over contact and time; on a line also of slip
        and the change of shear traction, and of gap and pressure if loads change the pressure.
        Empty without a companion.
    companion : Marched or None
        The same march on half the nodes, from which errors are estimated.  Next to a slot it takes
        half the steps, and stores every other level.
    motion : Motion or None
        Rates of slip and opening of a whole line in every step, which drive the bodies.

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
    >>> bool(run.error_of(lambda march: march.max_slip(1.0)) < 0.1 * run.max_slip(1.0))
    True
    """

    method = "space-time"
    saved_as, compression = "slipfront march 8", 4

    scene: Scene
    nodes: int
    interface: InterfaceHistory
    totals: Totals
    seen: Extremes
    status: str
    checkpoint: MarchCheckpoint = field(repr=False)
    caution: str = ""
    error_estimates: Mapping[str, float] = field(default_factory=dict)
    companion: Marched | None = field(default=None, repr=False)
    motion: Motion | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        estimate = self.error_estimate
        error = "no error estimate" if np.isnan(estimate) else f"error estimate {estimate:.1e}"
        return (
            f"<Marched: to t = {self.end_time:.4g} in {self.steps} steps, {self.nodes} nodes, "
            f"{len(self.interface.t)} levels; {self.status.partition(':')[0]}, {error}>"
        )

    @property
    def end_time(self) -> float:
        """The last time [time]."""
        return float(self.totals.t[-1])

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return len(self.totals.t) - 1

    @property
    def is_interrupted(self) -> bool:
        """Whether the march along a line, or the estimate of its error, was ended early."""
        return self.status.startswith("interrupted")

    @property
    def error_estimate(self) -> float:
        """Estimate of the relative L1 error of the slip rate, meant as a bound.

        It estimates the integral of |error| over the observed contact and all time until the end,
        divided by that of |slip rate|.  It is nan without a companion, and inf where nothing slips
        though the edge must.  Under rate weakening no grid is fine enough, and it is no bound.
        """
        return float(self.error_estimates.get("slip_rate", np.nan))

    @property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """The known reasons why the grid next to a slot is too coarse (`shortfalls_of`)."""
        return () if self.scene.on_line else shortfalls_of(self)

    @property
    def shift(self) -> float:
        """Distance by which the grid of a line is moved for the ends of contacts [length]."""
        return grid_of(self.scene, self.nodes).shift

    @property
    def contact_misfit(self) -> float:
        """Largest displacement of an end of a contact by the grid of a line, over the node
        distance.
        """
        return self.scene.contact.misfit(self.scene.period, self.nodes, self.shift)

    @property
    def spacing(self) -> float:
        """Distance between nodes [length]."""
        return self.checkpoint.grid.spacing

    @property
    def _weights(self) -> Array:
        """Length of the interface for which each node stands, (n,) [length]."""
        return self.checkpoint.grid.weights

    @property
    def work(self) -> dict[str, float]:
        """Work that the contact has taken from the bodies, per width [stress length^2].

        "friction" is the work of slip; "closing" is the work of the pressure on faces that meet,
        which is not negative and tends to 0 as the grid is refined, and that of adhesion, which is
        strength x length / 2 per area that has separated.
        """
        of_slip, meets = self.final_work_density, self.checkpoint.end.closing
        return {
            "friction": float(self._weights @ of_slip),
            "closing": float(self._weights @ meets),
        }

    @cached_property
    def _sums(self) -> tuple[Array, Array]:
        """Path and work that stored levels add up to, (m, n); refused if they pass over work.

        Levels at a few `times` may have passed over most of the slip and its return.
        """
        path, work = added_up(self.interface)
        known, exact = self.interface, self.work["friction"]
        on, weights = known.touching, self._weights[known.touching]
        off = abs(float(work[-1, on] @ weights) - exact)
        # slip of rounding errors does the work of none
        stress = np.abs(known.shear_traction[:, on]).max(initial=0.0)
        none = 1e-9 * stress**2 * self.end_time / self.scene.impedance * weights.sum()
        t = known.t
        if t[0] > 0 or t[-1] < self.end_time or off > MOST_OFF * exact + none:
            raise SceneError(
                "path, work_density: the stored times are too few to add up path and work; leave "
                "out `times`, or lower `every`. The attribute `work` has the work of all steps."
            )
        return path, work

    @property
    def final_path(self) -> Array:
        """Accumulated |slip| at the nodes until the end (n,) [length]."""
        return self.seen.path

    @property
    def final_work_density(self) -> Array:
        """Energy turned to heat at the nodes until the end, per area (n,) [stress length]."""
        on, work = self.interface.touching, np.zeros(len(self.interface.x))
        work[on] = self.checkpoint.end.work[: int(on.sum())]
        return work

    @cached_property
    def _hidden(self) -> float:
        """Part of what drives slip that openings which no node shows take off."""
        return EdgeNodes(self).missed_opening[1] if self.scene.on_line else hidden_force(self)

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        """Return the times at which something begins at the nodes; slip is known at every step."""
        known, seen, least = self.interface, self.seen, self.seen.slipping
        found = seen.onset
        if of == "opening" or share != ONSET_SHARE or (of != "slip" and least is None):
            found = super()._onset(of, share)
        elif of != "slip":
            times, rates = (np.concatenate([rows[:1], rows]) for rows in (known.t, known.slip_rate))
            never, threshold = np.full(len(known.x), np.inf), np.full(len(known.t), least)
            signs = (1, -1) if of == "forward" else (-1, 1)
            mine, other = (onsets_until(never, times, sign * rates, threshold) for sign in signs)
            # the first of both senses is known at every step
            found = np.where((mine <= other) & np.isfinite(mine), found, mine)
        return np.where(known.touching, found, np.inf)

    @property
    def slipped_length(self) -> float:
        """Length of the contact on which slip has begun [length]."""
        return float(self._weights @ np.isfinite(self.seen.onset))

    @property
    def rupture_speed(self) -> float:
        """Mean speed of the rupture [length / time], from where slip begins first to where last.

        Where slip begins at several nodes at once, the nearest of them is taken as its origin.  It
        is nan where nothing slips, and where slip begins everywhere at once.
        """
        begun = np.isfinite(self.seen.onset)
        if not begun.any():
            return np.nan
        x, onset, length = self.interface.x[begun], self.seen.onset[begun], self.scene.period
        time = float(np.ptp(onset))
        if time == 0:
            return np.nan
        # Mirror images and nodes of a patch begin together, but for rounding.
        first = x[onset <= onset.min() + SAME_TIME * time]
        last = x[onset >= onset.max() - SAME_TIME * time]
        if self.scene.even:
            first = np.concatenate([first, -first])
        # A line is periodic: a rupture may have come from the next period.
        first = np.sort(np.concatenate([first - length, first, first + length]))
        after = np.searchsorted(first, last)
        return float(np.minimum(last - first[after - 1], first[after] - last).max()) / time

    def at(self, values: Array, x: ArrayLike) -> Array:
        """Return a field of the nodes (..., n) at positions x (k,) of the contact, (..., k).

        It is linear between nodes that touch, and nan where the bodies do not touch and beyond the
        nodes.
        """
        given = np.asarray(x, dtype=float)
        if values.shape[-1:] != self.interface.x.shape:
            raise SceneError(f"at: values must be one per node in a row, got shape {values.shape}.")
        place = np.abs(given) if self.scene.even else given
        left, right, along = self.interface.beside(place)
        with np.errstate(invalid="ignore"):  # of what is not finite
            found = values[..., left] * (1 - along) + values[..., right] * along
        found = np.where(along == 0, values[..., left], found)
        known = (np.abs(given) <= self._reach) & self.scene.contact.touches(place)
        return np.where(known, found, np.nan)

    def beside_edge(self, edge: float, frame: int = -1) -> EdgeReading:
        """Return the fields next to an edge at which the contact of a line sticks.

        Nodal tractions there are off by 40 % at the first node and by 10 % five nodes on, and those
        of different bodies alternate.  Divided by the field of a crack tip on a grid, and averaged
        over three nodes, they are off by 0.5 to 2 % from the second node on.

        Parameters
        ----------
        edge : float
            Beginning or end of a part of the contact [length].
        frame : int
            Index of the time in `interface.t`.

        Returns
        -------
        EdgeReading
            Up to the middle of the contact and of the slot, at distances from the edge.

        Raises
        ------
        SceneError
            If there is no such edge, fewer than four nodes lie on a side of it, or the contact
            slips next to it.

        Examples
        --------
        >>> import semianalytic as sf
        >>> solid, contact = sf.Material(1, 1, 0.25), sf.Contact([(-2.0, 2.0)])
        >>> push = sf.InterfaceLoad(0.1, on="slot")
        >>> stuck = sf.Scene(solid, 0.5, sf.Tractions(1, 0), push, contact=contact, period=8.0)
        >>> done = sf.solve(stuck, end_time=0.5, nodes=128)
        >>> done.beside_edge(2.0).shear_traction[:2].round(3)
        array([0.095, 0.054])
        """
        return read_edge(self, edge, frame)

    @property
    def nearest_depth(self) -> float:
        """Least distance from the interface at which stress is known: that of nodes [length]."""
        return float(self._bodies.nearest)

    def error_of(self, reading: Callable[[Any], ArrayLike]) -> Array:
        """Estimate the error of any quantity read off the march, in its unit; meant as a bound.

        The estimate is 1.6 times the difference from the companion; it assumes that the error falls
        with the first power of the node distance or faster.  It is too small at a point where
        the two curves cross: take the largest value, or a norm, over several places.

        Parameters
        ----------
        reading : callable
            Function of a march that returns a number or an array, as
            ``lambda march: march.slip(x, t)``.

        Returns
        -------
        array
            The estimate, of the shape of the reading; nan without a companion.
        """
        if (own := floats_of(reading(self))) is None:
            raise SceneError("error_of: reading must return a number or an array of numbers.")
        if self.companion is None:
            return np.full(own.shape, np.nan)
        # The largest slip, at the edge, converges more slowly: errors are 0.1 to 1.7 of this.
        return SAMPLED_SAFETY * np.abs(np.subtract(own, reading(self.coarser)))

    @cached_property
    def coarser(self) -> Any:
        """The companion, whose stress is evaluated as close to the interface as here."""
        assert self.companion is not None
        other = replace(self.companion)
        # where `cached_property` keeps it
        other.__dict__["_bodies"] = replace(other._bodies, nearest=self._bodies.nearest)
        return other

    @cached_property
    def field_error(self) -> float:
        """Estimate of the L1 error of stress in the bodies, relative to the change of stress.

        It is the difference from the companion at 60 random places of 12 depths, no further than
        waves from x = 0 have come, at the end; nan without a companion.
        """
        if self.companion is None:
            return np.nan
        bodies, speed = self._bodies, self.scene.fastest_speed
        reach = min(speed * self.end_time, bodies.followed, bodies.length / 2)
        # The seed is fixed, so that the estimate of a march is always the same number.
        x = reach * np.random.default_rng(0).uniform(-1, 1, (5, 12))
        y = np.linspace(4 * bodies.nearest, reach, 6)
        place, end = (x, np.concatenate([y, -y])), min(self.end_time, reach / speed)
        stress, before = self.stress(*place, end), min(float(bodies.motion.t[0]), 0.0)
        size = float(np.abs(stress - self.stress(*place, before)).sum())
        apart = np.abs(stress - self.coarser.stress(*place, end))
        return float(apart.sum()) / size if size else 0.0

    @cached_property
    def _bodies(self) -> MarchedBodies:
        if self.motion is None:
            from semianalytic.engine.freed import bodies_beside_slot  # which takes a march

            return bodies_beside_slot(self)
        grid = grid_of(self.scene, self.nodes, self.shift)
        return bodies_on(self.scene, self.motion, grid)

    def to_xarray(self, x: Any = None, t: Any = None) -> Any:
        """Return fields as an `xarray.Dataset` of dimensions t and x, ready for NetCDF.

        Without positions x (n,) and times t (m,) it has all fields of the nodes and levels.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position or time is one that `slip` refuses.
        """
        if x is not None and t is not None:
            return answer_dataset(self, x, t)
        data = self.interface.to_xarray()
        data["onset"] = ("x", self.seen.onset, attributes("time", "time of first slip", ""))
        data.attrs.update(status=self.status, nodes=self.nodes, steps=self.steps)
        data.attrs.update({f"error_{name}": value for name, value in self.error_estimates.items()})
        return data

    @classmethod
    def load(cls, path: str | PathLike[str], scene: Scene | None = None) -> Marched:
        """Read a march that `save` wrote.

        If the scene has Python functions, which no file can contain, it must be given.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file is missing, damaged or not a march, or a march on another contact or period,
            or of a scene with Python functions that is not given.
        """
        given: dict[str, Any] = {} if scene is None else {"scene": scene}
        kept = Path(path), cls.saved_as, cls, "a file of one that this version saved", "march again"
        march = read_answer(*kept, **given)
        known, scene = march.interface, march.scene
        if scene.on_line:
            alike = np.array_equal(known.x, grid_of(scene, march.nodes).x)
            if not (alike and np.array_equal(scene.contact.touches(known.x), known.touching)):
                raise DataFileError(f"{path} is a march of another scene; give its own scene.")
        return march
