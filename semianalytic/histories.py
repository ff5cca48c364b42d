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

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import fresnel

from semianalytic.errors import SceneError
from semianalytic.primitives import stuck_primitive
from semianalytic.rayleigh import Array, Mode
from semianalytic.scene import Material, Tractions
from semianalytic.stuck import StuckTraction, stress_intensity, stuck_traction
from semianalytic.velocities import square_root_panels

Response = Callable[[Array], Array]

_BLOCK = 500_000
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
    slopes = np.where(sloped, rise / np.where(sloped, width, 1.0), 0.0)
    jumps = [(times[0], values[0]), *zip(times[:-1][~sloped], rise[~sloped], strict=True)]
    kinks = [
        *zip(times[:-1][sloped], slopes[sloped], strict=True),
        *zip(times[1:][sloped], -slopes[sloped], strict=True),
    ]
    return _Pieces(tuple(j for j in jumps if j[1]), tuple(k for k in kinks if k[1]))


def _superposed(pieces: tuple[tuple[float, float], ...], response: Response, t: Array) -> Array:
    """Sum of amplitude * response(t - start) over pieces, in blocks that bound the memory."""
    start, amplitude = np.array(pieces).reshape(-1, 2).T
    total = np.zeros(t.shape)
    block = max(1, _BLOCK // max(1, t.size))
    for first in range(0, len(start), block):
        part = slice(first, first + block)
        shape = (-1,) + (1,) * t.ndim
        total += np.tensordot(amplitude[part], response(t - start[part].reshape(shape)), 1)
    return total


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
        for left, right in pairwise(ends)
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
    primitive = stuck_primitive(material.poisson_ratio, mode)
    total = _superposed(pieces.jumps, lambda lag: stuck(lag / per), t)
    total += _superposed(pieces.kinks, lambda lag: per * primitive(lag / per), t)
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
    total = _superposed(pieces.jumps, lambda lag: np.sqrt(np.maximum(lag, 0.0)), t)
    total += _superposed(pieces.kinks, lambda lag: 2 / 3 * np.maximum(lag, 0.0) ** 1.5, t)
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
