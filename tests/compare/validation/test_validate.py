"""Right records agree, wrong ones differ, and what is detected is said."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.records.record import Records
from compare.validation import Conventions, validate
from docs.studies.validate.power import SPOILS, history_arrays
from semianalytic import Material, Scene, Tractions, march
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene

pytestmark = pytest.mark.usefixtures("exact_once")

PRELOADED = find_scene("preloaded")
CELLS = 100
TIMES = np.linspace(0.0, 1.0, 121)
NAMES = ("slip_rate", "slip", "shear_traction", "pressure")


@pytest.fixture(scope="module")
def solution():
    return solved(PRELOADED)


@pytest.fixture(scope="module")
def exact(solution):
    x = np.array([0.1, 0.25, 0.5, 0.75, 0.95])
    return recorded(solution, TIMES, x)


@pytest.fixture(scope="module")
def simulated():
    fem = pytest.importorskip("fem")
    return history_arrays(fem.simulate(PRELOADED, 1.0, resolution=60).interface, 1.0)


def recorded(answer, t, x):
    history = answer.history(x, t)
    return {"t": t, "x": x, **{name: getattr(history, name) for name in NAMES}}


def judged(data, scene=PRELOADED, **conventions):
    return validate(data, scene, spacing=1 / CELLS, conventions=Conventions(**conventions))


def test_exact_records_agree_in_every_row_and_nothing_is_said(exact):
    validation = judged(exact)
    assert validation.verdict == "agrees"
    assert validation.notes == ()
    assert validation.counts["differs"] == 0
    assert max(norm.L1 for norm in validation.norms) < 1e-6


@pytest.mark.thinned(2)
@pytest.mark.parametrize("samples", [40, 61])
def test_few_samples_are_no_late_arrival(solution, samples):
    """Cells are so small here that the interval of the samples is most of the bar."""
    data = recorded(solution, np.linspace(0.0, 1.0, samples), np.array([0.25, 0.5, 0.75]))
    rows = validate(data, PRELOADED, spacing=1 / 1000).rows
    arrivals = [row for row in rows if row.kind == "arrival"]
    assert len(arrivals) == 3
    assert all(row.verdict == "agrees" for row in arrivals)
    late = {**data, "t": data["t"] + 0.1}
    rows = validate(late, PRELOADED, spacing=1 / 1000).rows
    assert any(row.verdict == "differs" for row in rows if row.kind == "arrival")


@pytest.mark.thinned(2)
@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_friction_off_by_three_per_cent_differs(exact, factor):
    validation = judged(exact, replace(PRELOADED, friction=factor * PRELOADED.friction))
    assert validation.verdict == "differs"
    assert validation.notes == ()


def test_a_missing_zone_differs(exact):
    data, scene = SPOILS["no second zone"](exact, PRELOADED)
    validation = judged(data, scene)
    assert validation.verdict == "differs"
    assert validation.notes == ()


def test_finite_elements_agree_and_differ_with_other_friction(simulated):
    assert validate(simulated, PRELOADED, spacing=1 / 60).verdict == "agrees"
    other = replace(PRELOADED, friction=1.03 * PRELOADED.friction)
    assert validate(simulated, other, spacing=1 / 60).verdict == "differs"


def changed(data, **factors):
    return {**data, **{name: factor * data[name] for name, factor in factors.items()}}


def test_ten_per_cent_are_no_convention(exact):
    validation = judged(changed(exact, slip=1.1, slip_rate=1.1))
    assert validation.verdict == "differs"
    assert validation.notes == ()


@pytest.mark.slow
def test_another_time_origin_is_said_and_differs(exact):
    data = {**exact, "t": exact["t"] + 0.1}
    validation = judged(data)
    assert validation.verdict == "differs"
    assert any("if -0.1 is added" in note for note in validation.notes)
    assert judged(data, time_shift=-0.1).verdict == "agrees"


def test_unsorted_rows_and_gaps(exact):
    t, x = (grid.ravel() for grid in np.meshgrid(exact["t"], exact["x"], indexing="ij"))
    order = np.random.default_rng(1).permutation(len(t))
    data = {"t": t[order], "x": x[order], "slip_rate": exact["slip_rate"].ravel()[order]}
    data["slip_rate"][order % 7 == 3] = np.nan
    data["slip_rate"][5] = np.nan
    validation = judged(data)
    assert validation.verdict == "agrees"
    assert max(norm.L1 for norm in validation.norms) < 1e-6


def test_units_by_name(exact):
    data = {**exact, "x": 1e3 * exact["x"], "slip": 1e3 * exact["slip"]}
    data["slip_rate"] = 1e3 * exact["slip_rate"]
    spaced = validate(
        data, PRELOADED, spacing=1e3 / CELLS, conventions=Conventions(scale={"length": 1e-3})
    )
    assert spaced.verdict == "agrees"
    assert spaced.grids.spacing == pytest.approx(1 / CELLS)


def test_one_face_is_right_in_shear_and_unresolved_under_pressure(exact):
    half = changed(exact, slip=0.5, slip_rate=0.5)
    assert judged(half, slip="face").verdict == "agrees"
    scene = find_scene("remote-shock")
    data = changed(recorded(solved(scene), TIMES, exact["x"]), slip=0.5, slip_rate=0.5)
    rows = [
        row for row in judged(data, scene, slip="face").rows if row.kind in ("slip", "slip rate")
    ]
    assert {row.verdict for row in rows} == {"unresolved"}


def test_without_a_spacing_nothing_is_resolved_and_it_is_said_what_would_help(exact):
    validation = validate(exact, PRELOADED)
    assert validation.verdict == "unresolved"
    assert all("`spacing`" in row.obstacle for row in validation.rows)


def test_three_resolutions_show_orders_and_bars(exact):
    rising = [changed(exact, slip=1 + error, slip_rate=1 + error) for error in (0.04, 0.02, 0.01)]
    validation = validate(rising, PRELOADED)
    rows = {row.name: row for row in validation.rows}
    row = rows["slip all stations"]
    assert row.order == pytest.approx(1.0, abs=0.05)
    assert row.difference == pytest.approx(0.01, rel=1e-3)
    assert row.bar == pytest.approx(1.25 * 0.01, rel=0.05)
    stays = [changed(exact, slip=1.05 + error) for error in (0.04, 0.02, 0.01)]
    assert validate(stays, PRELOADED).verdict == "differs"


@pytest.mark.slow
def test_slip_rate_from_slip_if_it_is_asked_for(exact):
    data = {name: exact[name] for name in ("t", "x", "slip")}
    assert {row.kind for row in judged(data).rows} == {"slip"}
    validation = judged(data, rate_from_slip=True)
    assert "slip rate" in {row.kind for row in validation.rows}
    assert validation.verdict == "agrees"


@pytest.mark.slow
def test_a_march_is_validated_as_well():
    scene = find_scene("pulse")
    marched = march(scene, 1.0, 200)
    data = history_arrays(marched.history(np.linspace(0.02, 1.0, 50), TIMES), 1.0)
    assert validate(data, scene, spacing=1 / 200).verdict == "agrees"


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"t": [0.1], "slip": [1.0]}, "lack x"),
        ({"t": [0.1], "x": [1.0]}, "lack any of slip_rate"),
        ({"t": [0.1, 0.2], "x": [1.0], "slip": [1.0]}, "does not fit"),
        ({"t": [-0.2, -0.1], "x": 0.5, "slip": [0.0, 0.0]}, "nothing was recorded after t = 0"),
        ({"t": [0.1, 0.2], "x": 2000.0, "slip": [0.0, 0.0]}, "units of the file"),
        (Records(()), "nothing was recorded"),
        ([], "no records"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_sentence(data, sentence):
    with pytest.raises(DataFileError, match=sentence):
        validate(data, PRELOADED)


@pytest.mark.parametrize("factor", [0.0, 1.0, 2.0])
def test_stations_where_nothing_slips_do_not_decide(factor):
    """Slip reaches one station of four, late, so that a grid leaves its slip open."""
    scene = Scene(
        Material(1.0, 1.0, -0.0904), 0.9445, Tractions(1.0, -0.2405), Tractions(0.7322, 1.20705)
    )
    data = recorded(solved(scene), np.linspace(0, 1, 151)[1:], np.array([0.1, 0.3, 0.6, 0.9]))
    found = judged({**data, "slip": factor * data["slip"]}, scene)
    assert found.verdict == "unresolved"
    assert found.counts["agrees"] > 10


def test_conventions_that_are_none_are_refused():
    with pytest.raises(SceneError, match="sign must be one of as-given, reversed"):
        Conventions(sign="up")
    with pytest.raises(SceneError, match="nothing called 'mass' to scale"):
        Conventions(scale={"mass": 2.0})
    data = {"t": [0.1, 0.2], "x": 0.1, "slip": [0.0, 0.0]}
    with pytest.raises(SceneError, match="2 spacings"):
        validate(data, PRELOADED, spacing=[0.1, 0.2])


NARROW = Scene(
    Material(1.0, 1.0, -0.39553),
    0.664635,
    base=Tractions(1.0, -0.664635),
    load=Tractions(0.663173, 1.745875),
)
"""A third zone of slip is 0.016 c_t t wide, one cell of 100 over c_t T at the last station."""


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("cells", "verdict"), [(100, "unresolved"), (60, "unresolved"), (2000, "differs")]
)
def test_what_no_grid_shows_is_not_told_by_their_difference(cells, verdict):
    data = recorded(solved(NARROW), np.linspace(0.0, 1.0, 801), np.array([0.1, 0.25, 0.95]))
    for name in ("slip", "slip_rate"):
        data[name][:, 2] = 0.0
    found = validate([data, data], NARROW, spacing=[2 / cells, 1 / cells])
    rows = {row.name: row.verdict for row in found.rows}
    assert rows["slip at 0.25 c_t T"] == rows["slip rate at 0.25 c_t T"] == "agrees"
    assert rows["slip at 0.95 c_t T"] == rows["slip rate at 0.95 c_t T"] == verdict
