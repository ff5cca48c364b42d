"""Fields at the nodes of panels, and their differences between neighbouring sets of zones.

Nodes move with the edges of the zones. At a node fields are analytic in a parameter, whatever their
powers at the edges, and can be differenced there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class Stencil:
    """Finite difference: offsets of its points in steps, their weights, and the step."""

    offsets: Array
    weights: Array
    step: float

    @property
    def points(self) -> Array:
        """Differences of the parameter from its own value."""
        return self.offsets * self.step

    def difference(self, values: Array, axis: int) -> Array:
        """Return the derivative from values at all points, which lie along an axis."""
        return np.tensordot(values, self.weights / self.step, ([axis], [0]))


# Weights of f' from f at the offsets: central of order 2 and 4, and one-sided of order 4.
SECOND_ORDER = np.array([-1.0, 1.0]), np.array([-0.5, 0.5])
_TO_ONE_SIDE = np.arange(5.0), np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12


def stencils(step: float, central: tuple[Array, Array]) -> Iterator[Stencil]:
    """Yield central differences, and one-sided ones for neighbours of other panels."""
    # Next to a change of the set of zones a tenth of the step may still stay on this side.
    for size in (step, step / 10):
        yield Stencil(*central, size)
        yield Stencil(*_TO_ONE_SIDE, size)
        yield Stencil(*_TO_ONE_SIDE, -size)


@dataclass(frozen=True)
class NodeFields:
    """Fields at the nodes of panels, times dv/dy, and positions of the panels; or derivatives."""

    # slopes of slip rate, and of traction less the part unbounded at a stuck contact edge, times
    # dv/dy, (p, n) each
    rate: Array
    traction: Array
    # slip rate and traction at the left of each panel, (p,) each
    rate_starts: Array
    traction_starts: Array
    # ends and rho of the panels, (4, m, 1) and (p, 1)
    ends: Array
    skew: Array
    # powers (q, 1) that the slope of slip rate has near borders of an opening; not part of `rate`
    amounts: Array
    exponents: Array
    tail: Array  # limit of v^2 dV/dv, as of `Profile`, ()
    intensity: Array  # intensity of the traction at a stuck contact edge, ()

    @classmethod
    def of(cls, profile: Profile) -> NodeFields:
        """Return the fields of a profile, with an axis for k sets as `difference` has it."""
        panels = profile.panels
        integrals = profile.rate_integral, profile.traction_integral
        parts = [integral.density * panels.jacobian for integral in integrals]
        parts += [profile.rate_starts, profile.traction_starts, panels.ends.parts, panels.skew]
        parts += [*_of_powers(profile), profile.tail, np.asarray(profile.edge_intensity)]
        return cls(*parts)

    @classmethod
    def zero(cls, profile: Profile) -> NodeFields:
        """Return the derivatives of a profile that does not change."""
        return cls(*(np.zeros_like(part) for part in NodeFields.of(profile)._parts))

    @property
    def _parts(self) -> list[Array]:
        return [getattr(self, field.name) for field in fields(self)]

    @classmethod
    def difference(cls, beside: list[NodeFields], stencil: Stencil) -> NodeFields:
        """Return derivatives from neighbours on a stencil: one by one, or all as sets of one."""
        parts, count = [], len(stencil.weights)
        fields_of = zip(*(profile._parts for profile in beside), strict=True)
        for every, axis in zip(fields_of, (1, 1, 1, 1, 2, 1, 1, 1, 0, 0), strict=True):
            values = np.stack(every, axis) if len(beside) > 1 else every[0]
            # Numbers that all sets share have no axis of sets, and their difference is 0.
            if axis == 0:
                values = np.broadcast_to(values, (count,))
            parts.append(stencil.difference(values, axis))
        return cls(*parts)

    def plus(self, other: NodeFields) -> NodeFields:
        """Return the sum of two derivatives."""
        return NodeFields(*(a + b for a, b in zip(self._parts, other._parts, strict=True)))

    @property
    def of_resting_panels(self) -> NodeFields:
        """The part of the derivatives that is left if panels and the exponents of X are held."""
        moved = ("ends", "skew", "exponents")
        return replace(self, **{name: np.zeros_like(getattr(self, name)) for name in moved})


def _of_powers(profile: Profile) -> tuple[Array, Array]:
    """Return amounts and exponents (q, ..., 1) of the powers of a profile's slope of slip rate."""
    powers, shape = profile.rate_integral.powers, (*profile.panels.jacobian.shape[1:-1], 1)
    amounts, exponents = np.empty((2, len(powers), *shape))
    for i, power in enumerate(powers):
        amounts[i], exponents[i] = power.amount, power.exponent
    return amounts, exponents
