"""A scene over many friction coefficients: what is asked, and the answer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.rayleigh import Array
from semianalytic.results.datasets import QUANTITIES
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import needing
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.sweeps.continuation import FROM_SCRATCH, Continuation

_FIELDS = ("slip", "slip_rate", "shear_traction", "pressure")
_OF_SWEEPS = {
    "friction": ("1", "Coulomb friction coefficient"),
    "edge": ("", "which edge of a slip zone"),
    "edges": ("length / time", "velocity of the edge of a slip zone"),
    "error_estimate": ("1", "relative error estimate"),
    "status": ("", "converged, or what to distrust"),
    "origin": ("", "how the solution was found"),
}
"""Units and meaning of what datasets of sweeps hold beside the fields."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """Solutions of one scene with different friction coefficients: a sequence of `Solution`.

    As all results that hold arrays, a sweep equals only itself.

    Attributes
    ----------
    scene : Scene
        The scene; its own friction plays no part.
    friction : (n,) array
        Coulomb friction coefficients, in the order asked for.
    solutions : tuple of Solution, one per friction
    origin : tuple of str, one per friction
        "from scratch": solved without help from neighbours; "computed": edges corrected from a
        prediction, and checked like those from scratch; "interpolated" between such with the
        same zones, edges and Coulomb's law checked on the loose rule alone.
    """

    scene: Scene
    friction: Array
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
        """The solution at a place of `friction`, negative ones counted from the end, or the sweep
        over a slice of it."""
        if not isinstance(index, slice):
            return self.solutions[index]
        part = self.friction[index], self.solutions[index], self.origin[index]
        return Sweep(self.scene, *part)

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
        """Relative slip rate [length / time], upper minus lower side, at each friction.

        (n, ...) for positions x > 0 [length] and times t [time] that broadcast to (...).

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._field("slip_rate", x, t)

    def _field(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        """A field of every solution, (n, ...)."""
        shape = np.broadcast_shapes(np.shape(x), np.shape(t))
        fields = [getattr(solution, name)(x, t) for solution in self.solutions]
        return np.array(fields).reshape(len(self), *shape)

    def to_xarray(self, x: ArrayLike, t: ArrayLike) -> Any:
        """All fields at positions x (k,) and times t (m,) as an `xarray.Dataset`.

        Fields have the dimensions friction, t and x, `edges` friction, zone (from the contact edge
        outward) and edge ("inner", "outer"); `error_estimate`, `status` and `origin` friction
        alone.  Every variable has the attributes `units` and `long_name`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        with needing("to_xarray"):
            import xarray

        x, t = (np.atleast_1d(np.asarray(samples, dtype=float)) for samples in (x, t))
        data = xarray.Dataset(
            {
                **{
                    name: (("friction", "t", "x"), self._field(name, x, t[:, None]))
                    for name in _FIELDS
                },
                "edges": (("friction", "zone", "edge"), self.edges),
                "error_estimate": ("friction", self.error_estimate),
                "status": ("friction", np.array(self.status, dtype=str)),
                "origin": ("friction", np.array(self.origin, dtype=str)),
            },
            coords={"friction": self.friction, "t": t, "x": x, "edge": ["inner", "outer"]},
            attrs={"title": repr(self)},
        )
        for name, (units, meaning) in {**QUANTITIES, **_OF_SWEEPS}.items():
            if name in data.variables:
                data[name].attrs.update(units=units, long_name=meaning)
        return data

    @property
    def from_scratch(self) -> np.ndarray:
        """(n,) which solutions were solved without help from their neighbours."""
        return np.array([origin == FROM_SCRATCH for origin in self.origin], dtype=bool)

    @property
    def status(self) -> tuple[str, ...]:
        """Status of each solution; "converged", or a sentence saying what to distrust."""
        return tuple(solution.status for solution in self.solutions)

    @property
    def error_estimate(self) -> Array:
        """(n,) error estimates, see `Solution`."""
        return np.array([solution.error_estimate for solution in self.solutions])

    @property
    def edges(self) -> Array:
        """(n, m, 2) velocities of the inner and outer edge of the m-th zone from the contact
        edge outward [length / time]; NaN where there are fewer zones."""
        most = max((len(solution.zones) for solution in self.solutions), default=0)
        result = np.full((len(self.solutions), most, 2), np.nan)
        for row, solution in zip(result, self.solutions, strict=True):
            for pair, zone in zip(row, solution.zones, strict=False):
                pair[:] = zone.inner, zone.outer
        return result


def sweep(scene: Scene, friction: ArrayLike, rtol: float = 1e-8) -> Sweep:
    """Solve a scene for many friction coefficients, faster than one by one: the more, the faster.

    Parameters
    ----------
    scene : Scene
    friction : (n,) array
        Coulomb friction coefficients, in any order.
    rtol : float
        Wanted accuracy, as for `solve`.

    Returns
    -------
    Sweep
        Solutions that are "from scratch" or "computed" have passed the same checks as that of
        `solve`.  Those "interpolated" lie between two such with the same zones; their Coulomb
        inequalities and their edges were checked on the loose rule only (to 1e-3 and, in edge
        unknowns, 1e-2); finer than that they rest on the difference of interpolations through
        fewer and more neighbours.

    Raises
    ------
    SceneError
        If friction is not one-dimensional or not of numbers, a value of it does not make a scene,
        or rtol is out of range.
    TensionError
        If the contact pressure would turn tensile.
    """
    given = np.asarray(friction, dtype=object)
    if given.ndim != 1:
        raise SceneError(f"friction must be one-dimensional, got the shape {given.shape}.")
    values = np.array([checked_number("sweep: friction", value) for value in given], dtype=float)
    different, place = np.unique(values, return_inverse=True)
    continuation = Continuation([replace(scene, friction=float(f)) for f in different], rtol)
    continuation.run()
    solutions = tuple(continuation.solutions[i] for i in place)
    return Sweep(scene, values, solutions, tuple(continuation.origin[i] for i in place))
