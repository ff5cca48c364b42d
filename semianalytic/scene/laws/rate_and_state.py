"""Rate-and-state friction with the ageing or the slip law, and flash heating."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_word
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.delay import DelayedLaw
from semianalytic.scene.laws.law import not_negative, positive
from semianalytic.scene.quantities import with_quantities


@with_quantities
@dataclass(frozen=True, eq=False, repr=False)
class RateAndState(DelayedLaw):
    """Rate-and-state friction, regularised: a p arcsinh[(V / 2 V0) exp((f0 + b ln(V0 theta/L))/a)].

    The state theta [time] follows the ageing law, theta' = 1 - V theta / L, or the slip law,
    theta' = -(V theta / L) ln(V theta / L).  With `weakened` and `weakening_rate` steady friction
    falls to f_w + (f - f_w) / (1 + (V / V_w)^8)^(1/8) at high slip rates (flash heating; slip law).

    Parameters
    ----------
    a, b : field
        Direct effect and evolution of friction; a is positive.
    f0, v0 : field
        Steady friction f0 at the slip rate v0 [length / time].
    distance : field
        Slip L over which the state changes [length].
    evolution : str
        "ageing" or "slip".
    theta : field, optional
        State at t = 0 [time].  By default it is such that the base shear is carried at the slip
        rate at which the interface starts.
    weakened, weakening_rate : field, optional
        Friction f_w and slip rate V_w of flash heating.
    delay, delay_slip : field
        Time [time] and slip [length] over which friction follows pressure; see `DelayedLaw`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import RateAndState
    >>> law = RateAndState(a=0.01, b=0.015, f0=0.6, v0=1e-6, distance=1e-5)
    >>> round(float(law.strength(1.0, 1e-6, 10.0)), 6)
    0.6
    """

    a: Any
    b: Any
    f0: Any
    v0: Any
    distance: Any
    evolution: str = "ageing"
    theta: Any = None
    weakened: Any = None
    weakening_rate: Any = None

    has_threshold = False
    _not_negative = ("b", "f0")
    _positive = ("a", "v0", "distance")

    def __post_init__(self) -> None:
        super().__post_init__()
        owner = "RateAndState"
        checked_word(f"{owner}: evolution", self.evolution, ("ageing", "slip"))
        if self.theta is not None:
            positive(owner, theta=self.theta)
        if (self.weakened is None) != (self.weakening_rate is None):
            raise SceneError(f"{owner}: give weakened and weakening_rate together, or neither.")
        if self.weakened is not None:
            not_negative(owner, weakened=self.weakened)
            positive(owner, weakening_rate=self.weakening_rate)
            if self.evolution != "slip":
                raise SceneError(f'{owner}: flash heating needs evolution = "slip".')

    def _exponent(self, state: Array) -> Array:
        """Return E = (f0 + b ln(V0 theta / L)) / a."""
        return np.asarray((self.f0 + self.b * np.log(self.v0 * state / self.distance)) / self.a)

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return a p arcsinh(...); see `Law.strength`."""
        # arcsinh(y) from ln y: no overflow however large the exponent
        log = np.log(speed / (2 * self.v0)) + self._exponent(state)
        return np.asarray(self.a * pressure * _arcsinh_exp(log))

    def slip_speed(
        self, stopping: Array, pressure: Array, impedance: Array | float, state: Array
    ) -> Array:
        """Return the speed of balance; see `Law.slip_speed`.

        With V = V0 (e^(x - E) - e^(-x - E)) the balance a p x + impedance V = stopping is convex
        and rising in x.  Where x is large the second term is below rounding, and the balance has
        the closed solution impedance V = a p omega(y); elsewhere Newton's method starts from there
        and stays on the right of the root after its first step.
        """
        # e^700 times V0 is already a speed at which friction carries nothing
        exponent = np.maximum(self._exponent(state), -700.0)
        # without pressure the balance is stopping = impedance V, to rounding
        scale = np.maximum(self.a * pressure, np.maximum(1e-16 * stopping, 1e-300))
        knee, most = impedance * self.v0, stopping / scale
        omega = _wright_omega(most - exponent + np.log(knee / scale))
        x = most - omega
        # e^-x is below the rounding of e^x; with 10 the slip rate is off by 2e-9. Smaller omega are
        # left to Newton's method.
        if ((x > 20.0) & (omega > 1e-290)).all():
            return np.asarray(scale / impedance * omega)
        x = np.minimum(np.maximum(x, 0.0), most)
        for _ in range(60):  # 1 to 4 were needed in 20,000 random cases
            # 2 sinh x = e^x (1 - e^(-2x)), which keeps its digits at small x
            rising, small = knee * np.exp(x - exponent), -np.expm1(-2 * x)
            change = (scale * x + rising * small - stopping) / (scale + rising * (2 - small))
            x = np.minimum(np.maximum(x - change, 0.0), most)
            # convergence is quadratic: a change of 1e-8 leaves an error of 1e-16
            if (np.abs(change) <= 1e-8 * np.minimum(x, 1.0)).all():
                break
        return np.asarray(self.v0 * np.exp(x - exponent) * -np.expm1(-2 * x))

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the state after a time at a mean speed, exactly; see `Law.evolved`."""
        share = speed * time / self.distance
        if self.evolution == "ageing":
            # theta e^-y + (L/V)(1 - e^-y); (1 - e^-y)/y tends to 1 at rest
            mean = np.where(share > 1e-12, -np.expm1(-share) / share, 1.0)
            return np.asarray(state * np.exp(-share) + time * mean)
        fallen = np.exp(-share)
        steady = self._steady(np.maximum(speed, 1e-300))
        return np.asarray(np.exp(fallen * np.log(state) + (1 - fallen) * steady))

    def _steady(self, speed: Array) -> Array:
        """Return ln theta in steady sliding at a speed > 0."""
        plain = np.log(self.distance / speed)
        if self.weakened is None:
            return np.asarray(plain)
        # f0 + (a - b) ln(V/V0), regularised like strength: it would be negative at rest if a > b
        logs = np.log(speed / self.v0)
        low = self.a * _arcsinh_exp(logs - np.log(2) + (self.f0 - self.b * logs) / self.a)
        # flash heating leaves exp(-heating), and no difference may lose the digits of a small `low`
        heating = np.logaddexp(0.0, 8 * np.log(speed / self.weakening_rate)) / 8
        steady = low * np.exp(-heating) - self.weakened * np.expm1(-heating)
        return self._theta(steady, speed)

    def _theta(self, friction: Array, speed: Array) -> Array:
        """Return ln theta at which friction is carried at a speed > 0."""
        # 2 sinh x = e^x (1 - e^-2x)
        x = friction / self.a
        exponent = x + np.log(-np.expm1(-2 * x)) - np.log(speed / self.v0)
        power = (self.a * exponent - self.f0) / self.b
        return np.asarray(power + np.log(self.distance / self.v0))

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return theta at t = 0; see `Law.start`."""
        if self.theta is not None:
            return np.broadcast_to(np.asarray(self.theta, dtype=float), pressure.shape).copy()
        carried = np.abs(shear) / pressure
        if not ((carried > 0) & (speed > 0)).all() or np.any(np.asarray(self.b) == 0):
            raise SceneError(
                "RateAndState: give `theta`, or a base shear and a `b` that are not zero and the "
                "`rate` of the scene, at which it slips at the start."
            )
        state = np.exp(self._theta(carried, speed))
        if not (np.isfinite(state) & (state > 0)).all():
            raise SceneError(
                "RateAndState: no state carries the base shear at the slip rate at the start; "
                "change `rate` or give `theta`."
            )
        return state

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the direct effect, about a p / V; see `Law.rate_slope`."""
        # d/dV of a p arcsinh(c V) = a p / sqrt(V^2 + c^-2)
        least = 2 * self.v0 * np.exp(np.minimum(-self._exponent(state), 700.0))
        return np.asarray(self.a * pressure / np.maximum(np.hypot(speed, least), 1e-300))

    def state_slip(self) -> Any:
        """Return L; see `Law.state_slip`."""
        return self.distance

    def weakening(self, pressure: Array) -> float:
        """Return b p / L, the fall of strength behind a rapid front [stress / length]."""
        return float(np.max(self.b * pressure / self.distance, initial=0.0))


def _wright_omega(y: Array) -> Array:
    """Return omega with omega + ln omega = y, to rounding where it is above 1e-290.

    Two steps of fourth order (Fritsch, Shafer and Crowley 1973) from ln(1 + e^y), which has both
    limits, e^y and y.  `scipy.special.wrightomega` takes a quarter more time.
    """
    omega = np.maximum(y, 0.0) + np.log1p(np.exp(-np.abs(y)))
    for _ in range(2):
        omega = np.maximum(omega, 1e-300)  # where e^y underflows
        rest, slope = y - omega - np.log(omega), 1 + omega
        both = 2 * slope * (slope + 2 / 3 * rest)
        omega = omega * (1 + rest / slope * (both - rest) / (both - 2 * rest))
    return np.asarray(omega)


def _arcsinh_exp(log: Array) -> Array:
    """Return arcsinh(e^log), also where e^log overflows or underflows."""
    # ln(e^l + sqrt(e^2l + 1)) = l + ln(1 + sqrt(1 + e^-2l)) for l > 0
    above = np.maximum(log, 0.0)
    large = above + np.log1p(np.sqrt(1 + np.exp(-2 * above)))
    return np.where(log > 0, large, np.arcsinh(np.exp(np.minimum(log, 0.0))))
