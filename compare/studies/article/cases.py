"""The article's cases: its material, its loads on a base, and two answers to each.

The article takes f P_0 = 1 and Q_0 = 1/chi without a base load.  The friction bound f P_0 p*(u) is
then negative on 0.59 c_t t < x < c_l t, where Coulomb's law is not defined.  Two physical bases
replace it:

- remote: the loads arrive as sudden remote loads (P_0, Q_0), base = step;
- preloaded: constant pressure P_0, sudden shear Q_0.

Lengths and times are those of the article (c_t = 5, t = 0.01).  It gives no modulus; here mu = 1.
Slip rates are relative, over V_0 = 2 Q_0/(mu b), whereas the article's V is one-sided.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from compare.studies.article.prescribed import slipping_half_plane
from fem import simulate
from semianalytic import InterfaceHistory, Material, Scene, Solution, Tractions, solve
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.reference.kernels import SlipHistory, interface_traction
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import REMOTE

Array = NDArray[np.float64]
Progress = Callable[[str], None]

END_TIME = 0.01
SHEAR_SPEED = 5.0
POISSON_RATIO = 1 / 3
AUXETIC_RATIO = -0.5
"""Poisson ratio at which reverse slip covers a visible width."""
LOW_FRICTION = 0.01
REMOTE_CHI = (LOW_FRICTION, 0.5, 0.9, 1.2, 2.0)
PRELOADED_CHI = (LOW_FRICTION, 0.5, 2.0)


def article_material(poisson_ratio: float = POISSON_RATIO) -> Material:
    """Return the material with c_t = 5 and mu = 1; with the default Poisson ratio, c_l = 10."""
    return Material(1.0, 1 / SHEAR_SPEED**2, poisson_ratio)


def article_scene(chi: float, base: str, poisson_ratio: float = POISSON_RATIO) -> Scene:
    """Return the scene with f P_0 = 1 and Q_0 = 1/chi on a base.

    Parameters
    ----------
    chi : float
        Friction number f P_0 / Q_0, positive.
    base : str
        Base and kind of load, "remote" or "preloaded".
    poisson_ratio : float
        Poisson ratio of the material.

    Raises
    ------
    SceneError
        If chi is not positive, or the base is another one, such as that of the article.
    """
    if not (np.isfinite(chi) and chi > 0):
        raise SceneError(f"article_scene: chi must be positive, got {chi!r}.")
    material = article_material(poisson_ratio)
    if base == "remote":
        loads = Tractions(1.0, 1 / chi)
        return Scene(material, 1.0, base=Tractions(0.0, 0.0), load=loads, load_on=REMOTE)
    if base == "preloaded":
        return Scene(material, 1.0, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1 / chi))
    raise SceneError(
        f"article_scene: base must be 'remote' or 'preloaded', got {base!r}; without a base load "
        "the friction bound is negative on part of the interface."
    )


@dataclass(frozen=True)
class Case:
    """One scene with its exact solution and its finite-element history.

    Attributes
    ----------
    chi, base : float, str
        Arguments of `article_scene`.
    solution : Solution
        Exact solution.
    history : InterfaceHistory
        History of the interface in the simulation.
    resolution : int
        Elements per c_t T.
    """

    chi: float
    base: str
    solution: Solution
    history: InterfaceHistory
    resolution: int

    @property
    def scale(self) -> float:
        """V_0 = 2 Q_0/(mu b), the relative slip rate under a plane shear wave [length / time]."""
        return 2 / self.chi / self.solution.scene.material.shear_impedance

    def exact(self, velocity: Array) -> Array:
        """Return the exact slip rate over V_0 at velocities x/(c_t t)."""
        return self.solution.slip_rate(velocity * SHEAR_SPEED, 1.0) / self.scale

    def simulated(self) -> tuple[Array, Array]:
        """Return x/(c_t T) > 0 and the slip rate over V_0 at the end of the simulation."""
        x = self.history.x / (SHEAR_SPEED * self.history.t[-1])
        return x, self.history.slip_rate[-1] / self.scale

    def simulated_mean(self, low: float, high: float) -> float:
        """Return the mean of the simulated slip rate over low < x/(c_t T) < high."""
        velocity, rate = self.simulated()
        inside = (velocity > low) & (velocity < high)
        return float(rate[inside].mean())

    def disagreement(self) -> float:
        """Return the mean difference of the two slip rates over x < c_l T, over V_0."""
        velocity, rate = self.simulated()
        inside = velocity < self.solution.scene.material.longitudinal_speed / SHEAR_SPEED
        return float(np.abs(rate[inside] - self.exact(velocity[inside])).mean())


@dataclass(frozen=True)
class Cases:
    """All cases, by base and chi; `auxetic` has Poisson ratio -1/2, preloaded, chi = 0.01."""

    remote: dict[float, Case]
    preloaded: dict[float, Case]
    auxetic: Case

    def everyone(self) -> list[Case]:
        """Return the cases in one list."""
        return [*self.remote.values(), *self.preloaded.values(), self.auxetic]

    def disagreement(self) -> float:
        """Return the largest disagreement of all cases."""
        return max(case.disagreement() for case in self.everyone())


def run_case(chi: float, base: str, resolution: int, poisson_ratio: float = POISSON_RATIO) -> Case:
    """Solve and simulate one case."""
    scene = article_scene(chi, base, poisson_ratio)
    simulation = simulate(scene, END_TIME, resolution=resolution, every=max(1, resolution // 10))
    return Case(chi, base, solve(scene), simulation.interface, resolution)


def run_cases(resolution: int, progress: Progress | None = None) -> Cases:
    """Solve and simulate all cases.

    Parameters
    ----------
    resolution : int
        Elements per c_t T; the work grows with its third power.
    progress : callable, optional
        Called with one line before each case.
    """

    def run(chi: float, base: str, poisson_ratio: float = POISSON_RATIO) -> Case:
        if progress is not None:
            progress(f"{base}, chi = {chi:g}, Poisson ratio {poisson_ratio:.3g}")
        return run_case(chi, base, resolution, poisson_ratio)

    return Cases(
        remote={chi: run(chi, "remote") for chi in REMOTE_CHI},
        preloaded={chi: run(chi, "preloaded") for chi in PRELOADED_CHI},
        auxetic=run(LOW_FRICTION, "preloaded", AUXETIC_RATIO),
    )


def smooth_slip() -> SlipHistory:
    """Return a pulse of slip, Gaussian in position and time, that reaches the edge of the contact.

    It is meant for a material with c_t = 1, and is over by t = 1.
    """
    centre, width, moment, duration = 0.25, 0.18, 0.45, 0.12

    def rate(x: Array, t: Array) -> Array:
        return np.exp(-np.square((x - centre) / width) - np.square((t - moment) / duration))

    return SlipHistory(
        slip_rate=rate,
        gradient=lambda x, t: -2 * (x - centre) / width**2 * rate(x, t),
        acceleration=lambda x, t: -2 * (t - moment) / duration**2 * rate(x, t),
    )


@dataclass(frozen=True, eq=False)
class SlotCheck:
    """Tractions under a prescribed pulse of slip, by finite elements and by both kernels.

    Attributes
    ----------
    mode : str
        Mode of the slip, "I" or "II".
    x : (n,) array
        Positions on both sides of the edge [length].
    simulated : (n,) array
        Simulated traction with free slot faces [stress].
    free, held : (n,) arrays
        Traction by both versions of `interface_traction` [stress].
    """

    mode: Mode
    x: Array
    simulated: Array
    free: Array
    held: Array

    def error(self, version: str) -> float:
        """Return the largest difference from the simulation, relative to the largest traction."""
        difference = np.abs(getattr(self, version) - self.simulated)
        return float(difference.max() / np.abs(self.simulated).max())


def check_slot(mode: Mode, element_size: float) -> SlotCheck:
    """Prescribe a smooth slip on x > 0 with free slot faces, and compute t = 1 in all three ways.

    Parameters
    ----------
    mode : str
        Mode of the slip, "I" or "II".
    element_size : float
        Size of the elements [length]; the pulse is 0.18 wide.
    """
    material, slip = Material(1.0, 1.0, POISSON_RATIO), smooth_slip()
    motion = slipping_half_plane(
        material, slip, mode, end_time=1.0, element_size=element_size, half_width=1.8
    )
    inside = (motion.x > -1.0) & (motion.x < 1.2) & (np.abs(motion.x) > 0.05)
    x = motion.x[inside]
    free, held = (
        interface_traction(slip, mode, material, x, 1.0, slot=slot, rtol=1e-4).value
        for slot in ("free", "held")
    )
    return SlotCheck(mode, x, motion.traction[inside], free, held)
