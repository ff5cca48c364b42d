"""A loaded pair in its own units, and the exponents at the edges of its zones.

Slowness is in units of b of the upper body, stress in the larger of the two steps on the slot
faces, and rates of slip and opening, which are relative, in that over mu b of the upper body.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semianalytic.dissimilar.compliance import Body, Compliance, compliance_of
from semianalytic.dissimilar.phase import SlipPhase, contact_phase, rayleigh_phases, slip_phase
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.scene import Material, Scene, Tractions


@dataclass(frozen=True)
class LoadedBodies:
    """Two half-planes, f, eta of a film per relative slip rate [mu b], and P_b, Q_b, P_0, Q_0."""

    compliance: Compliance
    friction: float
    resistance: float
    base_pressure: float
    base_shear: float
    load_pressure: float
    load_shear: float

    @property
    def rayleigh_slownesses(self) -> tuple[float, float]:
        """Slownesses of the Rayleigh waves of the free faces, upper and lower."""
        upper, lower = self.compliance.bodies
        return rayleigh_slowness(upper), rayleigh_slowness(lower)

    def level(self, sense: int) -> float:
        """Return s f P_b - Q_b, to which tau + s f sigma is equal in sense s without a film."""
        return sense * self.friction * self.base_pressure - self.base_shear

    def slip_phase(self, sense: int) -> SlipPhase:
        """Return the phase theta_K for slip of a sense."""
        return _slip_phase(self.compliance, sense * self.friction, self.resistance)

    def slip_turn(self, sense: int, u: float) -> float:
        """Return theta_K / pi at slowness u."""
        return self.slip_phase(sense).at(u) / np.pi

    def open_turn(self, sense: int, u: float) -> float:
        """Return theta_N / pi at slowness u, N = 1 / (A + s f k D), near slip of a sense."""
        # N = R_1 R_2 / (Phi R_1 R_2): both phases are of functions that are regular on the cut.
        free = sum(phase.at(u) for phase in _rayleigh_phases(self.compliance))
        return (free - _contact_phase(self.compliance, sense * self.friction).at(u)) / np.pi

    def edge_decay(self, sense: int) -> float:
        """Return lambda = 1/2 - arctan(s f beta) / pi of V' ~ v^(lambda - 2), or v^(-2), at an
        edge.
        """
        return 0.5 - float(np.arctan(sense * self.friction * self.compliance.dundurs)) / np.pi

    def sharp_turns(self, sense: int, opened: bool) -> tuple[float, ...]:
        """Return slownesses where hidden zeros make the equations of a zone change fast."""
        phase = self.slip_phase(sense)
        turns = phase.denominator.sharp_turns
        return turns if opened else tuple(sorted({*turns, *phase.numerator.sharp_turns}))


@lru_cache(maxsize=64)
def rayleigh_slowness(body: Body) -> float:
    """Return the slowness of the Rayleigh wave of a free body."""
    # The Rayleigh speed over c_t depends on the ratio of the body waves alone: any solid of this
    # Poisson ratio has it.
    ratio = (body.a / body.b) ** 2
    poisson_ratio = (1 - 2 * ratio) / (2 * (1 - ratio))
    return body.b / Material(1.0, 1.0, poisson_ratio).rayleigh_speed


def interface_of(scene: Scene) -> tuple[LoadedBodies, float]:
    """Return a scene of two bodies in its own units, and the unit of stress."""
    assert isinstance(scene.load, Tractions)
    assert type(scene.law) is Coulomb
    base, load = scene.base, scene.load
    # Without a load nothing moves; the base then serves for a unit that is not 0.
    unit = max(abs(load.pressure), abs(load.shear)) or scene.base.pressure
    # Rates are relative here, as those of the film: no factor of 2, unlike identical bodies.
    resistance = scene.law.viscosity / scene.material.shear_impedance
    tractions = (part / unit for both in (base, load) for part in (both.pressure, both.shear))
    compliance = compliance_of(*scene.bodies)
    return LoadedBodies(compliance, scene.coefficient, resistance, *tractions), unit


_slip_phase = lru_cache(maxsize=64)(slip_phase)
_contact_phase = lru_cache(maxsize=64)(contact_phase)
_rayleigh_phases = lru_cache(maxsize=64)(rayleigh_phases)
