"""Laws of friction of interfaces: Coulomb, viscous, weakening with slip or rate, rate-and-state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.law import InterfaceLaw, not_negative, positive
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

BALANCE = 60
"""Most Newton steps for the local balance of rate-and-state friction, which takes 1 to 4 (in
20,000 random cases from 1e-300 m/s to 100 m/s): half as many or twice as many change nothing."""

DIMENSIONS: Mapping[str, str] = {
    **dict.fromkeys(("friction", "static", "dynamic", "a", "b", "f0", "weakened"), "1"),
    **{"cohesion": "stress", "viscosity": "stress time / length"},
    **dict.fromkeys(("delay", "theta", "arrival", "fall"), "time"),
    **dict.fromkeys(("distance", "delay_slip"), "length"),
    **dict.fromkeys(("rate", "v0", "weakening_rate"), "length / time"),
}
"""Dimensions of the parameters of laws by name; those of other laws may go by the same names."""


@dataclass(frozen=True, eq=False)
class Coulomb(InterfaceLaw):
    """Strength f p + cohesion + viscosity |V|, whatever the slip so far.

    With a delay, friction follows a pressure p' that lags behind p (Prakash and Clifton 1993,
    simplified): dp'/dt = (p - p') (1/delay + |V|/delay_slip), where a delay of 0 is left out.
    The state of the law is p' then.  Between different bodies only this makes most friction
    well-posed (docs/dissimilar.md).

    Parameters
    ----------
    friction : field
        Coefficient f; a number, a function of x or a `Table`, like all parameters of laws.
    cohesion : field
        Strength without pressure [stress].
    viscosity : field
        Traction per slip rate [stress time / length].
    delay : field
        Time t* in which friction follows pressure [time]; 0 for none.
    delay_slip : field
        Slip L over which friction follows pressure [length]; 0 for none.

    Raises
    ------
    SceneError
        If a parameter is negative or not finite.

    Examples
    --------
    >>> from semianalytic import Coulomb
    >>> Coulomb(0.6, cohesion=1.0, viscosity=0.5).strength(10.0, 2.0, 0.0)
    8.0
    >>> slow = Coulomb(0.6, delay=1.0)
    >>> round(float(slow.evolved_under(10.0, 0.0, 1.0, 20.0, 20.0)), 6)  # 20 - 10 / e
    16.321206
    """

    friction: Any
    cohesion: Any = 0.0
    viscosity: Any = 0.0
    delay: Any = 0.0
    delay_slip: Any = 0.0

    def __post_init__(self) -> None:
        not_negative(
            "Coulomb",
            friction=self.friction,
            cohesion=self.cohesion,
            viscosity=self.viscosity,
            delay=self.delay,
            delay_slip=self.delay_slip,
        )

    @property
    def is_delayed(self) -> bool:
        """Whether friction lags behind the pressure anywhere."""
        return any(callable(one) or np.any(one) for one in (self.delay, self.delay_slip))

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return f p + cohesion + viscosity |V|; see `InterfaceLaw.strength`."""
        felt = state if self.is_delayed else pressure
        return self.friction * felt + self.cohesion + self.viscosity * speed

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        dry = self.strength(pressure, np.zeros(np.shape(pressure)), state)
        return np.maximum(stopping - dry, 0.0) / (impedance + self.viscosity)

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the viscosity; see `InterfaceLaw.rate_slope`."""
        return np.broadcast_to(np.asarray(self.viscosity, dtype=float), pressure.shape)

    def pressure_delay(self, speed: Array) -> Any:
        """Return the time in which friction follows pressure; see `InterfaceLaw.pressure_delay`."""
        if not self.is_delayed:
            return 0.0
        with np.errstate(divide="ignore"):
            return 1 / self._pace(speed)

    def _pace(self, speed: Array) -> Array:
        """Return 1/delay + |V|/delay_slip [1 / time]; inf where there is no delay at all."""
        delay, slip = np.asarray(self.delay, dtype=float), np.asarray(self.delay_slip, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            own = np.where(delay > 0, 1 / delay, np.where(slip > 0, 0.0, np.inf))
            return np.asarray(own + np.where(slip > 0, speed / slip, 0.0))

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return the pressure that friction follows at t = 0; see `InterfaceLaw.start`."""
        return np.array(pressure) if self.is_delayed else np.zeros(len(pressure))

    def evolved_under(
        self, state: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Array:
        """Return the state after a time, exactly; see `InterfaceLaw.evolved_under`."""
        if not self.is_delayed:
            return self.evolved(state, speed, time)
        lag = np.asarray(self._pace(speed) * time)
        left = np.exp(-lag)
        # Mean of exp(-lag s) over the step: the share of the pressure at its end that is missing.
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(lag > 1e-8, -np.expm1(-lag) / lag, 1 - lag / 2)
            mean = np.where(lag < np.inf, mean, 0.0)
        return np.asarray(left * state + (mean - left) * before + (1 - mean) * after)


@dataclass(frozen=True, eq=False)
class SlipDependent(InterfaceLaw):
    """Friction that falls with accumulated slip from static to dynamic, linearly or exponentially.

    Strength is (f_d + (f_s - f_d) w) p + cohesion w, with w = max(1 - slip / distance, 0), or
    exp(-slip / distance).

    Parameters
    ----------
    static, dynamic : field
        Coefficients before and after weakening.
    distance : field
        Slip over which friction falls, or falls by a factor e [length].
    cohesion : field
        Strength without pressure, lost with slip [stress].
    shape : str
        "linear" or "exponential".

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import SlipDependent
    >>> law = SlipDependent(static=0.6, dynamic=0.2, distance=0.4)
    >>> law.strength(1.0, 0.0, np.array([0.0, 0.2, 1.0])).round(6).tolist()
    [0.6, 0.4, 0.2]
    """

    static: Any
    dynamic: Any
    distance: Any
    cohesion: Any = 0.0
    shape: str = "linear"

    def __post_init__(self) -> None:
        owner = "SlipDependent"
        not_negative(owner, static=self.static, dynamic=self.dynamic, cohesion=self.cohesion)
        positive(owner, distance=self.distance)
        if self.shape not in ("linear", "exponential"):
            raise SceneError(
                f"{owner}: shape must be linear or exponential, got {shown(self.shape)}."
            )

    def _left(self, state: Array) -> Array:
        if self.shape == "linear":
            return np.maximum(1 - state / self.distance, 0.0)
        return np.exp(-state / self.distance)

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the weakened strength; see `InterfaceLaw.strength`."""
        left = self._left(state)
        friction = self.dynamic + (self.static - self.dynamic) * left
        return np.asarray(friction * pressure + self.cohesion * left + 0 * speed)

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        weakened = self.strength(pressure, np.zeros(len(pressure)), state)
        return np.asarray(np.maximum(stopping - weakened, 0.0) / impedance)

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return 0; see `InterfaceLaw.rate_slope`."""
        return np.zeros(len(pressure))

    def weakening(self, pressure: Array) -> float:
        """Return the steepest fall [stress / length]; see `InterfaceLaw.weakening`."""
        fall = (self.static - self.dynamic) * pressure + self.cohesion
        return float(np.max(fall / self.distance))


@dataclass(frozen=True, eq=False)
class ForcedFront(InterfaceLaw):
    """Friction that falls from static to dynamic when a front arrives, whatever the slip.

    The state is the time since t = 0.  With a static friction that is never reached the front is
    that of a rupture of prescribed speed (Kostrov 1964).

    Parameters
    ----------
    static, dynamic : field
        Coefficients before and after the front.
    arrival : field
        Time at which the front arrives [time], such as ``lambda x: abs(x) / speed``.
    fall : field
        Time over which friction falls from then on [time]; 0 for at once.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import ForcedFront
    >>> law = ForcedFront(static=0.6, dynamic=0.2, arrival=1.0, fall=2.0)
    >>> law.strength(1.0, 0.0, np.array([0.5, 2.0, 4.0])).round(6).tolist()
    [0.6, 0.4, 0.2]
    """

    static: Any
    dynamic: Any
    arrival: Any
    fall: Any = 0.0

    def __post_init__(self) -> None:
        owner = "ForcedFront"
        not_negative(owner, static=self.static, dynamic=self.dynamic, fall=self.fall)

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the time since t = 0; see `InterfaceLaw.evolved`."""
        return state + time

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength at a time; see `InterfaceLaw.strength`."""
        since, fall = state - self.arrival, np.asarray(self.fall, dtype=float)
        gone = np.where(fall > 0, np.clip(since / np.where(fall > 0, fall, 1.0), 0, 1), since >= 0)
        friction = self.static + (self.dynamic - self.static) * gone
        return np.asarray(friction * pressure + 0 * speed)

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        strength = self.strength(pressure, np.zeros(len(pressure)), state)
        return np.asarray(np.maximum(stopping - strength, 0.0) / impedance)

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return 0; see `InterfaceLaw.rate_slope`."""
        return np.zeros(len(pressure))


@dataclass(frozen=True, eq=False)
class RateDependent(InterfaceLaw):
    """Friction that falls with slip rate: f_d + (f_s - f_d) / (1 + |V| / rate), times pressure.

    Parameters
    ----------
    static, dynamic : field
        Coefficients at rest and at high speed.
    rate : field
        Slip rate at which half the difference is lost [length / time].
    cohesion : field
        Strength without pressure [stress].

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> from semianalytic import RateDependent
    >>> RateDependent(0.6, 0.2, rate=1.0).strength(1.0, 1.0, 0.0)
    0.4
    """

    static: Any
    dynamic: Any
    rate: Any
    cohesion: Any = 0.0

    def __post_init__(self) -> None:
        owner = "RateDependent"
        not_negative(owner, static=self.static, dynamic=self.dynamic, cohesion=self.cohesion)
        positive(owner, rate=self.rate)

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength at a speed; see `InterfaceLaw.strength`."""
        friction = self.dynamic + (self.static - self.dynamic) / (1 + speed / self.rate)
        return friction * pressure + self.cohesion

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        # Multiplied by (V + rate), the balance is a quadratic in w = impedance V.
        excess = stopping - self.static * pressure - self.cohesion
        knee = impedance * self.rate
        linear = excess + (self.static - self.dynamic) * pressure - knee
        root = np.sqrt(np.maximum(linear**2 + 4 * knee * excess, 0.0))
        return np.where(excess > 0, (linear + root) / 2, 0.0) / impedance


@dataclass(frozen=True, eq=False)
class RateAndState(InterfaceLaw):
    """Rate-and-state friction, regularised: a p arcsinh[(V / 2 V0) exp((f0 + b ln(V0 theta/L))/a)].

    The state theta [time] follows the ageing law, theta' = 1 - V theta / L, or the slip law,
    theta' = -(V theta / L) ln(V theta / L).  With `weakened` and `weakening_rate` steady friction
    falls to f_w + (f - f_w) / (1 + (V / V_w)^8)^(1/8) at speed (flash heating; slip law).

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

    def __post_init__(self) -> None:
        owner = "RateAndState"
        positive(owner, a=self.a, v0=self.v0, distance=self.distance)
        not_negative(owner, b=self.b, f0=self.f0)
        if self.evolution not in ("ageing", "slip"):
            raise SceneError(
                f"{owner}: evolution must be ageing or slip, got {shown(self.evolution)}."
            )
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
        """Return a p arcsinh(...); see `InterfaceLaw.strength`."""
        with np.errstate(divide="ignore"):
            # arcsinh(y) from ln y: no overflow however large the exponent
            log = np.log(speed / (2 * self.v0)) + self._exponent(state)
        return np.asarray(self.a * pressure * _arcsinh_exp(log))

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`.

        With V = V0 (e^(x - E) - e^(-x - E)) the balance a p x + impedance V = stopping is convex
        and rising in x: Newton's method stays on the right of the root after its first step.
        """
        # e^700 times V0 is already a speed at which friction carries nothing
        exponent = np.maximum(self._exponent(state), -700.0)
        # without pressure the balance is stopping = impedance V, to rounding
        scale = np.maximum(self.a * pressure, np.maximum(1e-16 * stopping, 1e-300))
        knee, most = impedance * self.v0, stopping / scale
        # Without e^(-x - E), which counts below x = 20 alone, the root is x = most - omega(y).
        x = np.clip(most - _wright_omega(most - exponent + np.log(knee / scale)), 0.0, most)
        for _ in range(BALANCE):
            # 2 sinh x = e^x (1 - e^(-2x)), which keeps its digits at small x
            rising, small = knee * np.exp(x - exponent), -np.expm1(-2 * x)
            change = (scale * x + rising * small - stopping) / (scale + rising * (2 - small))
            x = np.clip(x - change, 0.0, most)
            # convergence is quadratic: a change of 1e-8 leaves an error of 1e-16
            if (np.abs(change) <= 1e-8 * np.minimum(x, 1.0)).all():
                break
        return np.asarray(self.v0 * np.exp(x - exponent) * -np.expm1(-2 * x))

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the state after a time at a mean speed, exactly; see `InterfaceLaw.evolved`."""
        share = speed * time / self.distance
        if self.evolution == "ageing":
            # theta e^-y + (L/V)(1 - e^-y); (1 - e^-y)/y tends to 1 at rest
            with np.errstate(invalid="ignore", divide="ignore"):
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
        low = self.f0 + (self.a - self.b) * np.log(speed / self.v0)
        steady = self.weakened + (low - self.weakened) * np.exp(
            -np.logaddexp(0.0, 8 * np.log(speed / self.weakening_rate)) / 8
        )
        return self._theta(steady, speed)

    def _theta(self, friction: Array, speed: Array) -> Array:
        """Return ln theta at which friction is carried at a speed > 0."""
        # 2 sinh x = e^x (1 - e^-2x)
        x = friction / self.a
        exponent = x + np.log(-np.expm1(-2 * x)) - np.log(speed / self.v0)
        power = (self.a * exponent - self.f0) / self.b
        return np.asarray(power + np.log(self.distance / self.v0))

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return theta at t = 0; see `InterfaceLaw.start`."""
        if self.theta is not None:
            return np.broadcast_to(np.asarray(self.theta, dtype=float), pressure.shape).copy()
        carried = np.abs(shear) / pressure
        if not ((carried > 0) & (speed > 0)).all() or np.any(np.asarray(self.b) == 0):
            raise SceneError(
                "RateAndState: give `theta`, or a base shear, a slip rate at the start (`rate`) "
                "and a `b` that are not zero."
            )
        state = np.exp(self._theta(carried, speed))
        if not (np.isfinite(state) & (state > 0)).all():
            raise SceneError(
                "RateAndState: no state carries the base shear at the slip rate at the start; "
                "change `rate` or give `theta`."
            )
        return state

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the direct effect, about a p / V; see `InterfaceLaw.rate_slope`."""
        # d/dV of a p arcsinh(c V) = a p / sqrt(V^2 + c^-2)
        least = 2 * self.v0 * np.exp(np.minimum(-self._exponent(state), 700.0))
        return np.asarray(self.a * pressure / np.maximum(np.hypot(speed, least), 1e-300))

    def state_slip(self) -> Any:
        """Return L; see `InterfaceLaw.state_slip`."""
        return self.distance

    def weakening(self, pressure: Array) -> float:
        """Return b p / L, the fall of strength behind a rapid front [stress / length]."""
        return float(np.max(self.b * pressure / self.distance))


def _wright_omega(y: Array) -> Array:
    """Return omega with omega + ln omega = y, to about 1e-4.

    One step of fourth order (Fritsch, Shafer and Crowley 1973) from ln(1 + e^y), which has both
    limits, e^y and y.  `scipy.special.wrightomega` takes as long as five steps of the balance.
    """
    omega = np.maximum(y, 0.0) + np.log1p(np.exp(-np.abs(y)))
    omega = np.maximum(omega, 1e-300)  # where e^y underflows
    rest, one = y - omega - np.log(omega), 1 + omega
    both = 2 * one * (one + 2 / 3 * rest)
    return np.asarray(omega * (1 + rest / one * (both - rest) / (both - 2 * rest)))


def _arcsinh_exp(log: Array) -> Array:
    """Return arcsinh(e^log), also where e^log overflows or underflows."""
    # ln(e^l + sqrt(e^2l + 1)) = l + ln(1 + sqrt(1 + e^-2l)) for l > 0
    above = np.maximum(log, 0.0)
    large = above + np.log1p(np.sqrt(1 + np.exp(-2 * above)))
    return np.where(log > 0, large, np.arcsinh(np.exp(np.minimum(log, 0.0))))
