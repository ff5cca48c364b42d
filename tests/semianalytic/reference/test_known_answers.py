"""What has a closed form, and what the published algorithm applies to."""

from dataclasses import replace

import numpy as np
import pytest

from semianalytic import Material, Ramp, Scene, SceneError, Tractions, solve
from semianalytic.reference.known_answers import (
    closed_form,
    published_answer,
    published_obstacle,
    published_unit,
)

SOLID = Material(2.0, 3.0, 0.25)
PRESSURE, SHEAR, BOTH = Tractions(1.5, 0.0), Tractions(0.0, 2.0), Tractions(1.5, 2.0)
NOTHING, HELD = Tractions(0.0, 0.0), Tractions(1.5, 1.0)
SCENES = {
    "one slow zone": Scene(SOLID, 1.2, base=PRESSURE, load=SHEAR),
    "slip everywhere": Scene(SOLID, 0.5, base=NOTHING, load=BOTH, load_on="remote"),
    "no friction": Scene(SOLID, 0.0, base=PRESSURE, load=SHEAR),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_solver_agrees_with_what_is_known(name):
    scene = SCENES[name]
    solution, known = solve(scene, rtol=1e-11), closed_form(scene)
    velocity = np.linspace(0.03, 1.6, 40) * scene.material.shear_speed
    rate = solution.slip_rate(velocity, 1.0)
    assert known.slip_rate(velocity) == pytest.approx(rate, abs=1e-9 * np.abs(rate).max())
    assert (known.edge_speed is None) == (name != "one slow zone")
    if known.edge_speed is not None:
        assert solution.zones[-1].outer == pytest.approx(known.edge_speed, rel=1e-10)


@pytest.mark.parametrize(
    "changes", [{"base": HELD}, {"load": BOTH}, {"shear_history": Ramp(0.5)}, {"load": PRESSURE}]
)
def test_other_scenes_have_no_closed_form(changes):
    with pytest.raises(SceneError, match="no closed form"):
        closed_form(replace(SCENES["one slow zone"], **changes))


def test_the_published_algorithm_knows_a_remote_shock_only():
    shock = SCENES["slip everywhere"]
    assert published_obstacle(shock) == ""
    assert published_answer(shock) is not None
    assert published_unit(shock) == pytest.approx(2 * 0.5 * 1.5 / SOLID.shear_impedance)
    for scene, why in (
        (SCENES["one slow zone"], "sudden remote"),
        (replace(shock, friction=0.0), "zero"),
        (replace(SCENES["one slow zone"], shear_history=Ramp(0.5)), "not steps"),
    ):
        assert why in published_obstacle(scene)
        assert published_answer(scene) is None
