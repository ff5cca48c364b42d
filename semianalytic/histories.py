"""Load histories and the stuck interface under them, (3.20).

A remote load P_0 f(t) makes the stuck pressure P_0 int f'(s) p*((t - s)/x) ds, with the unit
step's p*(u) of (3.10); likewise shear with q*.  Jumps and straight pieces of f are exact: they
need p* and its primitive in slowness.  Smooth histories take, on the slowness axis,

    f(0) p*(t/x) + int_a^{t/x} [f(t - v x) - f(0)] dp*/dv dv,

with the inverse square roots of dp*/dv at the wave fronts removed by substitution.  Tractions
are what the load adds to the base; with base = P_0 f remote, add P_0 f(t) itself (the constant
of (3.10)).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.special import fresnel

from semianalytic.errors import SceneError
from semianalytic.rayleigh import Array, Mode, RayleighFactors, gauss, rayleigh_factors
from semianalytic.scene import Material, Tractions
from semianalytic.stuck import StuckTraction, stress_intensity, stuck_traction
from semianalytic.velocities import square_root_panels

_DEGREE = 128
_GAUSS = 48
_ORDERS = (24, 36)
_PANELS_PER_PERIOD = 2


def _positive(owner: str, name: str, value: float) -> None:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (number and np.isfinite(value) and value > 0):
        raise SceneError(f"{owner}: {name} must be a positive number, got {value!r}.")


@dataclass(frozen=True)
class Step:
    """Shock load: f = H(t)."""

    def value(self, t: ArrayLike) -> Array:
        """f(t), any shape."""
        return np.where(np.asarray(t, dtype=float) > 0, 1.0, 0.0)


@dataclass(frozen=True)
class Ramp:
    """Load rising linearly from 0 to 1 over `rise_time` [time], then constant.

    Raises
    ------
    SceneError
        If the rise time is not positive.
    """

    rise_time: float

    def __post_init__(self) -> None:
        _positive("ramp", "rise_time", self.rise_time)

    def value(self, t: ArrayLike) -> Array:
        """f(t), any shape."""
        return np.clip(np.asarray(t, dtype=float) / self.rise_time, 0.0, 1.0)


@dataclass(frozen=True)
class Harmonic:
    """f = sin(2 pi frequency t) for t > 0, `frequency` in cycles per time.

    Raises
    ------
    SceneError
        If the frequency is not positive.
    """

    frequency: float

    def __post_init__(self) -> None:
        _positive("harmonic", "frequency", self.frequency)

    @property
    def angular(self) -> float:
        """Angular frequency [1 / time]."""
        return 2 * np.pi * self.frequency

    def value(self, t: ArrayLike) -> Array:
        """f(t), any shape."""
        return np.sin(self.angular * np.maximum(np.asarray(t, dtype=float), 0.0))


@dataclass(frozen=True)
class Tabulated:
    """Load interpolated linearly between samples, 0 before the first and constant after the last.

    Parameters
    ----------
    t : increasing times >= 0 [time]; one time given twice is a jump.
    value_at_t : values there; a first value other than 0 is a jump at t[0].

    Raises
    ------
    SceneError
        If the samples are not finite, not of one length, or not in order.
    """

    t: tuple[float, ...]
    value_at_t: tuple[float, ...]

    def __post_init__(self) -> None:
        try:
            times, values = (np.asarray(part, dtype=float) for part in (self.t, self.value_at_t))
        except (TypeError, ValueError) as error:
            raise SceneError("tabulated: times and values must be lists of numbers.") from error
        if times.ndim != 1 or times.shape != values.shape or not len(times):
            raise SceneError("tabulated: give as many values as times, and at least one.")
        if not (np.all(np.isfinite(times)) and np.all(np.isfinite(values))):
            raise SceneError("tabulated: times and values must be finite.")
        if times[0] < 0 or np.any(np.diff(times) < 0):
            raise SceneError("tabulated: times must start at 0 or later and not decrease.")
        if np.any((times[2:] == times[1:-1]) & (times[1:-1] == times[:-2])):
            raise SceneError(
                "tabulated: a time may be given twice, for a jump, but not more often."
            )
        object.__setattr__(self, "t", tuple(times.tolist()))
        object.__setattr__(self, "value_at_t", tuple(values.tolist()))

    def value(self, t: ArrayLike) -> Array:
        """f(t), any shape; after the jump where there is one."""
        t = np.asarray(t, dtype=float)
        times, values = np.array(self.t), np.array(self.value_at_t)
        right = np.searchsorted(times, t, "right")
        left = np.maximum(right - 1, 0)
        right = np.minimum(right, len(times) - 1)
        width = times[right] - times[left]
        share = np.where(width > 0, (t - times[left]) / np.where(width > 0, width, 1.0), 0.0)
        inside = values[left] + share * (values[right] - values[left])
        return np.where(t < times[0], 0.0, inside)


History = Step | Ramp | Harmonic | Tabulated


@dataclass(frozen=True)
class _Pieces:
    """Jumps (time, height) and kinks (time, change of slope) of a piecewise linear history."""

    jumps: tuple[tuple[float, float], ...]
    kinks: tuple[tuple[float, float], ...]


def _pieces(history: Step | Ramp | Tabulated) -> _Pieces:
    if isinstance(history, Step):
        return _Pieces(((0.0, 1.0),), ())
    if isinstance(history, Ramp):
        slope = 1 / history.rise_time
        return _Pieces((), ((0.0, slope), (history.rise_time, -slope)))
    times, values = np.array(history.t), np.array(history.value_at_t)
    width, rise = np.diff(times), np.diff(values)
    sloped = width > 0
    slope = np.where(sloped, rise / np.where(sloped, width, 1.0), 0.0)
    jumps = [(times[0], values[0]), *zip(times[:-1][~sloped], rise[~sloped], strict=True)]
    kinks = [
        *zip(times[:-1][sloped], slope[sloped], strict=True),
        *zip(times[1:][sloped], -slope[sloped], strict=True),
    ]
    return _Pieces(tuple(j for j in jumps if j[1]), tuple(k for k in kinks if k[1]))


@dataclass(frozen=True)
class StuckPrimitive:
    """int_a^u p* (mode I) or q* (mode II) dv over slowness, b = 1: what a ramp needs."""

    factors: RayleighFactors
    mode: Mode

    @cached_property
    def _traction(self) -> StuckTraction:
        return stuck_traction(self.factors.poisson_ratio, self.mode)

    @property
    def _power(self) -> float:
        return 2.5 if self.mode == "II" else 1.5

    @cached_property
    def _before_shear_front(self) -> Array:
        """Series on a < u < b of the primitive over (u - a)^(5/2) or (u - a)^(3/2)."""
        a = self.factors.a
        t, weight = gauss(_GAUSS)

        def series(z: Array) -> Array:
            # substituting v = a + (u - a) t^2 leaves the traction over (v - a)^power smooth
            width = (1 - a) * (z + 1) / 2
            v = a + width[:, None] * t**2
            power = self._power - 1
            smooth = self._traction(v) / (width[:, None] * t**2) ** power
            return (2 * smooth * t ** (2 * power + 1)) @ weight

        return chebyshev.chebinterpolate(series, _GAUSS)

    @cached_property
    def _behind_shear_front(self) -> Array:
        """Series in (s - 1)/(s + 1), s = sqrt(u - b), of the primitive over (s + 1)^3."""
        order = np.arange(_DEGREE + 1)
        angle = np.pi * (order[::-1] + 0.5) / (_DEGREE + 1)
        z = np.cos(angle)
        s = (1 + z) / (1 - z)
        ends = np.concatenate(([0.0], s))
        t, weight = gauss(24)
        width = np.diff(ends)
        nodes = ends[:-1, None] + width[:, None] * t
        gain = width * ((2 * nodes * self._traction(1 + nodes**2)) @ weight)
        at_front = self._near(np.array(1.0))
        value = (at_front + np.cumsum(gain)) / (s + 1) ** 3
        series = 2 / (_DEGREE + 1) * np.cos(np.outer(order, angle)) @ value
        series[0] /= 2
        return series

    def _near(self, u: Array) -> Array:
        a = self.factors.a
        series = chebyshev.chebval(2 * (u - a) / (1 - a) - 1, self._before_shear_front)
        return (u - a) ** self._power * series

    def __call__(self, u: ArrayLike) -> Array:
        """Primitive at slowness u [1/b], any shape; 0 ahead of the longitudinal front."""
        u = np.asarray(u, dtype=float)
        s = np.sqrt(np.maximum(u - 1, 0))
        behind = (s + 1) ** 3 * chebyshev.chebval((s - 1) / (s + 1), self._behind_shear_front)
        return np.where(u > 1, behind, self._near(np.clip(u, self.factors.a, 1)))


@lru_cache(maxsize=64)
def stuck_primitive(poisson_ratio: float, mode: Mode) -> StuckPrimitive:
    """Primitive of p* (mode I) or q* (mode II) for a Poisson ratio, tables kept.

    Raises
    ------
    SceneError
        If the Poisson ratio is not in (-1, 0.5).
    """
    return StuckPrimitive(rayleigh_factors(poisson_ratio), mode)


@dataclass(frozen=True)
class StuckHistory:
    """Stuck traction at positions and times [stress], and an estimate of its largest error.

    The error is 0 where everything is in closed form but for tables exact to rounding.
    """

    value: Array
    error: float


def _harmonic(history: Harmonic, stuck: StuckTraction, u: float, per: float, order: int) -> float:
    """int_a^u f((u - v) per) dp*/dv dv with `per` = x b, time per unit of slowness."""
    a = stuck.factors.a
    if u <= a:
        return 0.0
    longest = 1 / (_PANELS_PER_PERIOD * history.frequency * per)
    ends = [a, min(u, 1.0)]
    if u > 1:
        ends += [min(u, 2.0)]
    if u > 2:
        count = int(np.ceil(np.log2(u / 2))) + 1
        ends += list(2 * (u / 2) ** (np.arange(1, count + 1) / count))
    split = [
        np.linspace(left, right, int(np.ceil((right - left) / longest)) + 1)[:-1]
        for left, right in zip(ends[:-1], ends[1:], strict=True)
    ]
    v, weight = square_root_panels([*np.concatenate(split).tolist(), u], order)
    # weights vanish at the fronts like the square roots that slope has there
    return float((weight * stuck.derivative(v)) @ history.value((u - v) * per))


def _stuck(
    history: History, amplitude: float, material: Material, x: ArrayLike, t: ArrayLike, mode: Mode
) -> StuckHistory:
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(t))) or np.any(x <= 0):
        raise SceneError(
            "the contact is x > 0; ask for finite positive positions and finite times."
        )
    stuck = stuck_traction(material.poisson_ratio, mode)
    per = x / material.shear_speed
    if isinstance(history, Harmonic):
        points = list(zip((t / per).ravel(), per.ravel(), strict=True))
        rough, fine = (
            np.array([_harmonic(history, stuck, u, width, order) for u, width in points])
            for order in _ORDERS
        )
        error = float(np.abs(fine - rough).max(initial=0.0))
        return StuckHistory(amplitude * fine.reshape(x.shape), abs(amplitude) * error)
    pieces = _pieces(history)
    total = np.zeros(x.shape)
    for start, height in pieces.jumps:
        total += height * stuck((t - start) / per)
    if pieces.kinks:
        primitive = stuck_primitive(material.poisson_ratio, mode)
        for start, slope in pieces.kinks:
            total += slope * per * primitive((t - start) / per)
    return StuckHistory(amplitude * total, 0.0)


def stuck_pressure(
    history: History, amplitude: float, material: Material, x: ArrayLike, t: ArrayLike
) -> StuckHistory:
    """Pressure a slot load P_0 f(t) adds to a stuck interface, (3.10) with (3.20).

    Parameters
    ----------
    history : Step, Ramp, Harmonic or Tabulated
    amplitude : P_0 [stress], compression positive.
    material : Material
    x, t : positions x > 0 [length] and times [time]; they broadcast.

    Raises
    ------
    SceneError
        If a position is not positive, or a position or time not finite.
    """
    return _stuck(history, amplitude, material, x, t, "I")


def stuck_shear(
    history: History, amplitude: float, material: Material, x: ArrayLike, t: ArrayLike
) -> StuckHistory:
    """Shear traction a slot load Q_0 f(t) adds to a stuck interface, (3.14) with (3.20).

    Parameters and errors as `stuck_pressure`.
    """
    return _stuck(history, amplitude, material, x, t, "II")


def _root_response(history: History, t: Array) -> Array:
    """int f'(s) sqrt(t - s) ds [time^(1/2)]."""
    if isinstance(history, Harmonic):
        # by parts: int_0^sqrt(t) sin(omega (t - r^2)) dr
        time = np.maximum(t, 0.0)
        sine, cosine = fresnel(np.sqrt(4 * history.frequency * time))
        angle = history.angular * time
        mixed = np.sin(angle) * cosine - np.cos(angle) * sine
        return np.asarray(mixed / np.sqrt(4 * history.frequency))
    pieces = _pieces(history)
    total = np.zeros(t.shape)
    for start, height in pieces.jumps:
        total += height * np.sqrt(np.maximum(t - start, 0.0))
    for start, slope in pieces.kinks:
        total += slope * 2 / 3 * np.maximum(t - start, 0.0) ** 1.5
    return total


def intensity_history(
    history: History, step: Tractions, material: Material, t: ArrayLike
) -> tuple[Array, Array]:
    """(K_I, K_II) of a stuck interface under the loads P_0 f(t), Q_0 f(t), (3.13), (3.16), (3.20).

    [stress sqrt(length)], K_I > 0 in compression; exact for every history.

    Parameters
    ----------
    history : Step, Ramp, Harmonic or Tabulated
    step : Tractions
        Amplitudes (P_0, Q_0).
    material : Material
    t : times [time], any shape.
    """
    response = _root_response(history, np.asarray(t, dtype=float))
    mode_one, mode_two = stress_intensity(material, step, 1.0)
    return mode_one * response, mode_two * response


def near_field(intensity: ArrayLike, x: ArrayLike) -> Array:
    """K / sqrt(2 pi x) [stress]: traction near the edge, the remote load f(t) included, (3.13).

    What the load adds on the slot alone (`stuck_pressure`) is smaller by the load itself; the
    next term is of order sqrt(x).
    """
    return np.asarray(intensity, dtype=float) / np.sqrt(2 * np.pi * np.asarray(x, dtype=float))
