"""A run of an interface and its simulations at the same nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fem.lines import LineSimulation
from semianalytic import Run
from semianalytic.engine.stepping.tuning import LEAST_GAP
from semianalytic.interface.fields import at_nodes
from semianalytic.scene.laws.sampling import sampled

Array = NDArray[np.float64]

NOTHING = 1e-9
"""Part of the slip, or of the strength, below which a gap or a traction counts as none, and of what
loads would move, below which contacts that can stick do not."""
KINDS: Mapping[str, tuple[str, str]] = {
    "slip": ("slip", "length"),
    "slip_rate": ("slip rate", "length / time"),
    "gap": ("gap", "length"),
    "shear_traction": ("shear traction", "stress"),
    "pressure": ("pressure", "stress"),
}
"""Kind of the row and unit of each quantity; tractions are compared by their changes."""


@dataclass(frozen=True)
class LineCase:
    """A run and its simulations side by side, as `compare.comparison.judging.judged` needs them.

    Attributes
    ----------
    run : Run
    simulations : list of LineSimulation
    """

    run: Run
    simulations: list[LineSimulation]
    amplified: str = ""
    needed: int | None = None

    @property
    def finer(self) -> int:
        """Nodes of a mesh twice as fine."""
        return 2 * self.simulations[0].nodes

    @property
    def caution(self) -> str:
        """Why the run decides nothing; "" if it does."""
        return "" if self.run.status == "done" else f"the run is {self.run.status}"

    @cached_property
    def base(self) -> dict[str, Array]:
        """Tractions in place at t = 0, (n,) at the nodes of the run [stress], by name."""
        done, interface = self.run, self.run.interface
        spacing, given = interface.length / done.nodes, interface.pressure
        return {
            "shear_traction": sampled("interface: shear", interface.shear, done.x, spacing),
            "pressure": at_nodes("interface: pressure", given, done.x, done.touching, spacing),
        }

    def ran(self, name: str, count: int) -> Array:
        """Return a field of the run, of tractions its change, at a number of nodes, (m, count)."""
        return self._at(_whole(getattr(self.run, name) - self.base.get(name, 0.0), self.run), count)

    def meshed(self, number: int, name: str, count: int) -> Array:
        """Return a field of a simulation likewise."""
        one, still = self.simulations[number], np.zeros_like(self.run.x)
        start = self._at(_whole(self.base.get(name, still)[None], self.run), one.nodes)
        return self._at(getattr(one, name) - start, count)

    def touching(self, count: int) -> NDArray[np.bool_]:
        """Return which of a number of nodes stand for nothing but contact, (count,)."""
        return self._at(self.simulations[0].touching[None].astype(float), count)[0] == 1

    def _at(self, values: Array, count: int) -> Array:
        return _common(values, count, between=not self.run.interface.contact.is_whole)

    def least(self, name: str) -> float:
        """Return the mean of a field up to which it is not compared.

        It is a part of the motion of the faces or of all tractions: rounding moves faces that rest,
        and a small gap decides nothing.
        """
        # slots are wider than contacts open
        done = self.run
        fields = {name: np.abs(getattr(done, name)[:, done.touching]) for name in KINDS}
        stress = max(float(fields[name].mean()) for name in ("shear_traction", "pressure"))
        if name in self.base:
            return NOTHING * stress
        motion = max(float(fields[name].mean()) for name in ("slip", "gap"))
        if name == "gap":
            return LEAST_GAP * motion
        if done.interface.law.has_threshold:
            motion = max(motion, stress * done.end_time / done.interface.material.shear_impedance)
        return NOTHING * motion / (done.end_time if name == "slip_rate" else 1.0)


def _whole(values: Array, done: Run) -> Array:
    """Return fields (m, n) of a run on the whole period, mirrored where it computed one half."""
    if not done.interface.even:
        return values
    if done.interface.contact.is_whole:
        # nodes at 0 and length / 2 are their own mirror images
        return np.concatenate([values[:, :0:-1], values[:, :-1]], axis=1)
    return np.concatenate([values[:, ::-1], values], axis=1)


def _common(values: Array, count: int, between: bool) -> Array:
    """Return fields (m, n) at the nodes of a coarser grid of the same period, (m, count).

    Nodes of grids that lie between the ends of contacts do not coincide: means replace them.
    """
    times = values.shape[1] // count
    if not between:
        return np.asarray(values[:, ::times])
    return np.asarray(values.reshape(len(values), count, times).mean(axis=2))
