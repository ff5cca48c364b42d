"""Nodal values of a grid near the edge of a stuck contact between two bodies.

tau + i sigma and tau - i sigma diagonalise the static symbol of a grid, |theta| (1 -+ beta sgn
theta) with Dundurs' beta, and these scalar symbols have Wiener-Hopf factors in closed form: with
z = exp(i theta), nu = -+ artanh(beta) / pi and the factor E(z) of |theta| / (2 |sin(theta / 2)|),

    contact nodes  t_j = [z^j] (1 - z)^(-1/2 - i nu) (1 + z)^(i nu) E(z),
    slot nodes     u_l = [z^l] (1 - z)^(-3/2 - i nu) (1 + z)^(i nu) / E(z).

They tend to the fields of a crack tip at (j + 0.31) h and (l + 0.69) h from it, but for known
factors, and for waves two nodes long, of relative size j^(-1/2), from the jump of the symbol at
theta = pi: no grid removes these, and means of three nodes do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semianalytic.halfplane.edge_factors import edge_offset_and_factors, exponential, log_factor
from semianalytic.scene.arrays import Array, Complex, Mask

MOST_NODES = 512
"""Largest number of nodes that are read: the next one's factor is 1 to 2e-3 for beta = 0.3."""


@dataclass(frozen=True, eq=False)
class EdgeReading:
    """Fields near the edge of a stuck contact, as far as a grid knows them.

    Attributes
    ----------
    distance : (n,) array
        Distances from the edge into the contact [length].
    shear_traction, pressure : (n,) arrays
        Total shear traction and contact pressure there [stress].
    slot_distance : (m,) array
        Distances from the edge into the slot [length].
    slip, gap : (m,) arrays
        Slip and change of the width of the slot there [length].

    Examples
    --------
    >>> import semianalytic as sa
    >>> push, contact = sa.InterfaceLoad(0.1, on="slot"), sa.Contact.half_line()
    >>> solid, law = sa.Material(1.0, 1.0, 0.25), sa.Coulomb(0.5)
    >>> held = sa.Scene(solid, law, sa.Tractions(1.0, 0.0), push, contact=contact, period=8.0)
    >>> reading = sa.solve(held, end_time=1.0, nodes=64).beside_edge(0.0)
    >>> reading.distance[:2].round(4), reading.shear_traction[:2].round(3)
    (array([0.1637, 0.2887]), array([0.095, 0.054]))
    """

    distance: Array
    shear_traction: Array
    pressure: Array
    slot_distance: Array
    slip: Array
    gap: Array

    def __repr__(self) -> str:
        far, off = self.distance, self.slot_distance
        return (
            f"<EdgeReading: contact at {len(far)} points {far.min():.3g} to {far.max():.3g} from "
            f"the edge, slot at {len(off)} points {off.min():.3g} to {off.max():.3g}>"
        )


@lru_cache(maxsize=16)
def edge_factors(beta: float) -> tuple[float, Complex, Complex]:
    """Return the offset of the grid's edge, and the factors of nodes of the contact and the slot.

    `beta` is Dundurs' of the upper body minus that of the lower one.  The offset is the distance
    from the edge to the first node of a contact x > 0, over the node distance.  The factors
    (MOST_NODES,) are tau + i sigma at nodes of the contact, and slip + i gap at nodes of the slot,
    over the fields of a crack tip, K d^(-1/2 + i nu) and K d^(1/2 + i nu) with nu = -artanh(beta) /
    pi, at the nodes' distances d from the edge.
    """
    from scipy.special import loggamma  # here, for `import semianalytic` is to be quick

    offset, smooth = edge_offset_and_factors()[0], log_factor()[: MOST_NODES - 1]
    total = log_factor().sum()  # ln E(1), with E(0) = 1
    nu = -np.arctanh(beta) / np.pi
    k, j = np.arange(1, MOST_NODES), np.arange(MOST_NODES)
    # ln(1 + z) = -sum (-z)^k / k, times i nu; those of the powers of (1 - z) are (1/2 + i nu) / k.
    alternating = -1j * nu * (-1.0) ** k / k
    contact: Complex = exponential((0.5 + 1j * nu) / k + alternating + smooth).astype(complex)
    slot: Complex = exponential((1.5 + 1j * nu) / k + alternating - smooth).astype(complex)
    # Far from the edge [z^j] (1 - z)^-s tends to j^(s - 1) / Gamma(s), and the regular factors to
    # their values at z = 1: these make the quotient with the field of a crack tip tend to 1.
    turn = np.exp(-1j * nu * np.log(2))
    contact *= turn * np.exp(loggamma(0.5 + 1j * nu) - total) * (j + offset) ** (0.5 - 1j * nu)
    slot *= turn * np.exp(loggamma(1.5 + 1j * nu) + total) * (j + 1 - offset) ** (-0.5 - 1j * nu)
    return offset, contact, slot


def zone_beside_edge(
    change: Array, strength: Array, where: Mask, spacing: float, compliance: float
) -> tuple[Array, Array]:
    """Return length and area of slip, or of an opening, near an edge whose first node is closed.

    Beyond any strength, the traction at an edge makes the contact slip over a length l.  The
    traction of the first node gives K; under a constant strength s, l = (pi / 8) (K / s)^2, the
    slip at the edge is 8 s l / (pi E') and its mean over l a third of it (Dugdale).  A tension
    opens the contact in the same way against the pressure on it.

    `change` is |change of traction| at the first node [stress], `strength` the strength there less
    the traction before the change in its sense [stress], positive `where` there is a zone;
    `spacing` is the node distance [length], `compliance` 2 / E', the mean of (1 - nu) / mu of both
    bodies [1 / stress].
    """
    offset, of_contact, _ = edge_factors(0.0)
    # tau = K / sqrt(2 pi d) at the distance d of the first node, which has a known factor.
    root = change * np.sqrt(2 * np.pi * offset * spacing) / of_contact[0].real
    length = np.pi / 8 * (root / np.where(where, strength, 1.0)) ** 2
    # A contact that sticks up to 2e-7 node distances next to an edge asked for 1e10 nodes.
    length = np.where(where & (length > 1e-5 * spacing), length, 0.0)
    return length, 4 * compliance * strength * length**2 / (3 * np.pi)


def read_beside_edge(
    contact: Complex, slot: Complex, spacing: float, beta: float
) -> tuple[Array, Complex, Array, Complex]:
    """Return what nodal values near an edge of a stuck contact x > 0 say of the exact fields.

    Every value is divided by that of a crack tip on the same grid; means of three quotients,
    weighted 1, 2, 1, are multiplied by the exact fields of a crack tip.  The first and the last
    node on either side have no neighbours for a mean and are left out.

    Given, from the edge on, are changes of tau + i sigma from the base state at nodes of the
    contact (n,), slip + i gap at nodes of the slot (m,), the node distance and Dundurs' beta;
    returned are distance (n - 2,), tau + i sigma (n - 2,), slot distance (m - 2,) and slip + i gap
    (m - 2,).
    """
    offset, of_contact, of_slot = edge_factors(beta)
    nu = -np.arctanh(beta) / np.pi
    distances, fields = [], []
    for values, factors, first, power in (
        (contact, of_contact, offset, -0.5),
        (slot, of_slot, 1 - offset, 0.5),
    ):
        away = np.arange(len(values)) + first
        tip = away ** (power + 1j * nu)
        share = values / (factors[: len(values)] * tip)
        # Weights 1, 2, 1 leave nothing of a wave that is two nodes long.
        mean = (share[:-2] + 2 * share[1:-1] + share[2:]) / 4
        distances.append(np.asarray(spacing * away[1:-1]))
        fields.append(np.asarray(mean * tip[1:-1], dtype=complex))
    return distances[0], fields[0], distances[1], fields[1]
