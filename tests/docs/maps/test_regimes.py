"""Regimes: classification, boundary curves against solved scenes, maps, order of thresholds."""

import math

import pytest
from scipy.integrate import quad

from compare.tasks.workers import run_tasks
from docs.studies.regimes.__main__ import (
    map_points,
    map_rows,
    opening_row,
    reverse_row,
    threshold_row,
    trace,
)
from semianalytic import Material, Scene, Tractions, solve
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.reference import edge_speed_of_opening, edge_speed_under_shear_step
from semianalytic.regimes import (
    crossing_poisson_ratio,
    edge_threshold,
    edge_threshold_alone,
    front_threshold_stuck,
    gap_threshold,
    log_frictionless_half_width,
    log_narrow_reverse_threshold,
    nucleation,
    opening_threshold,
    regime,
    reverse_threshold,
    scene_of,
)
from semianalytic.selfsimilar.zones.tuning import NARROWEST_GAP

THIRD = 1 / 3


@pytest.mark.parametrize(
    ("loading", "poisson_ratio", "chi", "name"),
    [
        ("remote", THIRD, 1.5, "stuck"),
        ("remote", THIRD, 1.35, "slow"),
        ("remote", -0.5, 1.115, "front"),
        ("remote", THIRD, 1.25, "two"),
        ("remote", THIRD, 1.1, "one"),
        ("remote", THIRD, 0.9, "everywhere"),
        ("preload", -0.5, 0.02, "reverse"),
    ],
)
def test_each_regime_is_recognised(loading, poisson_ratio, chi, name):
    assert regime(solve(scene_of(loading, poisson_ratio, chi))) == name


def test_slip_along_a_negative_load_is_not_reverse():
    material = Material(1.0, 1.0, THIRD)
    scene = Scene(material, 0.2, Tractions(1.0, 0.0), Tractions(0.0, -1.0))
    assert regime(solve(scene)) == "two"


def test_edge_threshold_is_the_closed_form_unless_the_shear_front_breaks_first():
    assert edge_threshold_alone(THIRD) == pytest.approx(math.sqrt(2), rel=1e-14)
    assert edge_threshold(THIRD) == edge_threshold_alone(THIRD)
    crossing = crossing_poisson_ratio()
    assert front_threshold_stuck(crossing) == pytest.approx(edge_threshold_alone(crossing))
    assert edge_threshold(-0.5) > edge_threshold_alone(-0.5)


@pytest.mark.thinned(6)
@pytest.mark.parametrize("share", [-1e-6, 0.0, 1e-9, 1e-6])
def test_a_zone_at_the_front_alone_makes_the_edge_slip(share):
    """Zones of 6e-8 c_t at the edge and 1e-3 c_t around the shear front, not one up to c_l."""
    ratio = -0.3291071428571428
    alone = edge_threshold_alone(ratio)
    chi = alone + share * (front_threshold_stuck(ratio) - alone)
    solution = solve(scene_of("remote", ratio, chi), rtol=1e-6)
    assert solution.status == "converged"
    assert [zone.inner > 0.9999 for zone in solution.zones] == [False, True]
    assert solution.zones[0].outer < 1e-7
    assert 1e-9 < edge_threshold(ratio) - alone < 1e-8


@pytest.mark.thinned(3)
@pytest.mark.parametrize("poisson_ratio", [-0.8, -0.5, THIRD])
def test_edge_slips_just_below_its_threshold_only(poisson_ratio):
    chi = edge_threshold(poisson_ratio)
    # Twice 1e-4 moves the front by about 1e-3 c_t, far above the tolerance of the solver.
    below = solve(scene_of("remote", poisson_ratio, chi * (1 - 1e-4)))
    above = solve(scene_of("remote", poisson_ratio, chi * (1 + 1e-4)))
    assert below.edge_slip_rate > 0
    assert above.edge_slip_rate == 0


def test_nucleation_under_a_preload_agrees_with_the_closed_form():
    """The traction at the shear front ahead of one zone, by an adaptive rule."""
    factors = rayleigh_factors(THIRD)
    chi = nucleation("preload", THIRD)
    front = 1 / edge_speed_under_shear_step(Material(1.0, 1.0, THIRD), chi)

    def density(theta: float) -> float:
        v = factors.a + (1 - factors.a) * math.sin(theta) ** 2
        impedance = 4 * v * v * math.sqrt(v * v - factors.a**2)
        product = factors.kappa * float(factors.m_plus(v) * factors.m_plus(0.0))
        width = (1 - factors.a) * math.sin(2 * theta)
        return impedance / product * math.sqrt(front / (front - v)) / (math.pi * v) * width

    assert quad(density, 0, math.pi / 2, epsabs=1e-12)[0] == pytest.approx(chi, rel=1e-9)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("loading", "poisson_ratio"), [("preload", THIRD), ("preload", 0.0), ("remote", THIRD)]
)
def test_a_second_zone_appears_just_below_nucleation(loading, poisson_ratio):
    chi = nucleation(loading, poisson_ratio)
    assert regime(solve(scene_of(loading, poisson_ratio, chi * 0.999))) == "two"
    assert regime(solve(scene_of(loading, poisson_ratio, chi * 1.001))) == "slow"


def test_the_stick_gap_at_the_rayleigh_front_is_four_reversed_half_widths():
    chi = gap_threshold("remote", THIRD)
    solution = solve(scene_of("remote", THIRD, chi * (1 + 1e-12)), rtol=1e-10)
    outward, inward = solution.profile.fields.zones
    # c is known to 1e-16, the gap to the solver's tolerance of its logarithm.
    assert inward.left.minus(outward.right)[0] == pytest.approx(4 * NARROWEST_GAP, rel=1e-3)
    assert regime(solve(scene_of("remote", THIRD, 0.99 * chi))) == "one"
    assert gap_threshold("preload", THIRD) is None
    assert gap_threshold("preload", 0.49) > 0


@pytest.mark.thinned(2)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.5, -0.2, 0.0])
def test_slip_reverses_just_below_its_threshold_only(poisson_ratio):
    chi = reverse_threshold(poisson_ratio)
    assert regime(solve(scene_of("preload", poisson_ratio, 0.98 * chi))) == "reverse"
    assert regime(solve(scene_of("preload", poisson_ratio, 1.02 * chi))) in ("slow", "two")


def test_narrow_strips_reverse_below_the_closed_form():
    for poisson_ratio in (0.2, 0.3):
        narrow = math.exp(log_narrow_reverse_threshold(poisson_ratio))
        # The traction is read beside c_R by 1e-4 of the gap, 1e-8 of the dip.
        assert reverse_threshold(poisson_ratio) == pytest.approx(narrow, rel=1e-6)
    # The published threshold at this Poisson ratio is 0.0575.
    assert reverse_threshold(THIRD) == pytest.approx(1.5967e-8, rel=1e-4)


def test_reversed_half_widths_without_friction():
    """Values of the theory, given to one or two figures."""
    stated = {-0.5: 0.09, -0.2: 0.027, 0.0: 0.004, 0.2: 4e-5, THIRD: 5e-8}
    for poisson_ratio, width in stated.items():
        assert math.exp(log_frictionless_half_width(poisson_ratio)) == pytest.approx(
            width, rel=0.08
        )


def test_the_reversed_strip_is_widest_at_some_friction():
    """Half-widths over c_R at nu = -0.5: 9.6 % without friction, 11 % at chi = 0.007, then less."""
    speed, widths = Material(1.0, 1.0, -0.5).rayleigh_speed, []
    for row in map_rows("map", "preload", -0.5, [0.007, 0.03]):
        widths += [
            (outer - inner) / (2 * speed) for inner, outer, sense in row["zones"] if sense < 0
        ]
    assert math.exp(log_frictionless_half_width(-0.5)) == pytest.approx(0.096, abs=0.001)
    assert widths[0] == pytest.approx(0.11, abs=0.002)
    assert widths[1] < widths[0]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.2, 0.45])
def test_a_remote_load_never_reverses_slip(poisson_ratio):
    for chi in (0.0, 0.3, 0.95):
        assert regime(solve(scene_of("remote", poisson_ratio, chi))) == "everywhere"
    stuck = max(edge_threshold_alone(poisson_ratio), front_threshold_stuck(poisson_ratio))
    for share in (0.2, 0.6, 0.9):
        name = regime(solve(scene_of("remote", poisson_ratio, 1 + share * (stuck - 1))))
        assert name in ("one", "two", "slow", "front")


@pytest.mark.parametrize("poisson_ratio", [-0.5, THIRD])
def test_the_contact_opens_below_its_threshold_and_from_the_edge(poisson_ratio):
    threshold, material = opening_threshold(poisson_ratio), Material(1.0, 1.0, poisson_ratio)
    above, below = (opening_row(poisson_ratio, 1, part * threshold) for part in (1.001, 0.999))
    assert (above["inner"], above["outer"]) == (0, 0)
    assert below["inner"] < material.rayleigh_speed < below["outer"]
    assert below["outer"] - below["inner"] < 0.1
    edge = opening_row(poisson_ratio, -1, 0.7)
    assert edge["inner"] == 0
    assert edge["outer"] == pytest.approx(edge_speed_of_opening(material, 0.7), rel=1e-8)


@pytest.mark.slow
def test_points_of_a_map_are_in_the_regimes_that_the_traced_curves_allow():
    points = [point for point in map_points(True) if point[0] in ("map", "curves")]
    for part, loading, nu, chi in points[::3]:
        if part == "map":
            curves = {k: v for k, v in trace(loading, nu).items() if isinstance(v, float)}
            levels = {name: 10**value for name, value in curves.items()}
            for row in map_rows(part, loading, nu, chi):
                assert row["regime"] in expected(loading, row["chi"], levels)


def test_tables_of_regimes():
    row = threshold_row(THIRD)
    names = ("preload_nucleation", "gap", "stuck_front", "remote_nucleation", "edge")
    assert [row[name] for name in names] == sorted(row[name] for name in names)
    first, other = (reverse_row(nu) for nu in (-0.5, 0.0))
    assert first["threshold"] > other["threshold"] > 0
    assert first["half_width"] > other["half_width"] > 0


def expected(loading, chi, curves):
    """Regimes that the traced curves allow at a friction."""
    if loading == "preload" and chi < curves["reverse"]:
        return {"reverse"}
    if chi < curves.get("everywhere", 0.0):
        return {"everywhere"}
    if chi < curves.get("gap", 0.0):
        return {"one"}
    slips_at_edge = chi < curves.get("edge", math.inf)
    if chi < curves["nucleation"]:
        return {"two"} if slips_at_edge else {"front"}
    return {"slow"} if slips_at_edge else {"stuck"}


def test_tasks_run_in_processes_and_report_progress_and_errors():
    seen: list[tuple[int, int]] = []
    tasks = [(math.sqrt, (float(n),)) for n in range(5)]
    results = dict(run_tasks(tasks, 2, lambda done, total: seen.append((done, total))))
    assert results == {n: math.sqrt(n) for n in range(5)}
    assert seen == [(n, 5) for n in range(1, 6)]
    with pytest.raises(ValueError, match="math domain"):
        dict(run_tasks([(math.sqrt, (-1.0,)), (math.sqrt, (1.0,))], 2))
