"""Weertman's pulse: its impedance, its direction, and that it is a state of friction."""

import numpy as np
import pytest
from dissimilar_pairs import GOUGE_ON_ROCK, ROCK

from semianalytic import Material, SceneError
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.reference import weertman_pulse

FASTER = Material(1.44, 1.0, 0.25)


def test_slip_rate_per_relief_of_pressure():
    pulse = weertman_pulse(ROCK, FASTER, 0.5, 1.0, 0.3)
    assert pulse.velocity == pytest.approx(0.98483953, abs=1e-8)
    assert pulse.pressure == pytest.approx(0.6, rel=1e-14)  # friction holds inside
    assert (1 - pulse.pressure) / pulse.slip_rate == pytest.approx(0.423570, abs=6e-7)


def test_it_runs_the_way_in_which_the_slower_body_slides():
    for upper, lower, shear, direction in (
        (ROCK, FASTER, 0.3, 1),
        (ROCK, FASTER, -0.3, -1),
        (FASTER, ROCK, 0.3, -1),
    ):
        pulse = weertman_pulse(upper, lower, 0.5, 1.0, shear)
        assert np.sign(pulse.velocity) == direction
        assert np.sign(pulse.slip_rate) == np.sign(shear)


def test_it_solves_the_equations_of_the_interface():
    """A steady wave of slowness k = -1/v in the relative slip alone: sigma = -(k D / Delta) V."""
    pulse = weertman_pulse(ROCK, FASTER, 0.5, 1.0, 0.3)
    entries = compliance_of(ROCK, FASTER).on_cut(np.array([1 / pulse.velocity]))
    shear, normal = -entries.inverse[0, :, 0] * pulse.slip_rate
    assert abs(shear) < 1e-12
    assert normal == pytest.approx(1 - pulse.pressure, rel=1e-9)


def test_si_units():
    upper, lower = Material(1e10, 2500.0, 0.25), Material(1.44e10, 2500.0, 0.25)
    pulse = weertman_pulse(upper, lower, 0.5, 1e7, 3e6)
    assert pulse.velocity == pytest.approx(0.98483953 * 2000, rel=1e-8)
    assert pulse.slip_rate == pytest.approx(0.4 / 0.42357021 * 1e7 / 5e6, rel=1e-7)


@pytest.mark.parametrize(
    ("pair", "shear", "complaint"),
    [
        (GOUGE_ON_ROCK, 0.3, "generalised Rayleigh"),
        ((ROCK, ROCK), 0.3, "different bodies"),
        ((ROCK, FASTER), 0.0, "below friction"),
        ((ROCK, FASTER), 0.5, "below friction"),
    ],
)
def test_what_has_no_pulse_is_refused(pair, shear, complaint):
    with pytest.raises(SceneError, match=complaint):
        weertman_pulse(*pair, 0.5, 1.0, shear)
