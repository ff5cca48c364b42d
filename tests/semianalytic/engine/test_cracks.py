"""Cracks of prescribed speed: Kostrov's on a whole line, Freund's beside a slot."""

import math

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.engine import freund_slip, kostrov_slip
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.memory.impedance import Antiplane, InPlane

THIRD = sf.Material(1.0, 1.0, 1 / 3)
SPEED = 0.5
FRONT = sf.ForcedFront(static=100.0, dynamic=0.0, arrival=lambda x: np.abs(x) / SPEED)


def test_references_have_the_digits_and_the_intensity_of_others():
    """Kostrov's amplitudes are those of the notes; Freund's K_III is sqrt(1 - v/c_t) K(0)."""
    for impedance, known in ((InPlane(0.5), 0.5882685), (Antiplane(), 0.8257256)):
        slip = kostrov_slip(np.array([0.0]), SPEED, impedance)[0]
        assert slip / (2 * SPEED) == pytest.approx(known, abs=1e-7)
    for speed in (0.2, 0.5, 0.8):
        x = speed * (1 - np.array([1e-6]))
        slip = freund_slip(x, speed, rayleigh_factors(1 / 3, "III"), "III")[0]
        # slip behind a tip is 4 K / (mu sqrt(1 - v^2)) sqrt(d / 2 pi), K(0) = 2 sqrt(2 c_t t / pi)
        near = math.sqrt((speed - x[0]) / (2 * math.pi)) * 4 / math.sqrt(1 - speed**2)
        assert slip / near == pytest.approx(2 * math.sqrt(2 / math.pi * (1 - speed)), rel=2e-3)


@pytest.mark.parametrize(("mode", "off"), [("in-plane", 0.0055), ("antiplane", 0.004)])
def test_a_forced_front_is_kostrovs_crack(mode, off):
    impedance = InPlane(0.5) if mode == "in-plane" else Antiplane()
    line = sf.Interface(THIRD, FRONT, 5.0, shear=1.0, mode=mode, even=True)
    done = sf.run(line, 1.0, 1024, times=[1.0], estimate=False)
    known = kostrov_slip(done.x, SPEED, impedance)
    assert np.abs(done.slip[0] - known).sum() < off * known.sum()
    slower = kostrov_slip(done.x, 0.48, impedance)
    assert np.abs(done.slip[0] - slower).sum() > 5 * off * known.sum()


def test_a_forced_front_beside_a_slot_is_freunds_crack():
    loads, beside = [sf.InterfaceLoad(1.0, on="slot")], sf.Contact.half_line()
    line = sf.Interface(
        THIRD, FRONT, 10.0, shear=1.0, loads=loads, contact=beside, mode="antiplane"
    )
    done = sf.run(line, 1.0, 1024, times=[1.0], estimate=False)
    near = (done.x > 0) & (done.x < SPEED)
    known = freund_slip(done.x[near], SPEED, rayleigh_factors(1 / 3, "III"), "III")
    assert np.abs(done.slip[0][near] - known).sum() < 0.006 * known.sum()


def test_a_forced_front_may_let_strength_fall_slowly():
    """Slip begins before strength has fallen to the end, not before the front can be felt."""
    law = sf.ForcedFront(0.6, 0.2, arrival=lambda x: np.abs(x), fall=0.5)
    fault = sf.Interface(THIRD, law, 8.0, shear=0.4, even=True, mode="antiplane")
    done, h = sf.run(fault, 2.0, 64, estimate=False), 8.0 / 64
    at = done.x < 1.5
    assert (done.onset[at] <= done.x[at] + 0.5).all()
    assert (done.onset[at] >= done.x[at] - 2 * h).all()
