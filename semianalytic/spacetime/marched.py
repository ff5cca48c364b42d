"""What a space-time march leaves: histories, sums along the interface, and where to go on from."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.files import sealed_hdf5, whole_hdf5
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import SampledAnswer, Totals
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.scene import Scene, scene_document, scene_from_document
from semianalytic.spacetime.exponentials import Memory
from semianalytic.spacetime.marched_bodies import MarchedBodies
from semianalytic.spacetime.resolution import (
    Shortfall,
    advice,
    coarse_weakening,
    missed_zone,
)
from semianalytic.spacetime.tuning import (
    ERROR_SAFETY,
    FIELD_POINTS,
    FIELD_SMOOTHING,
    LARGEST_ERROR,
    MEMORY_SAFETY,
    ONSET_SHARE,
    READING_SAFETY,
)

Array = NDArray[np.float64]

FORMAT = "slipfront march 4"


@dataclass(frozen=True)
class Grid:
    """Nodes (i + 1/2) h: `slot` of them on x < 0, the others on the contact.

    Attributes
    ----------
    spacing : float
        h [length].
    slot, observed, size : int
        Nodes on the slot, on the part of the contact that was asked for, and in all.
    """

    spacing: float
    slot: int
    observed: int
    size: int

    @property
    def x(self) -> Array:
        """Observed positions on the contact (observed,) [length]."""
        return np.asarray((np.arange(self.observed) + 0.5) * self.spacing)

    @property
    def contact(self) -> slice:
        """The nodes of the contact among all of them."""
        return slice(self.slot, self.size)

    def observe(self, values: Array) -> Array:
        """Values (size,) at the observed nodes of the contact, (observed,)."""
        return values[self.slot : self.slot + self.observed]

    @property
    def wavenumbers(self) -> Array:
        """Of the cosines, (size,) [1 / length]."""
        return np.asarray(np.pi * np.arange(self.size) / (self.size * self.spacing))


@dataclass(frozen=True, eq=False)
class Extremes:
    """What every step of a march adds to, stored or not; (n,) arrays at the observed nodes.

    Attributes
    ----------
    forward, reverse : largest and least slip rate so far, 0 or beyond [length / time].
    slip : largest |slip| so far [length].
    onset : when slip began [time], inf where it did not: when |V| passed 1 % of the largest |V|
        that there had been anywhere until then, linear between the two levels around it.
    """

    forward: Array
    reverse: Array
    slip: Array
    onset: Array

    @classmethod
    def at_rest(cls, nodes: int) -> Extremes:
        """Before anything happens."""
        rest = np.zeros(nodes)
        return cls(rest, rest, rest, np.full(nodes, np.inf))

    @property
    def slip_rate(self) -> Array:
        """Largest |slip rate| (n,) [length / time]."""
        return np.maximum(self.forward, np.abs(self.reverse))

    def with_level(
        self, before: float, now: float, old: Array, new: Array, slip: Array
    ) -> Extremes:
        """With one more level: slip rates at it and at the level before it, and slip."""
        forward, reverse = np.maximum(self.forward, new), np.minimum(self.reverse, new)
        threshold = ONSET_SHARE * max(float(forward.max()), -float(reverse.min()))
        late, speed = np.abs(old), np.abs(new)
        begins = (speed > threshold) & np.isinf(self.onset)
        onset = self.onset
        if begins.any():
            onset, late, speed = onset.copy(), late[begins], speed[begins]
            rise = np.where(speed > late, speed - late, 1.0)
            share = np.where(speed > late, (threshold - late) / rise, 0.0)
            onset[begins] = before + (now - before) * np.clip(share, 0.0, 1.0)
        return Extremes(forward, reverse, np.maximum(self.slip, np.abs(slip)), onset)


@dataclass(frozen=True, eq=False)
class MarchState:
    """Where a march is.

    Attributes
    ----------
    time : float
        [time].
    modes : (poles, size) complex array
        Memory of the past, per pole and cosine [length / time].
    lasting : (size,) array
        Its static part, per cosine [length / time].
    rate : (size,) array
        Relative slip rate, slot included [length / time].
    traction : (size - slot,) array
        Shear traction of the contact [stress].
    slip, path : (size - slot,) arrays
        On the contact: slip and accumulated |slip| [length].
    work : (size - slot,) array
        On the contact: frictional work per area [stress length].
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
    def at_rest(cls, poles: int, grid: Grid) -> MarchState:
        """Before anything happens."""
        lasting, contact = np.zeros(grid.size), np.zeros(grid.size - grid.slot)
        modes = np.zeros((poles, grid.size), dtype=complex)
        return cls(0.0, modes, lasting, lasting, contact, contact, contact, contact)

    def copy(self) -> MarchState:
        """A state of which the memory can be changed in place."""
        return replace(self, modes=self.modes.copy(), lasting=self.lasting.copy())


@dataclass(frozen=True)
class Departure:
    """How far a march is from its companion: integrals over the observed contact and time.

    Attributes
    ----------
    difference, slip_rate : float
        Of |V - V of the companion| and of |V| [length^2].
    """

    difference: float = 0.0
    slip_rate: float = 0.0


@dataclass(frozen=True)
class MarchStatistics:
    """What a march cost.

    Attributes
    ----------
    steps : int
    nodes : int
        Of the whole grid.
    poles : int
        Exponentials that carry the memory.
    memory_error : float
        Relative error of their transform.
    seconds : dict
        By stage: setup, steps.
    """

    steps: int
    nodes: int
    poles: int
    memory_error: float
    seconds: dict[str, float]


@dataclass(frozen=True, eq=False)
class Marched(SampledAnswer):
    """Slip history of the interface by the space-time solver; see `SampledAnswer`.

    Fields are those of the stored levels, and linear between them; where `every` is above 1 ask
    for what lies on levels, `interface.t`.  Totals are those of every step.

    Attributes
    ----------
    scene : Scene
    interface : InterfaceHistory
        At the observed nodes and stored levels.
    totals : Totals
        Of the observed contact, at t = 0 and after every step.
    latest : float
        Time to which it can go on [time].
    step_ratio, damping, every : float, float, int
        Options of the march, which a continuation keeps.
    statistics : MarchStatistics
    grid, memory, state
        What a continuation starts from.
    seen : Extremes
        Largest values and beginnings of slip over all steps, stored or not.
    companion : Marched or None
        The same march on half the nodes in half the steps, to the same time: what an answer may be
        off by is seen in the difference (see `error_of`).  It stores every other of the levels.
    departure : Departure
        From the companion.
    rtol : float or None
        The error that was asked for.
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

    @property
    def end_time(self) -> float:
        """Time reached [time]."""
        return self.state.time

    @property
    def error_estimate(self) -> float:
        """Estimate, meant as a bound, of the error of the slip rate: L1, relative.

        The integral of the error's size over the observed contact and all time until the end, over
        that of |slip rate|.  nan without a companion; inf where nothing slips though the edge must.
        No bound under rate weakening, where no grid is fine enough (docs/spacetime.md).
        """
        if self.companion is None:
            return math.nan
        if self.departure.slip_rate == 0:
            return math.inf if self.departure.difference or self._missed_zone else 0.0
        share = self.departure.difference / self.departure.slip_rate
        return ERROR_SAFETY * share + MEMORY_SAFETY * self.memory.error

    def error_of(self, reading: Callable[[Marched], ArrayLike]) -> Array:
        """Estimate, meant as a bound, of the error of anything read off the march, in its unit.

        From what the companion says instead, which takes the error to fall with the first power of
        the node distance or faster.  Where two curves cross it is too small: take the largest, or a
        norm, of a reading over several places.

        Parameters
        ----------
        reading : callable
            Of a march, as ``lambda march: march.slip(x, t)``; a number or an array.

        Returns
        -------
        array
            Of the shape of the reading; nan without a companion.
        """
        if self.companion is None:
            return np.full(np.shape(reading(self)), np.nan)
        return READING_SAFETY * np.abs(np.subtract(reading(self), reading(self.companion)))

    @cached_property
    def _missed_zone(self) -> Shortfall | None:
        slips = self.seen.slip_rate > 0
        reach = float(self.grid.x[slips].max(initial=0.0))
        return missed_zone(self.scene, self.end_time, self.grid.spacing, reach)

    @cached_property
    def shortfalls(self) -> tuple[Shortfall, ...]:
        """What the grid is too coarse for, as far as is known.

        Slip at the edge over less than four nodes, told in place of an answer of "no slip"; slip
        weakening on too few nodes; an error estimate above `rtol`, or above a half.
        """
        every = (
            self._missed_zone,
            coarse_weakening(self.scene, self.grid.spacing),
            self._inaccurate,
        )
        return tuple(one for one in every if one is not None)

    @property
    def _inaccurate(self) -> Shortfall | None:
        estimate = self.error_estimate
        largest = LARGEST_ERROR if self.rtol is None else self.rtol
        if not largest < estimate < math.inf:
            return None
        limit = "" if self.rtol is None else f", above the `rtol` of {self.rtol:.1e}"
        return Shortfall(
            f"the error of the slip rate is estimated as {estimate:.1e}{limit}", estimate / largest
        )

    @property
    def caution(self) -> str:
        """What the grid is too coarse for and what would do, as a sentence; "" if nothing is."""
        sentence = advice(self.shortfalls, "nodes")
        return sentence and f"{sentence}, or shorten `length` as much"

    @property
    def status(self) -> str:
        """ "resolved", or "unresolved" where there is a `caution`."""
        return "unresolved" if self.caution else "resolved"

    @cached_property
    def _bodies(self) -> MarchedBodies:
        return MarchedBodies(self.scene, self.interface)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Particle velocity anywhere in the bodies [length / time].

        Jumps of the loads on the stuck interface are exact; what slip does, and what loads do that
        rise and fall, is as accurate as the march, and smoothed over a hundredth of what waves have
        come through.  Points of one time, or of one depth, share most of the work: 100,000 at once
        take seconds.

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
        """Stress anywhere in the bodies, tension positive [stress]; otherwise as `velocity`.

        Returns
        -------
        (3, ...) array
            sigma_xx, sigma_yy, sigma_xy; in antiplane shear (5, ...), with sigma_xz and sigma_yz.
            The base tractions are part of sigma_yy and sigma_xy (or sigma_yz); sigma_xx is the
            change since t = 0.
        """
        return self._bodies.stress(x, y, t)

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Displacement since t = 0 anywhere in the bodies [length]; otherwise as `velocity`.

        Returns
        -------
        (2, ...) array
            u_x, u_y; in antiplane shear (3, ...), with u_z.
        """
        return self._bodies.displacement(x, y, t)

    @cached_property
    def field_error(self) -> float:
        """Estimate of the error of stress in the bodies: L1, relative to what has changed.

        From what the companion says at some points, at the end or when waves have come through the
        observed contact; nan without a companion.
        """
        reach = self.grid.observed * self.grid.spacing
        x, y = reach * np.random.default_rng(0).uniform(-1, 1, (2, FIELD_POINTS))
        end = min(self.end_time, reach / self.scene.fastest_speed)
        off = self.error_of(lambda march: march.stress(x, y, end)).sum()
        change = np.abs(self.stress(x, y, end) - self.stress(x, y, 0.0)).sum()
        return float(off / change) + FIELD_SMOOTHING if change else 0.0

    @property
    def final_path(self) -> Array:
        """|slip| accumulated at the observed nodes until the end (n,) [length]."""
        return self.state.path[: self.grid.observed]

    @property
    def final_work_density(self) -> Array:
        """Energy turned to heat at the observed nodes until the end, per area [stress length]."""
        return self.state.work[: self.grid.observed]

    def __repr__(self) -> str:
        grid, estimate = self.grid, self.error_estimate
        error = "no error estimate" if math.isnan(estimate) else f"error estimate {estimate:.1e}"
        return (
            f"<Marched: to t = {self.end_time:.4g} in {self.statistics.steps} steps, "
            f"{grid.observed} nodes on 0 < x < {grid.observed * grid.spacing:.4g}; {self.status}, "
            f"{error}>"
        )

    def save(self, path: str | Path) -> None:
        """Write all of it as HDF5, to be loaded or continued; whole or not at all."""
        with whole_hdf5(path) as file:
            file.attrs["format"] = FORMAT
            file.attrs["scene"] = json.dumps(scene_document(self.scene))
            self._write(file)
            if self.companion is not None:
                self.companion._write(file.create_group("companion"))

    def _write(self, group: Any) -> None:
        """Write all but scene and companion into an HDF5 group."""
        for name in _OPTIONS:
            group.attrs[name] = getattr(self, name)
        if self.rtol is not None:
            group.attrs["rtol"] = self.rtol
        group.attrs["statistics"] = json.dumps(asdict(self.statistics))
        group.attrs["departure"] = json.dumps(asdict(self.departure))
        for name in _GROUPS:
            part = group.create_group(name)
            for field in fields(getattr(self, name)):
                part[field.name] = getattr(getattr(self, name), field.name)

    @classmethod
    def load(cls, path: str | Path) -> Marched:
        """Read what `save` wrote.

        Raises
        ------
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
        """What `_write` wrote."""
        parts = {
            name: kind(**{field.name: group[name][field.name][()] for field in fields(kind)})
            for name, kind in _GROUPS.items()
        }
        parts["grid"] = Grid(
            float(parts["grid"].spacing),
            *(int(getattr(parts["grid"], name)) for name in ("slot", "observed", "size")),
        )
        return cls(
            scene=scene,
            **{name: kind(group.attrs[name]) for name, kind in _OPTIONS.items()},
            statistics=MarchStatistics(**json.loads(group.attrs["statistics"])),
            departure=Departure(**json.loads(group.attrs["departure"])),
            rtol=float(group.attrs["rtol"]) if "rtol" in group.attrs else None,
            **parts,
        )


_OPTIONS = {"latest": float, "step_ratio": float, "damping": float, "every": int}
_GROUPS = {
    "interface": InterfaceHistory,
    "totals": Totals,
    "grid": Grid,
    "memory": Memory,
    "state": MarchState,
    "seen": Extremes,
}
