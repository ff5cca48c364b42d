"""The result of a simulation, and its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fem.interface import OPEN
from fem.resolution import mesh_caution
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.reading import SAMPLED_SAFETY
from semianalytic.results.sampled import SampledAnswer, Totals
from semianalytic.results.saved import read_answer, write_answer
from semianalytic.scene.arguments import asked_in_units, checking
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import with_unit

FORMAT = "slipfront simulation 13"
FILE_NAME = "simulation.h5"


@dataclass(frozen=True, eq=False)
class SlotHistory:
    """The motion of the upper slot face.

    Attributes
    ----------
    x : (n,) array
        Positions on the slot [length], negative, increasing to the last node before the edge.
    t : (m,) array
        Times [time].
    velocity_x, velocity_y : (m, n) arrays
        Velocity of the upper face [length / time]; in antiplane shear the first is along z, and
        that along x is left out.

    Examples
    --------
    >>> from fem import simulate
    >>> from semianalytic import find
    >>> slot = simulate(find("preloaded"), resolution=8).slot
    >>> slot.velocity_x.shape == (len(slot.t), len(slot.x))
    True
    """

    x: Array
    t: Array
    velocity_x: Array
    velocity_y: Array


@dataclass(frozen=True, eq=False)
class EnergyHistory:
    """Energies of both blocks per unit thickness [stress length^2], as the scheme defines them.

    They are recorded at every step, stored or not.  In the middle of each step the energies of the
    central-difference scheme balance exactly: kinetic + strain + friction + damping + impact =
    external.

    Attributes
    ----------
    t : (m,) array
        Middles of steps [time].
    kinetic : (m,) array
        Kinetic energy of the velocity in the middle of the step.
    strain : (m,) array
        Strain energy of the change of stress: u_n . K u_{n+1} / 2, with the displacements u_n and
        u_{n+1} at the time levels on either side and the stiffness matrix K.
    friction : (m,) array
        Energy dissipated by friction since t = 0, the integral of shear traction over slip.
    damping : (m,) array
        Energy dissipated by the viscous damping.
    external : (m,) array
        Work done by the load on the slot faces, and by the base tractions on slip and opening.
    impact : (m,) array
        Energy lost where open parts of the interface close again.

    Examples
    --------
    >>> from fem import simulate
    >>> from semianalytic import find
    >>> simulate(find("preloaded"), resolution=8).energy.residual < 1e-12
    True
    """

    t: Array
    kinetic: Array
    strain: Array
    friction: Array
    damping: Array
    external: Array
    impact: Array

    @property
    def residual(self) -> float:
        """Largest imbalance over all steps, relative to the largest external work."""
        taken = self.kinetic + self.strain + self.friction + self.damping + self.impact
        scale = float(np.abs(self.external).max(initial=0.0))
        imbalance = float(np.abs(taken - self.external).max(initial=0.0))
        return imbalance / scale if scale > 0 else imbalance


@dataclass(frozen=True)
class ContactOpening:
    """The opening of the contact over all steps, stored or not: where and when it came apart.

    Attributes
    ----------
    time : float
        Time at which the first node opened [time].
    x : float
        Position of that node [length].
    gap : float
        Largest gap anywhere, at any time [length].
    length : float
        Greatest length of contact that was open at one time [length].

    Examples
    --------
    >>> from fem import simulate
    >>> from semianalytic import find
    >>> run = simulate(find("lift-off"), resolution=16)
    >>> 0 < run.opened.x < run.opened.length < 1
    True
    """

    time: float
    x: float
    gap: float
    length: float


@asked_in_units
@dataclass(frozen=True, eq=False, repr=False)
class Simulation(SampledAnswer):
    """The result of one finite-element simulation.

    `simulate` returns it.  It has the methods of all answers: `slip_rate(x, t)`, `slip(x, t)`,
    `shear_traction(x, t)`,
    `pressure(x, t)` and `gap(x, t)` between the stored nodes and levels, `max_slip(t)`,
    `accumulated_slip(t)` and `frictional_work(t)` between steps, `zones_at(t)`, `openings_at(t)`,
    `history(x, t)`, `to_xarray(x, t)`.

    Attributes
    ----------
    scene : Scene
    end_time : float
        T [time].
    resolution : int
        Node distances per c_t T.
    element_size : float
        Distance h of the nodes on the interface [length].
    damping : float
        eta of the damping C = eta K, in units of h / c_t.
    mesh : str
        Mesh pattern.
    model : str
        Model that was simulated, e.g. "antisymmetric half".
    step_ratio : float
        Largest time step that was requested, divided by the critical one.
    time_step, critical_step : float
        The step taken and the largest stable one [time].
    rate_window : float
        Length of the time window, centred on its level, over which each slip rate of `interface` is
        averaged [time]; 0 if slip rates are those of the level itself.
    steps : int
        Number of steps.
    unknowns : int
        Number of displacement unknowns.
    interface : InterfaceHistory
        Fields on the contact nodes x > 0, from h beyond the edge node on.  The edge node, at x = 0
        or, if the slot is pressed, a fraction of h from it, is left out: part of its mass belongs
        to the slot, and its motion does not converge.  All fields belong to the same times: the
        tractions are those of the level, and the slip rate is the mean over a window around it,
        second order in time, in which a shear wave crosses 2.8 elements (rounded to whole steps;
        soon after t = 0 the window begins at t = 0).  The same holds for the last level: the run
        continues until its window ends.
    state : (m, n) array of int8
        State of each node of `interface` in the step after each time: STICK (0), slip FORWARD
        (+1) or BACKWARD (-1), or OPEN (2).
    slip_after : (k, n) array
        Slip of each node of `interface` at each of the steps after the end, until the window of the
        last slip rate ends [length].
    final_path : (n,) array
        Accumulated |slip| of each node of `interface` at the end [length], summed over every step,
        stored or not, and also while the node is open.
    final_work_density : (n,) array
        Energy per area dissipated by friction at each node until the end [stress length], likewise
        summed over every step.
    totals : Totals
        Totals of the contact at each step, stored or not.  Accumulated slip and frictional work are
        sums over all nodes with the lengths that belong to them, the edge node's included, so that
        the work is that of `energy`; the largest slip is that on the nodes of `interface`.
    opened : ContactOpening or None
        Where and when the contact came apart; None if it never did.
    slot : SlotHistory
        Motion of the slot nodes next to the edge, over the length that no reflection reaches.
    energy : EnergyHistory
        Energies of both blocks.
    seconds : dict
        Wall-clock time of each stage [s]: "mesh", "assembly", "steps" and, a part of the steps,
        "snapshots".
    run : str
        Identity of the run: the same for the same scene, options, mesh and versions.  Field
        snapshots carry it too.
    unwritten : str
        A sentence about files that could not be written during the run; empty if there are none.
    companion : Simulation or None
        The same run at twice the element size, which carries its own; see `with_companions`.

    Examples
    --------
    >>> from fem import simulate
    >>> from semianalytic import find
    >>> run = simulate(find("preloaded"), resolution=8)
    >>> run.interface.slip.shape == (run.steps + 1, len(run.interface.x))
    True
    >>> run.model, run.opened
    ('antisymmetric half', None)
    """

    scene: Scene
    end_time: float
    resolution: int
    element_size: float
    damping: float
    mesh: str
    model: str
    step_ratio: float
    time_step: float
    critical_step: float
    rate_window: float
    steps: int
    unknowns: int
    interface: InterfaceHistory
    state: NDArray[np.int8]
    slip_after: Array
    final_path: Array
    final_work_density: Array
    totals: Totals
    opened: ContactOpening | None
    slot: SlotHistory
    energy: EnergyHistory
    seconds: dict[str, float]
    run: str
    unwritten: str
    companion: Simulation | None = None

    def __repr__(self) -> str:
        return (
            f"Simulation({self.model}, {self.unknowns:,} unknowns, {self.steps} steps to "
            f"t = {self.end_time:.6g})"
        )

    @property
    def is_open(self) -> Mask:
        """Whether each node of `interface` is open in the step after each time, (m, n)."""
        return self.state == OPEN

    @property
    def caution(self) -> str:
        """Sentences on what the mesh is too coarse for; "" if nothing is known."""
        return mesh_caution(self.scene, self.end_time, self.resolution)

    @property
    def status(self) -> str:
        """The word "resolved", or "unresolved" if the mesh is too coarse: see `caution`."""
        return "unresolved" if self.caution else "resolved"

    @property
    def error_estimate(self) -> float:
        """Estimate of the relative L1 error of the slip rate over contact and time.

        It is 1.6 times the difference from the companion at half the resolution, divided by the
        slip rate; nan without a companion.
        """
        if self.companion is None:
            return float("nan")
        seen = self.companion.interface
        x, t = seen.x[seen.x <= self.interface.x[-1]], seen.t[seen.t <= self.interface.t[-1], None]
        fine, coarse = self.slip_rate(x, t), self.companion.slip_rate(x, t)
        apart, size = np.abs(fine - coarse).sum(), np.abs(fine).sum()
        return float(SAMPLED_SAFETY * apart / size) if size else 0.0

    def save(self, directory: str | Path) -> None:
        """Write `simulation.h5` into a folder, companions included.

        The file appears under its name only when it is complete.

        Parameters
        ----------
        directory : path
            The folder; it is made if it does not exist.

        Raises
        ------
        DataFileError
            If the file cannot be written.
        """
        write_answer(Path(directory) / FILE_NAME, FORMAT, self, compression=4)


@checking
def load_simulation(directory: str | Path) -> Simulation:
    """Read the simulation that `Simulation.save` wrote into a folder; DataFileError if its file is
    missing, damaged or not a simulation."""
    path = Path(directory) / FILE_NAME
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the folder of a finished simulation.")
    instead = "the folder of a finished simulation"
    return read_answer(path, FORMAT, Simulation, instead, "simulate again")


@checking
def opening_sentence(simulation: Simulation) -> str:
    """Return a sentence that states whether the contact opened and, if so, where, when, how far and
    over which length.

    Examples
    --------
    >>> from fem import simulate
    >>> from fem.results import opening_sentence
    >>> from semianalytic import find
    >>> opening_sentence(simulate(find("preloaded"), resolution=8))
    'the contact stayed closed'
    """
    opened = simulation.opened
    if opened is None:
        return "the contact stayed closed"
    units = simulation.scene.units
    x, gap, length = (
        with_unit(value, "length", units) for value in (opened.x, opened.gap, opened.length)
    )
    time = with_unit(opened.time, "time", units)
    return (
        f"the contact opened, first at x = {x} at t = {time}, by up to {gap} and over a length of "
        f"up to {length}"
    )
