"""Velocity, stress and displacement in both bodies of a solved pair.

The transforms of the tractions T = Psi z are known on and above the axis of slowness.  Each body
sees them, and the motion of its own face, as the only half-plane: the lower one mirrored, with the
shear traction reversed.  Right of k = 0 the motion follows from T by the compliance of that body,
C_j, which has a pole at its Rayleigh wave; left of it, where T = C^(-1) rho with rho = R z, as

    C_j T = (R_i det N_j / R_j + N_j adj N_i) rho / (R_1 R_2 det C),    N_j = C_j R_j,

i being the other body, in which nothing has a pole at a Rayleigh wave and det N_j / R_j is
(alpha beta + k^2) / mu^2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partialmethod

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.compliance import Complex
from semianalytic.dissimilar_slot.densities.density import Density, density_of
from semianalytic.dissimilar_slot.densities.panels import rule_for, tolerance_of
from semianalytic.dissimilar_slot.densities.zones import edges_of
from semianalytic.field import tuning
from semianalytic.field.body import Quantity, Sent, checked_points, fields_of, points_around
from semianalytic.field.cells import Primitives
from semianalytic.field.sources import Source
from semianalytic.field.waves import Slowness, plane_wave, radiated
from semianalytic.halfplane.rayleigh import RayleighFactors, rayleigh_factors
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Scene

_MIRRORED = np.array([1, -1, 1, 1, -1, 1, -1])
"""Signs that turn the fields of the mirrored lower body into its own."""


@dataclass(frozen=True, eq=False)
class BodyFace(Source):
    """The face of one body of a pair as the `Source` of the waves in it, in the body's units."""

    density: Density
    below: bool
    poisson_ratio: float

    @cached_property
    def factors(self) -> RayleighFactors:
        return rayleigh_factors(self.poisson_ratio)

    @property
    def _unit(self) -> float:
        """Unit of slowness, b of the body over that of the upper one."""
        return self.density.interface.compliance.bodies[self.below].b

    @cached_property
    def _singular(self) -> list[float]:
        """Slownesses v, in units of the upper body, at which tractions are singular at k = -v."""
        interface, zones = self.density.interface, self.density.zones
        found = {*interface.compliance.distinct_fronts, *edges_of(zones)}
        found.update(interface.sharp_turns(1, False))
        for zone in zones:
            found.update(interface.sharp_turns(zone.sense, zone.open))
        found.update(pole.slowness for part in self.density.parts for pole in part.poles)
        return sorted(found, reverse=True)

    @cached_property
    def places(self) -> Array:
        left = [-v / self._unit for v in self._singular]
        return np.array([*left, 0.0, self.factors.a, 1.0, self.factors.c])

    @property
    def parting(self) -> int:
        return len(self._singular)

    @property
    def still(self) -> tuple[float, float]:
        return -self.density.interface.compliance.first / self._unit, self.factors.a

    @cached_property
    def ahead(self) -> Complex:
        return np.zeros_like(self.behind)

    @cached_property
    def behind(self) -> Complex:
        interface, a = self.density.interface, self.factors.a
        # Seen as an upper body, the lower one has y, and with it sigma_xy, reversed.
        shear = -interface.load_shear if self.below else interface.load_shear
        return -plane_wave(shear, "II", a) - plane_wave(-interface.load_pressure, "I", a)

    @property
    def is_coarse(self) -> bool:
        density = self.density
        return bool(density.parts) and tolerance_of(density.rule.spacing) > tuning.COARSE_FROM

    def densities(self, owners: np.ndarray, offset: Complex) -> Complex:
        owners = np.repeat(owners, offset.shape[1])
        nodes = sum(part.panel.count for part in self.density.parts) + 1
        # Each point meets every node of every zone: in pieces, or memory would grow as their
        # product; these take some MB.
        count = 1 + offset.size * nodes // 60_000
        pieces = (np.array_split(part, count) for part in (owners, offset.ravel()))
        values = [self._densities(*piece) for piece in zip(*pieces, strict=True)]
        return np.concatenate(values, axis=1).reshape(-1, *offset.shape)

    def _densities(self, owners: np.ndarray, offset: Complex) -> Complex:
        """Return all densities (f, m) at offsets (m,) from singular points (m,)."""
        fronts = np.array([[self.factors.a], [1.0], [self.factors.c]])
        place = self.places[owners]
        left, right = (fronts + place) + offset, (place - fronts) + offset
        at = Slowness(self.factors, place + offset, left, right)
        values = np.empty((4, len(offset)), dtype=complex)
        stuck, start = owners < self.parting, place * self._unit
        # The exact slowness of singular points, without the rounding of its scaled copy.
        start[stuck] = -np.array(self._singular)[owners[stuck]]
        ahead = at.k.real >= 0
        if ahead.any():
            parts = (at.k, at.alpha, at.beta, at.coupling, at.rayleigh)
            k, alpha, beta, coupling, rayleigh = (part[ahead] for part in parts)
            tau, sigma = self._tractions(start[ahead], offset[ahead] * self._unit)
            # V = -B tau - k D sigma and U = k D tau - A sigma of this body alone, in its own units.
            along = -(beta * tau + k * coupling * sigma) / rayleigh
            across = (k * coupling * tau - alpha * sigma) / rayleigh
            values[:, ahead] = along, across, tau, sigma
        if not ahead.all():
            values[:, ~ahead] = self._from_rates(start[~ahead], offset[~ahead] * self._unit)
        along, across, shear, press = values
        return radiated(at, (along, across), (shear, press))

    def _tractions(self, place: Array, offset: Complex) -> tuple[Complex, Complex]:
        """Return T_tau and T_sigma of the face right of k = 0, (m,) each."""
        z = self.density.above(place, offset)
        tau, sigma = (self.density.glued.psi(place + offset) @ z[..., None])[..., 0].T
        return -tau if self.below else tau, sigma

    def _from_rates(self, place: Array, offset: Complex) -> Complex:
        """Return V_x, V_y in units of the body, T_tau and T_sigma left of k = 0, (4, m)."""
        compliance, k = self.density.interface.compliance, place + offset
        entries = compliance.beside(place, offset)
        z = self.density.above(place, offset)
        rho = (self.density.glued.rates(-k) @ z[..., None])[..., 0]
        tau, sigma = (entries.inverse @ rho[..., None])[..., 0].T
        own_body, other = entries.bodies[::-1] if self.below else entries.bodies
        sign, (slip, part) = -1.0 if self.below else 1.0, rho.T
        own, far = sign * k * own_body.coupling, sign * k * other.coupling
        first = other.normal * slip + far * part
        second = other.tangential * part - far * slip
        static = own_body.determinant * other.rayleigh
        scale = own_body.body.modulus * own_body.body.b / entries.determinant
        along = (static * slip + own_body.tangential * first + own * second) * scale
        across = (static * part + own_body.normal * second - own * first) * scale
        return np.stack([-sign * along, -across, sign * tau, sigma])


@dataclass(frozen=True, eq=False)
class PairBodies:
    """The fields in both bodies of a solved pair, which its `PairSolution` returns."""

    scene: Scene
    density: Density
    stress_unit: float

    def _fields(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return a quantity, (q, ...); see `PairSolution.velocity`, `stress` and `displacement`."""
        x, y, t = checked_points(x, y, t)
        rows = np.zeros((3 if quantity == "stress" else 2, *x.shape))
        for below, body in enumerate(self.scene.bodies):
            # The sign bit distinguishes 0.0 from -0.0, the two faces of the interface.
            here = (t > 0) & (np.signbit(y) == bool(below))
            at = x[here], y[here], body.shear_speed * t[here]
            over = {"velocity": body.shear_impedance, "displacement": body.shear_modulus}
            unit = self.stress_unit / over.get(quantity, 1.0)
            rows[:, here] = unit * fields_of([self._sent[below]], quantity, at)
        if quantity == "stress":
            # Pressure is positive in compression, sigma_yy in tension; sigma_xx of the base is not
            # known.
            rows[1] -= self.scene.base.pressure
            rows[2] += self.scene.base.shear
        return rows

    velocity = partialmethod(_fields, "velocity")
    stress = partialmethod(_fields, "stress")
    displacement = partialmethod(_fields, "displacement")

    @cached_property
    def error(self) -> float:
        """Estimate of the error of velocities and stresses, relative to themselves plus the load.

        It is the change that a rule ten times coarser makes with the same edges, as in
        `semianalytic.field.bodies.Bodies`, and what Psi^T R(-k) = n_inf leaves.
        """
        density, change = self.density, 0.0
        # Fields of 12 stuck pairs were off by up to 4 times the largest residual of Psi^T R = n_inf
        far = density.interface.compliance.last * np.geomspace(0.01, 1e4, 7)
        cells = tuning.CELL_ERROR + 5.0 * density.glued.error(far)
        if density.parts:
            tolerance = tolerance_of(density.rule.spacing)
            rule = rule_for(tuning.COARSER * tolerance)
            given = density.interface, density.glued, density.zones
            coarse = replace(self, density=density_of(*given, rule))
            for sent, coarser, side in zip(self._sent, coarse._sent, (1.0, -1.0), strict=True):
                # The same points in both bodies, each over its own wave speed.
                x, y = points_around(sent.primitives.reach)
                at = x, np.copysign(y, side), np.ones_like(x)
                for quantity in ("velocity", "stress"):
                    rows, others = (fields_of([part], quantity, at) for part in (sent, coarser))
                    beside = np.abs(rows - others) / (1 + np.abs(rows))
                    change = max(change, float(beside.max()))
            if self._sent[0].primitives.source.is_coarse:
                cells += tuning.COARSE_ERROR
        return cells + change

    @cached_property
    def _sent(self) -> tuple[Sent, Sent]:
        """Waves that the faces of the upper and of the lower body send into them."""
        upper, lower = (
            Sent(Primitives(BodyFace(self.density, below, body.poisson_ratio)), _MIRRORED)
            for below, body in zip((False, True), self.scene.bodies, strict=True)
        )
        return upper, lower
