"""The interface that friction laws implement: strength, evolution of the state, and slopes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number, checked_size, finite
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.alike import Alike, expression
from semianalytic.scene.laws.sampling import BARRIER, barrier_misfit, sampled, widened

SLOWEST = 1e-300
"""Slip rate below which a law counts as one that sticks."""
_FOLLOWING = (
    "slip_speed",
    "steady_slope",
    "rate_slope",
    "rate_slopes",
    "fall_with_rate",
    "weakening",
)
"""Methods whose defaults follow from the strength of a law."""


@checking_methods
class Law(Alike, ABC):
    """The friction of an interface: strength at a slip rate, and a state that evolves with slip.

    Derive a class, best a frozen dataclass, and define `strength`.  The state is one number per
    node; without a definition of `evolved` it is the path, the accumulated |slip|.  Fields of a
    dataclass may be numbers, functions of x or `Table`; methods receive them as arrays (n,) on the
    contact.  All arguments are arrays (n,); strength must not fall with slip rate faster than the
    impedance.  A scene with a slot takes laws whose fields are numbers and whose state is the path;
    the exact solver takes those that also define `rate_slopes`.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> from semianalytic import Law
    >>> @dataclass(frozen=True)
    ... class Glue(Law):
    ...     friction: object
    ...     bond: object
    ...     distance: float
    ...     def strength(self, pressure, speed, state):
    ...         return self.friction * pressure + self.bond * (state < self.distance)
    >>> law = Glue(0.5, lambda x: 1 + x, 0.1).on([0.0, 1.0])
    >>> law.strength(1.0, 0.0, 0.0).tolist()
    [1.5, 2.5]
    """

    def __init_subclass__(cls, **options: Any) -> None:
        """Let no class that defines its strength inherit what follows from another one."""
        super().__init_subclass__(**options)
        checking_methods(cls)
        laws = [base for base in cls.__mro__[1:] if issubclass(base, Law)]
        derived = any("strength" not in law.__abstractmethods__ for law in laws)
        if derived and "strength" in vars(cls):
            for name in set(_FOLLOWING) - vars(cls).keys():
                setattr(cls, name, vars(Law)[name])

    def __repr__(self) -> str:
        return expression(self) if is_dataclass(self) else object.__repr__(self)

    has_threshold = True
    """Whether the interface sticks below its strength at rest, as most laws do."""

    @abstractmethod
    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the shear traction that the interface carries at a speed |V| >= 0 [stress].

        The pressure is the one that friction follows; see `pressure_delay`.
        """

    def rate_slopes(self, pressure: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength with respect to p, |V|, both, and |V| twice.

        Only laws define it whose strength is a smooth function of pressure and slip rate, and
        proportional to pressure at rest: under steps they keep self-similarity.
        """
        raise NotImplementedError

    @property
    def is_rated(self) -> bool:
        """Whether strength depends on pressure and slip rate alone, smoothly: `rate_slopes`."""
        return type(self).rate_slopes is not Law.rate_slopes

    @cached_property
    def keeps_similarity(self) -> bool:
        """Whether fields under step loads depend on x/t alone."""
        pressure = np.array([0.0, 1.0, 2.0])
        rest = np.asarray(self.strength(pressure, 0 * pressure, 0 * pressure))
        excess = np.abs(rest - self.coefficient * pressure)
        return self.is_rated and bool(np.all(excess <= 1e-12 * rest))

    @property
    def coefficient(self) -> float:
        """Friction coefficient at rest, before any slip: the field `friction` or `static`."""
        name = coefficient_field(type(self))
        if name is not None:
            return float(getattr(self, name))
        none = np.zeros(1)
        return float((self.strength(none + 1, none, none) - self.strength(none, none, none))[0])

    def with_coefficient(self, coefficient: float) -> Self:
        """Return the law with another coefficient at rest; dynamic friction keeps its ratio to it.

        Raises
        ------
        SceneError
            If the law has no field of the coefficient.
        """
        name = coefficient_field(type(self))
        if name is None:
            raise SceneError(
                f"{type(self).__name__} has no field `friction` or `static`; change its own "
                "parameters."
            )
        changes, before = {name: coefficient}, getattr(self, name)
        if before and hasattr(self, "dynamic"):
            changes["dynamic"] = self.dynamic * (coefficient / before)
        return replace(self, **changes)  # type: ignore[type-var]

    @cached_property
    def fall_with_rate(self) -> float:
        """Largest fall of strength per slip rate, over pressure [time / length]; 0 without any.

        By default it is found from slip rates of 1e-30 to 1e30, ten in each decade.
        """
        unit, none, speeds = np.ones(1), np.zeros(1), _decades()
        return _steepest((self.strength(unit, speed * unit, none), speed) for speed in speeds)

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
        if not delay.any():
            return np.array(after, dtype=float)
        lag = time / delay
        left = np.exp(-lag)
        # Mean of exp(-lag s) over the step: the share of the pressure at its end that is missing.
        mean = np.where(lag > 1e-8, -np.expm1(-lag) / lag, 1 - lag / 2)
        mean = np.where(lag < np.inf, mean, 0.0)
        return np.asarray(left * felt + (mean - left) * before + (1 - mean) * after)

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return the state at t = 0, where |shear| is carried at a speed; 0 by default."""
        return np.zeros(len(pressure))

    def slip_speed(
        self, stopping: Array, pressure: Array, impedance: Array | float, state: Array
    ) -> Array:
        """Return the speed V >= 0 at which strength + impedance V = stopping, 0 where it sticks.

        By default it is found by bracketing in ln V, to rounding; a law may have a faster way.
        """
        slope = self.steady_slope()
        if slope is None:
            return balanced(self, stopping, pressure, impedance, state)
        rest = self.strength(pressure, np.zeros(np.shape(pressure)), state)
        return np.asarray(np.maximum(stopping - rest, 0.0) / (impedance + slope))

    def steady_slope(self) -> Any:
        """Return the slope of strength over speed if it is constant; None by default.

        The unit is [stress time / length].
        """
        return None

    @property
    def follows_state(self) -> bool:
        """Whether the state matters: strength depends on it, or it is not the path."""
        return not (self.is_rated and follows_path(type(self)))

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the slope of strength over speed [stress time / length], by default from
        differences.

        Steps are longer where it is large.
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
        """Return the largest fall of strength per path [stress / length].

        The grid has to resolve mu over it.  By default it is found from paths of 1e-30 to 1e30, ten
        in each decade, and is 0 if the state is not the path.
        """
        if self.is_rated or not follows_path(type(self)):
            return 0.0
        pressure, paths = np.atleast_1d(pressure), _decades()
        return _steepest(
            (self.strength(pressure, 0 * pressure, 0 * pressure + path), path) for path in paths
        )

    def on(self, x: ArrayLike, spacing: float = 0.0) -> Self:
        """Return the law with all its fields as arrays on positions x (n,).

        With a node distance, nodes near a jump of a field take its mean; see `sampling.sampled`.
        """
        x = np.asarray(x, dtype=float)
        owner = type(self).__name__
        drawn = {
            name: sampled(f"{owner}: {name}", value, x, spacing, BARRIER)
            for name, value in self._along.items()
        }
        return replace(cast(Any, self), **drawn) if drawn else self

    @property
    def _along(self) -> dict[str, Any]:
        """Fields that are functions of x, by their names."""
        if not is_dataclass(self):
            return {}
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.init}
        return {name: value for name, value in values.items() if callable(value)}

    def barrier_misfit(self, x: Array, spacing: float) -> float:
        """Return how far a grid displaces the ends of barriers; see `sampling`."""
        return max((barrier_misfit(part, x, spacing) for part in self._along.values()), default=0.0)

    def with_wider_barriers(self, by: float) -> Self:
        """Return the law with barriers that reach farther by a distance on either side [length]."""
        wider: dict[str, Any] = {name: widened(entry, by) for name, entry in self._along.items()}
        return replace(cast(Any, self), **wider) if wider else self


def coefficient_field(law: type) -> str | None:
    """Return the field of a class of laws that is the coefficient at rest; None without one."""
    names = [field.name for field in fields(law)] if is_dataclass(law) else []
    return next((name for name in ("friction", "static") if name in names), None)


def follows_path(law: type[Law]) -> bool:
    """Whether the state of a class of laws is the path, the accumulated |slip|."""
    return all(
        getattr(law, name) is getattr(Law, name) for name in ("evolved", "evolved_under", "start")
    )


def _decades() -> Array:
    """Return 0, and 1e-30 to 1e30 in tenths of decades."""
    return np.concatenate([[0.0], np.logspace(-30, 30, 601)])


def _steepest(found: Iterable[tuple[Array, float]]) -> float:
    """Return the largest fall of strengths (n,) per slip or slip rate at which they are found."""
    # a sum of two terms of the strength, rounded, may fall by 1e-15 of it alone
    falls = (
        np.max(before - after - 1e-15 * np.abs(before)) / (end - start)
        for (before, start), (after, end) in pairwise(found)
    )
    return max(0.0, *map(float, falls))


def check_law(law: Law, pressure: Array, state: Array) -> None:
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


def check_balance(law: Law, pressure: float, impedance: float) -> None:
    """Raise SceneError unless the slip rate of a law balances its own strength.

    The laws of this package do; this one is for those of other packages.
    """
    size, path = np.full(3, pressure), np.zeros(3)
    stopping = np.asarray(law.strength(size, path, path)) * np.array([1.2, 2.0, 5.0])
    speed = np.asarray(law.slip_speed(stopping, size, impedance, path), dtype=float)
    left = stopping - np.asarray(law.strength(size, speed, path), dtype=float) - impedance * speed
    # Where the interface sticks, strength may exceed the traction; nan is wrong either way.
    off = np.where(speed == 0, np.maximum(left, 0.0), np.abs(left))
    # 1e-3 is far above what the root of any solver misses, and far below a factor left out.
    if not np.all(off <= 1e-3 * stopping):
        raise SceneError(
            f"scene: slip_speed of the friction law {type(law).__name__} must return the slip rate "
            "V >= 0 at which strength(pressure, V, path) + impedance V is the traction that "
            f"stops; for tractions {stopping.tolist()}, pressure {pressure:g} and impedance "
            f"{impedance:g} it returns {speed.tolist()}."
        )


def check_rate(law: Law, pressure: Array, state: Array, impedance: float) -> None:
    """Raise SceneError if friction falls with slip rate faster than the bodies can balance.

    With strength(V) + impedance V falling anywhere, a traction is balanced by several slip rates,
    and answers do not converge.  Slip rates of up to one hundred pressures over the impedance are
    looked at, ten in each decade.
    """
    size = float(np.max(pressure, initial=0.0)) / impedance
    if not size > 0:
        return
    speeds = size * np.concatenate([[0.0], np.logspace(-14, 2, 161)])
    steepest = _steepest((law.strength(pressure, 0 * pressure + v, state), v) for v in speeds)
    if steepest > impedance * (1 + 1e-6):
        raise SceneError(
            "interface: friction falls with slip rate faster than radiation can balance "
            f"(by {steepest:.3g} per slip rate, the impedance is {impedance:.3g}); let it fall "
            "over higher slip rates, or by less (docs/limits.md)."
        )


def positive(owner: str, **values: Any) -> None:
    """Raise SceneError unless parameters given as numbers are finite and positive."""
    for name, value in values.items():
        _check(f"{owner}: {name}", value, lambda number: number > 0, "be positive and finite")
        if finite(value):
            checked_size(f"{owner}: {name}", value)


def not_negative(owner: str, **values: Any) -> None:
    """Raise SceneError unless parameters given as numbers are finite, 0 or more."""
    for name, value in values.items():
        _check(f"{owner}: {name}", value, lambda number: number >= 0, "be 0 or more and finite")


def _check(what: str, value: Any, admitted: Any, words: str) -> None:
    if callable(value):
        return
    # values at nodes are a row
    if not isinstance(value, np.ndarray) or value.ndim != 1 or value.dtype.kind not in "iuf":
        checked_number(what, value, words, admitted)
        return
    wrong = ~(np.isfinite(value) & admitted(value))
    if wrong.any():
        raise SceneError(f"{what} must {words}, got {value[wrong][0]:.6g}.")


def balanced(law: Law, stopping: Array, pressure: Array, impedance: Any, state: Array) -> Array:
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
