"""Waves at an angle and moving loads on interfaces, between like and different bodies."""

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.dissimilar.bonded import bonded_tractions
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.engine.stepping.fronts import ActingFront
from semianalytic.field.plane_wave import plane_wave
from semianalytic.halfplane.hilbert import comes_back, transformed
from tests.semianalytic.engine.runs import one_run

THIRD = sf.Material(1.0, 1.0, 1 / 3)
HALF = sf.Contact.half_line()
HARD, SOFT = sf.Material(4.0, 1.3, 0.25), sf.Material(1.0, 0.9, 0.3)
WAVES = [
    sf.IncidentWave(kind, angle, stress=1.0, from_=side)
    for kind in ("P", "SV")
    for side in ("below", "above")
    for angle in (0.0, 10.0, -25.0, 50.0, -80.0)
]


def beside_slot(load, mode="in-plane", nodes=512, at=0.0, length=12.0):
    """The run at unit time after a front has reached the tip, and the exact answer."""
    scene = sf.Scene(THIRD, friction=0.3, base=sf.Tractions(1.0, 0.0), load=load, mode=mode)
    begun = -load.slowness(THIRD) * at
    loads = [sf.FrontLoad(load, at=at)]
    face = scene_along(THIRD, sf.Coulomb(0.3), length, 1.0, 0.0, loads, HALF, mode)
    return one_run(face, begun + 1, nodes, times=[begun + 1]), sf.solve(scene)


@pytest.mark.parametrize(
    ("load", "mode", "at", "off"),
    [
        (sf.IncidentWave("SV", -20.0, stress=0.3), "in-plane", 0.0, 0.009),
        (sf.IncidentWave("SH", -40.0, stress=0.3), "antiplane", 0.0, 0.01),
        (sf.MovingLoad(4.0, 0.0, 1.0), "in-plane", 0.0, 0.008),
        pytest.param(
            sf.IncidentWave("SV", 18.0, stress=0.2), "in-plane", -10.0, 0.01, marks=pytest.mark.slow
        ),
    ],
)
def test_fronts_beside_a_slot_are_those_of_the_exact_solver(load, mode, at, off):
    length, nodes = (12.0, 512) if at == 0 else (20.0, 1024)
    done, known = beside_slot(load, mode, nodes, at, length)
    near = (done.interface.x > 0.02) & (done.interface.x < 1.9)
    x = done.interface.x[near]
    for name, base in (("slip_rate", 0.0), ("shear_traction", 0.0), ("pressure", 1.0)):
        exact, found = (
            getattr(known, name)(x, 1.0) - base,
            getattr(done.interface, name)[0][near] - base,
        )
        size = np.abs(exact).sum()
        assert np.abs(found - exact).sum() < off * size + 1e-12


def test_a_wave_at_no_angle_is_a_load_of_the_line():
    wave = sf.IncidentWave("SV", 0.0, stress=0.6)
    shear = wave.tractions(THIRD).shear
    runs = []
    for load in (wave, sf.InterfaceLoad(shear)):
        face = scene_along(THIRD, sf.Coulomb(0.3), 8.0, loads=[load], contact=HALF, even=False)
        runs.append(one_run(face, 1.0, 64))
    assert runs[0].interface.slip.max() > 0.01 or runs[0].interface.slip.min() < -0.01
    assert runs[0].interface.slip == pytest.approx(runs[1].interface.slip, abs=1e-12)


def test_a_front_is_the_mean_of_its_load_over_a_node_distance():
    wave = ActingFront(sf.IncidentWave("SH", -30.0, stress=2.0), at=4.0, material=THIRD)
    x = np.linspace(-4, 4, 161)
    step, smooth = wave.traction(x, 1.0), wave.traction(x, 1.0, spread=(0.5, 0.0))
    assert set(step) == {0.0, step[-1]}
    middle = np.abs(x - 2) < 0.25
    assert smooth[middle] == pytest.approx(step[-1] * ((x - 2) / 0.5 + 0.5)[middle])
    assert smooth.sum() == pytest.approx(step.sum(), abs=abs(step[-1]))  # one node
    away = ActingFront(sf.MovingLoad(2.0, 0.5, 1.0), material=THIRD)
    assert away.traction([-2.5, -1.5, 0.5], 1.0, of="pressure").tolist() == [0.0, 0.5, 0.0]
    comes = ActingFront(sf.MovingLoad(-2.0, 0.5, 1.0), at=-1.0, material=THIRD)
    assert comes.traction([-1.5, 0.5, 1.5], 1.0).tolist() == [1.0, 1.0, 0.0]


def name(wave):
    return f"{wave.kind} {wave.from_} {wave.angle:g}"


@pytest.mark.parametrize("wave", WAVES, ids=name)
def test_waves_of_bonded_bodies_are_continuous_and_obey_hooke(wave):
    """Stress since t = 0 is that of the displacement; like bodies have the incident wave alone."""
    x, t = np.random.default_rng(0).uniform((-1, 0), (1, 1.5), (20, 2)).T
    pulse, step = sf.Pulse(0.6, "triangle"), 1e-6

    def field(quantity, y, right=0.0, later=0.0, bodies=(HARD, SOFT)):
        at = x + right, np.full_like(x, y), t + later
        return plane_wave(wave, bodies, quantity, at, pulse)

    assert field("velocity", 1e-12) == pytest.approx(field("velocity", -1e-12), abs=1e-8)
    faces = [field("stress", y)[1:] for y in (1e-12, -1e-12)]
    assert faces[0] == pytest.approx(faces[1], abs=1e-8)
    pressure, shear = bonded_tractions(wave, HARD, SOFT)
    slowness = wave.slowness(SOFT if wave.from_ == "below" else HARD)
    since = t - slowness * x
    hilbert = transformed(pulse, since, since)
    for part, size in zip(faces[0], (-pressure, shear), strict=False):
        assert part == pytest.approx(size.real * pulse.value(since) + size.imag * hilbert, abs=1e-8)
    critical = abs(slowness) > 1 / HARD.longitudinal_speed
    assert (abs(pressure.imag) > 1e-3) == critical
    for body, y in ((HARD, 0.3), (SOFT, -0.3)):
        rate, along, across = (
            (field("displacement", y + up, *by) - field("displacement", y - up, *back)) / (2 * step)
            for up, by, back in (
                (0, (0, step), (0, -step)),
                (0, (step, 0), (-step, 0)),
                (step, (0, 0), (0, 0)),
            )
        )
        assert rate == pytest.approx(field("velocity", y), abs=1e-8)
        modulus = body.density * body.longitudinal_speed**2
        spread = (modulus - 2 * body.shear_modulus) * (along[0] + across[1])
        normal = [spread + 2 * body.shear_modulus * part for part in (along[0], across[1])]
        turned = body.shear_modulus * (along[1] + across[0])
        # displacement counts from t = 0 where waves run ahead of the front
        changed = field("stress", y) - critical * field("stress", y, later=-t)
        assert np.array([*normal, turned]) == pytest.approx(changed[:3], abs=1e-7)
    alone = plane_wave(wave, (SOFT,), "stress", (x, np.full_like(x, 0.3), t), pulse)
    assert field("stress", 0.3, bodies=(SOFT, SOFT)) == pytest.approx(alone, abs=1e-12)


def test_the_transform_of_a_history_is_its_hilbert_transform():
    """Held against a sum over frequencies: sin for cos, on a line on which the pulse is short."""
    step, count = 1 / 512, 2**18
    t = step * (np.arange(count) + 0.5)
    for pulse in (sf.Pulse(1.0), sf.Pulse(1.0, "triangle")):
        lines = np.fft.rfft(pulse.value(t - 200))
        known = np.fft.irfft(-1j * lines, n=count)
        for at in (198.0, 199.9, 200.3, 201.2, 203.0):
            near = slice(round(at / step) - 26, round(at / step) + 26)
            ends = np.array([t[near][0] - step / 2, t[near][-1] + step / 2]) - 200
            found = transformed(pulse, ends[:1], ends[1:])[0]
            assert found == pytest.approx(known[near].mean(), abs=2e-3)
    assert transformed(sf.Pulse(1.0), np.array([2.0]), np.array([2.0]))[0] == pytest.approx(
        np.log(2.0) / np.pi
    )
    assert not comes_back(sf.Step())
    assert not comes_back(sf.Pulse(1.0, "half-sine"))


def slipping(wave, upper, lower):
    """Slip rate and pressure per unit of history where nothing resists slip, from both faces."""
    below = wave.from_ == "below"
    source = lower if below else upper
    k = -wave.slowness(source) * (1 - 1e-14j) + 0j
    entries = compliance_of(upper, lower).at(np.array([k * upper.shear_speed]))
    scale = entries.rayleigh[0] * upper.shear_impedance
    b, kd, a = (term[0] / scale for term in (entries.tangential, entries.coupling, entries.normal))
    pressure, shear = bonded_tractions(wave, upper, lower)
    # [V, U] = C ([tau, sigma] of the bonded line less [0, sigma]) with U = 0
    sigma = -pressure - kd / a * shear
    return b * shear + kd * (-pressure - sigma), -sigma


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "wave",
    [sf.IncidentWave("P", -20.0, stress=0.2), sf.IncidentWave("SV", -12.0, stress=0.2)],
    ids=name,
)
def test_a_wave_meets_faces_that_slide_freely(wave):
    """Ahead of all that runs from where it began, slip rate and pressure are those of plane waves.

    Beyond critical angles fronts are slower than the fastest wave, and there is no such place.
    """
    at, length, end, nodes = 6.0, 16.0, 1.2, 1024
    load = sf.FrontLoad(wave, at=at)
    face = scene_along(HARD, sf.Coulomb(0.0), length, loads=[load], lower_material=SOFT)
    done = one_run(face, end, nodes, times=[end])
    assert done.interface.gap.max() == 0.0
    slow, width = wave.slowness(SOFT), length / nodes
    near = np.abs(done.interface.x - at - end / slow) < 1.0
    share = np.clip(0.5 + (done.interface.x[near] - at - end / slow) / width, 0, 1)
    rate, pressure = slipping(wave, HARD, SOFT)
    found = done.interface.slip_rate[0][near], done.interface.pressure[0][near] - 1.0
    for answer, size in zip(found, (rate.real, pressure.real), strict=True):
        assert np.abs(answer - size * share).sum() < 0.011 * np.abs(size * share).sum()


def test_a_wave_beyond_a_critical_angle_shows_before_its_front():
    """Where nothing slips, the shear is that of a sum over frequencies, each with its phase."""
    wave, at, end = sf.IncidentWave("P", 50.0, stress=0.2), -3.0, 2.0
    load = sf.FrontLoad(wave, sf.Pulse(0.6, "triangle"), at=at)
    stuck = sf.Coulomb(0.1, cohesion=9.0)
    face = scene_along(HARD, stuck, 16.0, loads=[load], lower_material=SOFT)
    done = one_run(face, end, 256, times=[end])
    assert np.abs(done.interface.slip).max() == 0.0
    t = (np.arange(2**16) - 2**15) / 256
    lines = np.fft.fft(sf.Pulse(0.6, "triangle").value(t))
    shear = bonded_tractions(wave, HARD, SOFT)[1]
    # exp(-i w t) with w > 0 stands at the negative frequencies of the transform
    phases = np.where(np.fft.fftfreq(len(t)) < 0, shear, np.conj(shear))
    history = np.fft.ifft(phases * lines).real
    since = end - wave.slowness(SOFT) * (done.interface.x - at)
    wanted = np.interp(since, t, history)
    size = np.abs(wanted).sum()
    assert np.abs(done.interface.shear_traction[0] - wanted).sum() < 0.01 * size
    plain = shear.real * sf.Pulse(0.6, "triangle").value(since)
    assert np.abs(plain - wanted).sum() > 0.5 * size
    ahead = np.abs(wanted[since < 0]).sum()
    assert ahead > 0.1 * size
