"""Sweeps of a scene over many friction coefficients and Poisson ratios, and their result."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from os import PathLike
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.datasets import QUANTITIES, attributes
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import needing
from semianalytic.scene.given.finding import scene_of_one_solid
from semianalytic.scene.laws.kinds import checked_friction
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import checked_rtol
from semianalytic.sweeps.plane import FROM_SCRATCH, Plane

_FIELDS = ("slip", "slip_rate", "shear_traction", "pressure")
_OF_SWEEPS = {
    "friction": ("1", "Coulomb friction coefficient"),
    "poisson_ratio": ("1", "Poisson ratio"),
    "edge": ("", "which edge of a slip zone"),
    "edges": ("length / time", "velocity of the edge of a slip zone"),
    "error_estimate": ("1", "relative error estimate"),
    "status": ("", "converged, or what to distrust"),
    "origin": ("", "how the solution was found"),
}
"""Units and meaning of the variables of sweep datasets that are no fields."""


@asked_in_units
@dataclass(frozen=True, eq=False)
class Sweep:
    """The solutions of one scene with different friction coefficients and Poisson ratios.

    A sweep is a sequence of `Solution`.  Like all results that hold arrays, it equals only itself.

    Attributes
    ----------
    scene : Scene
        The scene; its own friction is not used.
    friction : (n,) array
        Coulomb friction coefficients, in the order asked for.
    poisson_ratio : (n,) array
        Poisson ratios that go with them.
    solutions : tuple of Solution
        One solution per friction coefficient.
    origin : tuple of str
        Origin of each solution.  "from scratch": solved without help from neighbours; "computed":
        edges corrected from a prediction, and checked like those from scratch; "interpolated"
        between solutions with the same zones, and corrected with a coarse quadrature rule.

    Examples
    --------
    >>> from semianalytic import find, sweep
    >>> swept = sweep(find("preloaded"), friction=[0.2, 0.3, 0.5])
    >>> len(swept), swept.status
    (3, ('converged', 'converged', 'converged'))
    >>> swept.slip_rate(0.1, 1.0).round(2).tolist()
    [0.83, 0.77, 0.68]
    """

    scene: Scene
    friction: Array
    poisson_ratio: Array
    solutions: tuple[Solution, ...]
    origin: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.solutions)

    def __iter__(self) -> Iterator[Solution]:
        return iter(self.solutions)

    @overload
    def __getitem__(self, index: int) -> Solution: ...
    @overload
    def __getitem__(self, index: slice) -> Sweep: ...
    def __getitem__(self, index: int | slice) -> Solution | Sweep:
        """Return the solution at an index of `friction`, or the sweep over a slice of it."""
        if not isinstance(index, slice):
            return self.solutions[index]
        part = self.friction[index], self.poisson_ratio[index]
        return Sweep(self.scene, *part, self.solutions[index], self.origin[index])

    def __repr__(self) -> str:
        if not len(self):
            return "<Sweep: no friction coefficients>"
        low, high, worst = self.friction.min(), self.friction.max(), self.error_estimate.max()
        converged = self.status.count("converged")
        return (
            f"<Sweep: {len(self)} friction coefficients from {low:.4g} to {high:.4g}; "
            f"{converged} converged, error estimate at most {worst:.1e}>"
        )

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip rate at each friction, (n, ...) [length / time].

        Positions x > 0 [length] and times t [time] broadcast to (...).

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._field("slip_rate", x, t)

    def _field(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        """Return a field of every solution, (n, ...)."""
        shape = np.broadcast_shapes(np.shape(x), np.shape(t))
        fields = [getattr(solution, name)(x, t) for solution in self.solutions]
        return np.array(fields).reshape(len(self), *shape)

    def to_xarray(self, x: ArrayLike, t: ArrayLike) -> Any:
        """Return all fields at positions x (k,) and times t (m,) as an `xarray.Dataset`.

        Fields have the dimensions friction, t and x, `edges` friction, zone (from the contact edge
        outward) and edge ("inner", "outer"); `error_estimate`, `status` and `origin` friction
        alone.  Over several Poisson ratios the dimension is `point` instead of friction, which then
        is a coordinate along it, like poisson_ratio.  Every variable has the attributes `units` and
        `long_name`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        with needing("to_xarray"):
            import xarray

        x, t = (np.ravel(np.asarray(samples, dtype=float)) for samples in (x, t))
        along, places = "friction", {"friction": ("friction", self.friction)}
        if len(set(self.poisson_ratio.tolist())) > 1:
            along = "point"
            places = {name: (along, getattr(self, name)) for name in ("friction", "poisson_ratio")}
        data = xarray.Dataset(
            {
                **{name: ((along, "t", "x"), self._field(name, x, t[:, None])) for name in _FIELDS},
                "edges": ((along, "zone", "edge"), self.edges),
                "error_estimate": (along, self.error_estimate),
                "status": (along, np.array(self.status, dtype=str)),
                "origin": (along, np.array(self.origin, dtype=str)),
            },
            coords={**places, "t": t, "x": x, "edge": ["inner", "outer"]},
            attrs={"title": repr(self)},
        )
        units = self.solutions[0].scene.units if len(self) else ""
        for name, known in {**QUANTITIES, **_OF_SWEEPS}.items():
            if name in data.variables:
                data[name].attrs.update(attributes(*known, units))
        return data

    @property
    def from_scratch(self) -> np.ndarray:
        """Whether each solution was solved without help from its neighbours, (n,)."""
        return np.array([origin == FROM_SCRATCH for origin in self.origin], dtype=bool)

    @property
    def status(self) -> tuple[str, ...]:
        """Status of each solution; "converged", or a sentence on what is unreliable."""
        return tuple(solution.status for solution in self.solutions)

    @property
    def error_estimate(self) -> Array:
        """Error estimate of each solution, (n,); see `Solution`."""
        return np.array([solution.error_estimate for solution in self.solutions])

    @property
    def edges(self) -> Array:
        """Velocities of the inner and outer edges of zones, (n, m, 2) [length / time].

        Zones are counted from the contact edge outward; NaN stands where there are fewer than m.
        """
        most = max((len(solution.zones) for solution in self.solutions), default=0)
        result = np.full((len(self.solutions), most, 2), np.nan)
        for row, solution in zip(result, self.solutions, strict=True):
            for pair, zone in zip(row, solution.zones, strict=False):
                pair[:] = zone.inner, zone.outer
        return result


def sweep(
    scene: Scene | str | PathLike[str],
    friction: ArrayLike,
    rtol: float = 1e-8,
    *,
    poisson_ratio: ArrayLike | None = None,
) -> Sweep:
    """Solve a scene for many friction coefficients and Poisson ratios, faster than one by one.

    Edges are followed from value to value, so the time per solution falls with the number of
    values.

    Parameters
    ----------
    scene : Scene, str or path
        The scene, or its name or file as for `find`; its own friction is not used.
    friction : (n,) array
        Coulomb friction coefficients, in any order.
    rtol : float
        Wanted accuracy, as for `solve`.
    poisson_ratio : array, optional
        Poisson ratios; without them that of the scene.  Friction may then have any shape, and the
        two are broadcast: ``sweep(scene, f, poisson_ratio=nu[:, None])`` solves a grid.  The
        answers are in a row, in C order: ``.error_estimate.reshape(len(nu), len(f))``.

    Returns
    -------
    Sweep
        Solutions that are "from scratch" or "computed" have passed the same checks as that of
        `solve`.  Those "interpolated" lie between these.  Their edges fulfil the edge conditions on
        a quadrature rule as coarse as neighbours show to be enough; Coulomb's inequalities are
        checked there to 1e-3, near other zones to `rtol` on the fine rule.

    Raises
    ------
    SceneError
        If friction is not one-dimensional (without Poisson ratios) or not of numbers, a value does
        not make a scene, the shapes do not broadcast, or rtol is out of range.
    TensionError
        If the contact would open all the way to infinity.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import sweep
    >>> swept = sweep("antiplane", friction=np.linspace(0.1, 0.9, 5))
    >>> swept.edges[:, 0, 1].round(3).tolist()  # c_t / (1 + friction)^2
    [0.826, 0.592, 0.444, 0.346, 0.277]
    """
    given = np.asarray(friction, dtype=object)
    scene = scene_of_one_solid("sweep", scene)
    ratio = np.asarray(scene.material.poisson_ratio)
    if poisson_ratio is not None:
        ratio = np.asarray(poisson_ratio, dtype=object)
        try:
            given, ratio = (array.ravel() for array in np.broadcast_arrays(given, ratio))
        except ValueError:
            raise SceneError(
                f"friction of the shape {given.shape} and Poisson ratios of the shape "
                f"{ratio.shape} do not broadcast; give both one shape, or a grid as f and "
                "nu[:, None]."
            ) from None
    elif given.ndim != 1:
        raise SceneError(f"friction must be one-dimensional, got the shape {given.shape}.")
    values = _numbers("friction", given)
    ratios = np.broadcast_to(_numbers("Poisson ratio", ratio), values.shape)
    # Sorted by Poisson ratio, then friction, each pair once; `place` leads back to the order asked
    # for.
    points, place = np.unique(np.stack([ratios, values]), axis=1, return_inverse=True)
    solutions, origin = _solved(scene, points, rtol)
    place = np.ravel(place)
    chosen = tuple(solutions[i] for i in place)
    swept = Sweep(scene, values, ratios, chosen, tuple(origin[i] for i in place))
    logging.getLogger(__name__).info("a Scene by self-similar: %r", swept)
    return swept


def _numbers(name: str, given: np.ndarray) -> Array:
    """Return an array of finite numbers; raise SceneError if it is not one."""
    values = np.ravel(given).tolist()
    if not all(type(value) is float and math.isfinite(value) for value in values):
        values = [checked_number(f"sweep: {name}", value) for value in values]
    return np.array(values, dtype=float)


def _solved(scene: Scene, points: Array, rtol: float) -> tuple[list[Solution], list[str]]:
    """Return the solutions at Poisson ratios and frictions (2, n), in order, and their origins."""
    scenes = _scenes(scene, points, rtol)
    coulomb = isinstance(scene.friction, float) and scene.shear_mode == "II"
    # tables of many solids at once are those of loads that come at once
    coulomb = coulomb and not scene.front_slowness
    # With many frictions for each Poisson ratio, following them one ratio at a time is faster than
    # in the plane.
    several = len(set(points[0].tolist()))
    scattered = len(scenes) < 400 * several
    bounds = [0, len(scenes)]
    # Neighbours of other Poisson ratios help from 300 points on.
    if not (coulomb and scattered and several > 1 and len(scenes) >= 300):
        # Where the Poisson ratio changes in the sorted list, a new line begins.
        bounds[1:1] = (np.flatnonzero(np.diff(points[0])) + 1).tolist()
    solutions: list[Solution] = []
    origin: list[str] = []
    for start, stop in pairwise(bounds):
        if start == stop:  # nothing was asked for
            break
        run = Plane(scenes[start:stop], rtol)
        run.run()
        solutions += [run.solutions[i] for i in range(len(run.scenes))]
        origin += [run.origin[i] for i in range(len(run.scenes))]
    return solutions, origin


def _scenes(scene: Scene, points: Array, rtol: float) -> list[Scene]:
    """Return a scene at Poisson ratios and frictions (2, n), all of which can be solved to rtol.

    A condition on the least and the largest friction suffices: these alone are checked.
    """
    parts: dict[float, dict[str, Any]] = {}
    for ratio in set(points[0].tolist()):
        material = replace(scene.material, poisson_ratio=ratio)
        for friction in (points[1].min(), points[1].max()):
            law = scene.law.with_coefficient(float(friction))
            checked = replace(scene, material=material, friction=law)
            checked_rtol(checked, rtol)
        names = {*(field.name for field in fields(checked)), "_made_in_si"}
        parts[ratio] = {name: part for name, part in vars(checked).items() if name in names}
    coefficients = set(points[1].tolist())
    laws = {value: checked_friction(scene.law.with_coefficient(value)) for value in coefficients}
    scenes = [object.__new__(Scene) for _ in range(points.shape[1])]
    for placed, ratio, friction in zip(scenes, *points.tolist(), strict=True):
        vars(placed).update(parts[ratio], friction=laws[friction])
    return scenes
