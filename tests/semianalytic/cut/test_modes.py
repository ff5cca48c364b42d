"""The problem on the cut in all its modes: closed limits, another operator, residues at c_R."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from semianalytic import Material, Scene, Tractions, ViscousFriction, solve
from semianalytic.cut.load import Load, Opened
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.regimes import opening_threshold
from semianalytic.selfsimilar.zones.collocation import slip_grid

RULE = rule_for(1e-12)
OPEN = Scene(
    Material(1.0, 1.0, 0.2), 0.45, Tractions(0.0033, 0.0004), Tractions(1.0, 0.05)
)  # the contact opens around c, with slip ahead
CASES = {
    "slip from ahead of the shear front": Scene(
        Material(1.0, 1.0, 0.1), 1.08, Tractions(0.067, -0.016), Tractions(1.0, -0.9)
    ),
    "no friction": Scene(Material(1.0, 1.0, 0.25), 0.0, Tractions(1.0, 0.0), Tractions(0.0, 1.0)),
    "opening": OPEN,
    "opening behind the shear front": Scene(
        Material(1.0, 1.0, 0.1),
        0.3,
        Tractions(0.8 * opening_threshold(0.1), 0.0),
        Tractions(1.0, 0.4),
    ),
    "opening within a film": replace(OPEN, friction_law=ViscousFriction(0.04)),
}


def edge_zone(factors, load, last=60.0):
    """The zone next to the contact edge that opens slower than the last front."""

    def mismatch(v):
        return ZoneFields(factors, load, (Zone(factors.cut([v]), None, 1),), RULE, False).mismatch()

    first = factors.c * (1 + 1e-4)
    return Zone(factors.cut([brentq(lambda v: mismatch(v)[0], first, last, xtol=1e-15)]), None, 1)


def grid_traction(nu, load, slip_rate, size=400):
    """Places, and the shear traction of a slip rate there by the operator of the grid."""
    grid = slip_grid(nu, size)
    rate = slip_rate(1 / np.maximum(grid.xi, 1e-9))[:-1]
    far = float(load.far_slip_rate)
    base = load.base_shear + (load.load_shear * grid.shear + far * grid.far) / grid.weight
    return grid.xi[:-1], base + (grid.operator @ rate) / grid.weight


@pytest.mark.parametrize("resistance", [1e-6, 1e-3, 0.1, 1.0])
def test_viscous_slip_everywhere_balances_the_operator_of_the_grid(resistance):
    factors = rayleigh_factors(1 / 3)
    load = Load(0.5, 1.0, 1.0, 1.0, 1.0, 0.5 / (1 + resistance), resistance=resistance)
    profile = Profile(ZoneFields(factors, load, (Zone(None, None, 1),), RULE))
    xi, traction = grid_traction(1 / 3, load, profile.slip_rate)
    u = 1 / np.maximum(xi, 1e-9)
    grid = slip_grid(1 / 3, 400)
    strength = 0.5 * (1 + grid.pressure / grid.weight)
    expected = strength + resistance * profile.slip_rate(u)
    inside = (xi > 0.01) & (xi < 1.99)
    assert np.abs(traction - expected)[inside].max() < 6e-5
    assert np.abs(traction - strength)[inside].min() > 0.2 * resistance - 6e-5  # it counts


def test_resistance_per_node_is_resistance():
    factors = rayleigh_factors(0.2)
    zones = (Zone(factors.cut([2.0]), None, 1),)
    load = Load(0.3, 1.0, 0.0, 0.4, 1.0, 0.0, resistance=0.3)
    one = ZoneFields(factors, load, zones, RULE)
    many = Load(0.3, 1.0, 0.0, 0.4, 1.0, 0.0, resistance=np.full(one.panels.jacobian.shape, 0.3))
    other = ZoneFields(factors, many, zones, RULE)
    np.testing.assert_allclose(other.slip_rate_slope, one.slip_rate_slope, rtol=1e-13, atol=0)


def test_a_given_slope_of_strength_is_followed():
    """Slip everywhere whose strength rises towards the edge: so does the traction of that slip."""
    factors, zones = rayleigh_factors(0.2), (Zone(None, None, 1),)
    load = Load(0.3, 1.0, 1.0, 0.0, 1.0, 0.7 / 1.2, resistance=0.2)
    panels = ZoneFields(factors, load, zones, RULE).panels
    load = replace(load, given_slope=0.3 * panels.at.from_a / panels.at.v**3)
    profile = Profile(ZoneFields(factors, load, zones, RULE))
    xi, traction = grid_traction(0.2, load, profile.slip_rate)
    expected = 0.3 + 0.15 / factors.a * np.square(1 - factors.a * xi)
    inside = (xi > 0.02) & (xi < 0.98 / factors.a)
    resisted = 0.2 * profile.slip_rate(1 / np.maximum(xi, 1e-9))
    assert np.abs(traction - expected - resisted)[inside].max() < 2e-4
    assert np.ptp(expected[inside]) > 0.2


def test_slip_around_an_open_part_balances_the_operator_of_the_grid():
    nu = 1 / 3
    normal_factors, factors = rayleigh_factors(nu, "I"), rayleigh_factors(nu)
    normal = Load(0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
    opening = edge_zone(normal_factors, normal)
    gap = Profile(ZoneFields(normal_factors, normal, (opening,), RULE))
    known = np.zeros((2, 0))
    opened = Opened(opening, (), 1.0, -1.0, lambda at: 1.0 - gap.shear_change(at.v), known)
    load = Load(0.6, 1.0, 0.0, -1.0, 1.0, 0.0, opened=opened)
    zone = edge_zone(factors, load, last=5.3)
    profile = Profile(ZoneFields(factors, load, (zone,), RULE))
    errors = []
    for size in (150, 600):
        xi, traction = grid_traction(nu, load, profile.slip_rate, size)
        at = factors.cut(1 / np.maximum(xi, 1e-9))
        strength = np.where(xi < 0.1875, 0.0, 0.6 * opened.pressure(at))
        slips = (xi > 0.02) & (at.v > zone.left.v[0]) & (np.abs(xi - 0.1875) > 0.02)
        slips &= xi < 1 / zone.left.v[0] - 0.02
        errors.append(np.abs(traction - strength)[slips].max())
    assert errors[1] < 1e-3
    assert errors[1] < errors[0] / 5


def on_rule(fields, tolerance):
    return ZoneFields(fields.factors, fields.load, fields.zones, rule_for(tolerance))


@pytest.mark.parametrize("scene", CASES.values(), ids=CASES)
def test_residues_are_those_that_nodes_show(scene):
    fields = solve(scene, rtol=1e-10).profile.fields
    fine = on_rule(fields, 1e-13)
    pole, rate = fine.layout.pole, fine.rate_integral()
    assert pole >= 0
    shown = replace(rate, residue=None).residues[pole]
    largest = float(np.abs(rate.totals).max())
    assert rate.residues[pole] == pytest.approx(shown, rel=1e-8, abs=1e-10 * largest)
    # a loose rule knows it nearly as well
    loose = on_rule(fields, 1e-5).rate_integral()
    known = loose.residues[loose.panels.layout.pole]
    assert known == pytest.approx(shown, rel=1e-6, abs=1e-6 * largest)


def test_residues_of_the_gap_are_those_that_nodes_show():
    fields = solve(OPEN, rtol=1e-10).normal.profile.fields
    fine = replace(fields, rule=rule_for(1e-13))
    rate = fine.rate_integral()
    shown = replace(rate, residue=None).residues[fine.layout.pole]
    assert rate.residues[fine.layout.pole] == pytest.approx(shown, rel=1e-8)


def test_residues_of_many_sets_of_zones_are_those_of_each():
    fields = solve(CASES["slip from ahead of the shear front"], rtol=1e-8).profile.fields
    friction = np.array([[1.07], [1.08], [1.09]])
    load = replace(fields.load, friction=friction, far_slip_rate=np.zeros((3, 1)))
    many = ZoneFields(fields.factors, load, fields.zones, fields.rule).residue
    each = [
        ZoneFields(
            fields.factors, replace(fields.load, friction=float(f)), fields.zones, fields.rule
        )
        for f in friction[:, 0]
    ]
    np.testing.assert_allclose(many, [float(one.residue) for one in each], rtol=1e-12)
