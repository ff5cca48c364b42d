"""Fields in the bodies after a march along a line: waves that faces send, and their sums."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.engine.bodies import marched_bodies
from semianalytic.engine.bodies.marched_bodies import MarchedBodies
from semianalytic.engine.bodies.motion import Levels, Motion, MotionRecord
from semianalytic.engine.bodies.spectrum import terms_of
from semianalytic.engine.bodies.transfer import decays, driven
from semianalytic.engine.march import march
from semianalytic.engine.marched import Marched
from semianalytic.field.plane_wave import plane_wave

SOLID, UPPER, LOWER = (
    sf.Material(*number) for number in ((1.0, 1.0, 1 / 3), (1.0, 1.0, 0.25), (2.5, 1.2, 0.25))
)
Q, S, DEPTH = 1.5, np.array(0.7 + 2.3j), 0.4
# v_x, v_y, e_xx, e_yy, gamma_xy per unit rate: of bodies, the lower one or not, slip or opening
WAVES = {
    (SOLID, 0, 0): "0.2184301865-0.0883992869j -0.0771720961+0.0048604980j "
    "0.1464365735-0.0130840561j -0.0466460851+0.0279248245j -0.1192675906+0.2095409798j",
    (SOLID, 0, 1): "0.0763480147-0.2543545387j 0.3632715030-0.1934406690j "
    "0.0917773212-0.1379511666j -0.1859731946+0.1461199358j 0.1062888067+0.0855311860j",
    (UPPER, 0, 0): "0.3144692990-0.1614612539j -0.1804997479-0.0436641429j "
    "0.2170334599-0.0392471561j 0.0006294446+0.0603849025j -0.1831169284+0.2666058086j",
    (UPPER, 1, 0): "-0.1235358189-0.0145492276j -0.1109554648-0.0293017679j "
    "-0.0710937520-0.0311258555j 0.0098393485+0.0118393341j -0.1067756427+0.0646869293j",
    (UPPER, 0, 1): "0.0593649238-0.1719558399j 0.4198217522-0.2896511598j",
    (UPPER, 1, 1): "0.1116676086-0.0423004534j -0.3545626144+0.0688325989j",
}


@pytest.mark.parametrize("lower", [False, True])
def test_equal_bodies_as_two_send_the_waves_of_one_and_another(lower):
    roots, names = decays(SOLID, Q, S), ("x", "y")
    one, two = (driven((SOLID,) * count, lower, Q, S, names, roots) for count in (1, 2))
    assert one.keys() == two.keys()
    for wave, drive in one.items():
        assert two[wave] == pytest.approx(drive, rel=1e-12)


def sent(asked, body, waves):
    """Rows of a field, of waves at the face by name."""
    a, b = decays(body, Q, S)
    at = {name: wave * np.exp(-(a if name == "P" else b) * DEPTH) for name, wave in waves.items()}
    return [
        sum(
            entry.coefficient * (1j * Q) ** entry.turns * at[entry.wave]
            * entry.factor(Q, a if entry.wave == "P" else b, S)
            for entry in row
        )
        for row in terms_of(asked, body)
        if row[0].wave in at
    ]  # fmt: skip


@pytest.mark.parametrize("case", WAVES, ids=lambda case: f"{case[0].poisson_ratio:.2f}-{case[1:]}")
def test_waves_of_moving_faces_have_the_values_of_another_computation(case):
    body, lower, drive = case
    bodies = (SOLID,) if body is SOLID else (UPPER, LOWER)
    own = bodies[lower and len(bodies) - 1]
    drives = driven(bodies, lower, Q, S, "xy"[drive], decays(own, Q, S))
    waves = {wave: amplitude for (_, wave), amplitude in drives.items()}
    found = np.array([*sent("velocity", own, waves), *sent("strain", own, waves)])
    found *= np.where(lower, [1, -1, 1, 1, -1], 1) * [1, 1, 1, 1, 2]
    known = np.array([complex(wave) for wave in WAVES[case].split()])
    np.testing.assert_allclose(found[: len(known)], known, atol=1e-10)


def test_waves_along_z_and_of_bodies_that_are_equal():
    (velocity,), strains = (sent(asked, SOLID, {"Z": 0.5}) for asked in ("velocity", "strain"))
    found = [velocity, *(2 * strain for strain in strains)]
    known = [0.2618261411 - 0.2342138567j, 0.1988278091 - 0.0922353560j]
    np.testing.assert_allclose(found, [*known, -0.1875758324 + 0.2291572215j], atol=1e-10)
    for lower in (False, True):
        single, two = (
            driven(bodies, lower, Q, S, "xy", decays(SOLID, Q, S))
            for bodies in ((SOLID,), (SOLID,) * 2)
        )
        assert single.keys() == two.keys()
        np.testing.assert_allclose([*single.values()], [*two.values()], atol=1e-14)


def test_joined_steps_keep_what_has_moved_and_levels_too(monkeypatch):
    monkeypatch.setattr("semianalytic.engine.bodies.motion.MOST_VALUES", 90)
    record, t = MotionRecord(), np.cumsum([0.0, *np.linspace(0.1, 0.3, 36)])
    rates = np.cos(t)[:, None] * [1.0, 2.0, -1.0]
    for start in range(0, 36, 4):
        record.add(t[start : start + 5].tolist(), rates[start : start + 5])
    motion = record.motion()
    moved = np.diff(t) @ (rates[1:] + rates[:-1]) / 2
    assert len(motion.slip) < 20
    np.testing.assert_allclose(np.diff(motion.t) @ motion.slip, moved, rtol=1e-5)
    levels = Levels(0.0, t[-1] / 50, 50).means(motion.t, motion.slip)
    np.testing.assert_allclose(levels.sum(axis=0) * t[-1] / 50, moved, rtol=1e-5)
    middle = (np.arange(50) + 0.5) * t[-1] / 50
    assert np.abs(levels[5:-5, 0] - np.cos(middle)[5:-5]).max() < 0.05


@cache
def marched(name, nodes, **settings):
    scene = sf.find(name)
    if not scene.on_line:
        scene = replace(scene, period=12.0 if name == "pair-slip" else 10.0)
    return march(scene, settings.pop("end_time", 1.0), nodes, **settings)


def test_a_point_beside_a_slip_zone_comes_to_the_digits_of_another_computation():
    march = marched("preloaded", 1024, estimate=False)
    strain = march.strain(0.4, 0.2, 1.0) * [1, 1, 2]
    found = [*march.velocity(0.4, 0.2, 1.0), *strain]
    exact = [0.300986, 0.095281, -0.364188, 0.162481, -0.106349]
    np.testing.assert_allclose(found, exact, atol=6e-5)


# errors of velocity and strain in percent at y = .01, .05, .2 and .5 c_t t, those of a prototype
TABLE = [
    ("preloaded", 512, (0.225, 0.227, 0.095, 0.104, 0.093, 0.065, 0.089, 0.075)),
    ("antiplane", 512, (0.177, 0.609, 0.158, 0.134, 0.175, 0.138, 0.179, 0.184)),
    ("remote-shock", 512, (0.166, 2.19, 0.141, 0.611, 0.044, 0.068, 0.116, 0.090)),
    ("pair-slip", 512, (0.508, 0.966, 0.273, 0.450, 0.204, 0.221, 0.242, 0.222)),
    ("preloaded", 1024, (0.109, 0.100, 0.029, 0.025, 0.029, 0.020, 0.035, 0.029)),
]


def test_a_slot_is_the_same_beside_a_half_line_and_on_a_line():
    """Both marches, their readings and their bodies, on nodes of one distance."""
    scene, t = sf.find("ramp"), 0.9
    beside = sf.solve(scene, nodes=100, end_time=1.0)
    along = march(replace(scene, period=8.0), 1.0, nodes=400)
    places = np.array([-0.4, 0.2, 0.5, 0.3]), np.array([0.2, 0.3, -0.25, -0.1])
    for name in ("velocity", "stress", "displacement"):
        slot, line = (getattr(each, name)(*places, t) for each in (beside, along))
        assert np.abs(slot - line).max() < 1e-3 * np.abs(slot).max(), name
    slot, line = (each.reading([0.1, 0.3, 0.6], t) for each in (beside, along))
    measured = [(getattr(slot, of), getattr(line, of)) for of in ("slip", "slip_rate", "gap")]
    for pair in [*measured, (slot.arrivals["slip"], line.arrivals["slip"])]:
        assert np.all(np.abs(pair[0].value - pair[1].value) <= pair[0].error + pair[1].error)


@pytest.mark.parametrize("load", [0.0, 0.05])
def test_where_nothing_slips_the_bodies_carry_what_is_in_place(load):
    """Without a load, and under one that friction bears."""
    push = sf.InterfaceLoad(load, on="line")
    still = sf.Scene(UPPER, 0.5, sf.Tractions(1.0, 0.3), push, contact=sf.Contact(), period=8.0)
    done = sf.solve(still, end_time=1.0, nodes=64)
    assert not done.velocity(0.3, 0.4, 0.5).any()
    assert done.stress(0.3, 0.4, 0.5) == pytest.approx([0.0, -1.0, 0.3 + load])
    reading = done.reading([0.1], 0.5)
    assert (reading.slip.value, reading.slip.error) == (0.0, 0.0)
    assert np.isinf(reading.arrivals["slip"].value)
    assert done.field_error == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("name", "nodes", "known"), TABLE)
def test_fields_are_as_exact_as_the_march(name, nodes, known):
    """Against self-similar fields, and within the difference from half the nodes."""
    item, exact = marched(name, nodes), sf.solve(name)
    assert item.companion is not None
    x, speed = np.random.default_rng(7).uniform(-1.6, 1.9, 80), exact.scene.material.shear_speed
    t, solid = np.array([[0.5], [0.75], [1.0]]), exact.scene.material
    place = x * speed * t
    weights = np.array([1, 1, 2, 2, 2])[: 5 if exact.scene.antiplane else 3, None, None]
    for share, velocity, strain in zip(
        (0.01, 0.05, 0.2, 0.5), known[::2], known[1::2], strict=True
    ):
        at = place, share * speed * t, t
        near = share * speed < item.nearest_depth * 2  # at t = .5
        true = exact.velocity(*at)
        kept = np.isfinite(true).all(axis=0) & np.isfinite(exact.stress(*at)).all(axis=0)

        def off(found, known, kept=kept, weights=1):
            return float((weights * np.abs(found - known))[:, kept].sum())

        error = off(item.velocity(*at), true)
        assert error < 0.012 * velocity * off(true, 0.0)
        if not near:
            changed = exact.stress(*at) - exact.stress(*at[:2], 0.0 * t)
            right = sf.strain(changed, solid)
            wrong = off(item.strain(*at), right, weights=weights)
            assert wrong < 0.012 * strain * off(right, 0.0, weights=weights)
            assert error < float(item.error_of(lambda run, at=at: run.velocity(*at))[:, kept].sum())


def test_motion_and_stress_obey_the_equation_of_motion():
    march, h = marched("supershear", 512, end_time=8.0, estimate=False), 0.02
    x, y, t = np.array([[-3.0], [1.0], [4.0]]), np.array([1.5, -2.5]), 7.0

    def slope(field, dx, dy, dt):
        ends = (field(x + s * dx * h, y + s * dy * h, t + s * dt * h) for s in (1, -1))
        return np.subtract(*ends) / (2 * h)

    along, across = slope(march.stress, 1, 0, 0), slope(march.stress, 0, 1, 0)
    forces = np.array([along[0] + across[2], along[2] + across[1]])
    pull = slope(march.velocity, 0, 0, 1)
    assert np.abs(forces - pull).max() < 0.02 * np.abs(pull).max()
    moving = slope(march.displacement, 0, 0, 1)
    velocity = march.velocity(x, y, t)
    assert np.abs(velocity - moving).max() < 0.01 * np.abs(velocity).max()


def test_a_picture_is_that_of_its_gauges_in_both_bodies():
    march = marched("rock-on-gouge", 128, end_time=1e-3, estimate=False)
    x, y, t = np.linspace(-1, 1, 5), np.linspace(-1.9, 1.9, 20)[:, None], march.motion.t[-8]
    picture = march.velocity(x, y, t)
    for row in (3, 14):
        gauges = march.velocity(x[:, None], y[row], np.linspace(0, t, 400))[..., -1]
        np.testing.assert_allclose(picture[:, row], gauges, atol=1e-3 * np.abs(picture).max())


def test_runs_that_are_saved_or_go_on_know_the_bodies(tmp_path):
    scene = replace(sf.find("preloaded"), period=10.0)
    at, whole = (0.3, 0.8, [0.7, 0.9]), march(scene, 1.0, 128)
    part = march(scene, 0.6, 128, latest=1.0)
    gone = march(scene, 1.0, 128, go_on=part)
    np.testing.assert_allclose(gone.stress(*at), whole.stress(*at), atol=1e-5)
    whole.save(tmp_path / "run.h5")
    loaded = Marched.load(tmp_path / "run.h5")
    assert loaded.stress(*at).tolist() == whole.stress(*at).tolist()
    estimate = loaded.error_of(lambda march: march.stress(*at))
    assert np.all((estimate > 0) & (estimate < 0.2))
    assert 0 < loaded.field_error < 0.1


def test_what_is_not_known_is_refused(monkeypatch):
    known = marched("preloaded", 256, estimate=False)
    with pytest.raises(sf.SceneError, match=r"y = 0.01 is nearer .*; take 1000 nodes of the line"):
        known.stress(0.1, [0.3, -0.01], 0.5)
    assert np.isfinite(known.velocity(0.1, -0.0, 0.5)).all()
    monkeypatch.setattr(marched_bodies, "MOST_LEVELS", 256 * 10)
    with pytest.raises(sf.SceneError, match=r"slip is never slow in the .* before t = 0.5, and"):
        known.velocity(0.1, 0.3, 0.5)


@pytest.mark.parametrize("name", ["pair-slip", "preloaded", "antiplane"])
def test_the_window_of_an_event_is_part_of_the_whole(name, monkeypatch):
    """Slow slip and opening before it are static; times far apart have windows of their own."""
    scene, wave = replace(sf.find(name), period=1.0), np.pi / 32 * np.arange(64)
    t, shapes = np.linspace(0.0, 60.0, 1201), (np.cos(wave), 0.2 + 0.5 * np.sin(2 * wave))
    slow = 2e-3 * np.sin(np.minimum(t[1:], 20.0) * np.pi / 40) ** 2
    rate = (slow + np.exp(-16 * (t[1:] - 50.0) ** 2))[:, None]
    slip, opening = ((rate * shape).astype(np.float32) for shape in shapes)
    motion = Motion(t, slip, opening[:, : 0 if scene.antiplane else None])
    two, times = MarchedBodies(scene, motion, -0.5, 1 / 64), np.array([42.0, 49.5, 50.1, 51.0])
    at, fields = ([0.04, 0.3], [0.05, -0.1], times[:, None]), ("velocity", "stress", "displacement")
    whole = [getattr(two, field)(*at) for field in fields]
    monkeypatch.setattr(marched_bodies, "MOST_LEVELS", 64 * 600)
    for field, wanted in zip(fields, whole, strict=True):
        found = getattr(two, field)(*at)
        for event in (slice(0, 1), slice(1, None)):
            size = np.abs(wanted[:, event]).max()
            assert np.abs(found - wanted)[:, event].max() < 5e-3 * size


def test_an_incident_wave_goes_through_two_bodies_that_hold():
    wave = sf.FrontLoad(sf.IncidentWave("P", 20.0, stress=0.1), at=-1.0)
    pair = replace(sf.find("pair-slip"), friction=sf.Coulomb(0.3, cohesion=9.0), load=wave)
    run = march(replace(pair, period=8.0, contact=sf.Contact()), 0.5, 64, estimate=False)
    at = np.array([0.1, -0.3]), np.array([0.3, -0.4]), np.array(0.4)
    there = at[0] + 1.0, *at[1:]
    alone = plane_wave(wave.front, pair.bodies, "velocity", there, wave.history)[:2]
    assert run.velocity(*at).tolist() == alone.tolist()
    assert np.abs(alone).min() > 1e-3


def test_base_that_varies_along_x_is_left_out_of_stress():
    scene = sf.find("tpv205")
    stress = march(scene, 0.5, 64, estimate=False).stress([0.0, 9e3], 5e3, 0.0)
    assert stress[2].tolist() == [0.0, 0.0]
    assert stress[1].tolist() == [-scene.base.pressure] * 2


def test_faces_move_apart_by_slip_that_the_plates_carry():
    end = marched("rate-and-state", 64, end_time=0.5, estimate=False)
    x = end.interface.x[4:20]
    for name, rate in (("velocity", end.interface.slip_rate), ("displacement", end.interface.slip)):
        apart = np.subtract(*(getattr(end, name)(x, y, end.end_time)[0] for y in (0.0, -0.0)))
        np.testing.assert_allclose(apart, rate[-1, 4:20], rtol=0.01)
