"""Zones of a slot between different bodies: reference numbers of an independent prototype.

The prototype (densities as here, but sinc panels without far weights, Gauss-Legendre stick parts
and a dense QR) gave ten to twelve digits; a spectral march agrees to a cell of its grid.
"""

from dataclasses import replace

import numpy as np
import pytest
from dissimilar_pairs import PAIRS

from semianalytic import Material, find, solve
from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar_slot.densities.density import density_of
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies
from semianalytic.dissimilar_slot.densities.panels import edge_exponents, rule_for
from semianalytic.dissimilar_slot.densities.profile import NORMAL, SHEAR, PairProfile
from semianalytic.dissimilar_slot.densities.zones import MovingZone, edges_of
from semianalytic.dissimilar_slot.placement import place, polished

TOLERANCE = 1e-11


def interface(pair, friction, base_pressure, load, base_shear=0.0):
    """`load` is (Q_0, -P_0), the jump of tau and sigma."""
    bodies = compliance_of(*(PAIRS[pair] if isinstance(pair, str) else pair))
    return LoadedBodies(bodies, friction, 0.0, base_pressure, base_shear, -load[1], load[0])


def placed(known, zones):
    """The zones with edges where they belong, from a start nearby."""
    matrix = glued(known.compliance, TOLERANCE / 10)
    start = place(known, matrix, zones, rule_for(1e-5), 1e-5)
    assert start.converged
    return polished(start, matrix, rule_for(TOLERANCE), TOLERANCE)


def assert_no_constant_is_free(known, zones, least):
    """The least singular value is between 0.26 and 0.37 and does not fall with refinement."""
    coarse, fine = (
        density_of(known, glued(known.compliance, accuracy), zones, rule_for(accuracy))
        for accuracy in (1e-5, 1e-8)
    )
    assert fine.smallest_singular_value == pytest.approx(least, abs=0.002)
    assert coarse.smallest_singular_value > 0.26
    assert coarse.smallest_singular_value == pytest.approx(fine.smallest_singular_value, rel=0.03)


@pytest.mark.parametrize(
    ("edge", "level", "least"), [(2.2, 0.85487324832243, 0.318), (1.6, 0.57862945297427, 0.318)]
)
def test_level_at_which_slip_from_the_slot_ends(edge, level, least):
    """The prototype had 0.854873248232 and 0.578629452911, 9e-11 and 6e-11 less: its tractions on
    stick were integrated along the cut, past a hidden zero."""
    known = interface("0", 0.2, 0.0, (1.0, -0.5))
    zones = (MovingZone(edge, None, 1),)
    density = density_of(known, glued(known.compliance, 1e-13), zones, rule_for(TOLERANCE))
    tau, sigma = density.at_edges[edge]
    assert tau + 0.2 * sigma == pytest.approx(level, abs=2e-11)
    assert_no_constant_is_free(known, zones, least)


@pytest.mark.parametrize(
    ("pair", "pressure", "load", "speed", "rate"),
    [
        ("A", 5.0, (-1.0, 0.0), 0.373588458106, -0.5108806917),
        ("C", 5.0, (-1.0, 0.0), 0.347997525295, -0.5562363275),
        ("A", 4.0, (-1.0, -0.5), 0.450208159960, -0.5120783632),
        ("C", 4.0, (-1.0, -0.5), 0.409015941566, -0.5416429694),
    ],
)
def test_slip_from_the_slot(pair, pressure, load, speed, rate):
    """A and C at P_0 = 0 leave out an opening within x/t < 1e-5, which changes them by 3e-9."""
    known = interface(pair, 0.2, pressure, load)
    result = placed(known, (MovingZone(1 / 0.37, None, -1),))
    assert 1 / result.zones[0].left == pytest.approx(speed, abs=1e-11)
    assert_no_constant_is_free(known, result.zones, 0.333)
    assert result.density.change(0)[0] == pytest.approx(rate, abs=1e-10)


def test_a_detached_zone():
    known = interface("0", 0.4, 0.7, (-1.0, -5.5))
    result = placed(known, (MovingZone(1 / 1.25, 1 / 0.54, -1),))
    speeds = 1 / np.array(edges_of(result.zones))
    np.testing.assert_allclose(speeds, [1.24499152201, 0.5476249625], atol=4e-10)
    assert_no_constant_is_free(known, result.zones, 0.368)
    exponents = edge_exponents(known, None, result.zones[0], None)
    assert exponents == pytest.approx((-0.25618698, 0.47286015), abs=2e-8)
    assert result.density.change(0)[0] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.slow
def test_two_zones():
    known = interface("C", 0.2, 1.1, (-1.0, 0.0))
    start = (MovingZone(1 / 1.16, 1 / 0.985, -1), MovingZone(1 / 0.93, None, -1))
    result = placed(known, start)
    speeds = 1 / np.array(edges_of(result.zones))
    np.testing.assert_allclose(speeds, [1.16734526, 0.98407487, 0.93325727], atol=6e-9)
    first, other = (edge_exponents(known, None, zone, None) for zone in result.zones)
    assert (*first, other[0]) == pytest.approx((-0.3887, -0.4247, -0.4326), abs=6e-5)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("load", "sense", "slip", "opening"),
    [((0.5, 1.0), 1, 0.5570204652, 0.1574862063), ((-0.5, 1.0), -1, 0.5528459861, 0.1245261371)],
)
def test_opening_with_slip_ahead(load, sense, slip, opening):
    start = (MovingZone(1 / 0.556, 1 / 0.14, sense), MovingZone(1 / 0.14, None, sense, True))
    known = interface("0", 0.3, 1.5, load)
    result = placed(known, start)
    assert_no_constant_is_free(known, result.zones, 0.277)
    speeds = 1 / np.array(edges_of(result.zones))
    np.testing.assert_allclose(speeds, [slip, opening], atol=7e-11)


def test_far_apart_edges_do_not_spoil_the_equations():
    """Between slip that starts at 2.7 and an opening at 1e5 the weight has to follow v: with that
    of the ends alone the smallest singular value falls like a power of their ratio."""
    known = interface("A", 0.2, 5.0, (-1.0, 0.0))
    matrix = glued(known.compliance, 1e-9)
    values = []
    for edge in (1e1, 1e3, 1e5):
        zones = (MovingZone(2.677, edge, -1), MovingZone(edge, None, -1, True))
        values.append(density_of(known, matrix, zones, rule_for(1e-6)).smallest_singular_value)
    assert min(values) > 0.25
    assert max(values) / min(values) < 1.2


def test_shear_fronts_of_both_bodies_at_once():
    """There K is singular like d^(-1/2), and a power of omega above 1/2 would admit too much."""
    solid = Material(1.0, 1.0, -0.2)
    known = interface((solid, solid), 0.37, 1.0, (-0.8, 0.0), -0.3)
    zones = (MovingZone(0.889, 1.054, -1), MovingZone(1.375, None, -1))
    density = density_of(known, glued(known.compliance, 1e-9), zones, rule_for(1e-6))
    assert density.smallest_singular_value > 0.02


@pytest.mark.parametrize("name", ["pair-slip", "pair-opening"])
def test_integrals_of_tractions_have_more_digits_than_the_equations(name):
    """At edges, along half circles, and on stick; one spacing for all rules left 3e-12, with which
    the tightest answers were off by 0.85 of their estimates."""
    density = solve(find(name), rtol=1e-10).profile.density
    finer = replace(density, rule=rule_for(1e-18))  # the rule of these integrals alone
    for edge, tractions in density.at_edges.items():
        assert tractions == pytest.approx(finer.at_edges[edge], abs=2e-13)
    u = np.geomspace(0.4, 40.0, 200)
    fine, finest = (PairProfile(both).at(u)[[SHEAR, NORMAL]] for both in (density, finer))
    assert fine == pytest.approx(finest, abs=5e-12)
