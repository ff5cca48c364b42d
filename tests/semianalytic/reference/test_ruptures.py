"""Rate-and-state sliding and ruptures against digits computed elsewhere, and waves marched."""

import math

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.engine import marched_growth
from semianalytic.memory.impedance import Antiplane, InPlane
from semianalytic.reference.ruptures import critical_wavenumber, growth

MODES = {"II": InPlane(1 / math.sqrt(3)), "III": Antiplane()}


@pytest.mark.parametrize(
    ("mode", "ratio", "inertia", "known"),
    [
        ("III", 1.1, 0.01, 0.1000499875),
        ("III", 1.4, 1.0, 0.7483314774),
        ("III", 2.0, 10.0, 10.0498756211),
        ("II", 1.1, 0.1, 0.0805978331),
        ("II", 1.4, 10.0, 6.9146425541),
        ("II", 2.0, 3.0, 3.3727587908),
    ],
)
def test_critical_wavenumber(mode, ratio, inertia, known):
    found = critical_wavenumber(ratio, inertia, MODES[mode])
    assert found == pytest.approx(known, abs=1e-10)
    # longer waves grow, shorter ones decay
    assert growth(ratio, inertia, 0.9 * found, MODES[mode]).real > 0
    assert growth(ratio, inertia, 1.1 * found, MODES[mode]).real < 0


def test_antiplane_closed_form():
    for ratio in (1.05, 1.4, 3.0):
        for inertia in (0.02, 1.0, 30.0):
            known = math.sqrt((ratio - 1) ** 2 + (ratio - 1) * inertia**2)
            assert critical_wavenumber(ratio, inertia, Antiplane()) == pytest.approx(known)


def test_growth_of_known_waves():
    found = growth(1.4, 0.3, 0.5 * critical_wavenumber(1.4, 0.3, MODES["II"]), MODES["II"])
    assert found == pytest.approx(0.0703074033 + 0.397668486315j, rel=1e-9)
    found = growth(1.1, 0.01, 0.0300149962519, MODES["III"])
    assert found == pytest.approx(0.034955079211 + 0.169527868864j, rel=1e-9)


@pytest.mark.parametrize("mode", ["II", "III"])
def test_a_marched_wave_grows_as_it_must(mode):
    kappa = 0.5 * critical_wavenumber(1.4, 0.3, MODES[mode])
    known = growth(1.4, 0.3, kappa, MODES[mode])
    assert abs(marched_growth(mode, 1.4, 0.3, kappa, 0.1) - known) < 1e-3 * abs(known)


def test_critical_wavelength_in_units():
    rock = sf.Material(32e9, 2670.0, 0.25)
    slow = sf.critical_wavelength(rock, 0.008, 0.012, 120e6, 0.02)
    # pi mu* L / ((b - a) sigma) (Rice & Ruina 1983)
    assert slow == pytest.approx(math.pi * 32e9 / 0.75 * 0.02 / (0.004 * 120e6))
    # inertia takes short waves their growth
    assert sf.critical_wavelength(rock, 0.008, 0.012, 120e6, 0.02, rate=1.0) < slow
    with pytest.raises(sf.SceneError, match="b must be above a"):
        sf.critical_wavelength(rock, 0.012, 0.008, 120e6, 0.02)


@pytest.mark.parametrize(
    ("nu", "known"), [(0.1, 1.2791911), (0.25, 1.7746479), (0.35, 2.1988733), (0.4, 2.4408742)]
)
def test_supershear_strength(nu, known):
    assert sf.supershear_strength(nu) == pytest.approx(known, rel=1e-7)


def test_supershear_strength_of_slower_cracks():
    assert sf.supershear_strength(0.25, 0.8) == pytest.approx(0.4515233, rel=1e-6)
    assert sf.supershear_strength(0.25, 0.99) == pytest.approx(1.5998262, rel=1e-6)


@pytest.mark.slow
def test_tpv101_on_a_coarse_grid():
    """Slip at 14.95 s against a march of 5,760 nodes made independently for this project."""
    found = sf.find_interface("tpv101")
    time = 148 * 20 * 0.35 * 50 / found.interface.material.shear_speed
    done = sf.run(found.interface, time, 480, step_ratio=0.35, times=[time], estimate=False)
    known = {0: 16.717576, 6000: 13.566330, 12000: 11.314320, 15000: 9.790005}
    for at, slip in known.items():
        here = float(np.interp(at, done.x, done.slip[0]))
        assert here == pytest.approx(slip, rel=2e-3)
