"""What a mesh resolves of a load, and loads too fast for it are refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene

from fem import simulate
from fem.resolution import (
    WEAKENING_ELEMENTS,
    mesh_caution,
    needed_resolution,
    resolves,
    weakening_caution,
)
from semianalytic import solve
from semianalytic.scene.contact import process_zone
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.weakening import SlipWeakening
from semianalytic.scene.loads import Harmonic, Pulse, Ramp, Step
from semianalytic.scene.scene import Material
from semianalytic.scene.tabulated import Tabulated
from tests.fem.runs import l1

SLOWER = Material(1.0, 4.0, 1 / 3)


def sheared(history, resolution, lower_material=None, **options):
    """A run under shear that rises and falls, on pressure that slips before long."""
    scene = unit_scene(0.15, shear_history=history, lower_material=lower_material)
    return simulate(scene, resolution=resolution, every=10**6, **options)


def wavy(noise, periods=2.0):
    t = np.linspace(0, 1, 2001)
    ripple = noise * np.random.default_rng(3).uniform(-1, 1, len(t))
    return Tabulated(tuple(t), tuple(np.sin(2 * np.pi * periods * t) + ripple))


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("history", "needed"),
    [
        (Pulse(0.2), 20),  # 4 node distances, and one more would not be a turn
        (Pulse(0.2, "triangle"), 40),
        (Pulse(0.3, "half-sine"), 20),
        (Pulse(0.2, "haversine"), 40),
        (Pulse(1e-6, "haversine"), 8e6),
        (Harmonic(2.0), 24),
        (Harmonic(1.6), 19.2),  # cut off by the end time soon after a crest
        (Harmonic(1003.0), 12036),
        (Harmonic(1e9), 12e9),
        (Tabulated((0.0, 0.1), (1.0, 0.5)), 33),  # a jump at once, half of it taken back
        (Tabulated((0.1, 0.1, 0.3, 0.3), (0.0, 1.0, 1.0, 0.0)), 20),
        (Tabulated((0.0, 0.3, 0.301, 0.302), (0.0, -2.0, 0.0, -2.0)), 4000),
        (wavy(0.0), 24),
        (wavy(0.05), 24),  # noise of a tenth of the load is not a turn
    ],
)
def test_mesh_follows_a_load_with_enough_nodes(history, needed):
    for speed, end_time in ((1.0, 1.0), (3.0, 1.0)):
        found = needed_resolution(history, end_time * speed, end_time)
        assert found == pytest.approx(needed * speed, rel=0.15 if needed < 25 else 2e-3, abs=1)


@pytest.mark.parametrize(
    "history",
    [
        Step(),
        Ramp(1e-9),
        Ramp(5.0),
        Pulse(1.5),
        Harmonic(0.2),
        Tabulated((0.2,), (1.0,)),
        Tabulated((0.0, 0.1, 0.1001, 0.7), (0.5, 0.6, 5.0, 5.1)),
        Tabulated((0.0,), (0.0,)),
    ],
)
def test_load_that_goes_one_way_needs_no_nodes(history):
    assert resolves(history, 0.1, 1.0)
    assert needed_resolution(history, 1.0, 1.0) <= 3


def test_noise_of_half_the_load_is_a_turn():
    assert needed_resolution(wavy(0.5), 1.0, 1.0) > 1000


@pytest.mark.parametrize(
    ("history", "needed"),
    [
        (Harmonic(1003.0), 12036),
        (Harmonic(3.0), 36),
        (Pulse(0.01), 400),
        (Pulse(0.1, "triangle"), 80),
    ],
)
def test_load_too_fast_for_the_mesh_is_refused(history, needed):
    for end_time in (1.0, 0.5):  # half the time, nodes twice as close
        with pytest.raises(SceneError, match=r"the shear history turns back .* at least") as caught:
            sheared(history, min(100, math.ceil(needed * end_time) - 1), end_time=end_time)
        named = int(str(caught.value).split("at least ")[1].split(",")[0])
        assert named == pytest.approx(needed * end_time, abs=1.01)


def test_resolution_that_is_named_is_enough_and_a_slower_block_needs_more():
    assert sheared(Harmonic(3.0), 36).final_path.max() > 0
    for resolution, options, least in ((35, {}, 36), (40, {"lower_material": SLOWER}, 72)):
        with pytest.raises(SceneError, match=f"at least {least}"):
            sheared(Harmonic(3.0), resolution, **options)


def test_load_of_no_amplitude_is_not_looked_at():
    scene = unit_scene(pressure_history=Harmonic(1003.0))
    assert simulate(scene, resolution=8).steps > 0


def test_fast_pressure_is_refused_by_its_name():
    with pytest.raises(SceneError, match="the pressure history turns back"):
        simulate(unit_scene(load=(0.5, 1.0), pressure_history=Harmonic(1003.0)))


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    "history",
    [Harmonic(24 / 12), Pulse(4.001 / 24), Pulse(8 / 24, "triangle"), Pulse(8 / 24, "haversine")],
)
def test_what_is_accepted_is_resolved(history):
    """Measured at h = 1/24 against 1/72: friction work 4.4, 5.2, 2.7 and 3.2 % off."""
    assert resolves(history, 1 / 24, 1.0)
    assert not resolves(history, 1 / 23, 1.0)
    work = [float(sheared(history, number).frictional_work(1.0)) for number in (24, 72)]
    assert work[0] == pytest.approx(work[1], rel=0.08)


# --- slip weakening ---------------------------------------------------------------------------


def weakening(friction=0.6, residual=0.2, distance=0.05, shear=(0.4, 0.4), nu=0.25, pressure=0.0):
    law = SlipWeakening(friction, residual, distance)
    return unit_scene(friction, (1.0, shear[0]), (pressure, shear[1]), nu=nu, law=law)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "end_time"),
    [
        (weakening(), 2.0),
        (weakening(0.4, 0.1, 0.08, (0.1, 0.5), nu=0.4), 1.0),
        (weakening(0.5, 0.2, 0.05, (0.2, 0.5), pressure=0.3), 1.0),
    ],
)
def test_resolution_that_weakening_asks_for_gives_slip_to_one_percent(scene, end_time):
    """Measured: 0.6, 0.8 and 0.3 %; with half of it 2.0, 2.8 and 0.8 %."""
    with pytest.warns(UserWarning, match="slip weakening is under-resolved"):
        coarse = simulate(scene, end_time, resolution=8)
    assert coarse.status == "unresolved"
    needed = int(coarse.caution.split("a resolution of ")[1].split()[0])
    fine = simulate(scene, end_time, resolution=needed)
    assert (fine.status, fine.caution) == ("resolved", "")
    reach = 0.98 * scene.material.longitudinal_speed * end_time
    x, t = fine.interface.x[fine.interface.x < reach], np.linspace(0.3, 1, 15)[:, None] * end_time
    exact = solve(scene, method="space-time", end_time=end_time, nodes=600).slip(x, t)
    assert l1(fine.slip(x, t), exact) < 0.01


def test_too_short_a_process_zone_is_told_with_elements_and_resolution():
    sentence = told_of(weakening(distance=0.001), 0.02)
    zone = process_zone(weakening(distance=0.001))
    assert f"within about {zone:.3g} of length, which is {zone / 0.02:.2g} elements" in sentence
    assert f"a resolution of {math.ceil(WEAKENING_ELEMENTS / zone)} would" in sentence
    assert told_of(weakening(distance=0.001), zone / WEAKENING_ELEMENTS / 1.01) == ""
    assert told_of(unit_scene(), 0.1) == ""


def told_of(scene, size, lower_material=None):
    """What is told of a mesh of elements of a size, until T = 1."""
    scene = replace(scene, lower_material=lower_material)
    return weakening_caution(scene, 1.0, round(1 / size))


def test_softer_block_shortens_the_process_zone():
    soft = Material(0.25, 1.0, 0.25)
    assert told_of(weakening(), 0.012) == ""
    assert f"within about {process_zone(weakening()) / 4:.3g}" in told_of(weakening(), 0.012, soft)
    assert told_of(weakening(), 0.003, soft) == ""


def test_every_caution_is_told():
    told = mesh_caution(replace(weakening(), lower_material=SLOWER), 1.0, 10)
    assert "the lower block is under-resolved" in told
    assert "slip weakening is under-resolved" in told
