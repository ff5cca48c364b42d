"""Slip rate at c_R in all modes: the residues known in closed form are those that nodes show."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import under, unit_scene

from semianalytic import Coulomb, solve
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import rule_for
from semianalytic.regimes import opening_threshold

OPEN = unit_scene(0.45, (0.0033, 0.0004), (1.0, 0.05), nu=0.2)
"""The contact opens around c, with slip ahead."""
CASES = {
    "slip from ahead of the shear front": unit_scene(1.08, (0.067, -0.016), (1.0, -0.9), nu=0.1),
    "no friction": unit_scene(0.0, nu=0.25),
    "opening": OPEN,
    "opening behind the shear front": unit_scene(
        0.3, (0.8 * opening_threshold(0.1), 0.0), (1.0, 0.4), nu=0.1
    ),
    "opening within a film": under(OPEN, Coulomb(1.0, viscosity=0.04)),
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
