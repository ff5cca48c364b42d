"""Ends of contacts that a grid cannot place: nodes that fit them, and what is said of others."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semianalytic as sf
from semianalytic.interface.contact import Contact

STRIP = Contact([(-2.0, 2.0)])
END = 1.5


def punch():
    solid = sf.Material(1.0, 1.0, 0.3)
    shape = {"contact": STRIP, "pressure": 1.0, "even": True, "loads": [sf.InterfaceLoad(0.2)]}
    return sf.Interface(solid, sf.Coulomb(0.4), 20.0, **shape)


def off(one, truth):
    """Relative L1 error of slip on the contact at the end."""
    inside = np.abs(one.x) < 2
    exact = np.interp(one.x[inside], truth.x, truth.slip[-1])
    return np.abs(one.slip[-1][inside] - exact).sum() / np.abs(exact).sum()


@pytest.fixture(scope="module")
def truth():
    return sf.run(punch(), END, 2560, times=[END], estimate=False)


def test_a_grid_knows_ends_between_its_nodes():
    assert STRIP.misfit(40.0, 500) == 0
    assert STRIP.misfit(40.0, 512) == pytest.approx(0.4)
    assert STRIP.misfit(40.0, 250) == pytest.approx(0.5)
    assert Contact().misfit(40.0, 513) == Contact.half_line().misfit(40.0, 513) == 0
    # an end beyond the period is none
    assert Contact([(-2.0, 70.0)]).misfit(40.0, 500) == 0


def test_nodes_that_fit_are_the_fewest():
    assert STRIP.fitting_nodes(40.0, 512, 0) == 520
    assert STRIP.fitting_nodes(40.0, 512, 2) == 560
    assert STRIP.fitting_nodes(40.0, 512, 4) == 640
    assert Contact().fitting_nodes(1.0, 512, 4) == 512
    # no common fraction: the fewest are as good as any
    assert Contact([(-1.0, 2**0.5)]).fitting_nodes(7.3, 512, 4) == 512


@settings(deadline=None, max_examples=80)
@given(st.floats(-9.9, 9), st.floats(0.3, 15), st.integers(16, 300))
def test_half_the_nodes_see_displaced_ends_elsewhere(begin, width, quarter):
    length, nodes = 20.0, 4 * quarter
    contact = Contact([(begin, begin + width)])
    fine, coarse = (length * (np.arange(n) - n // 2 + 0.5) / n for n in (nodes, nodes // 2))
    inside = np.flatnonzero(contact.touches(fine))
    found = np.flatnonzero(contact.shortened(length, nodes).touches(coarse))
    if contact.misfit(length, nodes) == 0 or len(inside) < 6:
        return
    for end, first, sign in zip(contact.intervals[0], (0, -1), (-1, 1), strict=True):
        # ends of the cells of the outermost nodes: where the two grids have the end
        has = fine[inside[first]] + sign * length / nodes / 2
        other = coarse[found[first]] + sign * length / nodes
        if abs(end) < length / 2 and abs(has - end) > 1e-3 * length / nodes:
            assert abs(other - has) >= 2 * abs(has - end) * (1 - 1e-6)


def test_by_default_ends_fit(truth):
    done = sf.run(punch(), END, times=[END])
    assert done.contact_misfit == 0
    assert done.caution == ""
    assert off(done, truth) < 2e-3
    assert off(done, truth) < done.error_estimates["slip"] < 3e-2


def test_displaced_ends_are_told_and_estimated(truth):
    # the end lies at 25.6 node distances of the first grid, and half the nodes have it at the same
    # wrong place; it fits the second grid, and lies at 51.2 of the third
    for nodes in (256, 260, 512):
        done = sf.run(punch(), END, nodes, times=[END])
        error = off(done, truth)
        if nodes == 260:
            assert done.caution == ""
            assert error < 5e-3
        else:
            assert "node distances from where the grid has it; choose" in done.caution
            assert 1e-2 < error < done.error_estimates["slip"]
    assert "choose 520 nodes" in done.caution
    odd = replace(punch(), length=7.3, even=False, contact=Contact([(-1, 2**0.5)]))
    assert "choose a period" in sf.run(odd, 0.1, 64, estimate=False).caution


def test_a_contact_of_few_nodes_is_unresolved_and_gets_enough_by_default():
    """Two grids that share no node of the contact have nothing to compare."""
    push = sf.InterfaceLoad(0.5, on="slot")
    material, law = sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.05)
    face = sf.Interface(material, law, 16.0, loads=[push], contact=sf.Contact([(-0.11, 0.11)]))
    words = r"unresolved: a contact or slot of width 0\.22 has 2\.2 nodes; use 584 nodes or more"
    assert re.match(words, sf.run(face, 0.2, 160).status)
    assert sf.run(face, 0.2, estimate=False).nodes >= 584
    with pytest.raises(sf.SceneError, match="no node lies on the contact; use 584 nodes or more"):
        sf.run(face, 0.2, 144)
    slot = sf.Interface(
        material, law, 16.0, loads=[push], contact=sf.Contact([(-6, -0.05), (0.05, 6)])
    )
    assert "has 0.8 nodes" in sf.run(slot, 0.2, 128, estimate=False).status


def test_nothing_is_known_beyond_the_period():
    done = sf.run(sf.Interface(sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.3), 16.0), 0.1, 16)
    assert np.isnan(done.at(done.slip, [-8.1, 0.0, 100.0])).tolist()[-1] == [True, False, True]
