import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import REMOTE, unit_scene
from hypothesis import given
from hypothesis import strategies as st

import semianalytic as sf
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import NAMED_SCENES


def test_wave_speeds_of_steel():
    steel = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.3)
    assert steel.shear_speed == pytest.approx(math.sqrt(80e9 / 7800))
    assert steel.longitudinal_speed == pytest.approx(steel.shear_speed * math.sqrt(3.5))
    # Published root of the Rayleigh cubic for nu = 0.3.
    assert steel.rayleigh_speed / steel.shear_speed == pytest.approx(0.92741, abs=1e-5)
    assert steel.shear_impedance == pytest.approx(7800 * steel.shear_speed)


@pytest.mark.parametrize("nu", [-0.99, -0.5, 0.0, 0.25, 0.3, 0.499])
def test_rayleigh_speed_is_a_root_of_the_rayleigh_function(nu):
    material = sf.Material(2.0, 3.0, nu)
    r = (material.rayleigh_speed / material.shear_speed) ** 2
    s = (material.rayleigh_speed / material.longitudinal_speed) ** 2
    assert (2 - r) ** 2 == pytest.approx(4 * math.sqrt((1 - r) * (1 - s)), rel=1e-13)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("shear_modulus", 0.0),
        ("density", -1.0),
        ("poisson_ratio", 0.5),
        ("poisson_ratio", -1.0),
    ],
)
def test_material_names_the_bad_parameter(field, value):
    good = {"shear_modulus": 1.0, "density": 1.0, "poisson_ratio": 0.3}
    with pytest.raises(sf.SceneError, match=field):
        sf.Material(**(good | {field: value}))


@given(st.floats(-0.95, 0.49), st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_a_solid_is_the_same_by_young_speeds_and_modulus(nu, modulus, density):
    solid = sf.Material(modulus, density, nu)
    young = sf.Material.from_young(E=2 * modulus * (1 + nu), nu=nu, rho=density)
    by_speeds = sf.Material.from_speeds(solid.longitudinal_speed, solid.shear_speed, density)
    for other in (young, by_speeds):
        assert other.shear_modulus == pytest.approx(modulus, rel=1e-12)
        assert other.poisson_ratio == pytest.approx(nu, abs=1e-12)
    if nu > -0.49:  # waves of a plate: E / (rho (1 - nu^2))
        plate = math.sqrt(2 * modulus / (density * (1 - nu)))
        assert solid.plane_stress().longitudinal_speed == pytest.approx(plate, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.Material(E=1.0, nu=0.3, rho=1.0), r"did you mean Material.from_young"),
        (lambda: sf.Material(mu=1.0, density=1.0, poisson_ratio=0.3), "mean shear_modulus"),
        (lambda: sf.Material.from_speeds(1.1, 1.0, 1.0), "c_l must be above c_t sqrt"),
        (lambda: sf.Material.from_young("5 GPa", 0.3, 1.0), "E must be positive and finite"),
        (lambda: sf.Material(1.0, 1.0, -0.6).plane_stress(), "ratio above -1/2"),
        (lambda: sf.Tractions(presure=1.0, shear=0.0), "did you mean pressure"),
    ],
)
def test_other_ways_to_a_solid_are_named_and_checked(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()


def test_scene_refuses_negative_friction_and_a_tensile_base():
    """Numbers that are none are refused in test_checks.py."""
    with pytest.raises(sf.SceneError, match="friction"):
        unit_scene(friction=-0.1)
    with pytest.raises(sf.SceneError, match="base pressure"):
        unit_scene(base=(-1.0, 0.0))


# --- where the load acts ------------------------------------------------------------------------


def test_a_load_on_the_slot_leaves_the_base_in_place():
    scene = unit_scene(0.5, (2.0, 0.5), (1.0, 1.5))
    assert scene.load_on == "slot"
    assert scene.superposition == (scene.base, scene.load)
    assert "load_on" not in scene_document(scene)
    assert scene.far_slip_rate == 0


def test_a_remote_load_is_carried_by_the_contact_beside_the_base():
    scene = unit_scene(0.5, (1.0, 0.25), (1.0, 1.25), load_on="remote")
    assert scene.superposition == (sf.Tractions(2.0, 1.5), sf.Tractions(1.0, 1.25))
    assert scene.far_slip_rate == pytest.approx(2 * (1.5 - 0.5 * 2.0))
    assert scene_from_document(scene_document(scene)) == scene
    assert scene != replace(scene, load_on="slot")
    assert repr(scene).endswith("load_on='remote')")


def test_far_slip_rate_follows_the_excess_of_a_remote_shock():
    assert unit_scene(1.25, **REMOTE).far_slip_rate == 0
    assert unit_scene(0.4, **{**REMOTE, "load": (1.0, -1.0)}).far_slip_rate == -1.2


@pytest.mark.parametrize("value", ["far", ["remote"]])
@pytest.mark.parametrize(
    ("name", "known"), [("load_on", "slot or remote"), ("mode", "in-plane or antiplane")]
)
def test_unknown_places_of_a_load_and_modes_are_refused_with_both_known(name, known, value):
    with pytest.raises(sf.SceneError, match=f"{name} must be {known}, got"):
        replace(find_scene("preloaded"), **{name: value})


@pytest.mark.parametrize("share", [0.5, 0.85, 1.0, 1.15])
def test_a_base_that_friction_does_not_hold_is_refused_whatever_the_load(share):
    """It was taken for a remote load where base - load is at rest, so that slip jumped from that of
    a load on the slot to an infinite one."""
    with pytest.raises(sf.SceneError, match="already slide") as refusal:
        unit_scene(0.2, (1.0, share), (0.0, 1.0))
    rewritten = f'write base = Tractions(1, {share - 1:g}) and load_on = "remote"'
    assert (rewritten in str(refusal.value)) is (share > 0.5)
    if share > 0.5:  # and that is a scene
        assert unit_scene(0.2, (1.0, share - 1), (0.0, 1.0), load_on="remote").far_slip_rate > 0


def test_what_is_no_remote_load_is_refused():
    with pytest.raises(sf.SceneError, match="comes as a step"):
        unit_scene(load_on="remote", shear_history=sf.Ramp(0.5))
    with pytest.raises(sf.SceneError, match=r"pressed together, .* -0\.5 in all"):
        unit_scene(load=(-1.5, 1.0), load_on="remote")
    law = sf.RateWeakening(1.0, 0.5, 1.0)
    with pytest.raises(sf.SceneError, match=r"under pressure 2\.5"):
        unit_scene(0.9, load=(1.5, 1.0), load_on="remote", law=law)
    unit_scene(0.9, load=(1.5, 1.0), law=law)


# --- the mode -----------------------------------------------------------------------------------


def test_mode_is_in_plane_unless_given_and_kept_by_documents():
    scene = find_scene("preloaded")
    out = replace(scene, mode="antiplane")
    assert (scene.mode, scene.shear_mode, scene.antiplane) == ("in-plane", "II", False)
    assert (out.mode, out.shear_mode, out.antiplane) == ("antiplane", "III", True)
    assert out != scene
    assert "mode" not in scene_document(scene)
    for problem in (scene, out):
        assert scene_from_document(scene_document(problem)) == problem


def test_first_wave_is_that_of_shear_where_it_acts_alone():
    scene = find_scene("antiplane")
    solid, soft = scene.material, sf.Material(1.0, 4.0, 0.2)
    assert scene.fastest_speed == solid.shear_speed
    assert replace(scene, lower_material=soft).fastest_speed == scene.material.shear_speed
    pressed = replace(scene, load=sf.Tractions(0.1, 1.0))
    assert pressed.fastest_speed == solid.longitudinal_speed
    assert replace(scene, mode="in-plane").fastest_speed == solid.longitudinal_speed


def test_static_modulus_knows_poisson_ratio_in_plane_only():
    scene = find_scene("antiplane")
    assert scene.static_modulus == scene.material.shear_modulus
    in_plane = replace(scene, mode="in-plane").static_modulus
    assert in_plane == pytest.approx(scene.material.shear_modulus / (1 - 1 / 3))


# --- how a scene is shown -------------------------------------------------------------------------


SCENE = NAMED_SCENES["preloaded"].scene
SHORT = {
    "plain": SCENE,
    "harmonic": replace(
        SCENE, friction=sf.SlipWeakening(0.3, 0.15, 0.1), shear_history=sf.Harmonic(2.0)
    ),
    "antiplane": replace(SCENE, mode="antiplane"),
    "table": replace(SCENE, shear_history=sf.Tabulated((0.0, 1.0), (0.0, 2.0))),
}


@pytest.mark.parametrize("name", SHORT)
def test_a_short_scene_is_made_again_by_what_it_shows(name):
    scene = SHORT[name]
    assert eval(repr(scene), vars(sf)) == scene
    assert "Step()" not in repr(scene)
    assert "Coulomb" not in repr(scene)
    assert ("mode" in repr(scene)) == (name == "antiplane")
    assert "units" not in repr(scene)
    assert "units='SI'" in repr(replace(scene, units="SI"))


def test_a_long_table_does_not_fill_the_screen():
    t = np.linspace(0, 2, 10_000)
    text = repr(replace(SCENE, shear_history=sf.Tabulated(t, np.sin(t))))
    assert "Tabulated(10000 samples, t = 0 ... 2)" in text
    assert len(text) < 300
    assert "\n" not in text
