"""Laws of scenes: falls and slopes that agree with the strength, what scenes take, files;
and the length that slip weakening gives a front."""

import copy
import math
import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.laws.kinds import law_from_table, law_table
from semianalytic.scene.scene import Material, Scene, Tractions

SCENE = NAMED_SCENES["preloaded"].scene
LAWS = (
    sf.Coulomb(0.3, cohesion=0.1, viscosity=0.7),
    sf.RateWeakening(0.3, 0.18, 1.0),
    sf.SlipWeakening(0.3, 0.12, 0.05),
    sf.SlipWeakening(0.3, 0.12, 0.05, 0.1, "exponential"),
)
any_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)


def plain(law):
    """The same strength from a class that defines nothing else."""
    return dataclass(frozen=True)(
        type("Plain", (sf.Law,), {"strength": lambda self, *given: law.strength(*given)})
    )()


@any_law
def test_falls_follow_from_the_strength_alone(law):
    own, pressure = plain(law), np.array([3.0, 1.0])
    # by differences in tenths of decades
    assert own.fall_with_rate == pytest.approx(law.fall_with_rate, rel=0.01, abs=1e-12)
    assert own.weakening(pressure) == pytest.approx(law.weakening(pressure), rel=0.2, abs=1e-12)
    free = law.strength(np.ones(1), np.zeros(1), np.zeros(1)) - law.strength(*np.zeros((3, 1)))
    assert own.coefficient == pytest.approx(float(free[0])) == law.coefficient


def test_a_strength_of_its_own_inherits_nothing_that_follows_from_another():
    @dataclass(frozen=True)
    class Half(sf.Coulomb):
        def strength(self, pressure, speed, state):
            return super().strength(pressure, speed, state) / 2

    half, unit = Half(0.3, viscosity=0.2), np.ones(1)
    assert half.slip_speed(unit, unit, 0.4, unit) == pytest.approx(0.85 / 0.5, rel=1e-12)
    assert half.rate_slope(unit, unit, unit) == pytest.approx(0.1, rel=1e-6)
    assert not half.is_rated


@pytest.mark.parametrize("law", LAWS[:2])
def test_slopes_are_derivatives_of_the_strength(law):
    pressure, speed, step = np.array([0.5, 2.0]), np.array([0.3, 1.0]), 1e-4

    def at(i, j):
        return law.strength(pressure + i * step, speed + j * step, 0 * speed)

    first = at(1, 0) - at(-1, 0), at(0, 1) - at(0, -1)
    mixed = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / 2
    twice = 2 * (at(0, 1) - 2 * at(0, 0) + at(0, -1))
    wanted = [first[0], first[1], mixed / step, twice / step]
    for slope, difference in zip(law.rate_slopes(pressure, speed), wanted, strict=True):
        np.testing.assert_allclose(slope, difference / (2 * step), rtol=1e-4, atol=1e-6)


# --- laws in scenes -------------------------------------------------------------------------------


def test_a_number_is_coulombs_law():
    assert replace(SCENE, friction=sf.Coulomb(np.float32(0.5))).friction == 0.5
    assert replace(SCENE, friction=sf.Coulomb(0.3, viscosity=0)) == SCENE
    weak = replace(SCENE, friction=sf.SlipWeakening(0.3, 0.1, 1.0))
    assert replace(weak, friction=0.3) == SCENE
    assert (weak.coefficient, SCENE.coefficient) == (0.3, 0.3)


@any_law
def test_scenes_with_laws_are_equal_and_travel(law):
    scene = replace(SCENE, friction=law)
    assert {scene} == {copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))}
    assert scene_from_document(scene_document(scene)) == scene
    assert scene != SCENE


@dataclass(frozen=True)
class Plain(sf.Law):
    """Coulomb friction of a user."""

    friction: float

    def strength(self, pressure, speed, state):
        return self.friction * pressure


def test_a_class_of_the_program_is_solved_stored_and_read_again(tmp_path):
    own = replace(SCENE, friction=Plain(0.3))
    marched, ours = (
        sf.solve(scene, method="space-time", end_time=0.5, nodes=50) for scene in (own, SCENE)
    )
    np.testing.assert_allclose(marched.interface.slip, ours.interface.slip, atol=1e-12)
    marched.save(tmp_path / "march.h5")
    assert sf.Marched.load(tmp_path / "march.h5").scene == own


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (sf.Coulomb(lambda x: 0.3 + 0 * x), "parameters that vary along x"),
        (sf.RateAndState(0.01, 0.015, 0.6, 1e-6, 1e-5), "a state other than the path"),
        (sf.ForcedFront(0.6, 0.2, 1.0), "a state other than the path"),
        (sf.Coulomb(0.3, delay=1.0), "a delay"),
        (sf.SlipWeakening(0.3, 0.4, 1.0), "a dynamic friction above the static one"),
    ],
)
def test_what_a_march_along_a_line_alone_knows_is_no_scene_of_the_exact_solver(law, said):
    scene = replace(SCENE, friction=law)
    assert scene.on_line == f"{type(law).__name__} with {said}"
    with pytest.raises(sf.SceneError, match=r"is for a Scene, .* a Scene on a line"):
        sf.solve(scene, method="self-similar")


def test_the_exact_solver_takes_laws_that_keep_similarity():
    for law in (sf.Coulomb(0.3, cohesion=0.1), sf.SlipWeakening(0.3, 0.1, 1.0)):
        with pytest.raises(sf.SceneError, match="`method` space-time"):
            sf.solve(replace(SCENE, friction=law), method="self-similar")


def test_cohesion_is_carried_without_pressure():
    """Slip under friction f p + c is that under friction (f + c / p) p, where p is uniform."""
    glued, like = (
        sf.solve(replace(SCENE, friction=law), method="space-time", end_time=1.0, nodes=100)
        for law in (sf.Coulomb(0.2, cohesion=0.1), 0.3)
    )
    np.testing.assert_allclose(glued.interface.slip, like.interface.slip, atol=1e-12)


def test_a_new_law_is_refused_where_it_is_ill_posed_or_too_sharp():
    steep, sharp = sf.RateWeakening(0.3, 0.2, 1e-3), sf.SlipWeakening(0.3, 0.2, 1e-6)
    with pytest.raises(sf.SceneError, match="faster than radiation can balance"):
        replace(SCENE, friction=plain(steep))
    with pytest.raises(sf.SceneError, match="weakens within about"):
        sf.solve(replace(SCENE, friction=plain(sharp)), method="space-time", nodes=64)


# --- laws in files and parameters by name ---------------------------------------------------------


WEAKENING = {"kind": "slip-weakening", "distance": 1}


def test_a_table_gives_dynamic_friction_or_the_part_that_is_lost():
    for fall in ({"dynamic": 0.15}, {"reduction": 0.75}):
        law = law_from_table("law", WEAKENING | {"static": 0.6} | fall)
        assert law == sf.SlipWeakening(0.6, 0.15, 1.0)
    assert law_table(law) == {"kind": "slip-weakening", "dynamic": 0.15, "distance": 1.0}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"kind": "viscous"}, "kind must be one of coulomb"),
        ({"kind": "coulomb", "friction": 0.2}, "friction is friction_law.friction; leave"),
        (WEAKENING | {"reduction": 2}, "between 0 and 1, got 2"),
        (WEAKENING | {"reduction": 0, "dynamic": 0}, "excludes dynamic"),
        ({"kind": "forced-front"}, "friction_law.dynamic is missing"),
    ],
)
def test_tables_of_scenes_are_refused_in_a_sentence(table, said):
    with pytest.raises(sf.SceneError, match=said):
        scene_from_document(scene_document(SCENE) | {"friction_law": table})


def test_a_coefficient_takes_dynamic_friction_along():
    scene = replace(SCENE, friction=sf.SlipWeakening(0.3, 0.12, 0.05))
    assert with_numbers(scene, {"friction": 0.6}).friction == sf.SlipWeakening(0.6, 0.24, 0.05)
    assert numbers_of(scene)["friction_law_reduction"].value == 0.6
    for changes in ({"friction_law_reduction": 0.5}, {"friction_law_dynamic": 0.15}):
        assert with_numbers(scene, changes).friction == sf.SlipWeakening(0.3, 0.15, 0.05)
    with pytest.raises(sf.SceneError, match="say the same"):
        with_numbers(scene, {"friction_law_reduction": 0.5, "friction_law_dynamic": 0.15})


# --- the length that slip weakening gives a front -------------------------------------------------


def weakening(law, pressure=1.0, units=1.0):
    base = Tractions(pressure * units, 0.2 * units)
    return Scene(Material(2.0 * units, 1.0, 0.25), law, base, Tractions(0.0, 0.4 * units))


def test_process_zone_is_the_stiffness_over_the_fall_of_strength_per_slip():
    law = sf.SlipWeakening(0.6, 0.2, 0.05)
    assert process_zone(weakening(law)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, pressure=2.0)) == pytest.approx(1.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(law, units=1e6)) == pytest.approx(2.0 / (0.75 * 0.4 / 0.05))
    assert process_zone(weakening(sf.RateWeakening(0.6, 0.54, 1.0))) == math.inf
    assert process_zone(weakening(sf.SlipWeakening(0.6, 0.6, 0.05))) == math.inf
    # of a remote load the pressure in place counts
    base, load = Tractions(0.0, 0.0), Tractions(1.0, 0.4)
    remote = replace(weakening(law), base=base, load=load, load_on="remote")
    assert process_zone(remote) == process_zone(weakening(law))
