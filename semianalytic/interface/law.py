"""The interface that friction laws implement: strength, evolution of the state, and slopes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import fields, is_dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from semianalytic.interface.alike import Alike
from semianalytic.interface.fields import BARRIER, sampled
from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

SLOWEST = 1e-300
"""Slip rate below which a law counts as one that sticks."""


class InterfaceLaw(Alike, ABC):
    """The friction of an interface: strength at a slip speed and a state that evolves with slip.

    Derive a class, best a frozen dataclass, and define `strength`.  The state is one number per
    node; without a definition of `evolved` it is the accumulated |slip|.  Fields of a dataclass may
    be numbers, functions of x or `Table`; methods receive them as arrays (n,) on the contact.
    All arguments are arrays (n,); strength must not fall with speed faster than the impedance.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> from semianalytic import InterfaceLaw
    >>> @dataclass(frozen=True)
    ... class Glue(InterfaceLaw):
    ...     friction: object
    ...     bond: object
    ...     distance: float
    ...     def strength(self, pressure, speed, state):
    ...         return self.friction * pressure + self.bond * (state < self.distance)
    >>> law = Glue(0.5, lambda x: 1 + x, 0.1).on([0.0, 1.0])
    >>> law.strength(1.0, 0.0, 0.0).tolist()
    [1.5, 2.5]
    """

    has_threshold = True
    """Whether the interface sticks below its strength at rest, as most laws do."""

    @abstractmethod
    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the shear traction that the interface carries at a speed |V| >= 0 [stress].

        The pressure is the one that friction follows; see `pressure_delay`.
        """

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the state after a time at a mean speed; the accumulated |slip| by default."""
        return state + speed * time

    def evolved_under(
        self, state: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Array:
        """Return the state after a time under a changing pressure; that of `evolved` by default.

        The pressure changes linearly from `before` to `after`, which are 0 where the contact is
        open.
        """
        return self.evolved(state, speed, time)

    def pressure_delay(self, speed: Array) -> Any:
        """Return the time in which friction follows pressure at a speed; 0 by default: at once."""
        return 0.0

    def felt_pressure(
        self, felt: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Array:
        """Return the pressure that friction follows after a time at a mean speed.

        It relaxes from `felt` towards a pressure that changes linearly from `before` to `after`,
        exactly: dp'/dt = (p - p') / `pressure_delay`.
        """
        delay = np.asarray(self.pressure_delay(speed), dtype=float)
        with np.errstate(divide="ignore"):
            lag = time / delay
        left = np.exp(-lag)
        # Mean of exp(-lag s) over the step: the share of the pressure at its end that is missing.
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(lag > 1e-8, -np.expm1(-lag) / lag, 1 - lag / 2)
            mean = np.where(lag < np.inf, mean, 0.0)
        return np.asarray(left * felt + (mean - left) * before + (1 - mean) * after)

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return the state at t = 0, where |shear| is carried at a speed; 0 by default."""
        return np.zeros(len(pressure))

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed V >= 0 at which strength + impedance V = stopping, 0 where it sticks.

        By default it is found by bracketing in ln V, to rounding; a law may know a faster way.
        """
        slope = self.steady_slope()
        if slope is None:
            return balanced(self, stopping, pressure, impedance, state)
        rest = self.strength(pressure, np.zeros(np.shape(pressure)), state)
        return np.asarray(np.maximum(stopping - rest, 0.0) / (impedance + slope))

    def steady_slope(self) -> Any:
        """Return the slope of strength by speed if no speed changes it; None by default.

        The unit is [stress time / length].
        """
        return None

    @property
    def follows_state(self) -> bool:
        """Whether strength may depend on the state."""
        # A class that is derived from one without a state may have one.
        return not vars(type(self)).get("is_stateless", False)

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the slope of strength by speed [stress time / length], by differences by default.

        It lengthens steps where it is large.
        """
        slope = self.steady_slope()
        if slope is not None:
            return np.broadcast_to(np.asarray(slope, dtype=float), pressure.shape)
        small = np.maximum(speed, SLOWEST) * 1e-4
        rise = self.strength(pressure, speed + small, state)
        return np.asarray((rise - self.strength(pressure, speed, state)) / small)

    def state_slip(self) -> Any:
        """Return the slip over which the state of friction changes [length]; inf by default."""
        return np.inf

    def weakening(self, pressure: Array) -> float:
        """Return the largest fall of strength per slip [stress / length]; 0 by default.

        The grid has to resolve mu over it.
        """
        return 0.0

    def on(self, x: Any, spacing: float = 0.0) -> Self:
        """Return the law with all its fields as arrays on positions x (n,).

        With a node distance, nodes beside a jump of a field take its mean; see `fields.sampled`.
        """
        if not is_dataclass(self):
            return self
        x = np.asarray(x, dtype=float)
        owner = type(self).__name__
        given = {one.name: getattr(self, one.name) for one in fields(self) if one.init}
        drawn = {
            name: sampled(f"{owner}: {name}", value, x, spacing, BARRIER)
            for name, value in given.items()
            if callable(value)
        }
        return replace(self, **drawn) if drawn else self


def check_law(law: InterfaceLaw, pressure: Array, state: Array) -> None:
    """Raise SceneError if a law returns something else than one finite number per node."""
    speed = np.zeros(len(pressure))
    owner = type(law).__name__
    for name, value in (
        ("strength", law.strength(pressure, speed, state)),
        ("evolved", law.evolved(state, speed, 0.0)),
    ):
        value = np.asarray(value)
        if value.shape != pressure.shape or not np.isfinite(value).all():
            raise SceneError(
                f"{owner}.{name} must return {len(pressure)} finite numbers, one per node, got "
                f"shape {value.shape}{'' if value.shape != pressure.shape else ' with nan or inf'}."
            )


def check_rate(law: InterfaceLaw, pressure: Array, state: Array, impedance: float) -> None:
    """Raise SceneError if friction falls with slip rate faster than the bodies can balance.

    With strength(V) + impedance V falling anywhere, a traction is balanced by several slip rates,
    and answers do not converge.  Slip rates of up to one hundred pressures over the impedance are
    looked at, ten in each decade.
    """
    size = float(np.max(pressure, initial=0.0)) / impedance
    if not size > 0:
        return
    speeds = size * np.concatenate([[0.0], np.logspace(-14, 2, 161)])
    strength = [np.asarray(law.strength(pressure, 0 * pressure + one, state)) for one in speeds]
    rounding = 1e-15 * np.abs(strength[0])
    fall = (-np.diff(strength, axis=0) - rounding) / np.diff(speeds)[:, None]
    steepest = float(fall.max())
    if steepest > impedance * (1 + 1e-6):
        raise SceneError(
            "interface: friction falls with slip rate faster than radiation can balance "
            f"(by {steepest:.3g} per slip rate, the impedance is {impedance:.3g}); let it fall "
            "over higher slip rates, or by less (docs/limits.md)."
        )


def positive(owner: str, **values: Any) -> None:
    """Raise SceneError unless parameters given as numbers are finite and positive."""
    for name, value in values.items():
        _check(owner, name, value, lambda one: one > 0, "be positive")


def not_negative(owner: str, **values: Any) -> None:
    """Raise SceneError unless parameters given as numbers are finite, 0 or more."""
    for name, value in values.items():
        _check(owner, name, value, lambda one: one >= 0, "be 0 or more")


def _check(owner: str, name: str, value: Any, admitted: Any, words: str) -> None:
    if callable(value):
        return
    given = np.asarray(value if isinstance(value, np.ndarray) else finite(value), dtype=float)
    wrong = ~(np.isfinite(given) & admitted(given))
    if wrong.any():
        got = f"{given[wrong][0]:.6g}" if given.ndim else shown(value)
        raise SceneError(f"{owner}: {name} must {words} and finite, got {got}.")


def balanced(
    law: InterfaceLaw, stopping: Array, pressure: Array, impedance: float, state: Array
) -> Array:
    """Return the speeds at which strength + impedance V = stopping, by bracketing in ln V.

    Where strength at rest exceeds the stopping traction the speed is 0.
    """
    rest = np.asarray(law.strength(pressure, np.zeros(len(stopping)), state), dtype=float)
    slips = stopping > rest
    # strength is not negative, so V is below stopping / impedance
    high = np.log(np.where(slips, stopping, 1.0) / impedance)
    low = np.full(len(stopping), np.log(SLOWEST))

    def excess(y: Array) -> Array:
        speed = np.exp(y)
        return np.asarray(law.strength(pressure, speed, state) + impedance * speed - stopping)

    slips &= excess(low) < 0
    return np.where(slips, np.exp(_root(excess, low, np.maximum(high, low), slips)), 0.0)


def _root(excess: Any, low: Array, high: Array, wanted: Any) -> Array:
    """Return roots of a rising function between low and high, by Chandrupatla's rule (1997)."""
    a, b = low, high
    fa, fb = excess(a), excess(b)
    c, fc = a, fa
    share = np.full(len(a), 0.5)
    for _ in range(100):
        at = a + share * (b - a)
        f = excess(at)
        same = np.sign(f) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(same, b, a), np.where(same, fb, fa)
        a, fa = at, f
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        width = np.abs(b - a)
        least = 4e-16 * np.abs(best) + 1e-300
        if not (wanted & (fa != 0) & (width > least)).any():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
            inner = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (
                fc - fa
            ) * fb / (fc - fb)
        share = np.where(inner & np.isfinite(quadratic), quadratic, 0.5)
        edge = np.where(width > 0, 0.5 * least / np.where(width > 0, width, 1.0), 0.5)
        share = np.clip(share, np.minimum(edge, 0.5), 1 - np.minimum(edge, 0.5))
    return best
