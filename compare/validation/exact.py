"""The exact answer at the records of another code, and how far a grid would smear it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from compare.comparison.scales import slip_rate_scale, stress_scale
from semianalytic import Marched, Scene, Solution
from semianalytic.prediction import chosen_method, predict
from semianalytic.results.answer import Answer

Array = NDArray[np.float64]

POINT, BEFORE, AFTER = "point", "before", "after"
"""What a recorded slip rate is: that at its time, or the mean over the step before or after it."""
CLOSEST = 0.25
"""Part of the distance to the edge that a station is moved to at most."""
MARCH_NODES = 800


@dataclass(frozen=True, eq=False)
class Exact:
    """An answer until the end of the records.

    Attributes
    ----------
    scene : Scene
    answer : Solution or Marched
    end_time : float
        T, that of the last record [time].
    """

    scene: Scene
    answer: Answer
    end_time: float
    _known: dict[tuple[str, float, bytes, str], Array] = field(default_factory=dict, init=False)

    def record(self, name: str, x: float, t: Array, mean: str = POINT) -> Array:
        """One of `QUANTITIES` at a position x > 0 and times t (n,), in units of the scene.

        Slip rate may be the mean over the steps between times.
        """
        key = (name, x, t.tobytes(), mean)
        if key not in self._known:
            self._known[key] = self._record(name, x, np.minimum(t, self.end_time), mean)
        return self._known[key]

    def _record(self, name: str, x: float, t: Array, mean: str) -> Array:
        if name == "slip_rate" and mean != POINT:
            return self._mean_rate(x, t, mean)
        return np.asarray(getattr(self.answer, name)(x, t))

    def _mean_rate(self, x: float, t: Array, mean: str) -> Array:
        steps = np.diff(t)
        ends = np.append(t, t[-1] + steps[-1]) if mean == AFTER else np.append(t[0] - steps[0], t)
        slip = self.answer.slip(x, np.minimum(ends, self.end_time))
        width = np.diff(ends)
        return np.diff(slip) / np.where(width > 0, width, 1.0)

    def smeared(self, name: str, x: float, t: Array, band: float) -> tuple[Array, ...]:
        """What a grid may leave of a record that it sees by a band [length] too near, too far, too
        early or too late."""
        late = band / self.scene.material.shear_speed
        near = max(x - band, CLOSEST * x)
        records = [self.record(name, x, t + shift) for shift in (-late, late)]
        return (*records, *(self.record(name, place, t) for place in (near, x + band)))

    def unit(self, name: str) -> float:
        """What counts as one of a quantity: τ₀, V₀ or V₀ T."""
        rate = slip_rate_scale(self.scene)
        units = {"slip_rate": rate, "slip": rate * self.end_time}
        return units.get(name, stress_scale(self.scene))

    def doubt(self, name: str, x: float, t: Array) -> float:
        """Largest error of the answer itself, that of a march by its companion."""
        companion = getattr(self.answer, "companion", None)
        if companion is None:
            return 0.0
        t = np.minimum(t, self.end_time)
        return float(np.abs(getattr(companion, name)(x, t) - self.record(name, x, t)).mean())


def exact_answer(scene: Scene, end_time: float, reach: float) -> Exact:
    """Solve a scene for records until an end time [time] and as far as `reach` [length].

    Raises
    ------
    SceneError, ComputationError
        As `predict`.
    """
    if chosen_method(scene) == "self-similar":
        answer: Solution | Marched = predict(scene)
    else:
        length = max(1.25 * reach, scene.material.shear_speed * end_time)
        answer = predict(scene, end_time, nodes=MARCH_NODES, length=length)
    return Exact(scene, answer, end_time)
