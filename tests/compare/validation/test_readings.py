"""Units are stated; conventions are inferred where one combination alone explains a file."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.records.record import Stated, Unit
from compare.validation import Conventions, validate
from compare.validation.validation import CONVERTED, as_runs
from semianalytic import Material, Scene, Tractions
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene

pytestmark = pytest.mark.usefixtures("exact_once")

PRELOADED = find_scene("preloaded")
SHOCK = find_scene("remote-shock")
PMMA = Scene(
    Material(2.3e9, 1190.0, 0.35),
    0.9,
    base=Tractions(5e6, 2e6),
    load=Tractions(2e6, 8e6),
    units="SI",
)
END = 50e-6
PLACES = np.array([0.1, 0.25, 0.5, 0.75, 0.95])
NAMES = ("slip_rate", "slip", "shear_traction", "pressure")
LAB = {"x": 1e-3, "t": 1e-6, "slip": 1e-6, "slip_rate": 1.0, "shear_traction": 1e6, "pressure": 1e6}
"""Millimetres, microseconds, micrometres, m/s and megapascals in those of the SI."""
STRESSES = {"shear_traction": 1e6, "pressure": 1e6}


def recorded(scene, end=1.0, levels=121):
    t, x = np.linspace(0.0, end, levels), PLACES * end * scene.material.shear_speed
    history = solved(scene).history(x, t)
    return {"t": t, "x": x, **{name: getattr(history, name) for name in NAMES}}


@pytest.fixture(scope="module")
def plain():
    return recorded(PRELOADED)


@pytest.fixture(scope="module")
def lab():
    return recorded(PMMA, END)


def changed(data, **factors):
    return {**data, **{name: factor * data[name] for name, factor in factors.items()}}


def divided(data, sizes):
    return {name: value / sizes.get(name, 1.0) for name, value in data.items()}


def judged(data, scene, spacing=None, **conventions):
    spacing = spacing or data["x"][2] / 50
    return validate(data, scene, spacing=spacing, conventions=Conventions(**conventions))


def named(data, **units):
    """Records whose columns name units; their numbers are in units of the SI, as readers leave
    them."""
    (run,) = as_runs(data)
    return replace(run, stated=Stated({name: Unit(*unit) for name, unit in units.items()}))


# --- conventions ----------------------------------------------------------------------------------


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"slip": 0.5, "slip_rate": 0.5}, "slip and slip rate: half of the relative one"),
        (
            {"slip": -1, "slip_rate": -1, "shear_traction": -1},
            "slip and slip rate and shear traction: the sign is the other way",
        ),
        ({"pressure": -1}, "pressure: tension is positive"),
        (
            {"slip": -0.5, "slip_rate": -0.5, "shear_traction": -1, "pressure": -1},
            "the sign is the other way; slip and slip rate: half of the relative one, doubled; p",
        ),
    ],
)
def test_conventions_are_inferred_and_can_be_stated(plain, factors, words):
    data = changed(plain, **factors)
    found = judged(data, PRELOADED)
    assert found.verdict == CONVERTED
    assert words in "; ".join(found.inferred)
    assert found.detection.left < 1e-6 < 0.4 < found.detection.as_given
    stated = judged(data, PRELOADED, **found.detection.stating)
    assert (stated.verdict, stated.inferred) == ("agrees", ())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factors", "given", "verdict"),
    [
        ({"slip": 0.5, "slip_rate": 0.5}, {"slip": "relative"}, "differs"),
        ({"slip": 0.5, "slip_rate": 0.5}, {"slip": "half"}, "agrees"),
        ({"slip": -1, "slip_rate": -1, "shear_traction": -1}, {"sign": "as-given"}, "differs"),
        ({"slip": -1, "slip_rate": -1, "shear_traction": -1}, {"sign": "reversed"}, "agrees"),
        ({"shear_traction": -1}, {"scale": {"shear_traction": -1.0}}, "agrees"),
    ],
)
def test_what_is_given_is_not_inferred(plain, factors, given, verdict):
    found = judged(changed(plain, **factors), PRELOADED, **given)
    assert found.verdict == verdict
    if given == {"slip": "half"}:
        assert found.notes == ("slip, as given: half",)


WRONG = {
    "rate halved, slip whole": {"slip_rate": 0.5},
    "slip halved, rate whole": {"slip": 0.5},
    "shear reversed, slip not": {"shear_traction": -1},
    "slip reversed, shear not": {"slip": -1, "slip_rate": -1},
    "slip a thousand times too large": {"slip": 1e3},
    "pressure zero": {"pressure": 0.0},
    "shear alone in other units": {"shear_traction": 1e-6},
    "pressure alone in other units": {"pressure": 1e-6},
    "pressure halved": {"pressure": 0.5},
}


@pytest.mark.thinned(10)
@pytest.mark.parametrize("factors", WRONG.values(), ids=WRONG)
def test_no_quantity_is_mended_by_itself(plain, factors):
    assert judged(changed(plain, **factors), PRELOADED).verdict == "differs"


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("factor", "verdict"), [(1, "agrees"), (0.5, "differs"), (30, "differs"), (-1, CONVERTED)]
)
def test_normal_stress_has_one_size_and_either_sense(lab, factor, verdict):
    """Any factor would pass as a change since t = 0 if the base were much larger."""
    assert judged(changed(lab, pressure=factor), PMMA).verdict == verdict


@pytest.mark.slow
def test_tractions_are_changes_together_where_one_is_seen_to_be(plain, lab):
    changes = dict(lab)
    changes["shear_traction"] = lab["shear_traction"] - PMMA.base.shear
    mixed = judged(changes, PMMA)
    assert mixed.verdict == "differs"
    changes["pressure"] = lab["pressure"] - PMMA.base.pressure
    found = judged(changes, PMMA)
    assert found.verdict == CONVERTED
    assert "changes since t = 0" in found.detection.inferred[0]
    assert judged(changes, PMMA, tractions="changes").verdict == "agrees"
    assert judged(changes, PMMA, tractions="total").verdict == "differs"
    # nothing changes here, so that pressure which is left out could as well be a change
    silent = {**plain, "pressure": plain["pressure"] - PRELOADED.base.pressure}
    assert judged(silent, PRELOADED).verdict == "differs"
    assert judged(silent, PRELOADED, tractions="changes").verdict == "agrees"


def test_a_sense_that_does_not_show_is_as_given():
    scene = replace(PMMA, load=Tractions(0.0, 8e6))  # pressure does not change
    data = recorded(scene, END)
    data["shear_traction"] = data["shear_traction"] - scene.base.shear
    data["pressure"] = data["pressure"] - scene.base.pressure
    assert judged(data, scene).detection.stating == {"tractions": "changes"}


@pytest.mark.slow
def test_changes_under_a_load_from_afar_are_those_of_what_is_on_the_contact_with_it():
    data, held = recorded(SHOCK), SHOCK.superposition.in_place
    assert (held.shear, held.pressure) != (SHOCK.base.shear, SHOCK.base.pressure)
    data["shear_traction"] = data["shear_traction"] - held.shear
    data["pressure"] = data["pressure"] - held.pressure
    found = judged(data, SHOCK)
    assert found.verdict == CONVERTED
    assert "changes since t = 0" in found.detection.inferred[0]
    assert judged(data, SHOCK, tractions="changes").verdict == "agrees"


def test_where_two_conventions_fit_none_is_taken():
    """Numbers of minus half of the base are pressure in tension, or its change since t = 0."""
    scene = Scene(Material(1.0, 1.0, 0.25), 0.3, base=Tractions(1, 0), load=Tractions(-0.5, 0))
    t, x = np.linspace(0.38, 0.42, 41), np.array([0.05])
    assert solved(scene).pressure(x, t) == pytest.approx(0.5, abs=0.07)
    found = judged({"t": t, "x": x, "pressure": np.full(41, -0.5)}, scene, 0.01)
    assert (found.verdict, found.inferred) == ("differs", ())
    assert "several fit, pressure: tension is positive, or pressure: changes" in found.notes[0]


def test_means_over_steps_are_inferred_or_stated():
    t, x = np.linspace(0.0, 1.0, 41), PLACES
    solution = solved(PRELOADED)
    slip = solution.slip(x, t[:, None])
    rate = np.diff(slip, axis=0, prepend=0.0) / (t[1] - t[0])
    data = {"t": t, "x": x, "slip_rate": rate, "slip": slip}
    found = judged(data, PRELOADED, 0.01)
    assert found.verdict == CONVERTED
    assert found.detection.inferred == ("slip rate: the mean over the step before its time",)
    assert judged(data, PRELOADED, 0.01, rate="before").verdict == "agrees"
    (run,) = as_runs(data)
    run = replace(run, stated=Stated(mean="before"))
    assert validate(run, PRELOADED, spacing=0.01).verdict == "agrees"


# --- units ----------------------------------------------------------------------------------------


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("sizes", "scale", "hint"),
    [
        (LAB, {"length": 1e-3, "time": 1e-6, "stress": 1e6, "slip": 1e-6, "slip_rate": 1.0}, "x="),
        ({"x": 1e3}, {"x": 1e3}, "the outermost station lies at 0.0"),
        (STRESSES, {"stress": 1e6}, "(scale shear_traction=1e+06, pressure=1e+06)"),
        ({"slip": 1e-6}, {"slip": 1e-6}, "answer: slip 1e+06; if"),
    ],
)
def test_units_are_stated_and_never_inferred(lab, sizes, scale, hint):
    data = divided(lab, sizes)
    found = judged(data, PMMA)
    assert (found.verdict, found.inferred) == ("differs", ())
    (note,) = found.notes
    assert hint in note
    stated = judged(data, PMMA, scale=scale)
    assert (stated.verdict, stated.inferred) == ("agrees", ())
    # the grid is in the unit of the positions
    length = stated.exact.end_time * PMMA.material.shear_speed
    assert stated.grids.spacing == pytest.approx(length / 100, rel=1e-6)


MISNAMED = {
    "slip off by 1000": ({"slip": 1e3}, {"slip": ("m", 1.0)}),
    "t [ms] over microseconds": ({"t": 1e3}, {"t": ("ms", 1e-3)}),
    "[psi] over pascals": (
        {"shear_traction": 6894.757, "pressure": 6894.757},
        {"shear_traction": ("psi", 6894.757), "pressure": ("psi", 6894.757)},
    ),
    "[furlong/s]": ({"slip_rate": 201.168}, {"slip_rate": ("furlong/s", 201.168)}),
    "[thou]": ({"slip": 2.54e-5}, {"slip": ("thou", 2.54e-5)}),
    "[min]": ({"t": 60.0}, {"t": ("min", 60.0)}),
}
"""Factors by which the numbers are wrong, and the units that the header names."""


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("factors", "units"), MISNAMED.values(), ids=MISNAMED)
def test_a_named_unit_is_never_overruled(lab, factors, units):
    run = named(changed(lab, **factors), **units)
    try:
        found = validate(run, PMMA, spacing=run.stations[2].x / 50).verdict
    except DataFileError as error:
        found = str(error)
    assert found == "differs" or "no station lies on the contact" in found
    right = named(lab, **units)
    assert validate(right, PMMA, spacing=lab["x"][2] / 50).verdict == "agrees"


def test_a_scale_beside_a_named_unit_is_refused(lab):
    run = named(lab, slip=("mm", 1e-3))
    with pytest.raises(SceneError, match="the file says that slip is in mm"):
        validate(run, PMMA, spacing=1.0, conventions=Conventions(scale={"slip": 1e-3}))
    whole = validate(
        named(divided(lab, {"x": 1e-3, "t": 1e-3}), slip=("mm", 1e-3), slip_rate=("m/s", 1.0)),
        PMMA,
        spacing=lab["x"][2] / 50 / 1e-3,
        conventions=Conventions(scale={"length": 1e-3, "time": 1e-3}),
    )
    assert whole.verdict == "agrees"


def test_a_quantity_alone_may_be_read_in_the_other_sense():
    scene = find_scene("lift-off")
    data = recorded(scene)
    data = {"t": data["t"], "x": data["x"], "pressure": data["pressure"]}
    assert judged(data, scene).verdict == "agrees"
    tension = judged(changed(data, pressure=-1), scene)
    assert tension.verdict == CONVERTED
