"""Right records agree, wrong ones differ, what is detected is said; noise is told from errors."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.records.record import QUANTITIES, Records, Stated, Unit
from compare.validation import Conventions, validate
from compare.validation.bars import MEAN_NOISE, Bar, noise_mean, pooled_bar
from compare.validation.validation import as_runs
from docs.studies.trials.validate import SPOILS, history_arrays
from semianalytic import (
    Contact,
    InterfaceLoad,
    Material,
    Scene,
    SlipWeakening,
    Tractions,
    solve,
)
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene

pytestmark = pytest.mark.usefixtures("exact_once")

PRELOADED = find_scene("preloaded")
CELLS = 100
TIMES = np.linspace(0.0, 1.0, 121)
NAMES = ("slip_rate", "slip", "shear_traction", "pressure")


@pytest.fixture(scope="module")
def exact(solution):
    return recorded(solution, TIMES, np.array([0.1, 0.25, 0.5, 0.75, 0.95]))


@pytest.fixture(scope="module")
def simulated():
    fem = pytest.importorskip("fem")
    return history_arrays(fem.simulate(PRELOADED, 1.0, resolution=40).interface, 1.0)


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
    late = {**data, "t": data["t"] + 0.1}
    right, wrong = (
        [row.verdict for row in found.rows if row.kind == "arrival"]
        for found in (validate(record, PRELOADED, spacing=1 / 1000) for record in (data, late))
    )
    assert right == 3 * ["agrees"]
    assert "differs" in wrong


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "mistake", ["no second zone", "friction +3 %", "slip times 1.1", "friction −3 %"]
)
def test_what_is_wrong_differs_and_is_no_convention(exact, mistake):
    data, scene = SPOILS[mistake](exact, PRELOADED)
    validation = judged(data, scene)
    assert validation.verdict == "differs"
    assert validation.notes == ()


def test_finite_elements_agree_and_differ_with_other_friction(simulated):
    assert validate(simulated, PRELOADED, spacing=1 / 40).verdict == "agrees"
    other = replace(PRELOADED, friction=1.03 * PRELOADED.friction)
    assert validate(simulated, other, spacing=1 / 40).verdict == "differs"


def changed(data, **factors):
    return {**data, **{name: factor * data[name] for name, factor in factors.items()}}


def test_another_time_origin_differs_and_can_be_stated(exact):
    data = {**exact, "t": exact["t"] + 0.083}
    assert judged(data).verdict == "differs"
    assert judged(data, time_shift=-0.083).verdict == "agrees"


LINE = Scene(
    Material(1.0, 1.0, 0.25),
    SlipWeakening(0.6, 0.3, 0.5),
    base=Tractions(1.0, lambda x: 0.3 + 0.02 * x),
    load=InterfaceLoad(lambda x: 0.4 * np.exp(-(x**2))),
    contact=Contact(),
    period=12.0,
    run={"end_time": 2.0, "nodes": 256},
)


@pytest.mark.parametrize("scene", ["pair-slip", "whole-line-patch", "growing-load", LINE])
def test_scenes_of_every_method_are_judged(scene):
    answer, t = solve(scene), np.linspace(0.05, 1.0, 20)
    x = np.array([0.101, 0.272, 0.551])
    x = np.append(-x, x) if answer.scene.contact.is_whole else x
    data = {"t": t, "x": x, **{name: getattr(answer, name)(x, t[:, None]) for name in QUANTITIES}}
    found = validate(data, scene, spacing=0.01)
    assert (found.verdict, len(found.norms)) == ("agrees", 4 * (1 + len(x)))
    wrong = {name: 1.4 * data[name] for name in ("slip", "slip_rate")}
    assert validate(data | wrong, scene, spacing=0.01).verdict == "differs"
    if scene is LINE:  # the base is that of each station
        change = {**data, "shear_traction": data["shear_traction"] - LINE.base.shear(x)}
        del change["pressure"]
        said = Conventions(tractions="changes")
        assert validate(change, scene, spacing=0.01, conventions=said).verdict == "agrees"


def test_unsorted_rows_and_gaps(exact):
    t, x = (grid.ravel() for grid in np.meshgrid(exact["t"], exact["x"], indexing="ij"))
    order = np.random.default_rng(1).permutation(len(t))
    data = {"t": t[order], "x": x[order], "slip_rate": exact["slip_rate"].ravel()[order]}
    data["slip_rate"][order % 7 == 3] = np.nan
    data["slip_rate"][5] = np.nan
    validation = judged(data)
    assert validation.verdict == "agrees"
    assert max(norm.L1 for norm in validation.norms) < 1e-6


def test_one_face_is_right_in_shear_and_unresolved_under_pressure(exact):
    assert judged(changed(exact, slip=0.5, slip_rate=0.5), slip="face").verdict == "agrees"
    scene = find_scene("remote-shock")
    data = changed(recorded(solved(scene), TIMES, exact["x"]), slip=0.5, slip_rate=0.5)
    verdicts = {row.kind: row.verdict for row in judged(data, scene, slip="face").rows}
    assert (verdicts["slip"], verdicts["slip rate"]) == ("unresolved", "unresolved")


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


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"t": [0.1], "slip": [1.0]}, "has no array of positions"),
        ({"t": [0.1], "x": [1.0]}, "none of it is slip_rate"),
        ({"t": [0.1, 0.2], "x": [1.0], "slip": [1.0]}, "slip has shape"),
        ({"t": [0.5], "x": 0.1, "slip": [0.0]}, r"at x = 0\.1 has 1 times; it takes 2 at least"),
        ({"t": [-0.2, -0.1], "x": 0.5, "slip": [0.0, 0.0]}, "nothing was recorded after t = 0"),
        ({"t": [0.1, 0.2], "x": 2000.0, "slip": [0.0, 0.0]}, "unit of positions or of times"),
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


def test_conventions_that_are_none_are_refused(exact):
    with pytest.raises(SceneError, match="sign must be as-given or reversed"):
        Conventions(sign="up")
    with pytest.raises(SceneError, match="nothing called 'mass' to scale"):
        Conventions(scale={"mass": 2.0})
    with pytest.raises(SceneError, match="no noise of 'gap'"):
        Conventions(noise={"gap": 1.0})
    with pytest.raises(SceneError, match="spacing must be positive, or 0 where noise is given"):
        validate(exact, PRELOADED, spacing=0.0)
    with pytest.raises(SceneError, match="2 spacings"):
        validate(exact, PRELOADED, spacing=[0.1, 0.2])


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


# --- noise of the data ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def gauges(solution):
    return recorded(solution, np.linspace(0.0, 1.0, 401), np.array([0.1, 0.25, 0.5]))


def noisy(data, seed, share=0.01):
    """Records with independent errors of a part of the largest value, and their size."""
    random = np.random.default_rng(seed)
    sizes = {name: share * np.abs(data[name]).max() for name in NAMES}
    noise = {name: sizes[name] * random.normal(size=data[name].shape) for name in NAMES}
    return {**data, **{name: data[name] + noise[name] for name in NAMES}}, sizes


@pytest.mark.thinned(6)
@pytest.mark.parametrize("seed", range(6))
def test_a_gauge_with_one_per_cent_of_noise_does_not_differ(gauges, seed):
    data, sizes = noisy(gauges, seed)
    said = Conventions(noise=sizes)
    for spacing in (0.01, 0.0):  # of a point nothing is smeared
        found = validate(data, PRELOADED, spacing=spacing, conventions=said)
        assert found.verdict == "agrees"
        assert found.counts["differs"] == 0
    assert found.detection.inferred == ()
    assert validate(data, PRELOADED, spacing=0.001).verdict == "differs"


def test_what_is_wrong_beyond_the_noise_still_differs(gauges):
    data, sizes = noisy(gauges, 1)
    said = Conventions(noise=sizes)
    more = {**data, "slip": 1.1 * data["slip"], "slip_rate": 1.1 * data["slip_rate"]}
    assert validate(more, PRELOADED, spacing=0.0, conventions=said).verdict == "differs"
    other = replace(PRELOADED, friction=1.05 * PRELOADED.friction)
    assert validate(data, other, spacing=0.0, conventions=said).verdict == "differs"


def test_bars_are_made_of_three_parts(gauges):
    said = Conventions(noise={"slip": 1e-3})
    found = validate(gauges, PRELOADED, spacing=0.01, conventions=said)
    for row in found.rows:
        assert row.bar == pytest.approx(row.grid_bar + row.data_bar + row.answer_bar)
        # an arrival is known to the interval of its samples, without noise as well
        sampled = gauges["t"][1] / gauges["t"][-1] if row.kind == "arrival" else 0.0
        assert row.data_bar == pytest.approx(sampled) or row.kind == "slip"
        assert row.data_bar > 0 or row.kind not in ("arrival", "slip")
    rows = {row.name: row for row in found.rows}
    slip, rate = rows["slip at 0.1 c_t T"], rows["slip rate at 0.1 c_t T"]
    mean = gauges["slip"][:, 0].mean()
    assert MEAN_NOISE * 1e-3 < slip.data_bar * mean < 1.2 * MEAN_NOISE * 1e-3
    assert 0 < rate.answer_bar < 1e-6
    assert found.grids.noise == {"slip": pytest.approx(1e-3)}


def test_noise_is_in_the_unit_of_the_file(gauges):
    (run,) = as_runs(gauges)
    run = replace(run, stated=Stated({"slip": Unit("mm", 1e-3)}))
    said = Conventions(noise={"slip": 1.0}, slip="half")
    found = validate(run, PRELOADED, spacing=0.01, conventions=said)
    assert found.grids.noise == {"slip": pytest.approx(2e-3)}


def test_a_mean_of_noise_is_what_samples_show():
    random = np.random.default_rng(5)
    means = np.abs(random.normal(size=(4000, 50))).mean(axis=1)
    assert means.mean() == pytest.approx(MEAN_NOISE, rel=0.01)
    assert (means > noise_mean(1 / 50)).mean() < 0.01
    assert (means > MEAN_NOISE + 0.5 * (noise_mean(1 / 50) - MEAN_NOISE)).mean() > 0.03


def test_bars_of_all_stations_are_those_of_each_by_their_size():
    bars = [Bar(0.1, 0.2, 0.3, 1.0), Bar(0.3, 0.0, 0.0, 2.0)]
    whole = pooled_bar(bars, [1.0, 3.0], 2.0)
    assert (whole.grid, whole.data) == pytest.approx((0.25, 0.05))
    assert whole.whole == pytest.approx(0.25 + 0.05 + 0.075)
    assert pooled_bar([bars[0], Bar(None)], [1.0, 1.0], 1.0).whole is None


def test_noise_that_hides_everything_is_what_stands_in_the_way(gauges):
    said = Conventions(noise={"slip": 1.0})
    found = validate(gauges, PRELOADED, spacing=0.01, conventions=said)
    (row,) = (row for row in found.rows if row.name == "slip all stations")
    assert row.verdict == "unresolved"
    assert row.obstacle.startswith("the noise of the data makes its bar")


@pytest.mark.parametrize("seed", range(2))
def test_whatever_is_unresolved_says_why(gauges, seed):
    """Noise three times as large as said lies between agreement and difference in some rows."""
    data, sizes = noisy(gauges, seed)
    said = Conventions(noise={name: size / 3 for name, size in sizes.items()})
    found = validate(data, PRELOADED, spacing=0.0, conventions=said)
    between = [row for row in found.having("unresolved") if row.bar and row.over_bar > 1]
    assert between
    assert all(row.obstacle for row in found.having("unresolved"))
    assert all("true noise" in row.obstacle for row in between if row.bar < 0.05)
