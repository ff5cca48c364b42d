"""Loads of scenes, and which zones are tried next where Newton's method or Coulomb's law fails."""

from dataclasses import replace

import numpy as np
import pytest

from semianalytic import Material, Scene, Tractions
from semianalytic.cut.load import Load, Opened, common_load, scaled_load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.selfsimilar.zones.corrections import corrected, rearranged
from semianalytic.selfsimilar.zones.coulomb import Violation

FACTORS = rayleigh_factors(1 / 3)
LOAD = Load(0.3, 1.0, 0.0, 0.0, 1.0, 0.0)


def at(v):
    return FACTORS.cut([v])


def ends(zones):
    """Slownesses of the edges of zones, None where they are open, and their senses."""
    return [(*(edge and edge.v[0] for edge in (one.left, one.right)), one.sense) for one in zones]


def wrong(zone, left, right, touches=(False, False), sense=1):
    return Violation(zone, sense, at(left), right and at(right), *touches)


@pytest.mark.parametrize(
    ("violation", "expected"),
    [
        (wrong(0, 2.2, 2.4), [(2.0, 2.2, 1), (2.4, 3.0, 1)]),
        (wrong(0, 2.0, 2.4, (True, False)), [(2.4, 3.0, 1)]),
        (wrong(0, 2.6, 3.0, (False, True)), [(2.0, 2.6, 1)]),
        (wrong(0, 2.6, 3.0), [(2.0, 2.6, 1)]),  # between the last node and the end
        (wrong(0, 2.0, 2.4), [(2.4, 3.0, 1)]),
        (wrong(-1, 1.8, 2.0, (False, True)), [(1.8, 3.0, 1)]),
        (wrong(-1, 3.0, 3.5, (True, False)), [(2.0, 3.5, 1)]),
        (wrong(-1, 1.2, 1.5), [(1.2, 1.5, 1), (2.0, 3.0, 1)]),
        (wrong(-1, 3.5, None, sense=-1), [(2.0, 3.0, 1), (3.5, None, -1)]),
        (wrong(-1, 1.8, 2.0, (False, True), -1), [(1.8, 2.0, -1), (2.0, 3.0, 1)]),
    ],
)
def test_zones_are_cut_widened_or_joined_by_new_ones(violation, expected):
    assert ends(corrected([Zone(at(2.0), at(3.0), 1)], [violation], LOAD)) == expected


def test_new_zones_wait_until_the_present_ones_are_sound():
    violations = [wrong(-1, 1.2, 1.5), wrong(0, 2.2, 2.4)]
    zones = corrected([Zone(at(2.0), at(3.0), 1)], violations, LOAD)
    assert ends(zones) == [(2.0, 2.2, 1), (2.4, 3.0, 1)]


@pytest.mark.parametrize(("sense", "left"), [(1, None), (-1, 1.2)])
def test_under_a_critical_base_the_first_zone_starts_at_the_front(sense, left):
    critical = replace(LOAD, base_shear=0.3)
    assert ends(corrected([], [wrong(-1, 1.2, 1.5, sense=sense)], critical)) == [(left, 1.5, sense)]


def test_what_newtons_method_fails_on_is_rearranged():
    front, far = Zone(at(0.8), at(1 + 1e-6), 1), Zone(at(4.0), None, 1)
    (crossed, _) = rearranged(FACTORS, [front, far], LOAD)
    assert crossed.right.v[0] < 1  # an edge just behind the shear front starts ahead of it
    narrow = Zone(at(2.0), at(2.0 * (1 + 1e-5)), 1)
    assert ends(rearranged(FACTORS, [narrow, far], LOAD)) == [(4.0, None, 1)]
    assert rearranged(FACTORS, [narrow], LOAD) == []
    near = Zone(at(2.0), at(3.8), 1)
    assert ends(rearranged(FACTORS, [near, far], LOAD)) == [(2.0, None, 1)]
    assert rearranged(FACTORS, [near, replace(far, sense=-1)], LOAD) is None


def test_what_slips_behind_an_opening_is_joined_to_it_once_it_vanishes():
    opening = Zone(at(0.6), at(2.0), 1)
    known = np.array([[0.6, 2.0], [0.0, 0.0]])
    load = replace(LOAD, opened=Opened(opening, (), 1.0, 1.0, lambda at: at.v, known))
    held = Zone(at(0.55), opening.right, 1, held=True)
    vanished = Zone(at(2.5), at(2.5 * (1 + 1e-5)), -1)
    (joined,) = rearranged(FACTORS, [held, vanished], load)
    assert (joined.right, joined.last_sense, joined.held) == (vanished.left, -1, False)
    # slip ahead of the opening turns once
    (turned,) = rearranged(FACTORS, [replace(held, left=at(0.599))], load)
    assert (turned.sense, turned.last_sense) == (-1, 1)
    assert rearranged(FACTORS, [replace(held, left=at(0.599))], load, may_turn=False) is None


def test_out_of_the_plane_too_edges_cross_the_shear_front():
    factors = rayleigh_factors(1 / 3, "III")
    ahead = Zone(factors.cut([1 - 1e-6]), None, 1)
    (crossed,) = rearranged(factors, [ahead], LOAD)
    assert crossed.left.v[0] == pytest.approx(1.1)


def test_a_narrow_gap_around_the_rayleigh_front_is_joined_where_slip_meets_resistance():
    c = FACTORS.c
    outer, inner = Zone(at(0.8), at(c - 1e-3), 1), Zone(at(c + 1e-3), None, 1)
    assert rearranged(FACTORS, [outer, inner], LOAD) is None
    assert ends(rearranged(FACTORS, [outer, inner], replace(LOAD, resistance=0.1))) == [
        (0.8, None, 1)
    ]


def test_loads_are_in_units_of_the_largest_traction():
    material = Material(3.0, 0.7, 0.25)
    scene = Scene(material, 0.4, Tractions(20.0, 3.0), Tractions(5.0, 10.0))
    load, unit = scaled_load(scene)
    assert unit == 10.0
    assert load == Load(0.4, 2.0, 0.3, 0.5, 1.0, 0.0)
    shock = replace(scene, base=Tractions(0.0, 0.0), load=Tractions(20.0, 3.0), load_on="remote")
    shocked = [replace(shock, friction=f) for f in (0.1, 0.2)]
    both = common_load(shocked, 2.0)
    np.testing.assert_array_equal(both.friction, [[0.1], [0.2]])
    # V(inf) is what the shock exceeds friction by
    np.testing.assert_allclose(both.far_slip_rate, [[0.5], [0.0]], atol=1e-15)
    assert both.base_pressure == 10.0


def test_loads_know_whether_friction_counts_and_is_reached():
    assert replace(LOAD, friction=0.0).frictionless
    assert replace(LOAD, friction=1e-16).frictionless
    assert not replace(LOAD, friction=1e-14).frictionless
    assert replace(LOAD, base_shear=-0.3).critical
    assert not replace(LOAD, base_shear=0.299).critical
    assert replace(LOAD, load_shear=0.0).rests
    assert not LOAD.rests
