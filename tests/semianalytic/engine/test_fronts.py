"""Waves at an angle and moving loads on interfaces, against the exact solver and one another."""

import numpy as np
import pytest

import semianalytic as sf

THIRD = sf.Material(1.0, 1.0, 1 / 3)
HALF = sf.Contact.half_line()


def beside_slot(load, mode="in-plane", nodes=512, at=0.0, length=12.0):
    """The run at unit time after a front has reached the tip, and the exact answer."""
    scene = sf.Scene(THIRD, friction=0.3, base=sf.Tractions(1.0, 0.0), load=load, mode=mode)
    begun = -load.slowness(THIRD) * at
    loads = [sf.FrontLoad(load, at=at)]
    face = sf.Interface(THIRD, sf.Coulomb(0.3), length, 1.0, 0.0, loads, HALF, mode)
    return sf.run(face, begun + 1, nodes, times=[begun + 1], estimate=False), sf.solve(scene)


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
    near = (done.x > 0.02) & (done.x < 1.9)
    x = done.x[near]
    for name, base in (("slip_rate", 0.0), ("shear_traction", 0.0), ("pressure", 1.0)):
        exact, found = getattr(known, name)(x, 1.0) - base, getattr(done, name)[0][near] - base
        size = np.abs(exact).sum()
        assert np.abs(found - exact).sum() < off * size + 1e-12


def test_a_wave_at_no_angle_is_a_load_of_the_line():
    wave = sf.IncidentWave("SV", 0.0, stress=0.6)
    shear = wave.tractions(THIRD).shear
    runs = []
    for load in (wave, sf.InterfaceLoad(shear)):
        face = sf.Interface(THIRD, sf.Coulomb(0.3), 8.0, loads=[load], contact=HALF, even=False)
        runs.append(sf.run(face, 1.0, 64, estimate=False))
    assert runs[0].slip.max() > 0.01 or runs[0].slip.min() < -0.01
    assert runs[0].slip == pytest.approx(runs[1].slip, abs=1e-12)


def test_a_front_is_the_mean_of_its_load_over_a_node_distance():
    wave = sf.FrontLoad(sf.IncidentWave("SH", -30.0, stress=2.0), at=4.0).of(THIRD)
    x = np.linspace(-4, 4, 161)
    step, smooth = wave.traction(x, 1.0), wave.traction(x, 1.0, spread=(0.5, 0.0))
    assert set(step) == {0.0, step[-1]}
    middle = np.abs(x - 2) < 0.25
    assert smooth[middle] == pytest.approx(step[-1] * ((x - 2) / 0.5 + 0.5)[middle])
    assert smooth.sum() == pytest.approx(step.sum(), abs=abs(step[-1]))  # one node
    away = sf.FrontLoad(sf.MovingLoad(2.0, 0.5, 1.0)).of(THIRD)
    assert away.traction([-2.5, -1.5, 0.5], 1.0, of="pressure").tolist() == [0.0, 0.5, 0.0]
    comes = sf.FrontLoad(sf.MovingLoad(-2.0, 0.5, 1.0), at=-1.0).of(THIRD)
    assert comes.traction([-1.5, 0.5, 1.5], 1.0).tolist() == [1.0, 1.0, 0.0]


FILE = """
length = 8.0
contact = {intervals = [[0.0, inf]]}
[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.25
[law]
kind = "coulomb"
friction = 0.3
[load]
kind = "incident-wave"
wave = "SV"
angle = -20.0
stress = 0.3
at = 4.0
history = {kind = "pulse", duration = 0.5, shape = "half-sine"}
[run]
end_time = 1.0
nodes = 32
"""


def test_files_describe_fronts_and_surveys_vary_them(tmp_path):
    (tmp_path / "a.toml").write_text(FILE)
    found = sf.find_interface(tmp_path / "a.toml")
    load = found.interface.loads[0]
    assert load.front == sf.IncidentWave("SV", angle=-20.0, stress=0.3)
    assert (load.at, load.history) == (4.0, sf.Pulse(0.5, "half-sine"))
    from semianalytic.interface.parameters import interface_at, interface_parameters

    known = interface_parameters(found.interface)
    assert {"load_angle", "load_stress", "load_at", "load_history_duration"} <= set(known)
    other = interface_at(found.interface, {"load_angle": -30.0, "shear_modulus": 4.0})
    assert other.loads[0].front.angle == -30.0
    assert other.loads[0].material.shear_modulus == 4.0
    sf.run(other, 0.5, 32)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('wave = "SV"', 'wave = "SH"'), "must be of kind P or SV, got SH"),
        (("angle = -20.0", "angle = 95.0"), "angle must"),
        (("at = 4.0", "on = 4.0"), "has no 'on'"),
        (('"incident-wave"', '"wave"'), "kind must be one of"),
        (("length = 8.0", "length = 8.0\neven = true"), "not even in x"),
        (("at = 4.0", 'at = "end"'), "load: at must"),
        (
            (
                "[law]",
                "[lower_material]\nshear_modulus = 0.3\ndensity = 1.0\npoisson_ratio = 0.3\n[law]",
            ),
            "beyond a critical angle",
        ),
    ],
)
def test_fronts_that_mean_nothing_are_refused(tmp_path, change, message):
    (tmp_path / "a.toml").write_text(FILE.replace(*change))
    with pytest.raises(sf.SceneError, match=message):
        sf.find_interface(tmp_path / "a.toml")
