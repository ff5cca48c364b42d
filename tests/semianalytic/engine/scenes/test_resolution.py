"""What a march follows and what it refuses: loads faster than the grid, zones below it, memory."""

import json
from dataclasses import replace

import numpy as np
import pytest
from catalogue import UNIT, gone_on, unit_scene

import semianalytic as sf
from compare.comparison.documents import march_document
from docs.studies.article.stuck import stuck_shear
from semianalytic.engine import loads as grid_loads_module
from semianalytic.engine.loads import GridPressure
from semianalytic.engine.resolution import nodes_for_loads, zone_at_edge
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main
from tests.semianalytic.engine.scenes.runs import march


def sheared(history, friction=0.1, **parts):
    return unit_scene(friction, shear_history=history, **parts)


def sampled(history, count, end=1.0):
    t = np.linspace(0, end, count)
    return sf.Tabulated(tuple(t), tuple(history.value(t)))


def total_work(marched):
    return float(marched.final_work_density.sum() * marched.spacing)


# --- turns of loads ---------------------------------------------------------------------------


def brute_turn(history, width, until):
    """Largest rise and fall in windows of a fine sampling, over the largest value."""
    t = np.linspace(-0.01 * until, until, 4001)
    values, count = history.value(t), round(width / (t[1] - t[0])) + 1
    highest = 0.0
    for sign in (1, -1):
        window = np.lib.stride_tricks.sliding_window_view(sign * values, count)
        risen = window - np.minimum.accumulate(window, axis=1)
        falls = window - np.minimum.accumulate(window[:, ::-1], axis=1)[:, ::-1]
        highest = max(highest, float(np.minimum(risen, falls).max()))
    return highest / np.abs(values).max()


@pytest.mark.thinned(7)
@pytest.mark.parametrize(
    "history",
    [
        sf.Ramp(0.2),
        sf.Harmonic(5.0),
        *(sf.Pulse(0.3, shape) for shape in ("rectangle", "triangle", "half-sine", "haversine")),
    ],
)
@pytest.mark.parametrize("width", [0.05, 0.12, 0.4])
def test_turns(history, width):
    assert history.turn(width, 1.0) == pytest.approx(brute_turn(history, width, 1.0), abs=0.01)
    assert sampled(history, 400).turn(width, 1.0) == pytest.approx(
        history.turn(width, 1.0), abs=0.02
    )


def test_turns_of_random_tables():
    random = np.random.default_rng(5)
    for count in (3, 8, 30):
        t = np.sort(random.uniform(0, 1, count))
        t[1] = t[2]
        table = sf.Tabulated(tuple(t), tuple(random.standard_normal(count)))
        width = random.uniform(0.02, 0.4)
        assert table.turn(width, 1.0) == pytest.approx(brute_turn(table, width, 1.0), rel=0.15)


def test_rises_and_falls_are_no_turns():
    staircase = sf.Tabulated((0.1, 0.1001, 0.1001, 0.5, 0.5), (0.2, 0.3, 0.6, 0.6, 1.0))
    for history in (sf.Step(), sf.Ramp(1e-6), sf.Ramp(0.0), staircase):
        assert history.turn(0.5, 1.0) == 0
    assert sf.Pulse(0.5).turn(1.0, 0.4) == 0  # it does not end before
    assert sf.Harmonic(1.0).turn(1.0, 0.2) == 0


def test_integral_of_a_table_is_that_of_its_pieces():
    table = sf.Tabulated((0.2, 0.2, 0.5, 0.7, 0.7), (0.3, 0.6, -0.2, 0.1, 0.4))
    t = np.linspace(-0.2, 2.0, 45)
    np.testing.assert_allclose(table.integral(t), table.pieces.integral(t), atol=1e-15)


# --- loads that are too fast --------------------------------------------------------------------


@pytest.mark.thinned(5)
@pytest.mark.parametrize(
    "history",
    [
        sf.Harmonic(1003.0),
        sf.Harmonic(100.0),
        *(sf.Pulse(0.002, shape) for shape in ("rectangle", "triangle", "half-sine", "haversine")),
        sampled(sf.Harmonic(200.0), 1201),
        sf.Tabulated((0.3, 0.3, 0.301, 0.301), (0.0, 1.0, 1.0, 0.0)),
        sf.Tabulated((0.0, 0.5, 0.5, 0.501, 0.501), (0.0, 1.0, 1.3, 1.3, 1.0)),
    ],
)
@pytest.mark.parametrize("load", ["shear", "pressure"])
def test_what_turns_too_fast_is_refused(history, load):
    """Sampled at levels, 1003 cycles gave the answer of 3, and a short pulse none at all."""
    scene = sheared(history)
    if load == "pressure":
        scene = unit_scene(0.1, (2.0, 0.0), (0.5, 1.0), pressure_history=history)
    words = rf"the {load} history turns faster .* raise `nodes` to [0-9.e+]+,"
    with pytest.raises(sf.SceneError, match=words):
        march(scene, nodes=200)


def test_nodes_that_are_asked_for_are_enough():
    scene = sheared(sf.Harmonic(40.0))
    with pytest.raises(sf.SceneError, match="raise `nodes` to 310"):
        march(scene, end_time=0.5, nodes=100)
    assert march(scene, end_time=0.5, nodes=310, every=10**6).steps >= 310


@pytest.mark.parametrize("step_ratio", [0.1, 0.5])
def test_refused_by_the_grid_whatever_the_step(step_ratio):
    with pytest.raises(sf.SceneError, match="turns faster"):
        march(sheared(sf.Harmonic(10.0)), end_time=0.5, nodes=50, step_ratio=step_ratio)


@pytest.mark.slow
def test_more_nodes_by_default():
    scene = sheared(sf.Harmonic(400.0), friction=0.5)
    assert nodes_for_loads(scene, 0.2, 0.4, 1000)[0] == pytest.approx(1230, rel=0.02)
    assert march(scene, end_time=0.2, every=10**6).nodes > 1200
    assert march(sheared(sf.Harmonic(3.0)), end_time=0.2, every=10**6).nodes == 1000
    steel = sf.Material(80e9, 7800.0, 0.3)
    fast = replace(scene, material=steel, shear_history=sf.Harmonic(3.2e6))
    with pytest.raises(sf.SceneError, match="than 8000 nodes"):
        march(fast)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "history", [sf.Harmonic(10.0), sf.Pulse(0.06, "triangle"), sf.Pulse(0.04, "half-sine")]
)
def test_what_is_not_refused_is_right(history):
    """At the fewest nodes that are allowed: 1 to 3 % of frictional work off; sampled at 5 steps a
    cycle it was 35 %."""
    scene = sheared(history)
    least, _ = nodes_for_loads(scene, 0.5, 1.0, 16)
    coarse, fine = (
        march(scene, end_time=0.5, nodes=nodes, every=10**6) for nodes in (least, 8 * least)
    )
    assert total_work(coarse) == pytest.approx(total_work(fine), rel=0.04)
    with pytest.raises(sf.SceneError, match="turns faster"):
        march(scene, end_time=0.5, nodes=int(0.9 * least))


def test_dense_tables_take_the_mean_of_a_step():
    """Samples that alternate by a twentieth about a ramp at every half step, and between."""
    t = np.arange(801) / 800
    ripple = 0.03 * (-1.0) ** np.arange(801) * ((np.arange(801) % 4 == 0) | (t > 2))
    rough = sf.Tabulated(tuple(t), tuple(np.minimum(2 * t, 1) + np.where(t > 0, ripple, 0)))
    smooth = sf.Tabulated((0.0, 0.5), (0.0075, 1.0075))
    found, wanted = (march(sheared(h), nodes=200, every=10**6) for h in (rough, smooth))
    gap = np.abs(found.interface.slip[-1] - wanted.interface.slip[-1]).sum()
    assert gap < 2e-3 * np.abs(wanted.interface.slip[-1]).sum()


def test_a_continued_march_needs_no_other_check():
    """The loads are looked at until `latest`, for which the grid is made."""
    late = sf.Tabulated((0.0, 0.1, 0.8, 0.8, 0.801, 0.801), (0.0, 1.0, 1.0, 0.2, 0.2, 1.0))
    march(sheared(late), end_time=0.5, nodes=100, length=1.0)
    with pytest.raises(sf.SceneError, match="turns faster"):
        march(sheared(late), end_time=0.5, nodes=100, length=1.0, latest=1.0)


# --- pressure from tables -----------------------------------------------------------------------


def test_pressure_of_tables_is_that_of_the_exact_sum(monkeypatch):
    """Measured 1.1e-5 of the load at worst and 4e-8 in the mean with 1000 nodes."""
    random = np.random.default_rng(1)
    t = np.sort(random.uniform(0, 1, 60))
    table = sf.Tabulated(tuple(t), tuple(np.sin(7 * t)))
    scene = sf.Scene(UNIT, 0.3, sf.Tractions(3.0, 0.0), sf.Tractions(1.0, 0.5), table, sf.Step())
    levels = np.linspace(0.05, 1.0, 20)

    def pressures():
        return np.array(list(GridPressure(scene, 400, 2 / 400, 1.0, 1 / 400).over(levels, levels)))

    found = pressures()
    monkeypatch.setattr(grid_loads_module, "EXACT_KINKS", 1000)
    exact = pressures()
    assert np.ptp(exact) > 1
    assert np.abs(found - exact).max() < 1e-4
    assert np.abs(found - exact).mean() < 2e-6


# --- slip below the grid ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("history", "friction"), [(sf.Step(), 30.0), (sf.Ramp(0.5), 20.0), (sf.Harmonic(2.0), 5.0)]
)
def test_slip_below_the_grid_is_not_called_none(history, friction):
    scene = sheared(history, friction)
    marched = march(scene, nodes=64)
    x = marched.interface.x[0] / 50
    stuck = stuck_shear(history, 1.0, UNIT, x, marched.interface.t[1:]).value
    assert np.abs(stuck).max() > friction  # it must slip
    assert not marched.seen.slip_rate.any()  # and is not seen to
    assert marched.status == "unresolved"
    assert "raise `nodes`" in marched.caution
    document = march_document(marched)
    assert document["status"] == "unresolved"
    assert document["caution"] == marched.caution


@pytest.mark.parametrize("pressure", [-0.05, 0.0, 0.05])
def test_zone_beside_the_edge_is_as_long_as_the_exact_one(pressure):
    scene = sf.Scene(UNIT, 9.0, sf.Tractions(1.0, 0.0), sf.Tractions(pressure, 1.0))
    (zone,) = sf.solve(scene).zones
    assert zone_at_edge(scene, 1.0) == pytest.approx(zone.outer, rel=5e-3)


@pytest.mark.slow
def test_nodes_that_a_caution_asks_for_resolve_the_zone():
    scene = sheared(sf.Step(), 5.0)
    coarse = march(scene, end_time=0.5, nodes=36)
    times = float(coarse.caution.split("raise `nodes` ")[1].split()[0])
    assert coarse.status == "unresolved"
    fine, finest = (
        march(scene, end_time=0.5, nodes=int(36 * times * more), every=10**6) for more in (1, 5)
    )
    assert fine.status == "resolved"
    assert total_work(fine) == pytest.approx(total_work(finest), rel=0.05)
    assert total_work(coarse) < 0.9 * total_work(finest)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "name", ["stuck", "preloaded", "ramp", "pulse", "harmonic", "remote-shock"]
)
def test_named_scenes_are_resolved(name):
    assert march(find_scene(name), nodes=200, every=10**6).status == "resolved"
    assert (zone_at_edge(find_scene(name), 1.0) == 0) == (name == "stuck")


# --- summaries ----------------------------------------------------------------------------------


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["pulse", "harmonic", "remote-shock"])
def test_summary_does_not_depend_on_what_is_stored(name):
    scene = find_scene(name)
    whole, thin = (march(scene, nodes=150), march(scene, nodes=150, every=10**6))
    wanted, found = march_document(whole), march_document(thin)
    for document in (wanted, found):
        del document["statistics"], document["stored_levels"]
    assert found == wanted
    rate = whole.interface.slip_rate
    assert wanted["largest_slip_rate"] == np.abs(rate).max()
    assert wanted["largest_slip"] == np.abs(whole.interface.slip).max()
    slips = np.abs(rate) > 0.01 * np.abs(rate).max()
    assert wanted["reach_of_slip"] == whole.interface.x[slips.any(axis=0)].max()
    for onset in wanted["onset"]:
        if name != "remote-shock":  # where everything slips before any wave is there
            assert onset["time"] > onset["x"] / scene.material.longitudinal_speed


def test_onset_is_when_the_rate_passes_a_share_of_the_largest_until_then():
    marched = march(find_scene("ramp"), nodes=150)
    speed, t = np.abs(marched.interface.slip_rate), marched.interface.t
    until = np.maximum.accumulate(speed.max(axis=1))
    fast = speed > 0.01 * until[:, None]
    for node in range(0, 150, 7):
        first = np.flatnonzero(fast[:, node])
        onset = marched.seen.onset[node]
        if len(first):
            assert t[first[0] - 1] <= onset <= t[first[0]]
        else:
            assert np.isinf(onset)


# --- memory -------------------------------------------------------------------------------------


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "options",
    [
        ["ramp", "--length", "1e-6"],
        ["ramp", "--latest", "1e9"],
        ["ramp", "--nodes", str(10**12)],
        ["ramp", "--nodes", str(10**300)],
        ["ramp", "--latest", "1e300"],
        ["ramp", "--length", "1e-300"],
        ["ramp", "--end-time", "1e300"],
        ["ramp", "--end-time", "1e-320"],
        ["harmonic", "--nodes", "2000", "--memory", "0.001"],
        ["ramp", "--step-ratio", "1e-12"],
        ["ramp", "--memory", "-1"],
    ],
)
def test_too_large_marches_are_refused_at_once(options, capsys):
    assert main(["solve", *options]) == sf.SceneError.exit_code
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "GB of memory" in error or "must be" in error or "must lie within" in error


def test_stored_history_is_thinned_to_fit(capsys, tmp_path):
    scene = find_scene("ramp")
    whole = march(scene, nodes=200)
    thin = march(scene, nodes=200, memory=2_000_000)
    every = thin.checkpoint.every
    assert every > 1
    assert 32 * len(thin.interface.t) * 200 < 1_500_000
    assert thin.interface.t[-1] == 1.0
    np.testing.assert_array_equal(thin.interface.slip[-1], whole.interface.slip[-1])
    np.testing.assert_array_equal(thin.interface.slip[1], whole.interface.slip[every])
    assert main(["solve", "ramp", "--nodes", "200", "--memory", "0.002"]) == 0
    assert f"Every {every}th level is stored" in capsys.readouterr().err
    part = march(scene, end_time=0.5, nodes=200, length=2.0, latest=1.0)
    with pytest.raises(sf.SceneError, match="GB of memory"):
        gone_on(part, 1.0, memory=500_000)


def test_json_says_what_is_unresolved(capsys):
    assert main(["solve", "ramp", "--friction", "30", "--nodes", "50", "--json"]) == 4
    assert json.loads(capsys.readouterr().out)["status"] == "unresolved"
    assert main(["solve", "ramp", "--friction", "30", "--nodes", "50"]) == 4
    assert "unresolved" in capsys.readouterr().out
