"""Methods that all answers share, each of which answers or refuses in one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import Answer, Array, answer_dataset, sampled_history
from semianalytic.results.derived import strain
from semianalytic.results.in_words import html_table
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.units import unit


@asked_in_units
class Gridded:
    """An answer, which refuses in one sentence what its class does not say itself."""

    settings: Mapping[str, Any] = MappingProxyType({})
    """Settings of `solve` that were given for it."""
    saved_as: ClassVar[str] = ""
    """Format in which it is saved as it is; "" for an answer that is solved again."""
    compression: ClassVar[int | None] = None
    """Level of gzip with which it is then saved."""

    has_bodies: ClassVar[bool] = False
    """Whether the answer contains the fields in the bodies."""

    def _unknown(self, what: str, instead: str) -> NoReturn:
        """Raise SceneError for a question that this answer cannot say anything about."""
        raise SceneError(f"{what}: a {type(self).__name__} does not contain it; {instead}.")

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Raise SceneError; answers with fields in the bodies return the particle velocity."""
        self._unknown("velocity", "ask for fields of the interface")

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Raise SceneError; answers with fields in the bodies return the stress."""
        self._unknown("stress", "ask for tractions of the interface")

    def strain(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Raise SceneError; answers with fields in the bodies return the strain."""
        self._unknown("strain", "ask for tractions of the interface")

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Raise SceneError; answers with fields in the bodies return the displacement."""
        self._unknown("displacement", "ask for slip and gap of the interface")

    def save(self: Any, path: str | Path) -> None:
        """Write the answer as HDF5: a march as it is, with all that continues it; of an exact one
        the scene and the settings of `solve`, with which `sf.load` solves it again.

        The file appears under its name only when it is complete; missing folders are made.

        Raises
        ------
        MissingLibraryError
            If h5py is not installed.
        DataFileError
            If the file cannot be written.
        """
        from semianalytic.results.saved import SOLVED, SavedScene, write_answer

        if self.saved_as:
            write_answer(path, self.saved_as, self, compression=self.compression)
        else:
            write_answer(path, SOLVED, SavedScene(self.scene, dict(self.settings)))

    def plot(self: Any, ax: Any = None, t: float | None = None) -> Any:
        """Draw slip rate and tractions over x at a time, or the slip rate over (x, t).

        Waves and open parts are marked.  Scenes in SI units are drawn in km, m, mm or µm, in s, ms
        or µs, and in MPa, kPa or Pa, as suits the numbers.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw, without the tractions; by default a new figure.
        t : float, optional
            Time [time].  Left out, answers on a grid of nodes and times are drawn over (x, t), and
            exact ones at 1 / c_t.

        Returns
        -------
        Axes, or array of two Axes

        Raises
        ------
        MissingLibraryError
            If matplotlib is not installed.
        """
        from semianalytic.results.plotting import drawn

        axes = list(ax.flat) if isinstance(ax, np.ndarray) else ax
        axes = axes if isinstance(axes, list | tuple) else [axes]
        if ax is not None and not (
            len(axes) and all(hasattr(panel, "pcolormesh") for panel in axes)
        ):
            raise SceneError(f"plot: ax must be Axes of matplotlib, got {shown(ax)}.")
        return drawn(self, ax, t)

    def animate(self: Any, path: str | Path, t: ArrayLike | None = None) -> None:
        """Write slip rate and tractions over x as an animation in the format GIF.

        Parameters
        ----------
        path : str or path
            File to write; its name ends with .gif.
        t : (m,) array, optional
            Times of the frames [time]; by default 40 until the end, of exact answers 1 / c_t.

        Raises
        ------
        MissingLibraryError
            If matplotlib is not installed.
        SceneError
            If the name has another ending.
        DataFileError
            If the file cannot be written.
        """
        from semianalytic.results.plotting import animated

        animated(self, path, t)

    def _repr_html_(self: Any) -> str:
        """Return totals as a table of a notebook."""
        material, units = self.scene.material, self.scene.units
        end = getattr(self, "end_time", 1 / material.shear_speed)
        facts = (
            ("largest slip", self.max_slip, "length"),
            ("accumulated slip over the contact", self.accumulated_slip, "length^2"),
            ("frictional work over the contact", self.frictional_work, "stress length^2"),
        )
        rows = [(name, f"{float(total(end)):.6g}", unit(of, units)) for name, total, of in facts]
        return html_table(repr(self).strip("<>"), (f"at t = {end:.4g}", "value", "unit"), rows)

    def history(self: Answer, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """Return all fields at positions x (n,) and times t (m,); raises like `slip_rate`."""
        return sampled_history(self, x, t)

    def to_xarray(self: Answer, x: ArrayLike, t: ArrayLike) -> Any:
        """Return fields and totals at positions x (n,) and times t (m,) as an `xarray.Dataset`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position or time is one that `slip_rate` refuses.
        """
        return answer_dataset(self, x, t)


@asked_in_units
class AnswerInBodies(Gridded):
    """An answer with the fields in both bodies.

    Exact answers have them exactly, up to one interpolation, by Smirnov and Sobolev's method: a
    picture of 100,000 points takes a tenth of a second, and about a second the first time, when
    quantities that do not depend on the points are computed.
    """

    has_bodies = True

    @property
    def nearest_depth(self) -> float:
        """Least distance from the interface at which stress is known [length]."""
        return 0.0

    if TYPE_CHECKING:  # what the classes have that inherit from this one

        @property
        def error_estimate(self) -> float:
            """Estimate of the error of the answer, that of the edges of zones included."""

        @property
        def _bodies(self) -> Any:
            """The fields in both bodies, exact ones with their error."""

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity anywhere in the bodies [length / time].

        Parameters
        ----------
        x, y : arrays
            Positions [length] that broadcast with t: y > 0 is the upper body, y < 0 the lower one,
            0.0 and -0.0 are their faces, those of the slot x < 0 included.
        t : array
            Times [time]; until t = 0 the base state is at rest.

        Returns
        -------
        (2, ...) array
            v_x, v_y; in antiplane shear (3, ...), with v_z.  Infinite, with its sign, at the
            Rayleigh fronts of the slot, at that of the contact where slip covers it, and at other
            singular points.

        Raises
        ------
        SceneError
            If a position or a time is not a finite number, or beyond what was computed.

        Examples
        --------
        >>> import semianalytic as sa
        >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
        >>> base, load = sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6)
        >>> answer = sa.solve(sa.Scene(gouge, 0.4, base, load, lower_material=rock), rtol=1e-6)
        >>> answer.velocity(1.0, [0.0, -0.0], 2e-3)[0].round(3)  # the slip rate is 0.25
        array([ 0.141, -0.109])
        """
        return np.asarray(self._bodies.velocity(x, y, t))

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress anywhere in the bodies, tension positive [stress]; parameters as
        `velocity`.

        Returns
        -------
        (3, ...) array
            sigma_xx, sigma_yy, sigma_xy; in antiplane shear (5, ...), with sigma_xz and sigma_yz.
            The base tractions are part of sigma_yy and sigma_xy (or sigma_yz); they do not
            determine the initial sigma_xx, so that one is the change since t = 0.  Base tractions
            and loads on the line that vary along x determine no stress away from it: for these a
            march gives only the change due to slip.  At the contact edge the value is that just
            ahead of it, where that is finite.
        """
        return np.asarray(self._bodies.stress(x, y, t))

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement since t = 0 anywhere in the bodies [length]; parameters as
        `velocity`.

        Returns
        -------
        (2, ...) array
            u_x, u_y; in antiplane shear (3, ...), with u_z.
        """
        return np.asarray(self._bodies.displacement(x, y, t))

    def strain(self: Any, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the change of strain since t = 0 anywhere in the bodies; parameters as `velocity`.

        It follows from the change of stress by Hooke's law in plane strain.

        Returns
        -------
        (3, ...) array
            eps_xx, eps_yy, eps_xy, elongation positive; in antiplane shear (5, ...), with eps_xz
            and eps_yz.  Shear strains are those of the tensor, half the engineering ones.
        """
        change = self.stress(x, y, t) - self.stress(x, y, 0.0 * np.asarray(t, dtype=float))
        upper, lower = (strain(change, body) for body in self.scene.bodies)
        return np.where(np.signbit(np.asarray(y, dtype=float)), lower, upper)

    @cached_property
    def field_error(self) -> float:
        """Estimate of the error of fields in the bodies, relative to themselves plus the largest
        load.

        It adds the change on a coarser rule at some points and the error of the zone edges.
        """
        return float(self._bodies.error + self.error_estimate)
