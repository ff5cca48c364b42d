"""Parameters of a scene from records of slip rate: least squares with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.friction import ViscousFriction
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.derivative import PARAMETERS, Derivative, parameter
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve

_SETTLED = 1e-5
"""Change of chi2, relative, that ends a search: a hundredth of what noise does."""
UNCONSTRAINED = 1.0
"""Standard error over the size of a parameter from which data are said not to constrain it."""
LARGEST_CONDITION = 1e8
"""Of the weighted Jacobian in parameters over their sizes; beyond it some direction is free."""


@dataclass(frozen=True, eq=False)
class Gauge:
    """A record of relative slip rate at one place.

    Parameters
    ----------
    x : float
        Position on the contact [length], positive.
    t : (n,) array
        Times of the samples [time], ascending.
    slip_rate : (n,) array
        Samples [length / time].
    noise : float
        Standard deviation of their errors, taken to be independent [length / time].

    Raises
    ------
    SceneError
        If a number is out of range or not finite, or times and samples do not match.
    """

    x: float
    t: Array
    slip_rate: Array
    noise: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "x", checked_size("gauge: x", self.x))
        object.__setattr__(self, "noise", checked_size("gauge: noise", self.noise))
        for name in ("t", "slip_rate"):
            object.__setattr__(self, name, np.array(getattr(self, name), dtype=float))
        t, rate = self.t, self.slip_rate
        if t.ndim != 1 or t.shape != rate.shape or not t.size:
            raise SceneError("gauge: t and slip_rate must be two rows of as many numbers.")
        if not np.all(np.isfinite(t)) or not np.all(np.isfinite(rate)) or np.any(np.diff(t) <= 0):
            raise SceneError("gauge: t and slip_rate must be finite numbers, and t ascending.")

    def misfit(self, solution: Solution) -> Array:
        """(n,) slip rate of a solution less the record, over the noise."""
        return np.asarray((solution.slip_rate(self.x, self.t) - self.slip_rate) / self.noise)

    def sensitivity(self, solution: Solution, derivative: Derivative) -> Array:
        """(n,) derivatives of the misfit.

        At an edge they are infinite, and what a sample tells of it ends where its neighbour begins:
        nearer to an edge than half the time between samples they are taken at that distance.
        """
        t, half = self.t.copy(), np.gradient(self.t) / 2 if len(self.t) > 1 else self.t / 100
        speeds = solution.edge_speeds
        for speed in speeds[(speeds > 0) & np.isfinite(speeds)]:
            since = t - self.x / speed
            near = np.abs(since) < half
            t[near] = self.x / speed + np.where(since[near] < 0, -half[near], half[near])
        return np.asarray(derivative.slip_rate(self.x, t) / self.noise)


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters that fit records best, and how well they are known.

    Attributes
    ----------
    parameters : tuple of str, their names
    values : (p,) array, estimates, in the units of the scene
    covariance : (p, p) array, of the estimates; infinite for what the data do not constrain
    chi2 : float, sum of squares of the misfits over the noise
    freedom : int, samples less parameters: what chi2 is about where the noise is right
    unconstrained : tuple of str, parameters that the data do not constrain, alone or together
    status : str
        "converged", or a sentence saying what to distrust.
    solution : Solution, of the scene with these parameters
    gauges : tuple of Gauge
    solutions : int, that were computed on the way
    """

    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    chi2: float
    freedom: int
    unconstrained: tuple[str, ...]
    status: str
    solution: Solution
    gauges: tuple[Gauge, ...]
    solutions: int

    def __repr__(self) -> str:
        pairs = zip(self.parameters, self.values, self.standard_errors, strict=True)
        values = ", ".join(f"{name} {value:.5g} ± {error:.2g}" for name, value, error in pairs)
        return f"<Fit: {values}; chi2 {self.chi2:.4g} of {self.freedom}; {self.status}>"

    @property
    def scene(self) -> Scene:
        """The scene with these parameters."""
        return self.solution.scene

    @property
    def standard_errors(self) -> Array:
        """(p,) standard deviations of the estimates."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def residuals(self) -> tuple[Array, ...]:
        """Of each gauge, record less fit [length / time]."""
        return tuple(-one.noise * one.misfit(self.solution) for one in self.gauges)


def with_parameter(scene: Scene, name: str, value: float) -> Scene:
    """A scene with another value of one of `PARAMETERS`."""
    if name == "friction":
        return replace(scene, friction=value)
    if name == "poisson_ratio":
        return replace(scene, material=replace(scene.material, poisson_ratio=value))
    if name == "viscosity":
        return replace(scene, friction_law=ViscousFriction(value))
    part, kind = name.split("_")
    return replace(scene, **{part: replace(getattr(scene, part), **{kind: value})})


@dataclass
class _Trials:
    """Misfits of trial values, in units of `sizes`, and their derivatives."""

    gauges: tuple[Gauge, ...]
    scene: Scene
    names: tuple[str, ...]
    rtol: float
    count: int = 0
    last: tuple[bytes, Solution] | None = field(default=None, repr=False)

    @cached_property
    def sizes(self) -> Array:
        """By which parameters are counted: their own, or that of tractions or of one tenth."""
        scene = self.scene
        tractions = [scene.base.pressure, scene.base.shear, scene.load.pressure, scene.load.shear]
        stress, result = max(map(abs, tractions)) or 1.0, []
        for name in self.names:
            least = 0.1 if name in ("friction", "poisson_ratio") else 0.1 * stress
            if name == "viscosity":
                least = 0.1 * scene.material.shear_impedance
            result.append(max(abs(parameter(scene, name)), least))
        return np.array(result)

    def solution(self, scaled: Array) -> Solution:
        """Solution of the scene with values over `sizes`; the last one is kept."""
        if self.last is None or self.last[0] != scaled.tobytes():
            scene = self.scene
            for name, value in zip(self.names, scaled * self.sizes, strict=True):
                scene = with_parameter(scene, name, float(value))
            self.count += 1
            self.last = scaled.tobytes(), solve(scene, rtol=self.rtol)
        return self.last[1]

    def misfit(self, scaled: Array) -> Array:
        """Of all gauges in a row; infinite where there is no such scene."""
        try:
            solution = self.solution(scaled)
        except SceneError:
            return np.full(sum(len(one.t) for one in self.gauges), np.inf)
        return np.concatenate([one.misfit(solution) for one in self.gauges])

    def jacobian(self, scaled: Array) -> Array:
        """(samples, p) derivatives of the misfits."""
        solution = self.solution(scaled)
        columns = []
        for name, size in zip(self.names, self.sizes, strict=True):
            derivative = solution.derivative(name)
            rows = [one.sensitivity(solution, derivative) for one in self.gauges]
            columns.append(size * np.concatenate(rows))
        return np.stack(columns, axis=1)


def fit(
    gauges: Sequence[Gauge], scene: Scene, parameters: Sequence[str], *, rtol: float = 1e-8
) -> Fit:
    """Fit parameters of a scene to records of slip rate, by least squares.

    Parameters
    ----------
    gauges : sequence of Gauge
        Records, each with its noise.
    scene : Scene
        Where to begin, and all that is not fitted.
    parameters : sequence of str
        Any of "friction", "poisson_ratio", "base_pressure", "base_shear", "load_pressure",
        "load_shear" and "viscosity".
    rtol : float
        Accuracy of the solutions, as in `solve`.

    Returns
    -------
    Fit
        With the covariance from the derivatives at the best values, and a `status` that names
        what the data do not constrain.

    Raises
    ------
    SceneError
        If there are no gauges, fewer samples than parameters, an unknown or repeated parameter, or
        no solution or derivative where the fit begins.
    """
    from scipy.optimize import least_squares  # here, for `import semianalytic` is to be quick

    gauges, names = tuple(gauges), tuple(parameters)
    _check(gauges, names)
    trials = _Trials(gauges, scene, names, rtol)
    start = np.array([parameter(scene, name) for name in names]) / trials.sizes
    trials.jacobian(start)  # refuses what has no solution or derivative
    bounds = np.array([_bounds(name) for name in names]).T / trials.sizes
    found = least_squares(
        trials.misfit,
        np.clip(start, bounds[0] + 1e-9, bounds[1] - 1e-9),
        jac=trials.jacobian,
        bounds=(bounds[0], bounds[1]),
        xtol=1e-9,
        ftol=_SETTLED,
        gtol=_SETTLED,
    )
    solution = trials.solution(found.x)
    covariance, free = _covariance(trials.jacobian(found.x))
    status = "converged" if found.success else "the least squares did not converge"
    if solution.status != "converged":
        status = solution.status
    unconstrained = tuple(name for name, one in zip(names, free, strict=True) if one)
    if unconstrained:
        together = " apart" if len(unconstrained) > 1 else ""
        status = f"the data do not constrain {' and '.join(unconstrained)}{together}"
    size = trials.sizes
    return Fit(
        parameters=names,
        values=found.x * size,
        covariance=covariance * np.outer(size, size),
        chi2=float(2 * found.cost),
        freedom=len(found.fun) - len(names),
        unconstrained=unconstrained,
        status=status,
        solution=solution,
        gauges=gauges,
        solutions=trials.count,
    )


def _check(gauges: tuple[Gauge, ...], names: tuple[str, ...]) -> None:
    """Raise SceneError for what cannot be fitted."""
    if not gauges or not all(isinstance(one, Gauge) for one in gauges):
        raise SceneError("fit: gauges must be a sequence of at least one Gauge.")
    for name in names:
        if name not in PARAMETERS:
            known = ", ".join(PARAMETERS)
            raise SceneError(f"fit: parameters must be among {known}, got {shown(name)}.")
    if not names or len(set(names)) < len(names):
        raise SceneError("fit: name at least one parameter, and each of them once.")
    samples = sum(len(one.t) for one in gauges)
    checked_number(
        "fit: the number of samples",
        samples,
        f"be at least that of parameters, {len(names)}",
        lambda given: given >= len(names),
    )


def _bounds(name: str) -> tuple[float, float]:
    """Between which values a parameter may lie."""
    if name == "poisson_ratio":
        return -0.95, 0.499
    return (0.0 if name in ("friction", "base_pressure", "viscosity") else -np.inf), np.inf


def _covariance(jacobian: Array) -> tuple[Array, np.ndarray]:
    """(p, p) inverse of the weighted normal matrix, in parameters over their sizes, and which of
    them (p,) the data leave free."""
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    if not np.all(np.isfinite(values)):
        raise ComputationError("fit: the derivatives at the best values are not finite.")
    lost = values <= values.max(initial=0.0) / LARGEST_CONDITION
    inverse = np.where(lost, 0.0, 1 / np.where(lost, 1.0, values))
    covariance = (rows.T * inverse**2) @ rows
    within = np.abs(rows[lost]).max(axis=0, initial=0.0) > 1e-3
    free = within | (np.diag(covariance) > UNCONSTRAINED**2)
    covariance[free, :] = covariance[:, free] = 0.0
    covariance[free, free] = np.inf
    return covariance, free
