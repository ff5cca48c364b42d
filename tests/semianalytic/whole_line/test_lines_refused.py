"""Lines without a slot that are refused, and what tells that an answer is spoilt."""

import numpy as np
import pytest

from semianalytic import (
    Patch,
    PointForce,
    SceneError,
    Tractions,
    WholeLine,
    march,
    solve,
    solve_line,
)
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.whole_line.spreading import Spreading, least_missing
from tests.semianalytic.whole_line.test_lines import BASE, SOLID, patch_line


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"load": Tractions(0.0, 1.0)}, "tractions on the faces of a slot belong to a Scene"),
        ({"load": Patch(0.3, shear=0.5)}, "nothing slips"),
        ({"load": Patch(0.3, shear=0.2)}, "nothing slips"),
        ({"load": Patch(0.95, shear=1.0)}, "slower than the Rayleigh wave, 0.932526"),
        ({"load": Patch(30.0, shear=1.0)}, "slower than the Rayleigh wave"),
        ({"friction": -0.1}, "friction must not be negative"),
        ({"base": Tractions(-1.0, 0.0)}, "strength is negative"),
        ({"base": Tractions(1.0, 0.6)}, "would slide as a whole"),
        ({"friction": 0.0}, "would slide as a whole"),
        ({"load": Patch(0.3, -2.0, 1.0)}, "opens the interface"),
        ({"load": PointForce(1.0, 1.0)}, "set its pressure or its shear to 0"),
        ({"load": PointForce(1.0, 0.0)}, "moves nothing"),
        ({"mode": "mode II"}, "mode must be"),
        ({"units": "cgs"}, "units must be"),
        ({"material": 1.0}, "material must be a Material"),
        ({"friction": 0.1}, "a second zone of slip starts at the shear wave"),
        ({"friction": 1e-4}, "no edge slower than the Rayleigh wave"),
    ],
)
def test_a_line_that_cannot_be_is_refused_in_a_sentence(change, said):
    parts = {"material": SOLID, "friction": 0.5, "base": BASE, "load": Patch(0.3, shear=1.0)}
    with pytest.raises(SceneError, match=said) as refusal:
        solve_line(WholeLine(**{**parts, **change}))
    assert refusal.value.exit_code == 2
    assert str(refusal.value).endswith(".")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("speed", [0.0, -1.0, np.inf, np.nan, 1e99])
def test_a_speed_beyond_all_sense_is_refused(speed):
    with pytest.raises(SceneError, match="patch: speed must"):
        Patch(speed, shear=1.0)


def test_the_threshold_that_a_refusal_names_is_right():
    least = least_missing(rayleigh_factors(1 / 3), 0.3)
    solve_line(patch_line("II", 0.3, least * 1.001))
    with pytest.raises(SceneError, match=f"more than {least:.4g}"):
        solve_line(patch_line("II", 0.3, least * 0.999))
    # at it, shear at the shear wave is strength
    found = solve_line(patch_line("II", 0.3, least * (1 + 1e-9)))
    assert found.excess_at_shear_wave == pytest.approx(least, rel=1e-6)


def test_x_and_t_must_be_finite():
    found = solve_line(patch_line("II", 0.3, 0.5))
    with pytest.raises(SceneError, match="finite"):
        found.slip(np.nan, 1.0)
    with pytest.raises(SceneError, match="finite"):
        found.pressure(1.0, np.inf)
    with pytest.raises(SceneError, match="zones_at: t"):
        found.zones_at(np.nan)


def test_solve_and_march_name_what_takes_a_line():
    line = patch_line("II", 0.3, 0.5)
    for function in (solve, march):
        with pytest.raises(SceneError, match="scene must be a Scene"):
            function(line, 1.0) if function is march else function(line)
    with pytest.raises(SceneError, match="must be a WholeLine"):
        solve_line(SOLID)


def test_a_spoilt_edge_shows_in_the_second_evaluation():
    """The error estimate is worth its name: it sees an edge that is 1e-6 off."""
    good = solve_line(patch_line("II", 0.3, 0.5)).spreading
    off = Spreading(good.factors, 0.3, good.edge * (1 + 1e-6), good.lead - good.edge * 1e-6)
    assert abs(off.missing_again - 0.5) > 1e-8
