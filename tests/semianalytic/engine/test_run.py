"""Runs against exact answers, cracks of prescribed speed among them, and their estimates."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.accuracy.engine import freund_slip, kostrov_slip
from docs.studies.lines import scene_along
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.memory.impedance import Antiplane, InPlane
from tests.semianalytic.engine.runs import one_run

UNIT = sf.Material(1.0, 1.0, 0.25)
COULOMB = sf.Coulomb(0.5)
THIRD = sf.Material(1.0, 1.0, 1 / 3)
SPEED = 0.5
FRONT = sf.ForcedFront(static=100.0, dynamic=0.0, arrival=lambda x: np.abs(x) / SPEED)


@pytest.mark.parametrize(
    "contact", [sf.Contact(), sf.Contact([(-1.5, 1.5)])], ids=["line", "strip"]
)
@pytest.mark.parametrize("opens", [False, True])
def test_even_and_whole_lines_agree(contact, opens):
    pull = {"pressure": lambda x: -2 * np.exp(-2 * x**2)} if opens else {}
    loads = [sf.InterfaceLoad(lambda x: np.exp(-(x**2)), sf.Pulse(0.5), **pull)]
    half, whole = (
        one_run(scene_along(UNIT, COULOMB, 8.0, 1.0, 0.1, loads, contact, even=even), 1.5, 64)
        for even in (True, False)
    )
    right = whole.interface.x >= 0
    count = right.sum()  # x = -length/2 is the last node of the even half
    for field in ("slip", "pressure", "gap"):
        first, other = (getattr(each.interface, field) for each in (half, whole))
        assert np.abs(first).max() > 0 or not opens
        assert np.abs(first[:, :count] - other[:, right]).max() < 1e-13
    assert half.work["friction"] == pytest.approx(whole.work["friction"], rel=1e-10)
    assert half.work["closing"] == pytest.approx(whole.work["closing"], rel=1e-10)
    assert (half.work["closing"] > 0) == opens


def test_the_estimate_covers_the_error_and_rtol_is_met():
    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)), history=sf.Ramp(1.0))
    fault = scene_along(UNIT, sf.SlipWeakening(0.6, 0.2, 1.0), 8.0, loads=[load], even=True)
    times = [0.5, 1.0, 2.0]
    best = one_run(fault, 2.0, 1024, times=times)
    done = sf.solve(fault, end_time=2.0, nodes=32, rtol=5e-3, times=times)
    assert done.nodes > 32
    assert done.error_estimates["slip"] <= 5e-3
    step = 1024 // done.nodes
    error = (
        np.abs(done.interface.slip - best.interface.slip[:, ::step]).sum()
        / np.abs(done.interface.slip).sum()
    )
    assert 0 < error < done.error_estimates["slip"]


def test_bars_of_readings_hold_however_much_of_the_line_is_at_rest():
    """Bars are of the place: neither the period nor quiet parts of it count."""
    law = sf.RateAndState(a=0.01, b=0.015, f0=0.6, v0=1e-6, distance=1e-5, theta=1e3)
    rock, load = sf.Material(30e9, 2700.0, 0.25), sf.InterfaceLoad(lambda x: 2e6 * (abs(x) < 0.5))
    end, x = 4e-4, np.linspace(0.05, 0.45, 9)
    bars = []
    for period, nodes in ((12.0, 256), (24.0, 512)):
        fault = scene_along(rock, law, period, 5e6, 2.5e6, [load], rate=1e-9)
        reading = sf.solve(fault, end_time=end, nodes=nodes).reading(x, end)
        bars.append(reading.slip.error)
    assert bars[0] == pytest.approx(bars[1], rel=1e-3)
    best = sf.solve(fault, end_time=end, nodes=2048, estimate=False)
    off = np.abs(reading.slip.value - best.slip(x, end))
    assert (off > 0).all()
    assert (off < bars[1]).all()
    assert (reading.arrivals["slip"].error < end).any()


def test_two_edges_against_the_exact_solver():
    """A slot -2 < x < 0 beside a contact, until the wave of the other edge arrives."""
    scene = sf.find("preloaded")
    exact = sf.solve(scene)
    fault = scene_along(
        scene.material,
        sf.Coulomb(0.3),
        16.0,
        loads=[sf.InterfaceLoad(1.0, on="slot")],
        contact=sf.Contact([(-math.inf, -2.0), (0.0, math.inf)]),
    )
    errors = []
    for nodes in (1024, 2048):
        done = one_run(fault, 1.0, nodes, times=[1.0])
        near = (done.interface.x > 0) & (done.interface.x < 3)
        rate = exact.slip_rate(done.interface.x[near], 1.0)
        errors.append(np.abs(done.interface.slip_rate[0][near] - rate).sum() / np.abs(rate).sum())
    assert errors[0] < 4e-3
    assert errors[1] < 1e-3


@pytest.mark.slow
def test_cattaneo_and_mindlin_in_the_slow_limit():
    """Stick |x| < c of a contact |x| < 1 under uniform pressure, on a periodic line of 8."""
    found = sf.find("cattaneo")
    done = one_run(found, 62.0, 256, step_ratio=0.5, times=[62.0])
    tan = lambda x: np.tan(np.pi * x / 8)  # noqa: E731
    edge = 8 / np.pi * np.arccos(np.cos(np.pi / 8) / np.cos(np.pi * 0.15 / 2))
    assert edge == pytest.approx(0.807586, abs=1e-6)
    inside = done.interface.x < edge
    root = (tan(1) ** 2 - tan(edge) ** 2) / (tan(edge) ** 2 - tan(done.interface.x[inside]) ** 2)
    exact = 2 / np.pi * np.arctan(np.sqrt(root))
    error = np.abs(done.interface.shear_traction[0][inside] - exact).sum() / exact.sum()
    assert error < 6e-3
    # the whole contact carries the load of the line
    force = done.interface.shear_traction[0][done.interface.touching].mean()
    assert force == pytest.approx(0.15 * 4, rel=2e-3)


def test_a_jump_of_strength_does_not_make_slip():
    """A barrier beside a slipping patch stays stuck, and its neighbour slips no faster."""
    strength = lambda x: np.where(np.abs(x) < 1, 0.5, 1e6)  # noqa: E731
    load = sf.InterfaceLoad(1.0)
    done = one_run(scene_along(UNIT, sf.Coulomb(strength), 8.0, loads=[load]), 1.0, 128)
    assert np.abs(done.interface.slip_rate[:, np.abs(done.interface.x) >= 1]).max() == 0
    # (load - strength) / (mu / 2 c_t) = 1, and what waves add; as if strength were linear: 1e5
    assert done.interface.slip_rate.max() < 1.1


def test_slow_grids_are_called_unresolved():
    fault = scene_along(UNIT, sf.SlipWeakening(0.6, 0.1, 0.01), 8.0, shear=0.3)
    done = one_run(fault, 0.1, 32)
    assert done.status.startswith("unresolved")
    least = int(done.status.split("use ")[1].split()[0])
    assert one_run(fault, 0.1, least).status == "done"


@pytest.mark.parametrize(("mode", "off"), [("in-plane", 0.0055), ("antiplane", 0.004)])
def test_a_forced_front_is_kostrovs_crack(mode, off):
    impedance = InPlane(0.5) if mode == "in-plane" else Antiplane()
    line = scene_along(THIRD, FRONT, 5.0, shear=1.0, mode=mode, even=True)
    done = one_run(line, 1.0, 1024, times=[1.0])
    known = kostrov_slip(done.interface.x, SPEED, impedance)
    assert np.abs(done.interface.slip[0] - known).sum() < off * known.sum()
    slower = kostrov_slip(done.interface.x, 0.48, impedance)
    assert np.abs(done.interface.slip[0] - slower).sum() > 5 * off * known.sum()


def test_a_forced_front_beside_a_slot_is_freunds_crack():
    loads, beside = [sf.InterfaceLoad(1.0, on="slot")], sf.Contact.half_line()
    line = scene_along(THIRD, FRONT, 10.0, shear=1.0, loads=loads, contact=beside, mode="antiplane")
    done = one_run(line, 1.0, 1024, times=[1.0])
    near = (done.interface.x > 0) & (done.interface.x < SPEED)
    known = freund_slip(done.interface.x[near], SPEED, rayleigh_factors(1 / 3, "III"), "III")
    assert np.abs(done.interface.slip[0][near] - known).sum() < 0.006 * known.sum()


def test_a_forced_front_may_let_strength_fall_slowly():
    """Slip begins before strength has fallen to the end, not before the front can be felt."""
    law = sf.ForcedFront(0.6, 0.2, arrival=lambda x: np.abs(x), fall=0.5)
    fault = scene_along(THIRD, law, 8.0, shear=0.4, even=True, mode="antiplane")
    done, h = one_run(fault, 2.0, 64), 8.0 / 64
    at = done.interface.x < 1.5
    assert (done.seen.onset[at] <= done.interface.x[at] + 0.5).all()
    assert (done.seen.onset[at] >= done.interface.x[at] - 2 * h).all()


@pytest.mark.parametrize("law", [sf.Coulomb(0.5), sf.SlipWeakening(0.6, 0.2, 0.05)])
def test_equal_steps_in_blocks_are_those_taken_one_by_one(law):
    """A law that does not say how strength rises with slip rate is stepped one by one."""

    class Unknown(type(law)):
        def steady_slope(self):
            return None

    kept = {field.name: getattr(law, field.name) for field in fields(law)}
    push = sf.InterfaceLoad(0.3, history=sf.Pulse(0.7), on="slot")
    patch = sf.InterfaceLoad(lambda x: 0.8 * (abs(x - 1) < 0.4), history=lambda t: min(t, 0.5))
    base = scene_along(
        sf.Material(1.0, 1.0, 0.25),
        law,
        8.0,
        contact=sf.Contact([(-2.0, 3.0)]),
        loads=[push, patch],
        plate_rate=1e-3,
    )
    answer, other = (
        sf.solve(each, end_time=1.1, nodes=256, estimate=False, every=3)
        for each in (base, replace(base, friction=Unknown(**kept)))
    )
    assert answer.steps == other.steps > 64
    for part in ("interface", "totals", "seen"):
        for name, found in vars(getattr(answer, part)).items():
            wanted = getattr(getattr(other, part), name)
            if name not in ("state", "slipping", "frictional_work"):  # less where a zone ends
                np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-11, err_msg=name)
