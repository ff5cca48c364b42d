"""Misfits of trial values and their derivatives, for least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from semianalytic.cut.load import scaled_load
from semianalytic.inversion.gauges import INTERFACE, Gauge
from semianalytic.inversion.priors import LogNormal, Normal, Prior, Uniform
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.unknowns import (
    MATERIAL,
    SOLVED,
    Setup,
    Unknowns,
    has_similarity,
    is_of_setup,
)
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.loading import Tractions
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.derivatives.parameters import PARAMETERS
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve

if TYPE_CHECKING:
    from semianalytic.sweeps.plane import Plane

FINER_SAFETY = 2.0
"""Error of a march over its difference from twice the nodes, at first order."""
PASSAGE = 2001
"""Times at which the passage of a rupture is read."""


@dataclass
class Trials:
    """Trials of unknowns, in units of `sizes`; rows of misfits are samples, then priors."""

    samples: Samples
    unknowns: Unknowns
    priors: Mapping[str, Prior]
    rtol: float  # accuracy of solutions
    count: int = 0  # solutions that were computed one by one; those of sweeps do not count
    # Called as ``progress(done, total)`` with the numbers of looks at the gauges: one per misfit,
    # two per derivative.  The total is what the rest of the search takes at most, so it may shrink,
    # and grows where the search goes on.
    progress: Callable[[int, int], object] | None = None
    looks: int = 0
    # solutions of trials so far, if these differ in friction alone; without it each trial is solved
    # alone
    followed: Plane | None = field(default=None, repr=False)
    _ahead: int = field(default=0, repr=False)
    _known: dict[Scene, Solution] = field(default_factory=dict, repr=False)
    _last: tuple[bytes, Array] | None = field(default=None, repr=False)

    marched: ClassVar[bool] = False
    """Whether scenes are marched along a line; others touch at x > 0 alone, where gauges stay."""
    kept: ClassVar[int] = 8
    """Solutions that are kept: misfit and Jacobian at one point, and both sides of a difference,
    ask for the same scene."""

    @property
    def is_slow(self) -> bool:
        """Whether each trial costs so much that there should be fewer of them."""
        return self.marched or not self.samples.on_interface.all()

    def expect(self, ahead: int) -> None:
        """Set how many looks the search still takes, at most."""
        self._ahead = ahead
        self._look(0)

    def _look(self, count: int) -> None:
        """Count looks at the gauges, and report them."""
        self.looks += count
        self._ahead = max(self._ahead - count, 0)
        if self.progress is not None:
            self.progress(self.looks, self.looks + self._ahead)

    @property
    def of_jacobian(self) -> int:
        """Number of looks of a Jacobian: one to either side for each unknown."""
        return 2 * len(self.unknowns.names)

    @cached_property
    def sizes(self) -> Array:
        """Sizes by which unknowns are divided, (p,)."""
        return np.array([self.unknowns.size(name) for name in self.unknowns.names])

    @cached_property
    def start(self) -> Array:
        """Values at which the search begins, within the bounds, (p,)."""
        values = np.array([self.unknowns.value(name) for name in self.unknowns.names])
        low, high = self.bounds
        # Least squares with bounds refuse a start that lies on one of them.
        inside = 1e-9 * np.maximum(1.0, np.abs(values / self.sizes))
        return np.clip(values / self.sizes, low + inside, high - inside)

    @cached_property
    def bounds(self) -> Array:
        """Bounds between which unknowns may lie, (2, p)."""
        pairs = []
        for name in self.unknowns.names:
            low, high = self.unknowns.bounds(name)
            if name == "x0" and not self.marched and self.samples.on_interface.any():
                # An edge beyond the first gauge would put that gauge on the slot, where the
                # interface has no such quantity.
                high = float(self.samples.places[0][self.samples.on_interface].min()) * (1 - 1e-9)
            prior = self.priors.get(name)
            if isinstance(prior, Uniform):
                low, high = max(low, prior.low), min(high, prior.high)
            pairs.append((low, high))
        return np.array(pairs).T / self.sizes

    @cached_property
    def ranges(self) -> Array:
        """Ranges that a search considers, (2, p)."""
        pairs = []
        for name in self.unknowns.names:
            prior = self.priors.get(name)
            pairs.append(self.unknowns.plausible(name) if prior is None else prior.range)
        return np.clip(np.array(pairs).T / self.sizes, *self.bounds)

    def at(self, scaled: Array) -> tuple[Scene, Setup]:
        """Return scene and set-up for values over `sizes`; errors are those of `Scene`."""
        return self.unknowns.at((scaled * self.sizes).tolist())

    def _solved(self, scene: Scene) -> Solution:
        solution = self._known.get(scene)
        if solution is None:
            self.count += 1
            solution = self._known[scene] = self._solve(scene)
            for oldest in list(self._known)[: -self.kept]:
                self._known.pop(oldest, None)  # unless another thread has
        return solution

    def _solve(self, scene: Scene) -> Solution:
        return (
            solve(scene, rtol=self.rtol) if self.followed is None else self._solutions([scene])[0]
        )

    def misfit(self, scaled: Array) -> Array:
        """Return misfits (n,) of samples and priors, in deviations; infinite without a scene."""
        key, last = scaled.tobytes(), self._last
        if last is not None and last[0] == key:  # least squares, and differences, ask twice
            return last[1].copy()
        try:
            scene, setup = self.at(scaled)
            seen = self.samples.of(self._solved(scene), setup)
            rows = self._misfit(seen, setup, scaled)
            self._last = key, rows
            return rows.copy()
        # A trial that makes no scene is infinitely bad, not an error: the search may look anywhere.
        except (SceneError, ComputationError):
            return np.full(self.rows, np.inf)

    def misfits(self, points: Sequence[Array], exact: bool = False) -> Array:
        """Return the misfits (m, n) of many values, computed by a sweep where possible.

        A sweep over Poisson ratio as well is rough, and not taken where they are to be `exact`.
        """
        if not self.swept or (exact and "poisson_ratio" in self.swept):
            return np.array([self.misfit(point) for point in points])
        rows = np.full((len(points), self.rows), np.inf)
        ready: list[tuple[int, Scene, Setup]] = []
        for number, point in enumerate(points):
            with suppress(SceneError):
                ready.append((number, *self.at(point)))
        answers = self._solutions([scene for _, scene, _ in ready])
        together: dict[Solution, list[int]] = {}  # trials of the set-up alone share an answer
        for place, answer in enumerate(answers):
            together.setdefault(answer, []).append(place)
        for answer, places in together.items():
            setups = [ready[place][2] for place in places]
            for place, seen in zip(places, self.samples.of_each(answer, setups), strict=True):
                number, _, setup = ready[place]
                rows[number] = self._misfit(seen, setup, points[number])
        return rows

    @cached_property
    def swept(self) -> frozenset[str]:
        """Unknowns of the scene if a sweep follows all of them; others need a solution each."""
        if self.marched:
            return frozenset()
        of_scene = frozenset(self.unknowns.names).intersection(SOLVED)
        pressure = {"base_pressure"} if self._pressure_is_strength else set()
        return frozenset() if of_scene - {"friction", "poisson_ratio"} - pressure else of_scene

    def _solutions(self, scenes: Sequence[Scene]) -> Sequence[Solution]:
        """Return solutions of scenes by a sweep, all under the base of the first guess.

        With f p alone in play, a change of the base pressure is one of friction.
        """
        given = self.unknowns.scene
        held, *now = (near.superposition.in_place.pressure or 1.0 for near in (given, *scenes))
        frictions = [scene.coefficient * (p / held) for scene, p in zip(scenes, now, strict=True)]
        if "poisson_ratio" in self.swept:
            from semianalytic.sweeps.sweep import sweep  # here, for a quick import

            ratios = [scene.material.poisson_ratio for scene in scenes]
            return sweep(given, frictions, 1e-4, poisson_ratio=ratios).solutions
        # Trials of friction alone keep what they find: each helps those that come later.
        from semianalytic.sweeps.plane import Plane

        if self.followed is None:
            self.followed = Plane((given,), self.rtol, scaled_load(given)[1])
        known = set(self.followed.values[:, 0].tolist())
        # each friction once, for trials of the set-up alone share one
        new = [value for value in dict.fromkeys(frictions) if value not in known]
        if new:
            laws = map(given.law.with_coefficient, new)
            self.followed.add([replace(given, friction=law) for law in laws])
        places = {value: i for i, value in enumerate(self.followed.values[:, 0].tolist())}
        return [self.followed.solutions[places[friction]] for friction in frictions]

    @cached_property
    def _pressure_is_strength(self) -> bool:
        """Whether the base pressure changes what gauges saw through f p alone."""
        scene, seen = self.unknowns.scene, {gauge.quantity for gauge in self.samples.gauges}
        steady = isinstance(scene.load, Tractions) and scene.load.pressure == 0
        pressed = scene.superposition.in_place.pressure > 0
        return steady and pressed and seen <= set(INTERFACE) - {"pressure"}

    def _misfit(self, seen: Array, setup: Setup, scaled: Array) -> Array:
        """Return the misfits (n,) of what gauges would have seen without their gain."""
        samples, known = self.samples, list(self.pulls(scaled).values())
        self._look(1)
        # Priors are samples of the parameters themselves, with their own deviations.
        misfits = (samples.gain(setup) * seen - samples.values) / samples.noise
        return np.concatenate([misfits, known])

    def pulls(self, scaled: Array) -> dict[str, float]:
        """Return how far unknowns are from the middle of their priors, in deviations, by name."""
        return {
            self.unknowns.names[number]: prior.misfit(value)[0]
            for number, prior, value in self._known_before(scaled)
        }

    @property
    def rows(self) -> int:
        """Number of misfits: samples, and priors that are not uniform."""
        return len(self.samples.t) + len(self._known_before(self.sizes))

    def _known_before(self, scaled: Array) -> list[tuple[int, Normal | LogNormal, float]]:
        """Return index, prior and value of each unknown with a prior that is not uniform."""
        values, priors = (scaled * self.sizes).tolist(), map(self.priors.get, self.unknowns.names)
        return [
            (number, prior, value)
            for number, (prior, value) in enumerate(zip(priors, values, strict=True))
            if isinstance(prior, Normal | LogNormal)
        ]

    def jacobian(self, scaled: Array) -> Array:
        """Return the derivatives (n, p) of the misfits."""
        scene, setup = self.at(scaled)
        solution, samples = self._solved(scene), self.samples
        # Derivatives are taken where they are finite; the misfit itself is that at the times of the
        # records.
        t = samples.clear(solution, setup)

        @cache  # friction and a pressure that is strength share one derivative
        def exact(parameter: str) -> Array:
            return samples.exact(solution.derivative(parameter), setup, t)

        rows = np.zeros((self.rows, len(scaled)))
        for number, name in enumerate(self.unknowns.names):
            column = self._column(name, scene, solution, setup, t, exact)
            if not name.startswith("gain"):
                column = samples.gain(setup) * column
            rows[: len(t), number] = column / samples.noise
        for row, (which, prior, value) in enumerate(self._known_before(scaled), len(t)):
            rows[row, which] = prior.misfit(value)[1]
        self._look(self.of_jacobian)
        return rows * self.sizes  # d/d(scaled) = size d/d(value)

    def _column(
        self,
        name: str,
        scene: Scene,
        solution: Solution,
        setup: Setup,
        t: Array,
        exact: Callable[[str], Array],
    ) -> Array:
        """Return derivatives (n,) of the samples without gain; those for gains include it."""
        samples = self.samples
        if name == "t0":
            # The times since the load are those of the record less t0, hence the sign.
            return -samples.over_time(solution, setup, t)
        if name == "x0":
            # The position from the contact edge is that of the record less x0.
            return -samples.along_x(solution, setup, t)
        if name.startswith("gain"):
            seen = samples.of(solution, setup, t)
            # The common gain is a factor of all: the derivative is what was seen over its own
            # value.
            if name == "gain":
                return samples.gain(setup) / setup.gain * seen
            lone = setup.gains.get(name.removeprefix("gain:"), 1.0)
            return samples.of_gauge(name.removeprefix("gain:")) * samples.gain(setup) / lone * seen
        lacking = self._differenced(name, solution.scene)
        column = np.zeros(len(t))
        if name in MATERIAL and not lacking.any():
            impedance, speed = samples.over_moduli(solution, setup, t)
            # Z = sqrt(mu rho) and c_t = sqrt(mu / rho): half the logarithmic derivatives, with
            # opposite signs of c_t for the density.
            value = getattr(solution.scene.material, name)
            return (impedance + (speed if name == "shear_modulus" else -speed)) / (2 * value)
        if not lacking.all():
            other, share = name, 1.0
            strength = name in ("friction", "base_pressure") and self._pressure_is_strength
            if strength and scene.coefficient:
                now, held = (
                    each.superposition.in_place.pressure for each in (scene, solution.scene)
                )
                factor = scene.coefficient if name == "base_pressure" else now
                other, share = "friction", factor / held  # it was solved under another pressure
            column = share * exact(other)
        if lacking.any():
            recorded = partial(samples.of, setup=setup, t=t)
            column[lacking] = self.difference(name, solution, setup, recorded)[lacking]
        return column

    def _differenced(self, name: str, scene: Scene) -> np.ndarray:
        """Return which samples have derivatives by differences with respect to an unknown, (n,).

        Exact ones exist on the interface for the parameters of `derivative` alone.
        """
        on_interface = self.samples.on_interface
        similar = not self.marched and name in MATERIAL and has_similarity(scene)
        if is_of_setup(name) or similar:
            return np.zeros_like(on_interface)
        return ~(on_interface & (name in PARAMETERS and not self.marched))

    def difference(
        self,
        name: str,
        solution: Solution,
        setup: Setup,
        of: Callable[[Solution], Array],
        longer: float = 1.0,
    ) -> Array:
        """Return derivatives (n,) of what is read `of` solutions, by differences of a parameter.

        With a step h their errors are that of the solutions over h, and about h^2; h is the cubic
        root of the first, over the size of the parameter.
        """
        size = float(self.sizes[self.unknowns.names.index(name)])
        # The sum of e / h and h^2 is least at h about the cubic root of e.
        step = longer * size * float(np.clip(np.cbrt(solution.error_estimate), 1e-5, 1e-2))
        alone = self.unknowns.alone(name, solution.scene, setup)
        value, ends = alone.value(name), []
        for moved in (value + step, value - step):
            try:
                ends.append((moved, self._solved(alone.at((moved,))[0])))
            # At a bound one side alone is left: a difference of first order.
            except SceneError:  # beyond what is a scene
                ends.append((value, solution))
        (above, later), (below, earlier) = ends
        return np.asarray((of(later) - of(earlier)) / (above - below))

    def slopes(self, solution: Solution, setup: Setup, of: Callable[[Solution], Array]) -> Array:
        """Return derivatives (n, p) of what is read `of` a solution, over unknowns over sizes."""
        still = np.zeros(len(of(solution)))
        columns = [
            still if is_of_setup(name) else size * self.difference(name, solution, setup, of)
            for name, size in zip(self.unknowns.names, self.sizes, strict=True)
        ]
        return np.stack(columns, axis=1)

    def asking(self, gauges: tuple[Gauge, ...], setup: Setup) -> Trials:
        """Return trials of the same unknowns, for what other gauges record in about a set-up."""
        return replace(
            self, samples=Samples(gauges), progress=None, followed=None, _known={}, _last=None
        )

    def passage(self, solution: Any, x: Array) -> tuple[Array, Array]:
        """Return slip and shear traction at places x (k,) while records last, (m, k) each."""
        t = np.linspace(0.0, float(self.samples.t.max()), PASSAGE)[1:, None]
        return solution.slip(x, t), np.nan_to_num(solution.shear_traction(x, t))

    def finer(self, solution: Any) -> Any:
        """Return the solution on twice the nodes; None for exact ones, which have no grid."""
        return None

    def difference_error(self, scaled: Array) -> float:
        """Return the relative error of derivatives by differences, from those with twice the step.

        It is the norm of a third of the difference (Richardson) over that of the derivatives, the
        largest of all parameters; 0 where all derivatives are exact.
        """
        scene, setup = self.at(scaled)
        solution, worst = self._solved(scene), 0.0
        t = self.samples.clear(solution, setup)
        of = partial(self.samples.of, setup=setup, t=t)
        for name in self.unknowns.names:
            lacking = self._differenced(name, scene)
            if lacking.any():
                fine, coarse = (
                    self.difference(name, solution, setup, of, longer)[lacking] for longer in (1, 2)
                )
                # The error goes like h^2: twice the step has four times the error, three of which
                # the difference shows.
                away, size = np.linalg.norm(fine - coarse) / 3, np.linalg.norm(fine)
                worst = max(worst, float(away / size) if size else 0.0)
        return worst

    def final(self, scaled: Array) -> Solution:
        """Return the solution of the result; errors are those of `solve`."""
        return solve(self.at(scaled)[0], rtol=self.rtol)

    def grid_error(self, scaled: Array, solution: Any) -> Array:
        """Return the error (n,) that the grid of a solution makes in misfits; 0 of exact ones."""
        setup, finer, error = self.at(scaled)[1], self.finer(solution), np.zeros(self.rows)
        if finer is not None:
            here, there = (self.samples.of(run, setup) for run in (solution, finer))
            apart = self.samples.gain(setup) * (there - here) / self.samples.noise
            error[: len(apart)] = FINER_SAFETY * apart
        return error
