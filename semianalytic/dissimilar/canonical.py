"""The glued interface with a slot: a canonical matrix Psi, once per pair of bodies.

On x > 0 the bodies are bonded, on x < 0 the slot is free.  The transforms of the tractions
T = (T_tau, T_sigma) are then analytic but for the cut k < -m, those of the rates of slip and
opening W = -C T but for the cut k > m, m being the slowness of the fastest wave.  So

    C(k) Psi(k) = R(k),

with Psi analytic off the left cut and R off the right one.  Both are written as elementary factors,
which behave like C at infinity, times t and r that tend to the unit matrix:

    Psi(k) = sqrt(m + k) G(k) t(k),    R(k) = n_inf (m - k)^(-1/2) G(-k) r(k),    N t = r,
    N(k) = G(-k)^T C(k) G(k) sqrt(m^2 - k^2) / n_inf -> 1,

where G is the rotation by phi = eps (2 ln(1 + k / m) - ln(1 + k / (2 m))), eps that of the stuck
edge's exponents 1/2 +- i eps.  Cauchy's formula for t and r, with both cuts turned onto the curve
m sin(pi / 4 + i y) and its mirror images, gives

    r(-z) = 1 + sum_j w_j (N(z_j) - 1) t(z_j) / (z_j + z),
    t(z) = 1 + sum_j w_j (N(z_j)^(-T) - 1) r(-z_j) / (z_j + z):

no wave front and no zero comes near these points, so that the trapezoidal rule converges like
exp(-4.9 / h) for every pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Compliance
from semianalytic.dissimilar.stretch import Values
from semianalytic.scene.arrays import Array


@dataclass(frozen=True, eq=False)
class Glued:
    """Psi and R of one pair of bodies, at nodes z_j whose conjugates belong to the rule as well.

    `right`, `left` (n, 2, 2) are w_j (N(z_j)^(-T) - 1) r(-z_j) and w_j (N(z_j) - 1) t(z_j).
    """

    compliance: Compliance
    nodes: Complex
    right: Complex
    left: Complex

    @property
    def limit(self) -> float:
        """n_inf = a_inf sqrt(1 - beta^2)."""
        return _limit(self.compliance)

    def psi(self, k: Values) -> Values:
        """Return Psi(k), (m, 2, 2), at (m,) slownesses with Re k >= 0; it is real on the axis."""
        root = np.sqrt(self.compliance.first + k)[:, None, None]
        return np.asarray(root * (_rotation(self.compliance, k) @ self._sum(self.right, k)))

    def rates(self, v: Values) -> Values:
        """Return R(-v), (m, 2, 2), at (m,) slownesses with Re v >= 0; it is real on the axis."""
        scale = (self.limit / np.sqrt(self.compliance.first + v))[:, None, None]
        return np.asarray(scale * (_rotation(self.compliance, v) @ self._sum(self.left, v)))

    def _sum(self, residues: Complex, z: Values) -> Values:
        """Return 1 + sum_j residues_j / (z_j + z), conjugates included, (m, 2, 2)."""
        flat, apart = 2 * residues.reshape(-1, 4), self.nodes.real + z[:, None]
        # Both denominators together are real where z is, which halves the time, and nothing in
        # their product cancels, for |Im z_j| < Re z_j.
        over = np.square(apart)
        over += np.square(self.nodes.imag)
        np.reciprocal(over, out=over)
        total = over @ (flat.imag * self.nodes.imag[:, None])
        over *= apart
        total += over @ flat.real
        return np.asarray(np.eye(2) + total.reshape(-1, 2, 2))

    @cached_property
    def at_zero(self) -> Array:
        """Psi(0), (2, 2)."""
        return np.asarray(self.psi(np.zeros(1))[0].real)

    def constant(self, shear: float, pressure: float) -> Array:
        """Return Psi(0)^(-1) L, (2,), of a step (Q_0, P_0) on the slot faces, L = (Q_0, -P_0)."""
        return np.asarray(np.linalg.solve(self.at_zero, np.array([shear, -pressure])))

    def error(self, v: Array) -> float:
        """Return the residual of Psi(v)^T R(-v) = n_inf 1 at slownesses v (m,), an error bound."""
        # It is constant for the exact matrix, and nothing in the linear system uses that.
        product = np.swapaxes(self.psi(v), -1, -2) @ self.rates(v)
        return float(np.abs(product / self.limit - np.eye(2)).max())


def _limit(compliance: Compliance) -> float:
    return compliance.static * float(np.sqrt(1 - compliance.dundurs**2))


def _rotation(compliance: Compliance, k: Values) -> Values:
    """Return the rotation G(k), (m, 2, 2)."""
    share = k / compliance.first
    # eps of the exponent 1/2 +- i eps at a stuck contact edge
    oscillation = float(np.arctanh(compliance.dundurs) / np.pi)
    # Like eps ln k at infinity, which makes N tend to the unit matrix, and like k at 0.
    angle = oscillation * (2 * np.log1p(share) - np.log1p(share / 2))
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.moveaxis(np.array([[cosine, -sine], [sine, cosine]]), (0, 1), (-2, -1))


@lru_cache(maxsize=16)
def glued(compliance: Compliance, tolerance: float) -> Glued:
    """Return the canonical matrix of two bodies to a tolerance; recent ones are kept."""
    digits = np.log(30.0 / max(tolerance, 3e-15))  # finer ones are rounding
    # The error is exp(-4.9 / h) + exp(-2 Y) times about 30, Y being the length of the curve:
    # measured at h from 0.46 to 0.15.
    count = int(np.ceil(digits / 2.0 / (4.9 / digits)))
    spacing, m = digits / 2.0 / count, compliance.first
    y = spacing * np.arange(count + 1)
    nodes = m * np.sin(np.pi / 4 + 1j * y)
    # dz / (2 pi i) along the curve z = m sin(pi / 4 + i y).
    weights = spacing * m * np.cos(np.pi / 4 + 1j * y) / (2 * np.pi)
    weights[0] /= 2  # on the axis, where a point is its own conjugate's neighbour
    entries = compliance.at(nodes)
    matrix = entries.matrix / entries.rayleigh[:, None, None]
    # Two roots, each on its own branch; the root of the product would jump across the cut.
    root = np.sqrt(m - nodes) * np.sqrt(m + nodes) / _limit(compliance)
    turned = np.swapaxes(_rotation(compliance, -nodes), -1, -2) @ matrix
    symbol = (turned @ _rotation(compliance, nodes)) * root[:, None, None]
    of_t = weights[:, None, None] * (symbol - np.eye(2))
    of_r = weights[:, None, None] * (np.linalg.inv(np.swapaxes(symbol, -1, -2)) - np.eye(2))
    from_t, from_r = _operator(nodes, of_t), _operator(nodes, of_r)
    ones = np.zeros((4 * len(nodes), 2))
    ones[0 : 2 * len(nodes) : 2, 0] = ones[1 : 2 * len(nodes) : 2, 1] = 1.0
    # t = 1 + K_r r and r = 1 + K_t t, real and imaginary parts of both rows
    both = np.eye(len(ones)) - from_r @ from_t
    t = np.asarray(np.linalg.solve(both, ones + from_r @ ones), dtype=float)
    r = ones + from_t @ t
    return Glued(compliance, nodes, of_r @ _complex(r), of_t @ _complex(t))


def _operator(nodes: Complex, factors: Complex) -> Array:
    """Return the matrix (4 n, 4 n) of x_j -> sum factors_j x_j / (z_j + z_i), real parts first."""
    size = 2 * len(nodes)
    own = np.einsum("ij,jab->iajb", 1 / (nodes + nodes[:, None]), factors).reshape(size, size)
    mirrored = np.einsum("ij,jab->iajb", 1 / (nodes.conj() + nodes[:, None]), factors.conj())
    mirrored = mirrored.reshape(size, size)
    plus, minus = own + mirrored, own - mirrored
    return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])


def _complex(parts: Array) -> Complex:
    """Return (n, 2, 2) complex values from real parts above imaginary ones, (4 n, 2)."""
    real, imag = np.split(parts, 2)
    return np.asarray((real + 1j * imag).reshape(-1, 2, 2))
