"""Slot loads that rise and fall, or move: the load that acts at each time level.

The kick at t_n stands for the interval from t_n - dt/2 to t_n + dt/2, the first one for the half
step after t = 0.  It takes the mean of the load over that interval, so that the impulse is exact
whatever the load does in between; a jump at a time level counts half at that level.

A load whose front moves over the slot, or that an incident wave brings, acts at x from t = p x on.
The finite elements compute what the slot scatters: the uncut body lets the wave through with known
tractions, which the contact carries in addition, and which are taken off the slot faces behind the
front.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fem.interface import KickTractions
from semianalytic.scene.arrays import Array
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.scene import Scene


def kick_means(history: LoadHistory, step: float, steps: int) -> Array:
    """Return the mean of f(t) over the interval of each kick of a step dt [time], (steps + 1,)."""
    if history.pieces == Step().pieces:
        return np.ones(steps + 1)
    return history.mean(*kick_interval(np.arange(steps + 1), step))


def kick_interval(level: ArrayLike, step: float) -> tuple[Array, Array]:
    """Return the beginning and the end of the intervals that kicks at levels stand for [time]."""
    level = np.asarray(level, dtype=float)
    return np.maximum(level - 0.5, 0.0) * step, (level + 0.5) * step


SPREAD = 8
"""Places in the part of the slot of a node over which a front is spread.  A load that moves at half
of c_t enters node by node with 1, and the mesh rings: the error of slip rate at 50 cells is then
6.6 %, with 2, 4 and 8 places 3.3, 3.1 and 2.9 %; a faster load shows no difference."""


def front_delays(x: Array, slowness: float, *, contact: bool = False) -> Array:
    """Return the times p x at which a front reaches the parts of nodes, (k, `SPREAD`).

    Nodes are at x (k,) [length], increasing, on the slot or the contact, and the slowness p <= 0
    [time / length].
    """
    borders = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    share = (np.arange(SPREAD) + 0.5) / SPREAD
    within = borders[:-1, None] + np.diff(borders)[:, None] * share
    # the mesh's own edge lies next to x = 0, which the front reaches at t = 0
    return slowness * (np.maximum(within, 0.0) if contact else np.minimum(within, 0.0))


class SceneTractions:
    """The tractions of each kick under a scene's load, on the nodes of its contact and slot.

    The time step is dt [time], and steps are the kicks after the first one.
    """

    def __init__(
        self, scene: Scene, step: float, steps: int, contact_x: Array, slot_x: Array
    ) -> None:
        self.step, self.before = step, scene.before_load
        self.in_place, self.load = scene.superposition
        self.histories = scene.shear_history, scene.pressure_history
        slowness = scene.front_slowness
        self.delay = front_delays(slot_x, slowness) if slowness else None
        # an incident wave that is no step changes the tractions of the contact as well
        arrives = scene.arrives and not scene.is_step
        self.beyond = front_delays(contact_x, slowness, contact=True) if arrives else None
        self.means = [kick_means(history, step, steps) for history in self.histories]

    def __call__(self, level: int) -> KickTractions:
        """Return the tractions of a kick, means over its time and over the part of each node."""
        in_place, load = self.in_place, self.load
        shear: float | Array
        pressure: float | Array
        shear, pressure = self.means[0][level], self.means[1][level]
        if self.delay is not None:
            shear, pressure = self._spread(self.delay, level)
        along, across = load.shear * shear, -load.pressure * pressure
        if self.beyond is None:
            return KickTractions(in_place.pressure, in_place.shear, along, across)
        shear, pressure = self._spread(self.beyond, level)
        carried = (
            self.before.pressure + load.pressure * pressure,
            self.before.shear + load.shear * shear,
        )
        return KickTractions(*carried, along, across)

    def _spread(self, delay: Array, level: int) -> tuple[Array, Array]:
        """Return the means of both f(t - p x) over a kick and the places (k, n) of each node."""
        start, end = kick_interval(level, self.step)
        shear, pressure = (
            np.asarray(history.mean(start - delay, end - delay).mean(axis=1))
            for history in self.histories
        )
        return shear, pressure


class Arrived(NamedTuple):
    """The fields of an incident wave in the uncut body, where there is none 0."""

    # (3, n) arrays: in x, y and z [length] and [length / time]
    displacement: Array
    velocity: Array
    # dict of (n,) arrays: stress by component: xx, yy, xy, xz and yz [stress], tension positive
    stress: dict[str, Array]


def arrived_wave(scene: Scene, x: Array, y: Array, t: float) -> Arrived | None:
    """Return what an incident wave does at points (n,) [length] of the uncut body at t [time].

    None without one.  The simulation computes what the slot scatters of it, so that this is to be
    added.
    """
    wave, solid = scene.load, scene.material
    if not isinstance(wave, IncidentWave):
        return None
    n_x, n_y = wave.direction()
    lag = t - (n_x * x + n_y * y) / wave.speed(solid)
    # both histories of a wave are the same
    history = next(iter(scene.acting_histories.values()), Step())
    # the value after a jump: a front that sits on a node has passed it, as in `Solution.velocity`
    value = history.pieces.value(np.nextafter(lag, np.inf))
    along = wave.particle_velocity(solid) * np.array(wave.polarisation())[:, None]
    return Arrived(
        along * history.pieces.integral(lag),
        along * value,
        {name: stress * value for name, stress in wave.stresses(solid).items()},
    )
