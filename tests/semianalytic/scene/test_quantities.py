"""Numbers with units: quantities of pint in scenes and questions, all converted at one place."""

import warnings
from pathlib import Path

import numpy as np
import pint
import pytest

import slipfront as sf
from semianalytic.scene.given.solids import solids
from semianalytic.scene.units import measure

UNITS = pint.UnitRegistry()
STEEL = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)
PLAIN = sf.Scene(STEEL, 0.25, sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 5e6), units="SI")


def with_units():
    return sf.Scene(
        sf.Material(80 * UNITS.GPa, 7.8 * UNITS.g / UNITS.cm**3, poisson_ratio=0.29),
        friction=0.25 * UNITS.dimensionless,
        base=sf.Tractions(pressure=5 * UNITS.MPa, shear=0.0),
        load=sf.Tractions(0.0, 5 * UNITS.MPa),
    )


def test_scene_of_quantities_is_one_in_si_units():
    scene = with_units()
    assert scene == PLAIN
    assert scene.units == "SI"
    assert repr(scene.material) == repr(STEEL)
    assert sf.Scene(scene.material, 0.25, PLAIN.base, PLAIN.load).units == "SI"
    assert sf.Scene(STEEL, 0.25, sf.Tractions(5e6, 0.0), PLAIN.load).units == ""
    for solid in (
        sf.Material.from_young(206.4 * UNITS.GPa, 0.29, 7800.0),
        sf.Material.from_speeds(5.9 * UNITS.km / UNITS.s, 3200.0, 7800.0),
    ):
        assert sf.Scene(solid.plane_stress(), 0.25, PLAIN.base, PLAIN.load).units == "SI"


def test_histories_and_laws_take_quantities():
    assert sf.Ramp(3 * UNITS.us) == sf.Ramp(3e-6)
    assert sf.Pulse(duration=3 * UNITS.us, shape="triangle") == sf.Pulse(3e-6, "triangle")
    assert sf.Harmonic(2 * UNITS.kHz) == sf.Harmonic(2000.0)
    assert sf.Tabulated([0, 2] * UNITS.ms, (0, 1)) == sf.Tabulated((0, 2e-3), (0, 1))
    assert sf.Coulomb(1.0, viscosity=1 * UNITS.MPa * UNITS.s / UNITS.m) == sf.Coulomb(
        1.0, viscosity=1e6
    )
    assert sf.RateWeakening(1.0, 0.8, 5 * UNITS.mm / UNITS.s) == sf.RateWeakening(1.0, 0.8, 5e-3)
    assert sf.SlipWeakening(1.0, 0.5, 10 * UNITS.um) == sf.SlipWeakening(1.0, 0.5, 1e-5)


def test_answers_take_quantities_wherever_they_take_lengths_and_times():
    solution, x, t = sf.solve(with_units()), np.array([0.05, 0.08]), 3e-5
    given = (x * 100 * UNITS.cm, 30 * UNITS.us)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a unit that numpy strips is a wrong number
        for name in ("slip", "slip_rate", "shear_traction", "pressure", "gap", "path"):
            assert getattr(solution, name)(*given) == pytest.approx(getattr(solution, name)(x, t))
        assert solution.arrival(5 * UNITS.cm) == pytest.approx(solution.arrival(0.05))
        assert solution.slip([5 * UNITS.cm, 8 * UNITS.cm], t) == pytest.approx(solution.slip(x, t))
        assert solution.stress(5 * UNITS.cm, 1 * UNITS.mm, 30 * UNITS.us) == pytest.approx(
            solution.stress(0.05, 1e-3, 3e-5)
        )
        assert solution.reading(*given).slip.value == pytest.approx(solution.slip(x, t))
        assert solution.zones_at(30 * UNITS.us)[0].end == pytest.approx(solution.zones_at(t)[0].end)


def test_marches_take_quantities():
    scene = with_units()
    marched = sf.solve(
        scene, method="space-time", end_time=40 * UNITS.us, nodes=64, length=10 * UNITS.cm
    )
    plain = sf.solve(PLAIN, method="space-time", end_time=4e-5, nodes=64, length=0.1)
    assert marched.slip(3 * UNITS.cm, 30 * UNITS.us) == plain.slip(0.03, 3e-5)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: sf.Material(80 * UNITS.m, 1.0, 0.3), "shear_modulus must have a unit of stress"),
        (
            lambda: sf.solve(sf.find("preloaded")).slip(5 * UNITS.cm, 1.0),
            "the scene does not say which units",
        ),
        (
            lambda: sf.solve(sf.find("ramp"), method="space-time", end_time=1 * UNITS.s),
            "end_time has a unit",
        ),
        (lambda: sf.find_material("gold"), "one of steel, aluminium, pmma, homalite, granite"),
    ],
)
def test_wrong_units_are_refused_in_a_sentence(ask, said):
    with pytest.raises(sf.SceneError, match=said):
        ask()


def test_known_solids_make_scenes_in_si_units():
    scene = sf.Scene(sf.find_material("PMMA"), 0.5, sf.Tractions(5e6, 0), sf.Tractions(0, 6e6))
    assert scene.units == "SI"
    assert scene.material.shear_speed == pytest.approx(1345, rel=1e-3)
    assert scene.material.longitudinal_speed == pytest.approx(2705, rel=2e-3)
    granite = sf.find_material("granite")  # speeds that Leet and Ewing measured
    assert granite.shear_speed == pytest.approx(2480, rel=0.01)
    assert granite.longitudinal_speed == pytest.approx(4960, rel=0.01)


def test_solids_are_those_of_the_page():
    page = (Path(__file__).parents[3] / "docs" / "commands.md").read_text(encoding="utf-8")
    for name, solid in solids().items():
        material = solid.material
        row = (
            f"| `{name}` | {material.shear_modulus / 1e9:g} GPa | {material.density:g} kg/m³ | "
            f"{material.poisson_ratio:g} |"
        )
        assert row in page


@pytest.mark.parametrize(
    ("text", "dimension", "number"),
    [("5cm", "length", 0.05), (" 30 us ", "time", 3e-5), ("1e-3", "time", 1e-3), ("2%", "1", 0.02)],
)
def test_numbers_with_units_as_typed(text, dimension, number):
    assert measure(text, dimension) == number
    with pytest.raises(sf.SceneError, match="a number"):
        measure(text + "?", dimension)


def test_scenes_on_a_line_and_their_runs_take_quantities():
    solid = sf.Material(30 * UNITS.GPa, 2700 * UNITS.kg / UNITS.m**3, 0.25)
    base, pushed = sf.Tractions(10 * UNITS.MPa, 3 * UNITS.MPa), sf.InterfaceLoad(2 * UNITS.MPa)
    scene = sf.Scene(solid, 0.4, base, pushed, contact=sf.Contact(), period=24 * UNITS.m)
    assert (scene.units, scene.period, scene.load.shear) == ("SI", 24.0, 2e6)
    run = sf.solve(scene, end_time=1 * UNITS.ms, nodes=64, estimate=False)
    assert run.slip(3 * UNITS.cm, 0.5 * UNITS.ms) == run.slip(0.03, 5e-4) > 0
