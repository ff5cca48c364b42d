"""The exact answer at the records of another code, and how far a grid would smear it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.records.record import AFTER
from semianalytic import Scene, solve
from semianalytic.methods import chosen
from semianalytic.results.answer import Answer, method_of
from semianalytic.results.interruption import whole
from semianalytic.scene.arrays import Array, Mask

POINT = "point"
"""Kind of a slip rate that is the one at its time, and no mean over a step."""
CLOSEST = 0.25
"""Part of the distance to an end of the contact that a station is moved to at most."""
FRONT_STEP = 1e-3
"""Step, over T, whose mean stands for a slip rate that is infinite."""
MARCH_NODES = 800


@dataclass(frozen=True)
class Sampling:
    """Meaning of a recorded slip rate: a value at its time, or a mean over a step."""

    # `POINT`, or `BEFORE` or `AFTER`: the mean over a step before or after its time
    kind: str = POINT
    step: float | None = None  # that step [time]; None for the distance of samples


AT_TIME = Sampling()


@dataclass(frozen=True, eq=False)
class Exact:
    """An answer until the end of the records."""

    scene: Scene
    answer: Answer
    end_time: float  # T, that of the last record [time]
    _known: dict[tuple[str, float, bytes, Sampling], Array] = field(
        default_factory=dict, init=False
    )

    def record(self, name: str, x: float, t: Array, sampling: Sampling = AT_TIME) -> Array:
        """One of `QUANTITIES` at a position of the contact and times t (n,), in units of the scene.

        Slip rate may be a mean over steps.
        """
        key = (name, x, t.tobytes(), sampling)
        if key not in self._known:
            t, mean = np.minimum(t, self.end_time), name == "slip_rate" and sampling.kind != POINT
            values = self._mean_rate(x, t, sampling) if mean else getattr(self.answer, name)(x, t)
            if not np.isfinite(values).all():  # slip rate as the end of a patch passes
                near = self._mean_rate(x, t, Sampling(AFTER, FRONT_STEP * self.end_time))
                values = np.where(np.isfinite(values), values, near)
            self._known[key] = np.asarray(values)
        return self._known[key]

    def _mean_rate(self, x: float, t: Array, sampling: Sampling) -> Array:
        """Means over steps, which end with the answer."""
        if sampling.step is not None:
            width = np.full(len(t), sampling.step)
        else:
            steps = np.diff(t)
            width = np.append(steps, steps[-1:])
            width = width if sampling.kind == AFTER else np.append(steps[:1], steps)
        start = t if sampling.kind == AFTER else t - width
        start, stop = (np.minimum(end, self.end_time) for end in (start, start + width))
        moved = self.answer.slip(x, stop) - self.answer.slip(x, start)
        rate = np.asarray(self.answer.slip_rate(x, t))
        return np.divide(moved, stop - start, out=rate.copy(), where=stop > start)

    def smeared(self, name: str, x: float, t: Array, band: float) -> tuple[Array, ...]:
        """Return records that a grid may see instead: a band [length] early, late, near and far."""
        late = band / self.scene.material.shear_speed
        half = self.scene.period / 2
        ends = next((own for own in self.scene.contact.intervals if own[0] < x < own[1]), (x, x))
        begin, end = (CLOSEST * x + (1 - CLOSEST) * end for end in np.clip(ends, -half, half))
        records = [self.record(name, x, t + shift) for shift in (-late, late)]
        places = max(x - band, begin), min(x + band, end)
        return (*records, *(self.record(name, place, t) for place in places))

    def unit(self, name: str) -> float:
        """Return the unit of a quantity: τ₀, V₀ or V₀ T."""
        rate = slip_rate_scale(self.scene)
        units = {"slip_rate": rate, "slip": rate * self.end_time}
        return units.get(name, stress_scale(self.scene))

    def doubt(self, name: str, x: float, t: Array) -> float:
        """Mean error over time of the answer itself, by its own estimate, in the unit of `name`."""
        t = np.minimum(t, self.end_time)
        if method_of(self.answer) == "space-time":
            answer: Any = self.answer
            error = answer.error_of(lambda march: getattr(march, name)(x, t))
            return float(np.nan_to_num(error).mean())
        return float(getattr(self.answer, "error_estimate", 0.0)) * self.unit(name)


def farthest(scene: Scene, end_time: float) -> float:
    """Return how far from x = 0 a record until an end time may be compared [length]."""
    if scene.on_line:
        return scene.period / 2
    return max(body.longitudinal_speed for body in scene.bodies) * end_time


def compared(scene: Scene, x: ArrayLike, end_time: float) -> Mask:
    """Return which positions (n,) lie on the contact, where waves come until an end time."""
    x = np.asarray(x, dtype=float)
    return scene.contact.touches(x) & (np.abs(x) <= farthest(scene, end_time))


def exact_answer(scene: Scene, end_time: float, reach: float) -> Exact:
    """Solve a scene for records until an end time [time] and as far as `reach` [length]."""
    if chosen(scene).name == "self-similar":
        answer: Answer = solve(scene)
    elif scene.on_line:
        answer = whole(solve(scene, end_time=end_time))
        scene = answer.scene  # whose line has a length
    else:
        length = max(1.25 * reach, scene.material.shear_speed * end_time)
        answer = whole(solve(scene, end_time=end_time, nodes=MARCH_NODES, length=length))
    return Exact(scene, answer, end_time)
