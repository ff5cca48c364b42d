"""The result of a run: fields of the interface, their error estimates, and a checkpoint."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.grid_edge import MOST_NODES, EdgeReading, read_beside_edge
from semianalytic.dissimilar.kernels import pair_of
from semianalytic.engine.bodies.marched_bodies import MarchedBodies, bodies_on
from semianalytic.engine.bodies.motion import Motion
from semianalytic.engine.on_line import LineAnswer
from semianalytic.engine.stepping.line import fitting_nodes, grid_of
from semianalytic.engine.stepping.state import RunCheckpoint
from semianalytic.engine.stepping.tuning import LEAST_GAP
from semianalytic.results.answer import answer_dataset
from semianalytic.results.datasets import attributes, dataset
from semianalytic.results.saved import read_answer
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]

SAME_TIME = 1e-9
"""Part of the time of a rupture within which two nodes slip at once: far below a step."""
FIELDS = ("slip", "slip_rate", "shear_traction", "state", "pressure", "felt_pressure", "gap")


@dataclass(frozen=True, eq=False)
class LineFields:
    """Fields at the nodes of a line and at the stored times.

    Attributes
    ----------
    x : (n,) array
        Positions of nodes [length]; x >= 0 only if the interface is even.
    touching : (n,) array of bool
        Whether the bodies touch at these nodes.
    t : (m,) array
        Times of the frames [time].
    slip, slip_rate, shear_traction, state : (m, n) arrays
        Slip [length], slip rate [length / time], shear traction [stress] and state of friction;
        the state is nan on slots.
    pressure, gap : (m, n) arrays
        Contact pressure [stress], 0 where the contact is open and on slots, and negative where
        adhesion acts; gap [length], 0 or more on the contact, and the change of their width on
        slots.
    felt_pressure : (m, n) array
        Pressure that friction follows [stress]: that of the contact unless the law has a delay.
    """

    x: Array
    touching: NDArray[np.bool_]
    t: Array
    slip: Array
    slip_rate: Array
    shear_traction: Array
    state: Array
    pressure: Array
    felt_pressure: Array
    gap: Array


@asked_in_units
@dataclass(frozen=True, eq=False)
class Run(LineAnswer):
    """The slip of an interface from t = 0 until the end of a run, with its error estimates.

    Attributes
    ----------
    scene : Scene
        The interface that was computed.
    nodes : int
        Nodes of one period.
    interface : LineFields
        Fields at the nodes and stored times.
    onset : (n,) array
        Time at which slip began [time]: when |slip rate| first exceeded the `slipping` of `run`;
        nan where it never did, and on slots.
    step_times, peak_rates : (steps + 1,) arrays
        Time and largest |slip rate| of the contact after every step.
    error_estimates : mapping
        Estimated relative L1 errors, over frames and contact, of slip, slip rate and the change of
        shear traction, and of gap and pressure if loads change the pressure, from a second run with
        half the nodes; empty if there was no such run.
    status : str
        "done", "unresolved: ...", "interrupted at t = ...", or "interrupted in the estimate of its
        error: ...", whose fields are complete.
    checkpoint : RunCheckpoint
        Everything that `run` needs to continue this run.
    motion : Motion
        Rates of slip and opening of the whole line in every step, which drive the bodies.
    companion : Run or None
        The same run on half the nodes, at the same frames, from which errors are estimated.

    Examples
    --------
    >>> import semianalytic as sf
    >>> patch = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 0.5))
    >>> solid, base = sf.Material(1.0, 1.0, 0.25), sf.Tractions(1.0, 0.0)
    >>> patched = sf.Scene(solid, 0.5, base, patch, contact=sf.Contact(), period=8.0)
    >>> done = sf.solve(patched, end_time=1.0, nodes=64)
    >>> done.slip([0.1, 0.2], 1.0).shape, done.status
    ((2,), 'done')
    """

    saved_as, compression = "run along a line 13", 4

    scene: Scene
    nodes: int
    interface: LineFields
    onset: Array
    step_times: Array
    peak_rates: Array
    status: str
    checkpoint: RunCheckpoint = field(repr=False)
    motion: Motion = field(repr=False)
    error_estimates: Mapping[str, float] = field(default_factory=dict)
    companion: Run | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        slip = self.error_estimates.get("slip")
        error = "no error estimate" if slip is None else f"error of slip {slip:.1e}"
        return (
            f"<Run: to t = {self.end_time:.4g} in {self.steps} steps, {self.nodes} nodes, "
            f"{len(self.interface.t)} frames; {self.status.partition(':')[0]}, {error}>"
        )

    @property
    def end_time(self) -> float:
        """The last time [time]."""
        return float(self.step_times[-1])

    @property
    def is_interrupted(self) -> bool:
        """Whether the run, or the estimate of its error, was ended early."""
        return self.status.startswith("interrupted")

    @property
    def contact_misfit(self) -> float:
        """How far the grid has an end of a contact from its place, over the node distance."""
        return self.scene.contact.misfit(self.scene.period, self.nodes, self.shift)

    @property
    def shift(self) -> float:
        """Distance by which the grid is moved for the ends of contacts [length]."""
        return grid_of(self.scene, self.nodes).shift

    @property
    def caution(self) -> str:
        """A sentence on what limits the accuracy and can be changed; empty if nothing does.

        A grid knows ends of contacts midway between its nodes.  It is moved to have them there
        (`shift`), and displaces those that lie elsewhere still: the error of slip is then that of a
        contact which is longer or shorter.
        """
        contact, length = self.scene.contact, self.scene.period
        run_through = self.scene.fastest_speed * self.end_time
        if contact.ends_with_period and run_through > length / 4:
            free = max(length / 2 - run_through, 0.0)
            return (
                f"the contact ends with the period, and waves from there have arrived beyond |x| = "
                f"{free:.3g}; raise `period` to {4 * run_through:.3g}"
            )
        misfit = self.contact_misfit
        # Slip of a punch of 102 nodes is off by 0.1 % with ends in their places, by 2, 4 and 12 %
        # with 0.1, 0.2 and 0.5 of a node distance.
        if misfit < 0.05:
            return ""
        fitting = fitting_nodes(self.scene, self.nodes, 1)
        remedy = f"choose {fitting} nodes"
        if contact.misfit(length, fitting, grid_of(self.scene, fitting).shift) > misfit / 2:
            remedy = "choose a period of which the ends are simple fractions"
        return (
            f"an end of a contact lies {misfit:.2g} node distances from where the grid has it; "
            f"{remedy}"
        )

    @property
    def work(self) -> dict[str, float]:
        """Work that the contact has taken from the bodies, per width [stress length^2].

        "friction" is the work of slip; "closing" is the work of the pressure on faces that meet,
        which is not negative and tends to 0 as the grid is refined, and that of adhesion, which is
        strength x length / 2 per area that has parted.
        """
        weights = self._weights
        state = self.checkpoint.end
        kept = {"friction": state.work, "closing": state.closing}
        return {name: float(weights @ value) for name, value in kept.items()}

    @cached_property
    def _bodies(self) -> MarchedBodies:
        grid = grid_of(self.scene, self.nodes, self.shift)
        return bodies_on(self.scene, self.motion, grid)

    @property
    def _weights(self) -> Array:
        """Length of the line for which each node stands, (n,) [length]."""
        weights = np.full(len(self.interface.x), self.scene.period / self.nodes)
        if self.scene.even:
            # Nodes at x = 0 and length / 2 are their own mirror images.
            weights[self.interface.x > 0] *= 2
            weights[self.interface.x >= self.scene.period / 2] /= 2
        return weights

    @property
    def slipped_length(self) -> float:
        """Length of the contact on which slip has begun [length]."""
        return float(self._weights @ np.isfinite(self.onset))

    @property
    def rupture_speed(self) -> float:
        """Mean speed of the rupture [length / time], from where slip begins first to where last.

        Where slip begins at several nodes at once, the nearest of them is taken as its origin.  It
        is nan where nothing slips, and where slip begins everywhere at once.
        """
        begun = np.isfinite(self.onset)
        if not begun.any():
            return np.nan
        x, onset, length = self.interface.x[begun], self.onset[begun], self.scene.period
        time = float(np.ptp(onset))
        if time == 0:
            return np.nan
        # Mirror images and nodes of a patch begin together, but for rounding.
        first = x[onset <= onset.min() + SAME_TIME * time]
        last = x[onset >= onset.max() - SAME_TIME * time]
        if self.scene.even:
            first = np.concatenate([first, -first])
        # The line is periodic: a rupture may have come from the next period.
        first = np.sort(np.concatenate([first - length, first, first + length]))
        after = np.searchsorted(first, last)
        return float(np.minimum(last - first[after - 1], first[after] - last).max()) / time

    def at(self, values: Array, x: Any) -> Array:
        """Return a field of the nodes (..., n) at positions x (k,) of the contact, (..., k).

        It is linear between nodes that touch, and nan where the bodies do not touch and beyond the
        period.
        """
        given = np.asarray(x, dtype=float)
        place = np.abs(given) if self.scene.even else given
        nodes, touching = self.interface.x, self.interface.touching
        right = np.clip(np.searchsorted(nodes, place), 1, len(nodes) - 1)
        left = right - 1
        share = np.clip((place - nodes[left]) / (nodes[right] - nodes[left]), 0.0, 1.0)
        # at the end of a contact one of the two nodes is of the slot
        share = np.where(touching[left], share, 1.0)
        share = np.where(touching[right], share, 0.0)
        found = values[..., left] * (1 - share) + values[..., right] * share
        alone = np.where(share == 0, values[..., left], values[..., right])
        found = np.where((share == 0) | (share == 1), alone, found)
        within = np.abs(given) <= self.scene.period / 2
        return np.where(within & self.scene.contact.touches(place), found, np.nan)

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return len(self.step_times) - 1

    def events(self, rate: float) -> list[tuple[float, float]]:
        """Return begin and end of the times in which the peak slip rate exceeds a rate [time]."""
        above = np.concatenate([[False], self.peak_rates > rate, [False]])
        turns = np.flatnonzero(above[1:] != above[:-1])
        begins, ends = turns[::2], turns[1::2] - 1
        return [
            (float(self.step_times[i]), float(self.step_times[j]))
            for i, j in zip(begins, ends, strict=True)
        ]

    def beside_edge(self, edge: float, frame: int = -1) -> EdgeReading:
        """Return the fields next to an edge at which the contact sticks.

        Nodal tractions there are off by 40 % at the first node and by 10 % five nodes on, and those
        of different bodies alternate.  Divided by what a grid makes of a crack tip, and averaged
        over three nodes, they are off by 0.5 to 2 % from the second node on.

        Parameters
        ----------
        edge : float
            Begin or end of a part of the contact [length].
        frame : int
            Index of the time in `t`.

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
        >>> held = sf.Scene(solid, 0.5, sf.Tractions(1, 0), push, contact=contact, period=8.0)
        >>> done = sf.solve(held, end_time=0.5, nodes=128)
        >>> done.beside_edge(2.0).shear_traction[:2].round(3)
        array([0.095, 0.054])
        """
        return _beside_edge(self, edge, frame)

    def to_xarray(self, x: Any = None, t: Any = None) -> Any:
        """Return fields as an `xarray.Dataset` of dimensions t and x, ready for NetCDF.

        Without positions x (n,) and times t (m,) it has all fields of the nodes and frames.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position or time is one that `slip` refuses.
        """
        if x is not None and t is not None:
            return answer_dataset(cast(Any, self), x, t)
        known = self.interface
        data = dataset(known.x, known.t, {name: getattr(known, name) for name in FIELDS})
        data["onset"] = ("x", self.onset, attributes("time", "time of first slip", ""))
        data.attrs.update(status=self.status, nodes=self.nodes, steps=self.steps)
        data.attrs.update({f"error_{name}": value for name, value in self.error_estimates.items()})
        return data

    @classmethod
    def load(cls, path: str | PathLike[str], scene: Scene | None = None) -> Run:
        """Read a run that `save` wrote.

        A scene that has functions of Python, which no file can contain, is given.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file is missing, damaged or not a run, or a run on another contact or period, or
            of a scene with functions of Python, which is not given.
        """
        given: dict[str, Any] = {} if scene is None else {"scene": scene}
        kept = Path(path), cls.saved_as, cls, "a file that this version saved", "compute it again"
        run = read_answer(*kept, **given)
        scene = run.scene
        laid, touching = grid_of(scene, run.nodes).x, scene.contact.touches(run.interface.x)
        known = run.interface
        if not (np.array_equal(known.x, laid) and np.array_equal(touching, known.touching)):
            raise DataFileError(f"{path} is a run of another interface; load it with its own.")
        return run


def _beside_edge(run: Run, edge: float, frame: int) -> EdgeReading:
    known, scene, spacing = run.interface, run.scene, run.scene.period / run.nodes
    ends = [float(end) for part in scene.contact.intervals for end in part]
    near = min(ends, key=lambda end: abs(end - edge))
    if not abs(near - edge) < spacing / 2:
        raise SceneError(
            f"edge: no part of the contact begins or ends at x = {edge:g}; ends are "
            f"{', '.join(f'{end:g}' for end in ends if abs(end) < math.inf) or 'nowhere'}."
        )
    side = 1 if ends.index(near) % 2 == 0 else -1
    inside = np.flatnonzero(known.touching & (side * (known.x - near) > 0))[::side]
    outside = np.flatnonzero(~known.touching & (side * (known.x - near) < 0))[::-side]
    inside, outside = (
        nodes[: min(_unbroken(nodes) // 2, MOST_NODES)] for nodes in (inside, outside)
    )
    if min(len(inside), len(outside)) < _LEAST_READ:
        raise SceneError(
            f"edge: fewer than {2 * _LEAST_READ} nodes lie between x = {near:g} and the next end "
            "of the contact; take more nodes."
        )
    slip = np.abs(known.slip[frame])
    if slip[inside[:_LEAST_READ]].max() > LEAST_GAP * slip[outside[0]]:
        raise SceneError(
            f"edge: the contact slips next to x = {near:g} at t = {known.t[frame]:g}, so that "
            "tractions are not those of a stuck edge; read nodal values."
        )
    base = sampled("scene: shear", scene.base.shear, known.x, spacing)[inside]
    pressed = sampled("scene: pressure", scene.base.pressure, known.x, spacing)[inside]
    shear, gone = (
        known.shear_traction[frame, inside] - base,
        pressed - known.pressure[frame, inside],
    )
    beta = 0.0
    if (pair := pair_of(scene)) is not None:
        beta = pair.sense * pair.kernels.compliance.dundurs
    # x and shear change sign together where the contact lies on the other side
    slot = side * known.slip[frame, outside] + 1j * known.gap[frame, outside]
    distance, traction, depth, motion = read_beside_edge(
        side * shear + 1j * gone, slot, spacing, beta
    )
    return EdgeReading(
        distance,
        side * traction.real + base[1:-1],
        pressed[1:-1] - traction.imag,
        depth,
        side * motion.real,
        motion.imag,
    )


def _unbroken(nodes: NDArray[np.intp]) -> int:
    """Return how many of the nodes, from the first one on, are neighbours of one another."""
    breaks = np.flatnonzero(np.abs(np.diff(nodes)) > 1)
    return int(breaks[0]) + 1 if len(breaks) else len(nodes)


_LEAST_READ = 4
"""Nodes on either side of an edge that must stick, or be free, for its tractions to be read."""
