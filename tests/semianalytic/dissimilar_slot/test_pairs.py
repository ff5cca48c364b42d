"""The solver of two bodies on random and named pairs: like bodies, units, law, honest errors."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import under
from dissimilar_pairs import scene
from two_body_march import march

import slipfront as sf
from docs.studies.dissimilar.pairs import SCENES, error_of, random_pair
from semianalytic.dissimilar_slot.solver import coupled
from semianalytic.scene.given.finding import scene_label
from slipfront.cli.scenes.completion import scene_names

X = np.linspace(0.02, 1.95, 160)
NAMED_PAIRS = ("pair-slip", "pair-opening")
every_name = pytest.mark.parametrize("name", NAMED_PAIRS)


def random_scene(rng):
    """One solid on both sides: slip, openings from the edge, viscous films, several zones."""
    solid = sf.Material(*rng.uniform(0.5, 2, 2), rng.uniform(-0.3, 0.45))
    friction, kind = rng.uniform(0.05, 0.8), rng.integers(0, 4)
    base = sf.Tractions(1.0, rng.uniform(-0.9, 0.9) * friction * (rng.random() < 0.5))
    shear, size = rng.normal() * friction, abs(rng.normal()) / 2
    load = sf.Tractions([0.0, size, -size, 2 * rng.normal()][kind], shear)
    viscous = rng.random() < 0.25 and load.pressure == 0
    film = rng.uniform(0, 2) * solid.shear_impedance
    law = sf.Coulomb(friction, viscosity=film if viscous else 0.0)
    return sf.Scene(solid, law, base, load)


def check_like_bodies(given, accuracy):
    """A scene through the solver of two bodies is what `solve` says."""
    known = sf.solve(given, rtol=accuracy)
    solids = (given.material, given.material)
    found = coupled(sf.Scene(solids[0], given.friction, given.base, given.load), accuracy)
    assert found.status == "converged"
    speed = given.material.shear_speed
    assert len(found.zones) == len(known.zones)
    np.testing.assert_allclose(found.edge_speeds, known.edge_speeds, atol=accuracy * speed)
    edges = [*known.edge_speeds.ravel(), given.material.rayleigh_speed]
    edges += [end for part in known.openings for end in (part.inner, part.outer)]
    x = X * speed
    x = x[np.abs(x[:, None] - edges).min(axis=1) > 0.03 * speed]
    for name in ("slip_rate", "slip", "gap", "gap_rate", "pressure", "shear_traction"):
        first, other = (getattr(answer, name)(x, 1.0) for answer in (found, known))
        scale = np.abs(getattr(known, name)(X * speed, 1.0)).max(initial=1e-300)
        assert np.abs(first - other).max() <= accuracy * max(scale, 1e-6), name
    assert found.frictional_work(2.0) == pytest.approx(
        known.frictional_work(2.0), rel=1e-7, abs=1e-12
    )
    assert found.max_slip(2.0) == pytest.approx(known.max_slip(2.0), rel=1e-7, abs=1e-12)


@pytest.mark.thinned(16)
@pytest.mark.parametrize("seed", range(16))
def test_like_bodies_have_the_answer_of_solve(seed):
    given = random_scene(np.random.default_rng([1, seed]))
    film = not isinstance(given.friction, float)
    check_like_bodies(given, 1e-9 if film or abs(given.load.shear) < 1e-3 else 1e-10)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["slip from the slot", "slip and opening"])
def test_units_do_not_matter(name):
    pair, stress, speed, t = SCENES[name], 3e6, 2000.0, 3e-4
    density = 5e9 / speed**2
    upper, lower = (
        sf.Material(5e9 * solid.shear_modulus, density * solid.density, solid.poisson_ratio)
        for solid in (pair.material, pair.lower_material)
    )
    base, load = (
        sf.Tractions(stress * item.pressure, stress * item.shear) for item in (pair.base, pair.load)
    )
    first, other = (
        sf.solve(given)
        for given in (
            pair,
            replace(pair, material=upper, lower_material=lower, base=base, load=load),
        )
    )
    np.testing.assert_allclose(other.edge_speeds, speed * first.edge_speeds, rtol=1e-11)
    for field, x, unit, within in (
        ("slip_rate", 0.17, stress / (density * speed), 1e-10),
        ("gap", 0.02, stress * speed * t / 5e9, 1e-9),
        ("pressure", 0.17, stress, 1e-11),
    ):
        found = getattr(other, field)(x * speed * t, t) / unit
        assert found == pytest.approx(getattr(first, field)(x, 1.0), rel=within, abs=1e-15)


def check_law(answer, rtol):
    """Coulomb's law and contact hold at many points, and slip is the integral of its rate."""
    pair = answer.scene
    speeds = [pair.material.longitudinal_speed, pair.lower_material.longitudinal_speed]
    x = np.concatenate([np.geomspace(1e-3, 0.05, 40), np.linspace(0.05, max(speeds), 400)])
    rate, shear = answer.slip_rate(x, 1.0), answer.shear_traction(x, 1.0)
    pressure, gap = answer.pressure(x, 1.0), answer.gap(x, 1.0)
    film = getattr(pair.law, "viscosity", 0.0)
    unit = pair.coefficient * (pair.base.pressure + np.abs(pressure)) + np.abs(shear)
    strength = pair.coefficient * pressure + film * np.abs(rate)
    assert np.all(pressure >= -100 * rtol * (1 + np.abs(pressure)))
    assert np.all(gap >= 0)
    assert np.all(np.abs(shear) <= strength + 100 * rtol * unit)
    slips = (np.abs(rate) > 1e-5 * np.abs(rate).max(initial=0.0)) & (gap == 0)
    held = shear[slips] * np.sign(rate[slips])
    np.testing.assert_allclose(held, strength[slips], rtol=1e-9, atol=1e-12)
    assert np.all(gap[shear != 0] == 0)
    # x du/dx at fixed t is t (u - t V) / t for slip of degree 1: differences of the slip itself
    place, step = x[::40], 1e-5
    change = answer.slip(place, 1 + step) - answer.slip(place, 1 - step)
    scale = np.abs(rate).max(initial=1e-300)
    clear = np.abs(np.diff(answer.slip_rate(place, np.array([[0.99], [1.01]])), axis=0))[0]
    smooth = clear < 0.1 * scale
    error = change / (2 * step) - answer.slip_rate(place, 1.0)
    assert np.all(np.abs(error[smooth]) < 1e-3 * scale)


@pytest.mark.thinned(20)
@pytest.mark.parametrize("seed", [4, *range(4), *range(5, 20)])
def test_errors_of_random_pairs_are_below_their_estimates(seed):
    pair = random_pair(np.random.default_rng([2, seed]))
    try:
        exact = sf.solve(pair, rtol=1e-10)
    except sf.SceneError:
        assert seed not in (1, 4)
        return
    assert np.isfinite(exact.error_estimate)
    check_law(exact, 1e-9)
    for rtol in (1e-4, 1e-6, 1e-8):
        answer = sf.solve(pair, rtol=rtol)
        assert answer.status == "converged"
        error = error_of(answer, exact)
        if error is not None:  # else there are zones next to the edge that rtol leaves out
            assert error <= answer.error_estimate


def compared(pair, nodes, reach):
    """L1 differences of slip rate and pressure from a march, and its answer.

    Beside a stuck edge of different bodies the nodal pressure alternates by a share of j^(-1/2) at
    the j-th node on every grid, for the symbol of the grid jumps at its Nyquist frequency
    (docs/dissimilar.md): means of three neighbours are compared, of the march and of the answer.
    """
    answer = sf.solve(pair, rtol=1e-5)
    marched = march(pair, nodes, reach, getattr(pair.law, "viscosity", 0.0))
    x = marched.velocity
    clear = x[1:-1] > 0.03
    result = []
    for name in ("slip_rate", "pressure"):
        exact, found = getattr(answer, name)(x, 1.0), getattr(marched, name)
        exact, error = ((f[:-2] + 2 * f[1:-1] + f[2:])[clear] for f in (exact, found - exact))
        result.append(np.abs(error).sum() / np.abs(exact).sum())
    return answer, marched, result


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "reach", "rate", "pressure"),
    [
        ("slip from the slot", 0.8, 0.017, 0.00023),
        ("two zones", 1.3, 0.01, 0.0006),
        ("slip and opening", 0.8, 0.017, 0.008),
        ("film", 1.3, 0.01, 0.0017),
        ("both senses", 2.4, 0.036, 0.0098),
        ("detached opening", 2.0, 0.0074, 0.012),
    ],
)
def test_a_march_converges_to_the_answer(name, reach, rate, pressure):
    """On 512 nodes within some 4/3 of what was found; four times the nodes leave a quarter."""
    answer, marched, fine = compared(SCENES[name], 2048, reach)
    _, _, coarse = compared(SCENES[name], 512, reach)
    assert coarse[0] < rate
    assert coarse[1] < pressure
    assert fine[0] < min(0.007, 0.35 * coarse[0])
    assert fine[1] < min(0.002, 0.35 * coarse[1])
    for zone in answer.zones:
        if zone.outer - zone.inner > 0.1:
            ends = [end for state, *both in marched.zones if state == zone.sense for end in both]
            assert np.abs(np.array(ends) - zone.outer).min() < 4 * marched.spacing


@pytest.mark.slow
def test_a_stuck_edge_of_different_bodies_slips_within_a_strip():
    """The tractions turn like x^(i eps) there: they leave every cone of friction."""
    answer = sf.solve(scene("0", 0.4, (0.7, 0.0), (5.5, -1.0)))
    edge, detached = answer.zones
    assert (edge.inner, edge.sense) == (0.0, 1)
    assert edge.outer == pytest.approx(1.5728e-6, rel=1e-4)
    assert (detached.outer, detached.inner) == pytest.approx((1.24499146, 0.54762532), abs=1e-7)


def test_tension_next_to_the_edge_opens_it():
    answer = sf.solve(scene("A", 0.2, (5.0, 0.0), (0.0, -1.0)))
    assert answer.openings[0].outer == pytest.approx(1.036920e-5, rel=1e-6)
    assert answer.zones[0].outer == pytest.approx(0.373588456, abs=3e-9)


def test_a_grid_whose_pivoting_goes_astray_is_not_followed():
    """It shows 16 zones, which take minutes to place; weaker friction shows the right two."""
    upper = sf.Material(1.8145302730151307, 0.8738621910046238, 0.3144429164612502)
    lower = sf.Material(1.0, 1.0, 0.34676798720629365)
    base = sf.Tractions(1.0, -0.0298379203671244)
    load = sf.Tractions(-1.9398954248279061, -0.9257573724198593)
    answer = sf.solve(sf.Scene(upper, 0.2147322085626276, base, load, lower_material=lower))
    assert answer.status == "converged"
    assert answer.statistics.zone_sets < 10
    (slip,), (opening,) = answer.zones, answer.openings
    assert (opening.inner, slip.inner) == (0.0, opening.outer)
    assert (opening.outer, slip.outer) == pytest.approx((0.375556, 1.508213), abs=1e-6)


@pytest.mark.slow
def test_a_detached_opening():
    answer = sf.solve(SCENES["detached opening"])
    assert answer.status == "converged"
    assert answer.openings[0].inner == pytest.approx(0.7831567, abs=1e-7)
    assert answer.openings[0].outer == pytest.approx(1.1553929, abs=1e-7)
    check_law(answer, 1e-8)


@pytest.mark.slow
def test_a_detached_opening_of_like_bodies():
    base, load = sf.Tractions(0.02, 0.0), sf.Tractions(1.0, 0.5)
    check_like_bodies(sf.Scene(sf.Material(1.0, 1.0, 1 / 3), 0.3, base, load), 1e-7)


@pytest.mark.slow
def test_what_has_no_answer_is_refused():
    with pytest.raises(sf.SceneError, match=r"grow by 4\.82 % .* exchange the bodies"):
        sf.solve(scene("A", 0.2, (5.0, 0.0), (0.0, 1.0)))
    with pytest.raises(sf.SceneError, match=r"lower it below 0\.572"):
        sf.solve(scene("0", 0.8, (1.0, 0.0), (0.0, 1.0)))
    upper, lower = sf.Material(1.0, 1.0, 0.3), sf.Material(1.9706, 1.98737, -0.02)
    base, load = sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 0.3)
    bonded = sf.Scene(upper, 0.2, base, load, lower_material=lower)
    with pytest.raises(sf.SceneError, match="Stoneley"):
        sf.solve(bonded)
    film = under(SCENES["slip and opening"], sf.Coulomb(1.0, viscosity=0.3))
    with pytest.raises(sf.SceneError, match="viscous film"):
        sf.solve(film)
    with pytest.raises(sf.SceneError, match="rtol"):
        sf.solve(SCENES["slip from the slot"], rtol=1e-13)


@pytest.mark.slow
def test_waves_towards_the_edge_are_told():
    """Slip of pair C towards -x is solved; a march of it lets waves towards the edge grow."""
    answer = sf.solve(SCENES["slip from the slot"], rtol=1e-5)
    (wave,) = answer.growing
    assert wave.velocity < 0
    assert 0 < wave.growth < 0.02
    assert sf.solve(SCENES["slip and opening"], rtol=1e-5).growing == ()


def test_nothing_moves_without_a_load_or_before_it():
    still = sf.solve(scene("0", 0.3, (1.0, 0.1), (0.0, 0.0)))
    assert (still.status, still.zones) == ("converged", ())
    np.testing.assert_array_equal(still.shear_traction(X, 1.0), 0.1)
    answer = sf.solve(SCENES["slip from the slot"], rtol=1e-5)
    assert answer.slip_rate(0.1, -1.0) == 0
    assert answer.pressure(0.1, 0.0) == 4.0
    assert answer.zones_at(0.0) == ()
    assert answer.zones_at(2.0)[0].end == pytest.approx(2 * answer.zones[0].outer)
    assert "slip at 0 < x/t < 0.40" in repr(answer)
    with pytest.raises(sf.SceneError, match="x > 0"):
        answer.slip(-1.0, 1.0)


@every_name
def test_a_name_is_that_of_both_bodies(name):
    pair = sf.find(name)
    assert pair.lower_material is not None
    assert scene_label(name) == name
    assert name in scene_names("pair")


@pytest.mark.parametrize(
    ("name", "edges", "opening"),
    [("pair-slip", [0.0, 0.7614591804], None), ("pair-opening", [0.2360, 0.7222], 0.2360)],
)
def test_a_name_is_solved(name, edges, opening):
    answer = sf.solve(name)
    assert answer.edge_speeds[0].tolist() == pytest.approx(edges, abs=5e-5)
    assert [part.outer for part in answer.openings] == pytest.approx(
        [] if opening is None else [opening], abs=5e-5
    )


@pytest.mark.parametrize("name", [*NAMED_PAIRS, "preloaded"])
def test_slip_and_gap_are_continuous_towards_the_edge(name):
    """However close to it a position is, down to the smallest numbers, which divide nothing."""
    answer = sf.solve(name)
    for field in (answer.slip, answer.gap):
        np.testing.assert_allclose(field([1e-21, 1e-30, 1e-300], 1.0), field(1e-16, 1.0), 1e-8)
    assert np.isfinite(answer.slip(1e-320, 1.0))


@every_name
def test_what_knows_identical_bodies_only_names_what_can(name):
    with pytest.raises(sf.SceneError, match="slipfront solve or survey"):
        sf.sweep(name, [0.3])
    with pytest.raises(sf.SceneError, match="space-time is for a Scene, or"):
        sf.solve(name, method="space-time", end_time=1.0)


def test_the_list_has_both_bodies(printed):
    rows = {row["name"]: row for row in printed("scenes")["scenes"]}
    for name in NAMED_PAIRS:
        assert rows[name]["what"] == "two bodies"
        assert rows[name]["scene"]["lower_material"]["density"] == 1.2
    assert "lower_material" not in rows["preloaded"]["scene"]


@pytest.mark.thinned(2)
@every_name
def test_the_command_solves_it(name, printed):
    document = printed(f"solve {name}")
    assert document["zones"][0]["outer"] == sf.solve(name).zones[0].outer


def test_a_singular_jacobian_at_the_first_step_leaves_the_set_of_zones(monkeypatch):
    """The search goes on with the next grid, and comes to the same answer."""
    invert, calls = np.linalg.inv, []

    def singular_once(matrix):
        calls.append(matrix)
        if len(calls) == 1:
            raise np.linalg.LinAlgError("Singular matrix")
        return invert(matrix)

    known = sf.solve("pair-slip", rtol=1e-6)
    monkeypatch.setattr(np.linalg, "inv", singular_once)
    found = sf.solve("pair-slip", rtol=1e-6)
    assert len(calls) > 1
    assert found.status == "converged"
    assert found.zones[0].outer == pytest.approx(known.zones[0].outer, rel=1e-6)


def test_slip_rates_under_a_film_are_within_their_estimate_everywhere():
    """Between the middles and the ends of panels they were off by 1.03 of it."""
    upper, lower = sf.Material(0.6436321, 0.7143553, 0.2616997), sf.Material(1.0, 1.0, 0.1124854)
    law, base = sf.Coulomb(0.3515591, viscosity=1.9822956), sf.Tractions(1.0, 0.1336763)
    scene = sf.Scene(upper, law, base, sf.Tractions(0.0, 0.6190854), lower_material=lower)
    rough, fine = (sf.solve(scene, rtol=rtol) for rtol in (1e-5, 1e-9))
    (zone,) = fine.zones
    rate, right = (
        answer.slip_rate(np.linspace(0.01, 0.99, 400) * zone.outer, 1.0) for answer in (rough, fine)
    )
    assert np.abs(rate - right).max() < rough.error_estimate * np.abs(right).max()


def test_a_zone_far_slower_than_every_wave_moves_the_edges_beside_it():
    """Left out at 3e-7 of the wave speed, it moved an edge at 1.4e-3 by 70 estimates."""
    upper, lower = sf.Material(1.0, 1.0, 0.3176864), sf.Material(7.5967717, 1.4347317, 0.3371095)
    law, load = sf.Coulomb(0.3125673, viscosity=0.1949442), sf.Tractions(0.7123768, -0.3376177)
    scene = sf.Scene(upper, law, sf.Tractions(1.0, 0.0), load, lower_material=lower)
    rough, fine = (sf.solve(scene, rtol=rtol) for rtol in (1e-5, 1e-8))
    assert rough.status == "converged"
    assert [zone.sense for zone in rough.zones] == [1, -1]
    assert 0 < fine.edge_speeds[0, 1] < 1e-6
    allowed = (rough.error_estimate + fine.error_estimate) * fine.edge_speeds
    assert (np.abs(rough.edge_speeds - fine.edge_speeds) <= allowed).all()
