"""How much shear the interface carries at this kick, under the friction law of the scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import FrictionLaw, RateWeakening, SlipWeakening


def strength(
    law: FrictionLaw,
    static: NDArray[np.float64],
    path: NDArray[np.float64],
    stopping: NDArray[np.float64],
    compliance: NDArray[np.float64],
    step: float,
) -> NDArray[np.float64]:
    """Largest shear traction of each pair [stress], (n,).

    Slip weakening takes the slip accumulated up to this time level, rate weakening the slip rate
    in the step after it.

    Parameters
    ----------
    law : FrictionLaw
    static : (n,) array
        The scene's friction times pressure [stress].
    path : (n,) array
        Accumulated |slip| [length].
    stopping : (n,) array
        Traction that would stop the pair at this step [stress].
    compliance : (n,) array
        Slip over the step taken away per traction [length / stress].
    step : float
        dt [time].

    Raises
    ------
    SceneError
        If friction falls with slip rate faster than a pair of nodes can radiate.
    """
    if isinstance(law, RateWeakening):
        _check_radiation(law, static, step / compliance)
        excess = np.maximum(np.abs(stopping) - static, 0.0)
        return static * law.factor(slip_rate(law, static, excess, compliance, step), path)
    if isinstance(law, SlipWeakening):
        return static * law.factor(0.0, path)
    return static


def slip_rate(
    law: RateWeakening,
    static: NDArray[np.float64],
    excess: NDArray[np.float64],
    compliance: NDArray[np.float64],
    step: float,
) -> NDArray[np.float64]:
    """|V| in the step after this kick, at which weakened friction and motion agree, (n,).

    With the slip D over the step, the excess e over static strength S and the compliance c,

        D = c [ e + S reduction D / (D + rate dt) ],

    a quadratic with one root D >= 0, which grows from 0 with e as long as friction falls more
    slowly than the nodes radiate.

    Parameters
    ----------
    law : RateWeakening
    static : (n,) array
        S [stress].
    excess : (n,) array
        How much more than S would be needed to stop the pair, >= 0 [stress].
    compliance : (n,) array
        c [length / stress].
    step : float
        dt [time].
    """
    knee = law.rate * step
    linear = knee - compliance * (excess + static * law.reduction)
    root = np.sqrt(linear**2 + 4 * knee * compliance * excess)
    return (root - linear) / (2 * step)


def _check_radiation(
    law: RateWeakening, static: NDArray[np.float64], radiated: NDArray[np.float64]
) -> None:
    slope = static * law.reduction / law.rate
    worst = int(np.argmax(slope / radiated))
    if slope[worst] >= radiated[worst]:
        raise SceneError(
            "simulate: friction falls with slip rate faster than a node of the interface can "
            f"radiate (by {slope[worst]:.4g} per slip rate under the pressure it has reached, its "
            f"impedance is {radiated[worst]:.4g}); raise the rate or lower the reduction of the "
            "friction law, or lower `step_ratio`."
        )
