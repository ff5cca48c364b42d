"""The memories of slip and of opening that an interface needs on a grid until a time."""

from __future__ import annotations

import math

from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.tuning import (
    LARGEST_HORIZON,
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
    # The memory of an event with its echoes; later only the static stiffness acts.
    reach = math.pi / grid.spacing * min(speed * end_time, 20.0 * interface.length)
    horizon = min(max(reach, 100.0), LARGEST_HORIZON)
    # rounded up to a power of 2, so that runs of different lengths share a fit
    horizon = min(2.0 ** math.ceil(math.log2(horizon)), LARGEST_HORIZON)
    # Rungs whose tables are kept: 8 MB each at 4,096 nodes and 42 poles.
    line = grid.wavenumbers, 1 if grid.even else 2, 8
    if pair is not None:
        # The three kernels of different bodies take 33 to 59 poles.
        fit = fit_shared(pair.kernels, horizon, 1e-6)
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
