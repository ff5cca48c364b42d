"""A row of a judgement: what is compared, its three values, its error bar and its verdict."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

AGREES, DIFFERS, UNRESOLVED = "agrees", "differs", "unresolved"

TELLING = 0.5
"""A bar wider than that part of what is compared tells nothing of it."""
ALARM = 1.5
"""Bars beyond which a difference is one: of the many rows of a judgement some lie beyond one bar
by chance, as one in a hundred may (docs/judge.md)."""


DIFFERENCE_DIGITS = 2


def shown_number(value: float | None, digits: int = 4) -> str:
    """Some significant digits of any size, a dash for nothing."""
    if value is None:
        return "—"
    return "0" if value == 0 else f"{value:#.{digits}g}".rstrip(".")


def overall(verdicts: Iterable[str]) -> str:
    """Verdict on a whole: "differs" if one part does; else "agrees" if one does; else
    "unresolved"."""
    given = set(verdicts)
    return next((verdict for verdict in (DIFFERS, AGREES) if verdict in given), UNRESOLVED)


@dataclass(frozen=True)
class Row:
    """One quantity: exact, as the mesh would see the exact answer, and as it was simulated.

    Attributes
    ----------
    name : str
        What is compared.
    kind : str
        "arrival", "zone edge", "opening edge", "slip rate", "slip", "gap", "work",
        "shear traction", "pressure", "slot", "onset", "sense", "local", "law" or "field".
    exact : float or None
        By the prediction itself; None where it has no value apart from that at the nodes.
    at_nodes : float or None
        Read off the prediction at the nodes and times of the simulation.
    simulated : float or None
        Read off the simulation in the same way, and nothing else done to it.
    difference : float or None
        Of the last two: of the values, or for a field the norm of its difference.  None if one of
        the two is not there.
    bar : float or None
        What the difference may be: how far the simulation and the prediction may each be off.
        None where coarser meshes do not show the quantity.
    unit : str
        Of the three values: a reference value of `scales.reference_values`, a unit of the scene,
        or "1" for parts and counts.
    relative : bool
        Whether difference and bar are over the norm of the prediction and not in `unit`.
    order : float or None
        Order of convergence that the simulation shows on its meshes.
    obstacle : str
        Why this mesh, or this march, cannot tell; "" if it can.
    resolution : int or None
        Node distances per c_t T that would, where that is known.
    converges : bool
        Whether the reading converges from mesh to mesh.
    place : str
        Where and when the values are those of one place; "" of all others.
    """

    name: str
    kind: str
    exact: float | None
    at_nodes: float | None
    simulated: float | None
    difference: float | None
    bar: float | None
    unit: str = "1"
    relative: bool = False
    order: float | None = None
    obstacle: str = ""
    resolution: int | None = None
    converges: bool = True
    place: str = ""

    @property
    def size(self) -> float:
        """Of what is compared, in the unit of the bar: 1 of a part, else what is predicted at the
        nodes; 0 where that is nothing, or one place of many."""
        if self.relative:
            return 1.0
        return 0.0 if self.place else abs(self.at_nodes or 0.0)

    @property
    def label(self) -> str:
        """Name of the row and the unit of its values, where both belong together."""
        return self.name if self.relative or self.unit == "1" else f"{self.name} [{self.unit}]"

    def shown_share(self, value: float | None) -> str:
        """A difference or bar of the row in two digits, in per cent where it is relative."""
        if value is None or not self.relative:
            return shown_number(value, DIFFERENCE_DIGITS)
        return f"{shown_number(100 * value, DIFFERENCE_DIGITS)} %"

    @property
    def verdict(self) -> str:
        """ "agrees" within the bar, "differs" beyond one and a half, "unresolved" in between and
        where the mesh cannot tell."""
        if self.obstacle or self.bar is None:
            return UNRESOLVED
        if self.difference is None or abs(self.difference) > ALARM * self.bar:
            return DIFFERS
        return AGREES if abs(self.difference) <= self.bar else UNRESOLVED
