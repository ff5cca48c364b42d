"""Slip beside what is open: laws, symmetry, honest estimates, and where the motion ends."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import REMOTE, unit_scene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from laws import check_invariants, opening_scene

from semianalytic import Coulomb, solve
from semianalytic.cut.load import scaled_load
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.regimes import opening_threshold
from semianalytic.selfsimilar.zones.collocation import slip_on_grid
from semianalytic.separation.opening import with_opening


def tapped(friction=0.3, shear=1.0, base=0.02, held=0.0, **rest):
    """A sudden pressure of 1, and shear, on a small base."""
    return unit_scene(friction, (base, held), (1.0, shear), **rest)


def lifted(friction=0.3, shear=1.0, held=0.0, **rest):
    """A pressure put on the slot faces."""
    return unit_scene(friction, (1.0, held), (-1.0, shear), **rest)


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 10**9))
def test_laws_hold_in_scenes_that_open(seed):
    check_invariants(opening_scene(np.random.default_rng(seed)))


@pytest.mark.parametrize("scene", [lifted(), lifted(held=-0.2), tapped(held=0.003), tapped(0.5)])
def test_laws_hold_out_of_the_plane(scene):
    check_invariants(replace(scene, mode="antiplane"))


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("nu", "friction", "base", "shear"),
    [(-0.467, 0.4257, (0.0539, 0.0), 3.942), (-0.279, 0.0426, (0.0599, -0.00027), -0.4932)],
)
def test_laws_hold_where_a_zone_opens_between_the_shear_front_and_an_opening(
    nu, friction, base, shear
):
    """From the guess, that it opens ahead of that front, its edge runs into it."""
    scene = unit_scene(friction, base, (1.0, shear), nu=nu, mode="antiplane")
    solution = solve(scene)
    assert solution.openings[0].outer < 0.97 < solution.zones[-1].outer < 1
    check_invariants(scene)


@pytest.mark.parametrize("scene", [tapped(shear=0.0), lifted(shear=0.0)])
def test_nothing_moves_along_the_interface_without_shear(scene):
    solution = solve(scene)
    assert solution.zones == ()
    assert len(solution.openings) == 1
    x = np.linspace(0.05, 2.1, 60)
    for name in ("slip_rate", "slip", "shear_traction", "path"):
        assert np.all(getattr(solution, name)(x, 1.0) == 0), name
    assert solution.accumulated_slip(1.0) == 0


@pytest.mark.thinned(2)
@pytest.mark.parametrize("scene", [tapped(held=0.004), lifted(held=0.2), tapped(5.0, 0.1)])
def test_reversed_shear_reverses_slip(scene):
    base, load = (replace(traction, shear=-traction.shear) for traction in (scene.base, scene.load))
    solution, mirrored = solve(scene), solve(replace(scene, base=base, load=load))
    assert mirrored.openings == solution.openings
    assert [zone.sense for zone in mirrored.zones] == [-zone.sense for zone in solution.zones]
    x = np.linspace(0.05, 2.1, 60)
    for name in ("slip_rate", "slip", "shear_traction"):
        there, here = (getattr(answer, name)(x, 1.0) for answer in (mirrored, solution))
        np.testing.assert_allclose(there, -here, rtol=0, atol=1e-9)


def test_friction_decides_whether_slip_goes_on_behind_a_closing_edge():
    """Strength rises behind it like the root of the distance, and so does a stuck traction."""
    slips, sticks = solve(tapped(0.3)), solve(tapped(20.0))
    (opening,) = slips.openings
    assert sticks.openings[0].inner == pytest.approx(opening.inner, rel=1e-12)
    assert slips.zones[0].outer == opening.inner
    assert slips.zones[-1].inner == sticks.zones[0].inner == pytest.approx(opening.outer)
    assert len(sticks.zones) == 1
    beside = opening.inner * (1 - np.array([1e-6, 1e-5, 1e-4]))
    ratio = sticks.shear_traction(beside, 1.0) / (20.0 * sticks.pressure(beside, 1.0))
    assert np.ptp(ratio) < 0.01
    assert 0 < ratio[0] < 1
    rate = sticks.slip_rate(opening.inner * (1 + np.array([1e-7, 4e-7])), 1.0)
    assert rate[1] / rate[0] == pytest.approx(2.0, rel=0.01)


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    ("nu", "friction", "base", "load_shear"),
    [
        (0.449, 0.805, (0.0151, -0.00461), -0.262),  # no lawful zones were found
        (0.0086, 0.175, (0.0265, 0.00154), 0.0723),  # 25 sets were tried
        (0.267, 0.911, (0.0035, 0.00109), -0.372),
        (0.00119, 0.769, (0.0102, -0.00206), 0.362),
        (0.309, 0.658, (7.42e-4, 6.2e-5), 0.379),
        (0.261, 0.261, (4.8e-4, 1.12e-4), -0.838),
    ],
)
def test_slip_that_begins_where_an_opening_closes_is_soon_one_with_it(
    nu, friction, base, load_shear
):
    """It is no zone of its own, as grids and nodes of loose rules show it."""
    scene = unit_scene(friction, base, (1.0, load_shear), nu=nu)
    solution = solve(scene, rtol=1e-6)
    check_invariants(scene)
    (opening,) = solution.openings
    assert solution.status == "converged"
    assert any(zone.outer == pytest.approx(opening.inner) for zone in solution.zones)
    assert solution.statistics.zone_sets <= 3


def test_slip_may_change_sense_across_an_opening():
    solution = solve(tapped(1.0, -1.0, held=0.0183))
    (opening,) = solution.openings
    behind, ahead = solution.zones
    assert (behind.outer, ahead.inner) == (opening.inner, opening.outer)
    assert (behind.sense, ahead.sense) == (-1, 1)


FILM = {"law": Coulomb(1.0, viscosity=0.25)}


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    "scene",
    [
        tapped(),
        tapped(3.0),
        tapped(1.0, -1.0, held=0.018),
        lifted(),
        lifted(**FILM),
        tapped(mode="antiplane"),
        tapped(shear=0.5, mode="antiplane", **FILM),
        tapped(shear=0.5, law=Coulomb(1.0, viscosity=0.5)),
        tapped(shear=0.5, **FILM),
        unit_scene(0.5, **REMOTE, **FILM),
    ],
)
def test_slip_agrees_with_complementarity_on_a_grid(scene):
    solution, nu = solve(scene, rtol=1e-6), scene.material.poisson_ratio
    load, stress = scaled_load(scene)
    load, _ = with_opening(load, rayleigh_factors(nu, scene.shear_mode), 1e-6)
    grid = slip_on_grid(nu, load, 300, scene.shear_mode)
    inside = np.linspace(grid.xi[:-1], grid.xi[1:], 6)[1:-1]
    rate = solution.slip_rate(inside.ravel(), 1.0).reshape(inside.shape).mean(axis=0)
    seen = stress * (grid.slip_rate[1:] + grid.slip_rate[:-1])  # relative, averaged
    error = np.abs(rate - seen) @ np.diff(grid.xi)
    assert error < 0.01 * np.abs(rate) @ np.diff(grid.xi)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [tapped(), tapped(1.0, -1.0, held=0.018), lifted(held=-0.2)])
def test_motion_while_open_counts_as_slip_and_takes_no_work(scene):
    solution = solve(scene)
    (opening,) = solution.openings
    assert np.all(solution.frictional_power(2.0, 2 * opening.inner, 2 * opening.outer) < 1e-12)
    x = np.maximum(np.linspace(0.0, 2.0, 4001), 1e-9)
    path, slip = solution.path(x, 1.0), solution.slip(x, 1.0)
    assert np.all(path >= np.abs(slip) - 1e-12)
    # by self-similarity the integral of path over x is half that of |slip rate| over x/t
    total = np.trapezoid(np.abs(solution.slip_rate(x, 1.0)), x) / 2
    assert solution.accumulated_slip(1.0) == pytest.approx(total, rel=2e-3)
    assert np.trapezoid(path, x) == pytest.approx(total, rel=2e-3)
    assert solution.max_slip(1.0) >= np.abs(slip).max() * (1 - 1e-9)


def test_a_base_at_friction_that_hardly_slips_the_wrong_way_at_the_front_is_seen_at_once():
    """The loose rule lets the first zone begin at the longitudinal front, 1e-4 too early."""
    friction, base = 0.0144115, 1.0
    scene = unit_scene(friction, (base, friction * base), (-53624.4, -8136.1), nu=0.1358)
    solution = solve(scene, rtol=1e-5)
    assert solution.status == "converged"
    assert solution.zones[-1].outer < scene.material.longitudinal_speed - 1e-4
    assert solution.statistics.zone_sets <= 3


def test_slip_at_the_front_is_mended_at_a_strict_tolerance_too():
    """The strip is 2e-5 wide, and beside the front slip rate is below rounding of the rule."""
    friction, base = 0.0021214, 0.0270694
    scene = unit_scene(friction, (base, friction * base), (-1.0, 0.114371), nu=-0.212977)
    solution = solve(scene, rtol=1e-11)
    assert solution.status == "converged"
    assert [zone.sense for zone in solution.zones] == [1, -1, 1]
    assert solution.statistics.zone_sets <= 3


CLEAR = 0.03
FIELDS = ("slip", "path", "work_density", "gap")
TOTALS = ("frictional_power", "frictional_work", "accumulated_slip", "max_slip")


def relative(found, known):
    """The largest difference over the largest known value."""
    return float(np.abs(found - known).max() / max(np.abs(known).max(), 1e-300))


def errors(solution, exact):
    """Errors that an estimate is to bound, by name."""
    scene, speed = exact.scene, exact.scene.material.longitudinal_speed
    marks = [exact.scene.material.rayleigh_speed]
    result = {}
    if [zone.sense for zone in solution.zones] == [zone.sense for zone in exact.zones]:
        ends, known = (
            np.array([(part.inner, part.outer) for part in (*entry.zones, *entry.openings)]).ravel()
            for entry in (solution, exact)
        )
        result["edges"] = np.abs(ends - known).max(initial=0.0)
        marks += known.tolist()
    marks = np.array(marks)
    steps = CLEAR * np.array([1.0, 1.1, 1.5, 3.0])
    x = np.concatenate(
        [np.linspace(0.002, 1.1, 1500) * speed, np.add.outer(marks, [*steps, *-steps]).ravel()]
    )
    x = x[x > 0]
    far = np.abs(x[:, None] - marks).min(axis=1) >= 0.999 * CLEAR
    for name in ("slip_rate", "gap_rate"):
        result[name] = relative(*(getattr(entry, name)(x, 1.0)[far] for entry in (solution, exact)))
    found, known = (answer.shear_traction(x, 1.0)[far] for answer in (solution, exact))
    result["shear"] = (np.abs(found - known) / (exact.stress_unit + np.abs(known))).max()
    found, known = (answer.pressure(x, 1.0)[far] for answer in (solution, exact))
    size = scene.base.pressure + abs(scene.load.pressure)
    result["pressure"] = (np.abs(found - known) / np.maximum(size + known, 1e-300)).max()
    parts = (*exact.zones, *exact.openings)  # they may lie between two positions
    x = np.concatenate([x, *(np.linspace(part.inner, part.outer, 42)[1:-1] for part in parts)])
    for name in FIELDS:
        result[name] = relative(*(getattr(answer, name)(x, 1.0) for answer in (solution, exact)))
    for name in TOTALS:
        result[name] = relative(*(getattr(answer, name)(1.0) for answer in (solution, exact)))
    found, known = (answer.frictional_power(1.0, x[x < 2.2][::20]) for answer in (solution, exact))
    result["power of a part"] = np.abs(found - known).max() / max(
        float(exact.frictional_power(1.0)), 1e-300
    )
    result["edge slip rate"] = relative(solution.edge_slip_rate, exact.edge_slip_rate)
    pairs = zip(*(answer.stress_intensity(1.0) for answer in (solution, exact)), strict=True)
    return result | {f"K {mode}": relative(*pair) for mode, pair in enumerate(pairs)}


def check_estimates(seeds):
    """Whether estimates bound all errors against solutions of ten digits."""
    checked = 0
    for seed in seeds:
        random = np.random.default_rng(seed)
        scene, rtol = opening_scene(random), 10 ** random.uniform(-8, -3)
        exact, solution = solve(scene, rtol=1e-10), solve(scene, rtol=rtol)
        assert solution.status == "converged", scene
        if exact.error_estimate > 1e-9:
            continue  # rounding does not leave nine digits
        checked += 1
        bound = solution.error_estimate + exact.error_estimate
        for name, error in errors(solution, exact).items():
            assert error <= bound, (name, error, bound, seed, scene)
    assert checked > 0.8 * len(seeds)


@pytest.mark.thinned(4)
@pytest.mark.parametrize("seed", [1058, 1074, 1121, 1258, 1176])
def test_estimates_bound_work_on_narrow_slip_ahead_of_an_opening(seed):
    """Pressure is small there, and friction works nowhere else; the last works between nodes."""
    check_estimates([seed])


@pytest.mark.slow
def test_estimates_bound_errors():
    """Twenty openings are drawn; the campaign of docs/how_we_know.md draws thousands of scenes."""
    check_estimates(range(1000, 1020))


@pytest.mark.thinned(4)
@pytest.mark.parametrize("nu", [-0.5, 0.2, 0.45])
@pytest.mark.parametrize("below", [1e-3, 1e-4, 1e-6])
def test_estimates_cover_the_gap_of_narrow_openings(nu, below):
    """Just below the threshold, where the gap follows the width of the opening."""
    base = opening_threshold(nu) * (1 - below)
    scene = unit_scene(0.3, (base, 0.0), (1.0, 0.0), nu=nu)
    exact = solve(scene, rtol=1e-9)
    (opening,) = exact.openings
    angle = np.linspace(0, np.pi, 200)[1:-1]
    x = opening.inner + (opening.outer - opening.inner) * np.sin(angle / 2) ** 2
    weight, gap = np.sin(angle), exact.gap(x, 1.0)
    for rtol in (1e-3, 1e-5):
        solution = solve(scene, rtol=rtol)
        error = weight @ np.abs(solution.gap(x, 1.0) - gap) / (weight @ gap)
        assert error < solution.error_estimate <= rtol


@pytest.mark.parametrize("lift", [1e-6, 1e-9, 5e-10, 1e-12])
def test_openings_of_no_width_change_nothing(lift):
    """A wave that hardly lifts the contact opens (lift)^2 of it; slip is as without the lift."""
    scene = unit_scene(0.3, (1.0, 0.1), (-lift, 0.15), nu=0.25, load_on="remote")
    solution = solve(scene)
    assert solution.status == "converged"
    assert 0 < solution.openings[0].outer < 2 * lift**2
    # c_t / ((1 - nu) (1 + chi)^2) with what is missing to friction over the step, chi = 1/3
    assert solution.zones[0].outer == pytest.approx(0.75, abs=4 * lift + 1e-9)
