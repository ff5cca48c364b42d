"""What all answers share: the same questions, each answered or refused in one sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NoReturn

from numpy.typing import ArrayLike

from semianalytic.results.answer import Array, ContactFields, answer_dataset, sampled_history
from semianalytic.results.in_words import html_table
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import asked_in_units
from semianalytic.scene.units import unit


@asked_in_units
class Gridded:
    """An answer, which refuses in one sentence what its class does not say itself."""

    @property
    def has_bodies(self) -> bool:
        """Whether the answer knows the fields in the bodies."""
        return False

    def _unknown(self, what: str, instead: str) -> NoReturn:
        """Raise SceneError for a question that this answer cannot say anything about."""
        raise SceneError(f"{what}: a {type(self).__name__} does not know it; {instead}.")

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Refuse to say the particle velocity; answers that know the bodies say it."""
        self._unknown("velocity", "ask for fields of the interface")

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Refuse to say the stress in the bodies; answers that know the bodies say it."""
        self._unknown("stress", "ask for tractions of the interface")

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Refuse to say the displacement in the bodies; answers that know the bodies say it."""
        self._unknown("displacement", "ask for slip and gap of the interface")

    def save(self, path: str | Path) -> None:
        """Refuse to write a file; answers that take long to compute are saved."""
        self._unknown("save", "solve it again, or write to_xarray(x, t).to_netcdf(path)")

    def plot(self: Any, ax: Any = None, t: float | None = None) -> Any:
        """Draw the slip rate over x at a time t [time]: its end, or 1 / c_t of an exact answer.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; by default on a new figure, with the tractions below it.
        t : float, optional

        Returns
        -------
        Axes, or array of two Axes

        Raises
        ------
        MissingLibraryError
            If matplotlib is not installed.
        """
        from semianalytic.results.plotting import drawn

        return drawn(self, ax, t)

    def _repr_html_(self: Any) -> str:
        """Return totals as a table of a notebook."""
        material, units = self.scene.material, self.scene.units
        end = getattr(self, "end_time", 1 / material.shear_speed)
        facts = (
            ("largest slip", self.max_slip(end), "length"),
            ("accumulated slip over the contact", self.accumulated_slip(end), "length^2"),
            ("frictional work over the contact", self.frictional_work(end), "stress length^2"),
        )
        rows = [(name, f"{float(value):.6g}", unit(of, units)) for name, value, of in facts]
        return html_table(repr(self).strip("<>"), (f"at t = {end:.4g}", "value", "unit"), rows)

    def history(self: ContactFields, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """Return all fields at positions x (n,) and times t (m,); raises like `slip_rate`."""
        return sampled_history(self, x, t)

    def to_xarray(self: ContactFields, x: ArrayLike, t: ArrayLike) -> Any:
        """Return fields and totals at positions x (n,) and times t (m,) as an `xarray.Dataset`.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        SceneError
            If a position or time is one that `slip_rate` refuses.
        """
        return answer_dataset(self, x, t)
