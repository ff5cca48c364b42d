"""Slot loads that rise and fall: the load that acts at each time level.

The kick at t_n stands for the interval from t_n - dt/2 to t_n + dt/2, the first one for the half
step after t = 0.  It takes the mean of the load over that interval, so that the impulse is exact
whatever the load does in between; a jump at a time level counts half at that level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.stepping import Body
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.scene import Scene


def kick_means(history: LoadHistory, step: float, steps: int) -> NDArray[np.float64]:
    """Return the mean of f(t) over the interval of each kick, (steps + 1,).

    Parameters
    ----------
    history : LoadHistory
        The history f.
    step : float
        dt [time].
    steps : int
        Number of steps.
    """
    if history.pieces == Step().pieces:
        return np.ones(steps + 1)
    levels = np.arange(steps + 1)
    return history.mean(np.maximum(levels - 0.5, 0.0) * step, (levels + 0.5) * step)


@dataclass(frozen=True)
class SlotLoad:
    """The load on a body as a function of time: shear along x or z, pressure along y.

    Parameters
    ----------
    body : Body
    amplitude : (k,) array
        dt^2 F / s on its loaded unknowns where f = 1.
    means : (2, m) array
        Factors of shear and pressure at each time level.
    """

    body: Body
    amplitude: NDArray[np.float64]
    means: NDArray[np.float64]

    def set(self, level: int) -> None:
        """Set the body's load to that of a time level."""
        pressed = self.body.loaded % len(self.body.components)
        self.body.load = self.amplitude * self.means[pressed, level]


def slot_loads(scene: Scene, bodies: list[Body], step: float, steps: int) -> list[SlotLoad]:
    """Return the loads of bodies that change with time; none if all loads are steps.

    Parameters
    ----------
    scene : Scene
    bodies : list of Body
        Their `load` is the amplitude.
    step : float
        dt [time].
    steps : int
        Number of steps.
    """
    if scene.is_step:
        return []
    histories = (scene.shear_history, scene.pressure_history)
    means = np.array([kick_means(history, step, steps) for history in histories])
    return [SlotLoad(body, body.load, means) for body in bodies]
