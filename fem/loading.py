"""Slot loads that rise and fall, or move: the load that acts at each time level.

The kick at t_n stands for the interval from t_n - dt/2 to t_n + dt/2, the first one for the half
step after t = 0.  It takes the mean of the load over that interval, so that the impulse is exact
whatever the load does in between; a jump at a time level counts half at that level.

A load whose front moves over the slot, or that an incident wave brings, acts at x from t = p x on.
The finite elements compute what the slot scatters: the uncut body lets the wave through with known
tractions, which the contact carries besides, and which are taken off the slot faces behind the
front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem.interface import Carried, MeshContact
from fem.stepping import MarchedBody
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


def kick_means(history: LoadHistory, step: float, steps: int) -> Array:
    """Return the mean of f(t) over the interval of each kick of a step dt [time], (steps + 1,)."""
    if history.pieces == Step().pieces:
        return np.ones(steps + 1)
    return history.mean(*_kick(np.arange(steps + 1), step))


def _kick(level: ArrayLike, step: float) -> tuple[Array, Array]:
    """Return the beginning and the end of the intervals that kicks at levels stand for [time]."""
    level = np.asarray(level, dtype=float)
    return np.maximum(level - 0.5, 0.0) * step, (level + 0.5) * step


def _spread_mean(history: LoadHistory, delay: Array, level: int, step: float) -> Array:
    """Return the mean of f(t - p x) over a kick and over the places (k, n) of each node, (k,)."""
    start, end = _kick(level, step)
    return np.asarray(history.mean(start - delay, end - delay).mean(axis=1))


@dataclass(frozen=True)
class SlotTractions:
    """The load on a body as a function of time: shear along x or z, pressure along y.

    The amplitude (k,) is dt^2 F / s on its loaded unknowns where f = 1, and means (2, m) are
    factors of shear and pressure at each time level.
    """

    body: MarchedBody
    amplitude: Array
    means: Array

    def set(self, level: int) -> None:
        """Set the body's load to that of a time level."""
        pressed = self.body.loaded % len(self.body.components)
        self.body.load = self.amplitude * self.means[pressed, level]


@dataclass(frozen=True)
class FrontTractions:
    """The load on a body whose front moves over the slot, f(t - p x).

    The amplitude (k,) is dt^2 F / s on its loaded unknowns where f = 1, for the histories f of
    shear and pressure.  Delays (k, n) are times p x >= 0 at which the front reaches places spread
    over the part of the slot that each loaded unknown carries [time]; the step is dt [time].
    """

    body: MarchedBody
    amplitude: Array
    histories: tuple[LoadHistory, LoadHistory]
    delay: Array
    step: float

    def set(self, level: int) -> None:
        """Set the body's load to the mean of the load over the kick and over each node's part."""
        shear, pressure = (
            _spread_mean(history, self.delay, level, self.step) for history in self.histories
        )
        pressed = self.body.loaded % len(self.body.components) == 1
        self.body.load = self.amplitude * np.where(pressed, pressure, shear)


SPREAD = 8
"""Places in the part of the slot of a node over which a front is spread.  A load that moves at half
of c_t enters node by node with 1, and the mesh rings: the error of slip rate at 50 cells is then
6.6 %, with 2, 4 and 8 places 3.3, 3.1 and 2.9 %; a faster load shows no difference."""


def front_delays(x: Array, slowness: float, *, contact: bool = False) -> Array:
    """Return the times p x at which a front reaches the parts of nodes, (k, `SPREAD`).

    Nodes are at x (k,) [length], in any order and any number of times, on the slot or the contact,
    and the slowness p <= 0 [time / length].
    """
    places, which = np.unique(x, return_inverse=True)
    borders = np.concatenate([places[:1], (places[1:] + places[:-1]) / 2, places[-1:]])
    share = (np.arange(SPREAD) + 0.5) / SPREAD
    within = borders[:-1, None] + np.diff(borders)[:, None] * share
    # the mesh's own edge lies beside x = 0, which the front reaches at t = 0
    limited = np.maximum(within, 0.0) if contact else np.minimum(within, 0.0)
    return slowness * limited[which]


@dataclass(frozen=True)
class ContactLoad:
    """The tractions of an incident wave on the uncut contact, f(t - p x), added to the base.

    The contact carries them besides what the simulation computes, which is what the slot scatters.
    Delays (n, k) are times p x <= 0 at which the front reaches places spread over the part of each
    node [time]; the step is dt [time].
    """

    interface: MeshContact
    scene: Scene
    delay: Array
    step: float

    def set(self, level: int) -> None:
        """Set the tractions to their mean over the kick of a time level and each node's part."""
        base, load = self.scene.before_load, self.scene.superposition.taken_off
        pressure, shear = (
            _spread_mean(history, self.delay, level, self.step)
            for history in (self.scene.pressure_history, self.scene.shear_history)
        )
        self.interface.held = Carried(
            base.pressure + load.pressure * pressure, base.shear + load.shear * shear
        )


def contact_loads(scene: Scene, interface: MeshContact, step: float, x: Array) -> list[ContactLoad]:
    """Return what changes with time on the contact itself: an incident wave that is no step.

    The contact's nodes are at x (n,) [length], and the step is dt [time].
    """
    if scene.is_step or not scene.arrives:
        return []
    delay = front_delays(x, scene.front_slowness, contact=True)
    return [ContactLoad(interface, scene, delay, step)]


def slot_loads(
    scene: Scene,
    bodies: list[MarchedBody],
    step: float,
    steps: int,
    places: list[Array],
) -> list[SlotTractions] | list[FrontTractions]:
    """Return the loads of bodies that change with time; none if all are steps that come at once.

    The `load` of each body is the amplitude, and places are the positions x of its loaded unknowns
    (k,) [length]; the step is dt [time].
    """
    histories = (scene.shear_history, scene.pressure_history)
    if scene.front_slowness:
        return [
            FrontTractions(body, body.load, histories, front_delays(x, scene.front_slowness), step)
            for body, x in zip(bodies, places, strict=True)
        ]
    if scene.is_step:
        return []
    means = np.array([kick_means(history, step, steps) for history in histories])
    return [SlotTractions(body, body.load, means) for body in bodies]


class Arrived(NamedTuple):
    """The fields of an incident wave in the uncut body, where there is none 0.

    Attributes
    ----------
    displacement, velocity : (3, n) arrays
        In x, y and z [length] and [length / time].
    stress : dict of (n,) arrays
        Stress by component: xx, yy, xy, xz and yz [stress], tension positive.
    """

    displacement: Array
    velocity: Array
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
        {name: one * value for name, one in wave.stresses(solid).items()},
    )
