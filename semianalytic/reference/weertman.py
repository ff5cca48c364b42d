"""Weertman's pulse: slip that runs along a closed interface of two solids and heals behind itself.

At the generalised Rayleigh speed slip does not change the shear traction, A = 0, but the pressure:
sigma = -V / (k D).  So a pulse of uniform slip rate, of any length and in any distribution, moves
under shear traction below friction wherever it relieves the pressure enough (Weertman 1980).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.thresholds import generalised_rayleigh_speed
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material


@dataclass(frozen=True)
class WeertmanPulse:
    """A pulse of uniform slip rate.

    Attributes
    ----------
    velocity : float
        Speed of the pulse, positive towards +x [length / time].
    slip_rate : float
        Relative slip rate inside it [length / time]; it has the sign of the shear traction.
    pressure : float
        Contact pressure inside it [stress].
    """

    velocity: float
    slip_rate: float
    pressure: float


def weertman_pulse(
    upper: Material, lower: Material, friction: float, pressure: float, shear: float
) -> WeertmanPulse:
    """The pulse that a uniform state of less shear traction than friction sustains.

    V = (f p_0 - |tau_0|) / (f N), N = 1 / (v |D(v)|) at A(v) = 0, with the functions A and D of
    `dissimilar.compliance`; it runs in the direction in which the slower body slides.

    Parameters
    ----------
    upper, lower : Material
    friction : float
        Coefficient f.
    pressure, shear : float
        p_0 > 0 and tau_0 on the interface before the pulse [stress].

    Raises
    ------
    SceneError
        If there is no generalised Rayleigh wave, or the shear traction is zero or reaches friction.
    """
    compliance = compliance_of(upper, lower)
    speed = generalised_rayleigh_speed(compliance)
    if speed is None or upper == lower:
        raise SceneError(
            "Weertman's pulse needs different bodies with a generalised Rayleigh wave; make their "
            "shear wave speeds more alike."
        )
    if not 0 < abs(shear) < friction * pressure:
        raise SceneError(
            "Weertman's pulse needs shear traction below friction, and not zero; got "
            f"{shear:.6g} under friction {friction * pressure:.6g}."
        )
    entries = compliance.on_cut(np.array([1 / speed]))
    # sigma = -V / (k D) on k = -v: kD is real there
    compliant = float((entries.coupling / entries.rayleigh).real[0])
    sense = float(np.sign(shear))
    rate = (friction * pressure - abs(shear)) / friction * abs(compliant)
    # towards +x, k = -v, pressure falls by V / (-k D): for the other sense towards -x
    direction = sense if compliant < 0 else -sense
    unit = upper.shear_speed / upper.shear_modulus
    return WeertmanPulse(
        direction * speed * upper.shear_speed, sense * rate * unit, abs(shear) / friction
    )
