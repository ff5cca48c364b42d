"""Antiplane shear in closed form against multiprecision quadrature of what it was integrated from.

Units c_t = mu = 1.  On the cut |T| = (1 + chi) sqrt(|v - b| / |v - u_s|) is pi v d tau/dv on stick
and pi v m dV/dv on slip, m^2 = v^2 - b^2 (docs/antiplane.md).
"""

import mpmath as mp
import numpy as np
import pytest

from semianalytic import Material, SceneError
from semianalytic.reference import (
    antiplane_edge_intensity,
    antiplane_edge_speed,
    antiplane_slip,
    antiplane_slip_rate,
    antiplane_traction,
    viscous_edge_speed,
    viscous_slip_rate,
)

UNIT = Material(1.0, 1.0, 1 / 3)
STEEL = Material(80e9, 7800.0, 0.29)
CHIS = (0.0, 1e-3, 0.5, 1.0, 7.0)
SHARES = (1e-4, 0.3, 0.999)
"""Shares of the way from the contact edge to the front, or from there to the shear wave."""


def on_slip(chi, u, share=lambda v: 1):
    """int share(v) dV/dv dv from u_s to u, v = u_s + r^2."""
    start = (1 + mp.mpf(chi)) ** 2

    def density(r):
        v = start + r * r
        return 2 * (1 + mp.mpf(chi)) * share(v) / (mp.pi * v * mp.sqrt(v + 1))

    last = mp.sqrt(u - start)
    return mp.quad(density, [0, min(1, last / 2), last])


def on_stick(chi, v, share=lambda v: 1):
    """int share(v) d tau/dv dv from b to v, in v = b + (u_s - b) sin^2 angle."""
    start = (1 + mp.mpf(chi)) ** 2

    def density(angle):
        at = 1 + (start - 1) * mp.sin(angle) ** 2
        return 2 * (1 + mp.mpf(chi)) * (start - 1) * mp.sin(angle) ** 2 * share(at) / (mp.pi * at)

    return mp.quad(density, [0, mp.asin(mp.sqrt((v - 1) / (start - 1)))])


@pytest.mark.thinned(2)
@pytest.mark.parametrize("chi", CHIS)
def test_slip_rate_and_slip_against_quadrature(chi):
    """Slip is t V - x int v dV, by parts; both in mpmath."""
    start = (1 + mp.mpf(chi)) ** 2
    for share in SHARES:
        xi = share / float(start)
        u = 1 / mp.mpf(xi)
        rate = on_slip(chi, u)
        assert antiplane_slip_rate(UNIT, 1.0, chi, xi) == pytest.approx(float(2 * rate), rel=1e-11)
        slip = 2 * rate - 2 * xi * on_slip(chi, u, lambda v: v)
        found = antiplane_slip(UNIT, 1.0, chi, 3.0 * xi, 3.0)
        assert found == pytest.approx(3 * float(slip), rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("chi", CHIS[1:])
def test_traction_against_quadrature(chi):
    edge = antiplane_edge_speed(UNIT, chi)
    assert antiplane_traction(UNIT, 1.0, chi, 0.5 * edge) == chi
    assert antiplane_traction(UNIT, 1.0, chi, 1.5) == 0
    for share in SHARES:
        xi = edge + share * (1 - edge)
        exact = float(on_stick(chi, 1 / mp.mpf(xi)))
        found = antiplane_traction(UNIT, 1.0, chi, xi)
        assert found == pytest.approx(exact, rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("chi", [0.5, 3.0])
def test_traction_has_the_transform_that_slip_was_taken_from(chi):
    """T(k) = int d tau/(1 + k xi), the slot included: 1 + chi at xi = 0, the rest ahead."""
    start = (1 + mp.mpf(chi)) ** 2
    for k in (0, 0.7, 20):
        ahead = on_stick(chi, start, lambda v, k=k: v / (v + k))
        expected = (1 + chi) * mp.sqrt((1 + k) / (start + k))
        assert float(1 + chi - ahead) == pytest.approx(float(expected), rel=1e-11)


def test_units_and_edge_intensity():
    unit = 2e6 / STEEL.shear_impedance
    edge, speed = antiplane_edge_speed(STEEL, 0.5), STEEL.shear_speed
    assert edge == pytest.approx(speed / 2.25, rel=1e-15)
    rate = antiplane_slip_rate(STEEL, 2e6, 0.5, [0.0, 0.2 * speed, edge, speed])
    own = antiplane_slip_rate(UNIT, 1.0, 0.5, [0.0, 0.2, 1 / 2.25, 1.0])
    np.testing.assert_allclose(rate, unit * own, rtol=1e-13)
    assert rate[2] == rate[3] == 0
    slip = antiplane_slip(STEEL, 2e6, 0.5, 0.2 * speed * 3e-4, 3e-4)
    own = antiplane_slip(UNIT, 1.0, 0.5, 0.2, 1.0)
    assert slip == pytest.approx(unit * 3e-4 * own, rel=1e-13)
    lag = 1e-8
    near = antiplane_slip_rate(STEEL, 2e6, 0.5, edge * (1 - lag)) / lag**0.5
    assert near == pytest.approx(antiplane_edge_intensity(STEEL, 2e6, 0.5), rel=1e-7)


def test_viscosity_slows_the_front_to_that_of_the_theory():
    """theory-beyond, section 3: 0.40730 c_t."""
    edge = viscous_edge_speed(UNIT, 0.5, 0.25, "III")
    assert edge == pytest.approx(0.40730, abs=5e-6)
    assert edge < antiplane_edge_speed(UNIT, 0.5)


@pytest.mark.parametrize("chi", [0.01, 0.5, 3.0])
def test_without_viscosity_the_product_is_the_closed_form(chi):
    edge = viscous_edge_speed(UNIT, chi, 0.0, "III")
    assert edge == pytest.approx(antiplane_edge_speed(UNIT, chi), rel=1e-11)
    xi = edge * np.array([0.0, 0.2, 0.7, 0.99, 1.5])
    found = viscous_slip_rate(UNIT, 1.0, chi, 0.0, xi, "III")
    np.testing.assert_allclose(found, antiplane_slip_rate(UNIT, 1.0, chi, xi), atol=1e-11)


@pytest.mark.parametrize(
    "refused",
    [
        lambda: antiplane_edge_speed(UNIT, -0.1),
        lambda: antiplane_slip_rate(UNIT, 1.0, 0.5, -0.1),
        lambda: viscous_edge_speed(UNIT, 0.0, 0.25, "III"),
        lambda: viscous_slip_rate(UNIT, 1.0, 0.5, -0.25, 0.1, "III"),
    ],
)
def test_what_is_no_such_zone_is_refused(refused):
    with pytest.raises(SceneError, match="negative"):
        refused()
