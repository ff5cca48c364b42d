"""Panels between zone edges, and their rules: ends, layout, integrals against quad and Si."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import sici

from semianalytic.cut.quadrature import panels as panels_module
from semianalytic.cut.quadrature.laying import lay_panels
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for

RULE = rule_for(1e-11)


def two_zones(nu, gap=0.01):
    """Slip around the shear front, a stick gap around c, slip up to the contact edge."""
    factors = rayleigh_factors(nu)
    front = factors.beside("b", [-0.3 * (1 - factors.a)])
    healed, opened = factors.beside("c", [-gap]), factors.beside("c", [gap])
    return factors, (Zone(front, healed, 1), Zone(opened, None, 1))


@pytest.mark.parametrize("nu", [-0.5, 0.2, 1 / 3, 0.45])
def test_panels_lie_end_to_end_from_the_longitudinal_front(nu):
    factors, zones = two_zones(nu)
    panels = lay_panels(factors, zones, RULE)
    assert panels.left[0] is factors.front_a
    assert panels.right[-1] is None
    assert panels.right[:-1] == panels.left[1:]
    slipping = [bool(sense) for sense in panels.sense]
    assert slipping == [False] * slipping.index(True) + [True, True, False, True]
    # each distance is exact at its own end; they add up to the panel
    widths = panels.widths[:, 0]
    for i, width in enumerate(widths):
        assert panels.from_left[i] + panels.from_right[i] == pytest.approx(width, rel=1e-14)
    inverse_square = panels.integrals(1 / np.square(panels.at.v)).sum()
    assert inverse_square == pytest.approx(1 / factors.a, rel=1e-10)


@pytest.mark.parametrize("gap", [1e-9, 0.01, 0.2])
def test_points_that_stand_for_many_nodes_leave_cauchy_integrals_as_they_are(monkeypatch, gap):
    """Sums over all nodes are the reference, relative to the sums of the moduli of their terms."""
    factors, zones = two_zones(0.25, gap)
    panels = lay_panels(factors, zones, RULE)
    pairs = panels.layout.pairs_from(np.arange(len(panels.left)))
    # falls like (v - left)^(1/2) at the left end, and like v^(-1/2) on the unbounded panel
    density = panels.jacobian * np.sqrt(panels.rule.share) / panels.at.v**1.5
    few = panels.cauchy(pairs, density[pairs.source])
    monkeypatch.setattr(panels_module, "MANY_NODES", np.inf)
    every = panels.cauchy(pairs, density[pairs.source])
    core = panels.rule.core
    assert few[:, core] == pytest.approx(every[:, core], rel=2e-12, abs=0)
    assert np.abs(few / every - 1)[:, core].max() > 0  # they are not the same sums
    # far in on the unbounded panel integrals fall like 1 / v, and keep their digits
    far = panels.at.v[-1] > 1e6
    to_last = pairs.target == len(panels.left) - 1
    assert few[to_last][:, far] == pytest.approx(every[to_last][:, far], rel=1e-13, abs=0)


@settings(max_examples=30, deadline=None)
@given(
    nu=st.floats(-0.8, 0.45),
    gap=st.floats(-9.0, -1.5).map(lambda power: 10.0**power),
    source=st.sampled_from(["a stick panel ahead", "the gap"]),
)
def test_cauchy_integrals_between_panels(nu, gap, source):
    factors, zones = two_zones(nu, gap)
    panels = lay_panels(factors, zones, RULE)
    chosen = 0 if source != "the gap" else panels.layout.over_c
    width = float(panels.widths[chosen, 0])
    share = panels.from_left[chosen] / width
    weights = panels.jacobian[chosen] * share * (1 - share)
    pairs = panels.layout.pairs_from(np.array([chosen]))
    found = panels.cauchy(pairs, np.array([weights] * len(pairs.source)))
    for row, target in zip(found, pairs.target, strict=True):
        for node in range(len(row) // 5, len(row), len(row) // 4):
            # in units of the panel, from its left end
            to = float(panels.from_ends[chosen, target, node]) / width
            if min(abs(to), abs(to - 1)) < 1e-3 or abs(to) > 1e3:
                continue
            exact, _ = quad(lambda s, to=to: s * (1 - s) / (s - to), 0, 1, epsabs=1e-13)
            assert row[node] == pytest.approx(exact, rel=1e-8, abs=1e-12), target


def test_far_nodes_are_left_to_the_panels_around_a_narrow_gap():
    """What is skipped on the others is below the accuracy of the rule."""
    factors, zones = two_zones(0.2, 1e-12)
    panels = lay_panels(factors, zones, RULE)
    assert panels.rule.further > 20
    weights = panels.jacobian[0] * (1 - panels.from_left[0] / panels.widths[0])
    pairs = panels.layout.pairs_from(np.array([0]))
    rows = np.array([weights] * len(pairs.source))
    found = panels.cauchy(pairs, rows)
    own = panels.from_right[0]
    for row, target in zip(found, pairs.target, strict=True):
        other = panels.from_ends[1, target]
        exact = -panels.rule.spacing * (weights / (own + other[:, None])).sum(axis=1)
        kept = panels.jacobian[target] * np.abs(row - exact)
        assert kept.max() < 1e-11 * np.abs(panels.jacobian[target] * exact).max()


def test_principal_values_inside_a_panel():
    factors, zones = two_zones(1 / 3)
    panels = lay_panels(factors, zones, RULE)
    share = panels.from_left[0] / panels.widths[0]
    weights = panels.jacobian[0] * share * (1 - share)
    found = panels.principal_values(np.array([0]), weights[None])[0]
    middle = np.flatnonzero(np.abs(share - 0.5) < 0.3)
    for node in middle:
        # PV of s (1 - s) / (s - t): the polynomial part and the logarithm
        t = share[node]
        exact = (0.5 - t) + t * (1 - t) * np.log((1 - t) / t)
        assert found[node] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-11])
def test_integrals_up_to_many_points_are_sums_of_si(tolerance):
    """They come from a table between nodes; points beyond the nodes, and at infinity, do not."""
    rule, rng = rule_for(tolerance), np.random.default_rng(4)
    density = rng.normal(size=(2, len(rule.y))) * np.exp(-np.abs(rule.y) / 2)
    y = np.concatenate([rng.uniform(-1.5, 1.5, 80) * rule.reach, rule.y[:3], [-np.inf, np.inf]])
    nodes, values = rule._continued(density)
    weights = np.full(len(nodes), rule.spacing)
    weights[[0, -1]] = rule.weights[[0, -1]]
    steps = 0.5 + sici(np.pi * (y[:, None] - nodes) / rule.spacing)[0] / np.pi
    found = rule.interpolate_running(y, density)
    np.testing.assert_allclose(found, steps @ (weights * values).T, rtol=0, atol=1e-14)
    # from node to node, of a density in the middle, whose interpolant is one sinc
    k = np.arange(len(rule.y)) - len(rule.y) // 2
    expected = rule.spacing * (0.5 + sici(np.pi * k)[0] / np.pi)
    np.testing.assert_allclose(rule.running(1.0 * (k == 0)), expected, rtol=0, atol=4e-15)


@pytest.mark.parametrize("halvings", [1, 4])
def test_points_beside_an_end_hold_what_is_smooth_there(halvings):
    """1 / (share + d) has its pole as far from the piece as the piece is long."""
    rule, d = rule_for(1e-11), 2.0**-halvings
    few = rule.beside_end(halvings)
    share = rule.share[: few.count]
    assert share[-1] < d <= rule.share[few.count]
    np.testing.assert_allclose(few.onto @ (1 / (few.share + d)), 1 / (share + d), rtol=5e-15)
    # The mirror image falls like the share that is left of it.
    falling, exact = few.onto_falling @ (few.share / (few.share + d)), share / (share + d)
    np.testing.assert_allclose(falling[::-1], exact, rtol=5e-15)
