"""What a grid makes of a crack tip between two bodies: tables, closed forms, a linear system."""

import numpy as np
import pytest
from scipy.linalg import solve_toeplitz

from semianalytic.dissimilar.grid_edge import edge_factors
from semianalytic.halfplane.edge_factors import edge_offset_and_factors

CONTACT = {
    0.0: [(1.06024, 0.89515, 1.0383, 0.96981, 1.01685, 0.98513), (0.0,) * 6],
    0.1: [
        (1.05639, 0.90197, 1.03184, 0.97592, 1.01113, 0.99057),
        (-0.05002, 0.05508, -0.0393, 0.0332, -0.0278, 0.02494),
    ],
    0.2: [
        (1.04474, 0.92252, 1.01249, 0.99412, 0.99416, 1.00664),
        (-0.09958, 0.10798, -0.07564, 0.06316, -0.05221, 0.04642),
    ],
    0.3: [
        (1.02487, 0.95712, 0.98042, 1.02394, 0.96667, 1.03245),
        (-0.14819, 0.15626, -0.10575, 0.08636, -0.06959, 0.06078),
    ],
}
"""Real and imaginary parts of the factors of contact nodes for nu = +artanh(beta) / pi, of an
independent computation."""


@pytest.mark.parametrize("beta", CONTACT)
def test_factors_of_contact_nodes(beta):
    """The table is off by 6.4e-4 at the first node, and by 1.6e-4 and less at the others: see
    `test_the_first_factor_in_closed_form`."""
    offset, contact, _ = edge_factors(beta)
    assert offset == pytest.approx(0.30996, abs=4e-5)
    real, imaginary = np.array(CONTACT[beta])
    off = np.abs(contact[:6].conj() - real - 1j * imaginary)
    assert off[0] < 7e-4
    assert off[1:].max() < 1.6e-4


def test_factors_of_slot_nodes():
    known = [0.99093 - 0.0138j, 1.00858 + 0.0037j, 0.99915 - 0.00229j, 1.00185 + 0.00131j]
    np.testing.assert_allclose(edge_factors(0.15183)[2][:4].conj(), known, rtol=0, atol=3e-4)


def test_the_first_factor_in_closed_form():
    """ln E(0) is half of the mean of ln(|theta / 2| / |sin(theta / 2)|), (ln pi - 1) / 2."""
    offset, contact, _ = edge_factors(0.0)
    assert contact[0] == pytest.approx(np.pi * np.sqrt(offset / np.e), rel=2e-8)
    np.testing.assert_allclose(contact.real, edge_offset_and_factors()[1], rtol=1e-10)
    assert not contact.imag.any()


@pytest.mark.parametrize("beta", [0.0, 0.15183, -0.3])
def test_they_solve_the_equations_of_a_grid(beta):
    """A slot of many nodes under uniform traction, beside which both fields are those of a tip."""
    sizes, found = (500, 1000), []
    for count in sizes:
        m = np.arange(1, 2 * count)
        # coefficients of |theta| + i s beta theta / i at lag m, s = -1: -i nu has the sign of beta
        even = np.append(np.pi / 2, ((-1.0) ** m - 1) / (np.pi * m**2))
        odd = beta * np.append(0.0, 1j * (-1.0) ** m / m)
        lag = even + odd
        slip = solve_toeplitz((lag[:count], lag[:count].conj()), np.ones(count))
        # contact node j lies j + 1 places beyond the last node of the slot; what the slot carries
        # is taken off everywhere, which leaves x / sqrt(x^2 - 1)
        traction = np.array([lag[j + 1 : j + 1 + count] @ slip[::-1] for j in range(4)]) - 1
        tip = slip[::-1][:4]
        offset, contact, slot = edge_factors(beta)
        nu, j = -np.arctanh(beta) / np.pi, np.arange(4)
        shares = (
            traction / (contact[:4] * (j + offset) ** (-0.5 + 1j * nu)),
            tip / (slot[:4] * (j + 1 - offset) ** (0.5 + 1j * nu)),
        )
        found.append([share[1:] / share[0] - 1 for share in shares])
    extrapolated = 2 * np.array(found[1]) - np.array(found[0])  # the rest falls like 1 / count
    # the table above, off by 6e-4 at the first node, would not pass
    assert np.abs(extrapolated).max() < 2e-4
