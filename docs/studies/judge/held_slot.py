"""Prediction of a theory that glues the slot shut for slip, with the kernels (4.31), (4.37)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct

from semianalytic import Scene
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import impedance_of
from semianalytic.memory.line_memory import LineMemory
from semianalytic.spacetime.grid.line import damped
from semianalytic.spacetime.grid.nodes import causal_grid

Array = NDArray[np.float64]

_STEP_RATIO, _DAMPING, _TOLERANCE, _SWEEPS = 0.45, 0.7, 1e-5, 2


@dataclass(frozen=True, eq=False)
class HeldSlot:
    """Fields of the contact at the end of a march, (n,) arrays by velocity x/T > 0.

    Attributes
    ----------
    velocity : [length / time]
    slip_rate : relative [length / time]
    shear_traction : base included [stress]
    """

    velocity: Array
    slip_rate: Array
    shear_traction: Array


def held_slot(scene: Scene, nodes: int) -> HeldSlot:
    """March a self-similar scene whose slot faces stay where the load alone brings them.

    The stuck tractions are right, diffracted by the slot; what slip adds to them is taken from the
    kernel of an interface that is glued on x < 0, so that the slot does not send slip back.

    Parameters
    ----------
    scene : Scene
        Of step loads and constant friction.
    nodes : int
        On 0 < x < 1.1 c_l, marched until the time 1.
    """
    material, (held, load) = scene.material, scene.superposition
    grid = causal_grid(scene, 1.0, 1.1 * material.longitudinal_speed, nodes)
    x = (np.arange(grid.size - grid.slot) + 0.5) * grid.spacing
    steps = int(np.ceil(material.shear_speed / (_STEP_RATIO * grid.spacing)))
    length = material.shear_speed / steps
    fit = fit_memory(
        impedance_of(scene), material.shear_speed * float(grid.wavenumbers[-1]), _TOLERANCE
    )
    memory = LineMemory(fit, grid.wavenumbers)
    feedback = damped(memory.table(length).feedback[0], grid.wavenumbers, _DAMPING)
    impedance = material.shear_impedance / 2
    tables = [stuck_traction(material.poisson_ratio, mode) for mode in ("II", "I")]

    def contact_rate(time: float, past: Array) -> tuple[Array, Array]:
        """Slip rate and traction of the contact under what the past exerts."""
        u = time * material.shear_speed / x
        shear, pressure = (table(u) for table in tables)
        stopping = held.shear + load.shear * shear - impedance * past
        strength = scene.friction * (held.pressure + load.pressure * pressure)
        speed = np.maximum(np.abs(stopping) - strength, 0.0) / impedance
        rate = np.copysign(speed, stopping)
        return rate, stopping - impedance * rate

    def cosines(rate: Array) -> Array:
        return np.asarray(dct(np.concatenate([np.zeros(grid.slot), rate]), type=2))

    rate, traction = contact_rate(0.0, np.zeros(len(x)))
    transform = cosines(rate)
    for step in range(1, steps + 1):
        past = memory.advance(transform[None], length)[0, 0]
        for _ in range(_SWEEPS):
            exertion = idct(past + feedback * transform, type=2)[grid.contact]
            rate, traction = contact_rate(step / steps, exertion)
            transform = cosines(rate)
    seen = slice(0, grid.observed)
    return HeldSlot(np.asarray(x[seen]), rate[seen], traction[seen])
