"""Exact answers without a slot: over-stressed half-line, patch and point of a closed interface.

Two half-planes touch along the whole line y = 0 and never part.  Of slip V and its traction
F = tau + s f sigma only F = -K W is left, K = (A + s f k D) / (A B + k^2 D^2): F is real on the cut
where the interface slips, and F / K where it sticks.  So everything follows from one canonical
function,

    X(k) = exp(-(1/pi) int^{u_1} theta(w) dw / (w + k) - (1/pi) int^{u_2} theta'(w) dw / (w - k)),

with theta the phase of K on k = -v + i0, theta' that of the bodies exchanged (waves to the left),
u_1 and u_2 the slownesses of the edges of slip to the right and left (docs/dissimilar.md, "Without
a slot").  Speeds are over c_t of the upper body, tractions over what drives slip.

Tension between the bodies, where one of these answers has any, would part them: the point has
always some beside itself, the half-line none but exponentially close to its end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Compliance
from semianalytic.dissimilar.phase import SlipPhase, slip_phase
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.errors import SceneError

_REACH, _PIECE = 36.0, 1.5
"""Largest |x| on a stretch, and length of pieces: half changes no digit of docs/dissimilar.md."""
_TOO_FAST = (
    "no edge of slip is slower than all waves: slip runs ahead of them, or does not spread; make "
    "what is missing to friction larger, or less than what drives slip."
)
_ETA_STEP = 0.15
"""Spacing of ln eta in the edge conditions."""


RealFunction = Callable[[float], float]


@dataclass(frozen=True, eq=False)
class PhaseIntegrals:
    """Integrals of theta over slowness, from the first wave to any edge."""

    phase: SlipPhase

    def nodes(self, stop: float) -> tuple[Array, Array, Array]:
        """Return slownesses w up to `stop`, theta dw with quadrature weights, and `stop` - w."""
        parts = []
        for whole in stretches(self.phase.numerator.compliance.distinct_fronts):
            if whole.left >= stop:
                break
            if whole.right is None or stop < whole.right:
                parts.append(self._until(whole, stop))
                continue
            if whole not in self._complete:
                self._complete[whole] = self._until(whole, None)
            v, weight, _ = self._complete[whole]
            parts.append((v, weight, stop - v))
        if not parts:
            return np.zeros(0), np.zeros(0), np.zeros(0)
        points, weights, distances = zip(*parts, strict=True)
        return np.concatenate(points), np.concatenate(weights), np.concatenate(distances)

    @cached_property
    def _complete(self) -> dict[Stretch, tuple[Array, Array, Array]]:
        """Points that `_until` found for stretches up to their ends, where no edge lies."""
        return {}

    def _until(self, whole: Stretch, stop: float | None) -> tuple[Array, Array, Array]:
        """Return nodes, weights and distances from the end on a stretch, up to `stop` if given."""
        sharp = {*self.phase.numerator.sharp_turns, *self.phase.denominator.sharp_turns}
        stretch = whole if stop is None else Stretch(whole.left, stop)
        ends = _pieces(stretch, sorted(sharp))
        t, weight = gauss(12)
        x = (ends[:-1, None] + np.diff(ends)[:, None] * t).ravel()
        dx = (np.diff(ends)[:, None] * weight).ravel()
        at = stretch.at(x)
        beyond = whole.left if whole.right is None else whole.right - at.v
        # The phase knows whole stretches only: the coordinate of the same points on the whole one.
        there = x if stop is None else np.log(at.from_left / beyond)
        # The canonical function is singular at the edge: distances from it must keep their digits.
        weights = dx * np.asarray(stretch.slope(at)) * self.phase.on(whole, there)
        return at.v, weights, at.to_right

    def over(self, stop: float, kernel: Callable[[Array], Array]) -> float:
        """Return (1/pi) int theta(w) kernel(w) dw up to `stop`."""
        w, weight, _ = self.nodes(stop)
        return float(weight @ kernel(w) / np.pi)

    @cached_property
    def fastest(self) -> float:
        """Slowness beyond which theta is positive; no leading edge of slip is faster."""
        part = self.phase.numerator.table[-1]
        phase = self.phase.on(part.stretch, part.x)
        behind = np.flatnonzero(phase <= 0)
        first = part.x[behind[-1] + 1] if len(behind) else part.x[0]
        return float(part.stretch.at(np.array([first])).v[0])

    def root(self, function: RealFunction, limit: float = np.inf) -> tuple[float, bool]:
        """Return the slowness from `fastest` to a limit at which a function vanishes, and True.

        Without a zero, return the end at which its modulus is smaller, and False.
        """
        from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

        front = Stretch(self.fastest, None if limit == np.inf else limit)
        # Beyond x = 16 towards a patch the edge conditions do not change; no edge is looked
        # for below 1e-8 of the slowest wave speed.
        ends = (-_REACH, np.log(1e8) if limit == np.inf else 16.0)

        def slowness(x: float) -> float:
            return float(front.at(np.array([x])).v[0])

        at_ends = {x: function(slowness(x)) for x in ends}
        values = list(at_ends.values())
        # No zero: the caller says what that means for its own equation.
        if values[0] * values[1] > 0:
            return slowness(ends[int(abs(values[1]) < abs(values[0]))]), False

        def value(x: float) -> float:
            return at_ends[x] if x in at_ends else function(slowness(x))

        return slowness(brentq(value, *ends, xtol=1e-13)), True


def _pieces(stretch: Stretch, sharp: list[float]) -> Array:
    """Return the ends of pieces of a stretch in x, which are shorter about hidden zeros."""
    # Pieces reach twice as far towards an edge, where the rest is a root of the distance.
    ends = np.arange(-_REACH, 2 * _REACH + _PIECE, _PIECE)
    for v in sharp:
        if stretch.left < v and (stretch.right is None or v < stretch.right):
            x = float(stretch.coordinate(v))
            # Pieces within 3 in x of a hidden zero are 8 times shorter.
            near = x + np.linspace(-3.0, 3.0, int(48 / _PIECE) + 1)
            ends = np.concatenate([ends, near[np.abs(near) < _REACH]])
    return np.unique(ends)


def half_line_speed(compliance: Compliance, friction: float, ratio: float) -> float:
    """Return the speed of the edge of slip ahead of a half-line that is stressed beyond friction.

    On x < 0 the interface slips at once, and slip spreads along x > 0.  The integral
    (1/pi) int theta(w) dw / w up to 1 / speed equals ln(1 + chi).

    Parameters
    ----------
    friction : float
        s f, the friction coefficient with the sense of slip.
    ratio : float
        chi >= 0, the stress below friction on x > 0 over the excess above friction on x < 0.

    Raises
    ------
    SceneError
        If a wave that runs ahead grows, so that there is no answer.
    """
    phase = _well_posed(compliance, friction)
    integrals, wanted = PhaseIntegrals(phase), float(np.log1p(ratio))
    edge, found = integrals.root(lambda u: integrals.over(u, lambda w: 1 / w) - wanted)
    if not found:
        raise SceneError(_TOO_FAST)
    return 1 / edge


def half_line_exponent(compliance: Compliance, friction: float, speed: float) -> float:
    """Return the exponent 1 - theta / pi of slip rate at an edge of slip of a given speed."""
    return 1 - slip_phase(compliance, friction).at(1 / speed) / np.pi


def point_speeds(compliance: Compliance, friction: float, drop: float) -> tuple[float, float]:
    """Return the speeds of both edges, right and left, of slip sustained by a growing point force.

    The force is F_0 t delta(x) on an interface at rest: int theta = int theta' up to the edges, and
    d / F_0 = (1/pi) int_0^inf (1 - Re X(i eta)) d eta, with X tending to 1.

    Parameters
    ----------
    friction : float
        s f, the friction coefficient with the sense of slip.
    drop : float
        d c_t / F_0, d being the stress below friction.
    """
    return _two_edges(compliance, friction, drop, None)


def patch_speeds(
    compliance: Compliance, friction: float, drop: float, speed: float
) -> tuple[float, float]:
    """Return the speeds of both edges, right and left, of slip around a growing patch.

    Tractions on |x| < w t exceed those around by S: with e = 1/w, X(e) = X(-e) and
    1 - d / S = (2 e / (pi X(e))) int_0^inf Re X(i eta) / (e^2 + eta^2) d eta.

    Parameters
    ----------
    drop : float
        d / S, the stress below friction outside over the excess S, between 0 and 1.
    speed : float
        w, over c_t of the upper body.
    """
    return _two_edges(compliance, friction, drop, 1 / speed)


def _two_edges(
    compliance: Compliance, friction: float, drop: float, end: float | None
) -> tuple[float, float]:
    """Return the speeds to the right and left.

    The slowness of the end of a patch is `end`; None for a point.
    """
    if not drop > 0 or (end is not None and not drop < 1):
        raise SceneError(f"drop: must be positive, and less than 1 for a patch, got {drop}.")
    right = PhaseIntegrals(_well_posed(compliance, friction))
    left = PhaseIntegrals(_well_posed(compliance.mirrored, friction))
    y = np.arange(-_REACH, _REACH, _ETA_STEP)
    eta, limit = compliance.last * np.exp(y), end or np.inf

    def balance(w: Array) -> Array:
        # X(e) = X(-e) asks for equal integrals of theta / (e - w) + theta / (e + w) on both sides;
        # for a point, e = infinity, for those of theta.
        return np.ones_like(w) if end is None else end / ((end - w) * (end + w))

    def other_edge(edge: float) -> tuple[float, bool]:
        wanted = right.over(edge, balance)
        return left.root(lambda u: left.over(u, balance) - wanted, limit)

    def missing(edge: float) -> float:
        """Return the residual of the equation for d with the left edge balanced."""
        w, weight, _ = right.nodes(edge)
        v, other, _ = left.nodes(other_edge(edge)[0])
        # -ln X at k = i eta, where X(i eta) and X(-i eta) are conjugates: hence the real part.
        sums = _over_distance(weight, w, eta) + _over_distance(other, v, eta).conj()
        below_one = -np.expm1(-sums / np.pi).real  # 1 - Re X falls like 1 / eta^2
        if end is None:
            return float(_ETA_STEP / np.pi * (eta @ below_one)) - drop
        at_end = np.exp(-(weight @ (1 / (w + end)) + other @ (1 / (v - end))) / np.pi)
        share = 2 * end / (np.pi * at_end)
        return (
            1
            - drop
            - float(_ETA_STEP * share * (eta @ ((1 - below_one) / (end * end + eta * eta))))
        )

    edge, found = right.root(missing, limit)
    other, balanced = other_edge(edge)
    if not (found and balanced):
        raise SceneError(_TOO_FAST)
    return 1 / edge, 1 / other


def _over_distance(weight: Array, w: Array, eta: Array) -> Complex:
    """Return the sums of weight / (w + i eta) over w > 0, at eta (m,)."""
    # By real numbers: edges of a point force then take half of the time.
    shares = 1 / (w * w + np.square(eta)[:, None])
    return np.asarray(shares @ (weight * w) - 1j * eta * (shares @ weight))


def _well_posed(compliance: Compliance, friction: float) -> SlipPhase:
    """Return the phase of K; raise SceneError if a wave that runs ahead grows."""
    phase = slip_phase(compliance, friction)
    if not phase.is_regular(friction):
        raise SceneError(
            f"friction {abs(friction):.4g} lets waves grow that run ahead of slip: there is no "
            "answer (docs/dissimilar.md)."
        )
    return phase
