"""The residue of dV/dv at the Rayleigh front: known there, and as nodes on either side show it."""

from dataclasses import replace

import numpy as np
import pytest

from semianalytic import Material, Scene, Tractions, ViscousFriction, solve
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import rule_for
from semianalytic.regimes import opening_threshold

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
