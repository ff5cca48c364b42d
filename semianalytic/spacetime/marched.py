"""The result of a space-time march: histories, totals, and the state from which it can go on."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.memory.exponentials import Memory
from semianalytic.results.files import sealed_hdf5, whole_hdf5
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.notebook import html_table
from semianalytic.results.renamed import renamed
from semianalytic.results.sampled import ONSET_SHARE, SampledAnswer, Totals
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.quantities import asked_in_units
from semianalytic.scene.scene import Scene, Tractions, scene_document, scene_from_document
from semianalytic.scene.units import unit
from semianalytic.spacetime.bodies.marched_bodies import MarchedBodies
from semianalytic.spacetime.bodies.tuning import FIELD_POINTS, FIELD_SMOOTHING
from semianalytic.spacetime.grid.resolution import Shortfall, advice, coarse_weakening, missed_zone
from semianalytic.spacetime.tuning import (
    ERROR_SAFETY,
    HIGHEST_ORDER,
    LARGEST_ERROR,
    MEMORY_SAFETY,
    ORDER_SAFETY,
    READING_SAFETY,
)

Array = NDArray[np.float64]

FORMAT = "slipfront march 4"


@dataclass(frozen=True)
class Grid:
    """The nodes x = (i + 1/2) h of a march: `slot` of them on x < 0, the others on the contact.

    Attributes
    ----------
    spacing : float
        Node distance h [length].
    slot, observed, size : int
        Numbers of nodes on the slot, on the observed part of the contact, and in all.
    """

    spacing: float
    slot: int
    observed: int
    size: int

    @property
    def x(self) -> Array:
        """Positions of the observed nodes of the contact (observed,) [length]."""
        return np.asarray((np.arange(self.observed) + 0.5) * self.spacing)

    @property
    def contact(self) -> slice:
        """The slice of all nodes that lie on the contact."""
        return slice(self.slot, self.size)

    @property
    def nodes(self) -> Array:
        """Positions of all nodes, slot included, (size,) [length]."""
        return np.asarray((np.arange(self.size) - self.slot + 0.5) * self.spacing)

    def observe(self, values: Array) -> Array:
        """Return values (..., size) at the observed nodes of the contact, (..., observed)."""
        return values[..., self.slot : self.slot + self.observed]

    @property
    def wavenumbers(self) -> Array:
        """Wavenumbers of the cosines, (size,) [1 / length]."""
        # cos(q x) is even about both ends of a grid of length size h
        return np.asarray(np.pi * np.arange(self.size) / (self.size * self.spacing))


@dataclass(frozen=True, eq=False)
class Extremes:
    """Extremes over every step of a march, stored or not, at the observed nodes.

    Attributes
    ----------
    forward, reverse : (n,) arrays
        Largest slip rate so far, at least 0, and least one, at most 0 [length / time].
    slip : (n,) array
        Largest |slip| so far [length].
    onset : (n,) array
        Time at which slip began [time], inf where it did not: |V| passed 1 % of the largest |V|
        anywhere until then, interpolated linearly between the two levels around that time.
    """

    forward: Array
    reverse: Array
    slip: Array
    onset: Array

    @classmethod
    def at_rest(cls, nodes: int) -> Extremes:
        """Return the extremes at so many nodes before anything happens."""
        rest = np.zeros(nodes)
        return cls(rest, rest, rest, np.full(nodes, np.inf))

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_levels(self, times: Sequence[float], rates: Array, slips: Array) -> Extremes:
        """Return the extremes with k more levels included.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates : (k + 1, n) array
            Slip rates at these [length / time].
        slips : (k, n) array
            Slip at the levels [length].
        """
        forward = np.maximum(self.forward, rates[1:].max(axis=0))
        reverse = np.minimum(self.reverse, rates[1:].min(axis=0))
        slip = np.maximum(self.slip, np.maximum(slips.max(axis=0), -slips.min(axis=0)))
        waiting = np.flatnonzero(np.isinf(self.onset))
        if not len(waiting):
            return Extremes(forward, reverse, slip, self.onset)
        # The threshold of a level uses only what was until then, so that a march that is continued
        # finds the same onsets.
        speeds = np.abs(rates)
        until = np.maximum.accumulate(speeds[1:].max(axis=1))
        threshold = ONSET_SHARE * np.maximum(until, float(self.slip_rate.max()))
        begins = speeds[1:, waiting] > threshold[:, None]
        first = np.argmax(begins, axis=0)
        began = np.flatnonzero(begins[first, np.arange(len(waiting))])
        if not len(began):
            return Extremes(forward, reverse, slip, self.onset)
        level, node, t = first[began], waiting[began], np.asarray(times)
        late, speed = speeds[level, node], speeds[level + 1, node]
        # |V| is linear between the two levels; after a jump, where they are one, onset is now
        rise = np.where(speed > late, speed - late, 1.0)
        share = np.where(speed > late, (threshold[level] - late) / rise, 0.0)
        onset = self.onset.copy()
        onset[node] = t[level] + (t[level + 1] - t[level]) * np.clip(share, 0.0, 1.0)
        return Extremes(forward, reverse, slip, onset)


@dataclass(frozen=True, eq=False)
class MarchState:
    """The state of a march at one time, from which it can be continued.

    Attributes
    ----------
    time : float
        Time reached [time].
    modes : (poles, size) complex array
        Memory of past slip, per pole and cosine [length / time].
    lasting : (size,) array
        Static part of the memory, per cosine [length / time].
    rate : (size,) array
        Relative slip rate, slot included [length / time].
    traction : (size - slot,) array
        Shear traction of the contact [stress].
    slip, path : (size - slot,) arrays
        Slip and accumulated |slip| on the contact [length].
    work : (size - slot,) array
        Frictional work per area of the contact [stress length].
    """

    time: float
    modes: NDArray[np.complex128]
    lasting: Array
    rate: Array
    traction: Array
    slip: Array
    path: Array
    work: Array

    @classmethod
    def at_rest(cls, poles: int, grid: Grid, time: float = 0.0) -> MarchState:
        """Return the state before anything happens, at a time, for so many poles."""
        lasting, contact = np.zeros(grid.size), np.zeros(grid.size - grid.slot)
        modes = np.zeros((poles, grid.size), dtype=complex)
        return cls(time, modes, lasting, lasting, contact, contact, contact, contact)

    def copy(self) -> MarchState:
        """Return a state whose memory can be changed in place."""
        return replace(self, modes=self.modes.copy(), lasting=self.lasting.copy())


@dataclass(frozen=True)
class Departure:
    """The difference between a march and its companion, over the observed contact and time.

    Attributes
    ----------
    difference, slip_rate : float
        Integrals of |V - V of the companion| and of |V| [length^2].
    """

    difference: float = 0.0
    slip_rate: float = 0.0

    @property
    def share(self) -> float:
        """Difference relative to the slip rate, nan where nothing slips."""
        return self.difference / self.slip_rate if self.slip_rate else math.nan


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
class Marched(SampledAnswer):
    """The slip history of an interface by the space-time solver; see `SampledAnswer`.

    `march` returns it.  Fields are known at the stored levels and interpolated linearly between
    them; where `every` is above 1, ask for values at the stored levels, `interface.t`.  Totals are
    known at every step.

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
    grid, memory, state
        The grid, memory kernel and state from which a continuation starts.
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
    >>> from semianalytic import Material, Pulse, Scene, Tractions, march
    >>> solid = Material(shear_modulus=1.0, density=1.0, poisson_ratio=0.25)
    >>> base, load = Tractions(1.0, 0.0), Tractions(0.0, 0.5)
    >>> scene = Scene(solid, 0.2, base, load, shear_history=Pulse(duration=0.5))
    >>> run = march(scene, end_time=1.0, nodes=128)
    >>> [zone.sense for zone in run.zones_at(0.4)]  # the upper side slips towards +x
    [1]
    >>> run.slip_rate([0.1, 0.2], [[0.2], [0.4]]).shape
    (2, 2)
    >>> run.stress(0.5, 0.5, 1.0).shape  # sigma_xx, sigma_yy, sigma_xy
    (3,)
    >>> bool(run.error_of(lambda one: one.max_slip(1.0)) < 0.1 * run.max_slip(1.0))
    True
    """

    scene: Scene
    interface: InterfaceHistory
    totals: Totals
    latest: float
    step_ratio: float
    damping: float
    every: int
    statistics: MarchStatistics
    grid: Grid
    memory: Memory
    state: MarchState
    seen: Extremes
    companion: Marched | None = None
    departure: Departure = Departure()
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
        return self.state.time

    @property
    def error_estimate(self) -> float:
        """Estimate of the relative L1 error of the slip rate, meant as a bound.

        It estimates the integral of |error| over the observed contact and all time until the end,
        divided by that of |slip rate|, as 1.25 times the difference of march and companion, or
        less if a higher than the first `order` was seen.  It is nan without a companion, and inf
        where nothing slips though the edge must.  Under rate weakening no grid is fine enough, and
        it is no bound (docs/spacetime.md, "Friction laws").
        """
        if self.companion is None:
            return math.nan
        # Without slip the ratio is 0 / 0.  That is no error where the edge sticks in the continuum
        # as well, and a total one where K_II exceeds f K_I and the grid misses the zone.
        if self.departure.slip_rate == 0:
            return math.inf if self.departure.difference or self._missed_zone else 0.0
        # Both marches share the error of the memory's transform, which their difference does not
        # show.
        safety = ERROR_SAFETY
        if self.order is not None:
            # difference = (2^order - 1) error, if errors fall as nodes^-order
            safety = min(safety, ORDER_SAFETY / (2 ** min(self.order, HIGHEST_ORDER) - 1))
        return safety * self.departure.share + MEMORY_SAFETY * self.memory.error

    def error_of(self, reading: Callable[[Marched], ArrayLike]) -> Array:
        """Estimate the error of any quantity read off the march, in its unit; meant as a bound.

        The estimate is 1.6 times the difference from the companion, which assumes that the error
        falls with the first power of the node distance or faster.  It is too small at a point where
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
        if self.companion is None:
            return np.full(np.shape(reading(self)), np.nan)
        return READING_SAFETY * np.abs(np.subtract(reading(self), reading(self.companion)))

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
        reach = float(self.grid.x[slips].max(initial=0.0))
        return missed_zone(self.scene, self.end_time, self.grid.spacing, reach)

    @cached_property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """The known reasons why the grid is too coarse; empty if there is none.

        These are slip at the edge over less than five nodes (which would otherwise look like no
        slip), slip weakening on too few nodes, and an error estimate above `rtol`, or above a half.
        """
        every = (
            self._missed_zone,
            coarse_weakening(self.scene, self.grid.spacing),
            self._inaccurate,
        )
        return tuple(one for one in every if one is not None)

    @property
    def _inaccurate(self) -> Shortfall | None:
        """An error estimate above what was asked for, or None."""
        estimate = self.error_estimate
        largest = LARGEST_ERROR if self.rtol is None else self.rtol
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
        sentence = advice(self.shortfalls, "nodes")
        return sentence and f"{sentence}, or shorten `length` as much"

    @property
    def status(self) -> str:
        """The word "resolved", or "unresolved" where there is a `caution`."""
        return "unresolved" if self.caution else "resolved"

    @property
    def has_bodies(self) -> bool:
        """Whether the march knows the fields in the bodies: where no front of a load moves."""
        return isinstance(self.scene.load, Tractions)

    @cached_property
    def _bodies(self) -> MarchedBodies:
        if not self.has_bodies:
            raise SceneError(
                "march: the fields in the bodies under an incident wave or a moving load are not "
                "known from a march; ask `solve`, or simulate the scene (docs/limits.md)."
            )
        return MarchedBodies(self.scene, self.interface)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity anywhere in the bodies [length / time].

        The effect of load jumps on the stuck interface is exact.  The effects of slip, and of loads
        that rise and fall gradually, are as accurate as the march, and are smoothed over a
        hundredth of the distance that waves have travelled.  Points at one time, or at one depth,
        share most of the work: 100,000 at once take seconds.  See docs/spacetime.md, "Fields in the
        bodies".

        Parameters
        ----------
        x, y : arrays
            Positions [length] that broadcast with t: y > 0 is the upper body, y < 0 the lower one,
            0.0 and -0.0 are their faces.
        t : array
            Times [time], up to the end time; until t = 0 the base state is at rest.

        Returns
        -------
        (2, ...) array
            v_x, v_y; in antiplane shear (3, ...), with v_z.

        Raises
        ------
        SceneError
            If a position or a time is not a finite number, a time is later than the march, or waves
            have come from beyond the contact it observed.
        """
        return self._bodies.velocity(x, y, t)

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress anywhere in the bodies, tension positive [stress].

        Parameters and errors are those of `velocity`.

        Returns
        -------
        (3, ...) array
            sigma_xx, sigma_yy, sigma_xy; in antiplane shear (5, ...), with sigma_xz and sigma_yz.
            The base tractions are part of sigma_yy and sigma_xy (or sigma_yz); sigma_xx is the
            change since t = 0.
        """
        return self._bodies.stress(x, y, t)

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement since t = 0 anywhere in the bodies [length].

        Parameters and errors are those of `velocity`.

        Returns
        -------
        (2, ...) array
            u_x, u_y; in antiplane shear (3, ...), with u_z.
        """
        return self._bodies.displacement(x, y, t)

    @cached_property
    def field_error(self) -> float:
        """Estimate of the L1 error of stress in the bodies, relative to the change of stress.

        March and companion are compared at 60 random points, at the end time or when waves have
        crossed the observed contact.  The estimate is nan without a companion.
        """
        reach = self.grid.observed * self.grid.spacing
        # The seed is fixed, so that the estimate of a march is always the same number.
        x, y = reach * np.random.default_rng(0).uniform(-1, 1, (2, FIELD_POINTS))
        end = min(self.end_time, reach / self.scene.fastest_speed)
        # Sums come first: at points that no wave has reached, a ratio would be 0 / 0.
        off = self.error_of(lambda march: march.stress(x, y, end)).sum()
        change = np.abs(self.stress(x, y, end) - self.stress(x, y, 0.0)).sum()
        return float(off / change) + FIELD_SMOOTHING if change else 0.0

    @property
    def final_path(self) -> Array:
        """Accumulated |slip| at the observed nodes until the end (n,) [length]."""
        return self.state.path[: self.grid.observed]

    @property
    def final_work_density(self) -> Array:
        """Energy turned to heat at the observed nodes until the end, per area [stress length]."""
        return self.state.work[: self.grid.observed]

    path = renamed("path", "final_path", "0.3")
    friction_work = renamed("friction_work", "final_work_density", "0.3")

    def __repr__(self) -> str:
        grid, estimate = self.grid, self.error_estimate
        error = "no error estimate" if math.isnan(estimate) else f"error estimate {estimate:.1e}"
        return (
            f"<Marched: to t = {self.end_time:.4g} in {self.statistics.steps} steps, "
            f"{grid.observed} nodes on 0 < x < {grid.observed * grid.spacing:.4g}; {self.status}, "
            f"{error}>"
        )

    def _repr_html_(self) -> str:
        end, units = self.end_time, self.scene.units
        facts = (
            ("largest slip", self.max_slip(end), "length"),
            ("accumulated slip over the contact", self.accumulated_slip(end), "length^2"),
            ("frictional work over the contact", self.frictional_work(end), "stress length^2"),
        )
        rows = [(name, f"{float(value):.6g}", unit(of, units)) for name, value, of in facts]
        caption = repr(self).strip("<>")
        return html_table(caption, ("at the end", "value", "unit"), rows)

    def save(self, path: str | Path) -> None:
        """Write the march as HDF5, to be loaded or continued.

        The file appears under its name only when it is complete.

        Parameters
        ----------
        path : path
            File to write; missing folders are made.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file cannot be written.
        """
        with whole_hdf5(path) as file:
            file.attrs["format"] = FORMAT
            file.attrs["scene"] = json.dumps(scene_document(self.scene))
            self._write(file)
            if self.companion is not None:
                self.companion._write(file.create_group("companion"))

    def _write(self, group: Any) -> None:
        """Write everything but scene and companion into an HDF5 group."""
        for name in _OPTIONS:
            group.attrs[name] = getattr(self, name)
        for name in ("rtol", "order"):
            if getattr(self, name) is not None:
                group.attrs[name] = getattr(self, name)
        if self.entry:
            group.attrs["entry"] = self.entry
        group.attrs["statistics"] = json.dumps(asdict(self.statistics))
        group.attrs["departure"] = json.dumps(asdict(self.departure))
        for name in _GROUPS:
            part = group.create_group(name)
            for field in fields(getattr(self, name)):
                part[field.name] = getattr(getattr(self, name), field.name)

    @classmethod
    def load(cls, path: str | Path) -> Marched:
        """Read a march that `save` wrote.

        Parameters
        ----------
        path : path
            File to read.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file is missing, damaged or not a march.
        """
        try:
            with sealed_hdf5(path) as file:
                if file.attrs.get("format") != FORMAT:
                    raise DataFileError(f"{path} is not a slipfront march; give a file of one.")
                scene = scene_from_document(json.loads(file.attrs["scene"]))
                companion = cls._read(file["companion"], scene) if "companion" in file else None
                return replace(cls._read(file, scene), companion=companion)
        except (OSError, KeyError, TypeError, ValueError, SceneError) as error:
            raise DataFileError(
                f"{path} cannot be read as a march ({error}); march again."
            ) from error

    @classmethod
    def _read(cls, group: Any, scene: Scene) -> Marched:
        """Read what `_write` wrote."""
        parts = {
            name: kind(**{field.name: group[name][field.name][()] for field in fields(kind)})
            for name, kind in _GROUPS.items()
        }
        # HDF5 returns numpy scalars; the grid of a new march holds Python's own numbers.
        parts["grid"] = Grid(
            float(parts["grid"].spacing),
            *(int(getattr(parts["grid"], name)) for name in ("slot", "observed", "size")),
        )
        return cls(
            scene=scene,
            **{name: kind(group.attrs[name]) for name, kind in _OPTIONS.items()},
            statistics=MarchStatistics(**json.loads(group.attrs["statistics"])),
            departure=Departure(**json.loads(group.attrs["departure"])),
            rtol=_number_or_none(group, "rtol"),
            order=_number_or_none(group, "order"),
            entry=float(group.attrs.get("entry", 0.0)),
            **parts,
        )


def _number_or_none(group: Any, name: str) -> float | None:
    return float(group.attrs[name]) if name in group.attrs else None


_OPTIONS = {"latest": float, "step_ratio": float, "damping": float, "every": int}
_GROUPS = {
    "interface": InterfaceHistory,
    "totals": Totals,
    "grid": Grid,
    "memory": Memory,
    "state": MarchState,
    "seen": Extremes,
}
