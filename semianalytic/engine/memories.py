"""The memories of slip and of opening that an interface needs on a grid until a time."""

from __future__ import annotations

import math

from semianalytic.engine.line import Grid
from semianalytic.engine.tuning import (
    CROSSINGS,
    LARGEST_HORIZON,
    LEAST_HORIZON,
    PAIR_TOLERANCE,
    TABLES,
)
from semianalytic.interface.interface import Interface
from semianalytic.memory.exponentials import fit_memory, fit_shared
from semianalytic.memory.impedance import Antiplane, InPlane, Opening
from semianalytic.memory.line_memory import CoupledMemory, LineMemory


def memories(
    interface: Interface, grid: Grid, end_time: float, tolerance: float
) -> tuple[LineMemory, LineMemory | None, float]:
    """Return the memories of slip and opening, and the traction over wavenumber and slip [stress].

    That of opening is None where nothing opens.  `tolerance` is the relative error of the transform
    between identical bodies.
    """
    material, pair = interface.material, interface.pair
    speed = material.shear_speed if pair is None else pair.speed
    reach = math.pi / grid.spacing * min(speed * end_time, CROSSINGS * interface.length)
    horizon = min(max(reach, LEAST_HORIZON), LARGEST_HORIZON)
    # rounded up to a power of 2, so that runs of different lengths share a fit
    horizon = min(2.0 ** math.ceil(math.log2(horizon)), LARGEST_HORIZON)
    line = grid.wavenumbers, 1 if grid.even else 2, TABLES
    if pair is not None:
        fit = fit_shared(pair.kernels, horizon, PAIR_TOLERANCE)
        direct = pair.kernels.direct
        slip, gap = (CoupledMemory(fit, own, float(direct[own]), *line) for own in (0, 1))
        return slip, gap, pair.stiffness
    ratio = material.shear_speed / material.longitudinal_speed
    impedance = Antiplane() if interface.mode == "antiplane" else InPlane(ratio)
    memory = LineMemory(fit_memory(impedance, horizon, tolerance), *line)
    stiffness = impedance.static * material.shear_modulus / 2
    if not interface.may_open:
        return memory, None, stiffness
    return memory, LineMemory(fit_memory(Opening(ratio), horizon, tolerance), *line), stiffness
