"""Fits of interfaces: runs in place of solutions, and derivatives by differences of runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from semianalytic.engine.march import march
from semianalytic.engine.marched import Marched
from semianalytic.engine.stepping.line import with_period
from semianalytic.engine.stepping.tuning import NODES
from semianalytic.inversion.gauges import INTERFACE, Gauge
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.trials import Trials
from semianalytic.inversion.unknowns import Setup, Unknowns, is_of_setup
from semianalytic.parameters.numbers import Number, numbers_of
from semianalytic.results.interruption import whole
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.sampling import sampled
from semianalytic.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A run of a scene as gauges see it, at any position and time."""

    scene: Scene
    run: Marched

    @property
    def edge_speeds(self) -> Array:
        """No edge is known to be at constant speed."""
        return np.array([])

    @property
    def error_estimate(self) -> float:
        """Error of runs from which the step of differences follows."""
        return 1e-3  # a run changes by 1e-4 when its steps fall elsewhere

    @property
    def status(self) -> str:
        """ "converged", or what to distrust of the run."""
        return "converged" if self.run.status == "done" else self.run.status

    def __getattr__(self, name: str) -> Any:
        """Return what is that of the run; records of the interface begin before the load."""
        if name not in INTERFACE:
            return getattr(self.run, name)
        base = self.scene.base
        before = dict(
            zip(INTERFACE, (self.scene.rate, 0.0, base.shear, base.pressure), strict=True)
        )
        return partial(self._since, name, before[name])

    def _since(self, name: str, before: Any, x: Array, t: Array) -> Array:
        """Return a field of the run, and before the load what was in place."""
        early = sampled(name, before, np.asarray(x, dtype=float))
        found = getattr(self.run, name)(x, np.clip(t, 0.0, self.run.end_time))
        return np.where(t < 0, early, found)


@dataclass(frozen=True)
class LineUnknowns(Unknowns):
    """Unknowns of a fit of an interface."""

    scene: Any

    @cached_property
    def known(self) -> dict[str, Number]:
        """The parameters of the interface."""
        return numbers_of(self.scene)

    def value(self, name: str) -> float:
        """Return the value at which the search begins."""
        return super().value(name) if is_of_setup(name) else self.known[name].value

    def _least(self, name: str) -> float:
        if is_of_setup(name):
            return super()._least(name)
        scene = self.scene
        return {
            "length": 0.01 * self.scene.period,
            "time": 0.1 * self.duration,
            "stress": 0.1 * self._stress,
            "length / time": 0.1 * self._stress / scene.impedance,
            "stress time / length": 0.1 * scene.impedance,
            "angle": 5.0,
        }.get(self.known[name].dimension, 0.1)

    @property
    def _stress(self) -> float:
        """The largest traction before loads [stress]."""
        scene = self.scene
        # Fields along x may be functions; a hundredth of the period shows their largest value well
        # enough for a size.
        x = np.linspace(-self.scene.period / 2, self.scene.period / 2, 101)
        x = x[scene.contact.touches(x)]
        fields = (scene.base.pressure, scene.base.shear)
        return max(float(np.abs(sampled("", field, x)).max(initial=0.0)) for field in fields) or 1.0

    def size(self, name: str) -> float:
        """Return the size by which an unknown is divided: its value, or one that would matter."""
        value = abs(self.value(name))
        return value if value > 0 and not is_of_setup(name) else super().size(name)

    def bounds(self, name: str) -> tuple[float, float]:
        """Return the least and largest admissible value of an unknown."""
        if is_of_setup(name) or name == "poisson_ratio":
            return super().bounds(name)
        if name.endswith("poisson_ratio"):
            return super().bounds("poisson_ratio")
        if name.startswith("contact_"):
            # The ends of a contact stay within one period.
            half = self.scene.period / 2
            return -half, half
        # Numbers that a file names for its expressions may mean anything, and so may be negative.
        named = self.known[name].targets[0][0][-1] == name
        if name != "base_pressure" and (
            name.endswith(("shear", "rate", "plate_rate", "pressure", "angle", "at", "factor"))
            or named
        ):
            return -math.inf, math.inf
        return (1e-3 * self.size(name), math.inf) if self.value(name) > 0 else (0.0, math.inf)

    def plausible(self, name: str) -> tuple[float, float]:
        """Return the range that a search without a prior considers."""
        if is_of_setup(name):
            return super().plausible(name)
        value, size = self.value(name), self.size(name)
        if name.endswith("poisson_ratio"):
            return 0.02, 0.48
        if name.startswith("contact_"):
            return value - 10 * self._least(name), value + 10 * self._least(name)
        low, high = sorted((value / 3, 2.5 * value)) if value else (-size, size)
        least, largest = self.bounds(name)
        return max(low, least), min(high, largest)


@dataclass
class LineTrials(Trials):
    """Trials of unknowns of an interface."""

    marched, kept = True, 3

    lengthens: bool = False
    """Whether the period follows from the end of the march."""

    def _solve(self, scene: Any) -> Any:
        return recorded(scene, scene.run.get("nodes", NODES), estimate=False)

    def final(self, scaled: Array) -> Any:
        """Return the run of the result, with its error estimates."""
        scene: Any = self.at(scaled)[0]
        return recorded(scene, scene.run.get("nodes", NODES), estimate=True)

    def finer(self, solution: Any) -> Any:
        """Return the run on twice the nodes."""
        scene = solution.scene
        return recorded(scene, 2 * scene.run.get("nodes", NODES), estimate=False)

    def passage(self, solution: Any, x: Array) -> tuple[Array, Array]:
        """Return slip and shear traction of the nodes nearest to x (k,) in all frames, (m, k)."""
        known = solution.run.interface
        apart = np.abs(known.x[:, None] - (np.abs(x) if solution.scene.even else x))
        apart[~known.touching] = np.inf
        at = apart.argmin(axis=0)
        return known.slip[:, at], known.shear_traction[:, at]

    def asking(self, gauges: tuple[Gauge, ...], setup: Setup) -> LineTrials:
        """Return trials of the same unknowns, for what other gauges would record."""
        unknowns, scene = self.unknowns, self.unknowns.scene
        # derivatives with respect to the time of the load ask a little later
        end = max(float(gauge.t[-1] + gauge.half_interval[-1]) for gauge in gauges) - setup.t0
        if end > scene.run["end_time"]:
            settings = {**scene.run, "end_time": end}
            if self.lengthens:  # at the same node distance
                longer = with_period(replace(scene, period=math.inf), end)
                nodes = settings.get("nodes", NODES) * longer.period / scene.period
                settings["nodes"], scene = 4 * math.ceil(nodes / 4), longer
            scene = replace(scene, run=settings)
        asked = replace(self, unknowns=replace(unknowns, scene=scene), samples=Samples(gauges))
        # scenes are equal however long they are marched
        return replace(asked, progress=None, _known={}, _last=None)


def recorded(scene: Scene, nodes: int, estimate: bool) -> RecordedRun:
    """Run an interface for gauges; errors are those of `march`."""
    options = {
        key: value
        for key, value in scene.run.items()
        if key not in ("nodes", "rtol", "every", "frames", "times")
    }
    # Between these times all is linear.
    done = whole(march(scene, nodes=nodes, frames=1000, estimate=estimate, **options))
    return RecordedRun(scene, done)


def line_trials(
    gauges: tuple[Gauge, ...],
    scene: Scene,
    names: tuple[str, ...],
    priors: Mapping[str, Any],
    setup: Setup,
    nodes: int | None,
) -> LineTrials:
    """Return the trials of a fit of an interface, after checking what was asked.

    Raises SceneError if a gauge is off the contact, or all records end before the load acts.
    """
    for gauge in gauges:
        if gauge.on_interface and not scene.contact.touches([gauge.x - setup.x0]).all():
            raise SceneError(
                f"fit: the bodies do not touch at x = {gauge.x:g}; leave {gauge.label} out."
            )
    samples = Samples(gauges)
    # A trigger that is fitted may turn out earlier, which needs a later end of the run.
    end = float(samples.t.max()) - setup.t0 + (0.25 * samples.duration if "t0" in names else 0.0)
    if end <= 0:
        raise SceneError("fit: all records end before the load acts; check t0.")
    settings = {**scene.run, "end_time": end, **({} if nodes is None else {"nodes": nodes})}
    begun = replace(with_period(scene, end), run=settings)
    unknowns = LineUnknowns(names, begun, setup, samples.duration)
    return LineTrials(samples, unknowns, priors, 0.0, lengthens=math.isinf(scene.period))
