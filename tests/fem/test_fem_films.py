"""A viscous film that opens, against the exact answer."""

import numpy as np
import pytest

from fem import simulate
from semianalytic import Material, Scene, Tractions, ViscousFriction, solve

SOLID, FILM = Material(1.0, 1.0, 1 / 3), ViscousFriction(0.25)
LIFTED = Scene(SOLID, 0.3, Tractions(1.0, 0.0), Tractions(-1.0, 1.0), friction_law=FILM)
TAPPED = Scene(SOLID, 0.3, Tractions(0.02, 0.0), Tractions(1.0, 0.5), friction_law=FILM)


@pytest.mark.parametrize("scene", [LIFTED, TAPPED])
def test_slip_beside_an_opening(scene):
    """At the border slip rate is infinite, or nothing, where traction would jump."""
    run, exact = simulate(scene, resolution=40), solve(scene, rtol=1e-6)
    x = run.interface.x[run.interface.x > 0]
    slip = run.interface.slip[-1][run.interface.x > 0]
    expected = exact.slip(x, run.end_time)
    assert np.abs(slip - expected).sum() < 0.01 * np.abs(expected).sum()
