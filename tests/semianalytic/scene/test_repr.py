"""A scene is shown on one line, and a short one as it is made."""

from dataclasses import replace

import numpy as np
import pytest

import semianalytic
from semianalytic import Harmonic, SlipWeakening, Tabulated
from semianalytic.scene.given.named import NAMED_SCENES

SCENE = NAMED_SCENES["preloaded"].scene
SHORT = {
    "plain": SCENE,
    "harmonic": replace(SCENE, shear_history=Harmonic(2.0), friction_law=SlipWeakening(0.5, 0.1)),
    "antiplane": replace(SCENE, mode="antiplane"),
    "table": replace(SCENE, shear_history=Tabulated((0.0, 1.0), (0.0, 2.0))),
}


@pytest.mark.parametrize("name", SHORT)
def test_a_short_scene_is_made_again_by_what_it_shows(name):
    scene = SHORT[name]
    assert eval(repr(scene), vars(semianalytic)) == scene
    assert "Step()" not in repr(scene)
    assert "CoulombFriction" not in repr(scene)
    assert ("mode" in repr(scene)) == (name == "antiplane")
    assert "units" not in repr(scene)
    assert "units='SI'" in repr(replace(scene, units="SI"))


def test_a_long_table_does_not_fill_the_screen():
    t = np.linspace(0, 2, 10_000)
    text = repr(replace(SCENE, shear_history=Tabulated(t, np.sin(t))))
    assert "Tabulated(10000 samples, t = 0 ... 2)" in text
    assert len(text) < 300
    assert "\n" not in text
