"""Regimes: classification, boundary curves against solved scenes, tables, restart."""

import csv
import math

import numpy as np
import pytest
from scipy.integrate import quad

from compare.output.tables import append_rows
from compare.studies.regimes import study as regimes
from compare.studies.regimes.openings import opening_point
from compare.studies.regimes.points import (
    MapPoint,
    frictions,
    kept_columns,
    map_column,
    poisson_ratios,
    trace,
    zone_speeds,
)
from compare.studies.regimes.study import write_regimes
from compare.tasks.workers import run_tasks
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
from semianalytic.scene.errors import SceneError
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


@pytest.mark.thinned(2)
@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.2, 0.45])
def test_a_remote_load_never_reverses_slip(poisson_ratio):
    for chi in (0.0, 0.3, 0.95):
        assert regime(solve(scene_of("remote", poisson_ratio, chi))) == "everywhere"
    stuck = max(edge_threshold_alone(poisson_ratio), front_threshold_stuck(poisson_ratio))
    for share in (0.2, 0.6, 0.9):
        name = regime(solve(scene_of("remote", poisson_ratio, 1 + share * (stuck - 1))))
        assert name in ("one", "two", "slow", "front")


def test_map_column_is_ascending_and_solved():
    column = map_column("preload", THIRD, 4)
    assert [point.chi for point in column] == sorted(point.chi for point in column)
    assert "failed" not in {point.regime for point in column}
    inner, outer, sense = zone_speeds(column[-1])[0]
    assert (inner, sense) == (0.0, 1)
    exact = edge_speed_under_shear_step(Material(1.0, 1.0, THIRD), column[-1].chi)
    assert outer == pytest.approx(exact, rel=1e-6)


def test_cells_of_a_map_have_their_points_in_the_middle():
    corners = np.log(frictions("preload", 0.0, 5, corners=True))
    assert np.log(frictions("preload", 0.0, 5)) == pytest.approx((corners[1:] + corners[:-1]) / 2)


def test_unfinished_tables_keep_whole_columns_only(tmp_path):
    path = tmp_path / "part"
    first, second = poisson_ratios(2).tolist()
    rest = ("slow", "0:0.5:+1", "converged", 1e-9)
    whole = [MapPoint("preload", first, chi, *rest) for chi in (1.0, 2.0)]
    append_rows(path, whole)
    append_rows(path, [MapPoint("preload", second, 1.0, *rest)])
    with path.open("a") as stream:
        stream.write("preload,0.1")
    kept = kept_columns(path, "preload", 2)
    assert kept == {first: whole}
    assert len(path.read_text().splitlines()) == 2
    assert kept_columns(tmp_path / "absent", "preload", 2) == {}


def quickly(monkeypatch):
    """One Poisson ratio per kind of task, in this process."""
    monkeypatch.setattr(regimes, "FRONT_POISSON_RATIOS", (THIRD,))
    monkeypatch.setattr(regimes, "REVERSE_POISSON_RATIOS", (-0.5,))
    monkeypatch.setattr(regimes, "_OPENING_COUNTS", {True: (2, 3)})

    def here(tasks, *, progress=None, client=None):
        return run_tasks(tasks, 1, progress)

    monkeypatch.setattr(regimes, "run_tasks", here)


@pytest.mark.parametrize("poisson_ratio", [-0.5, THIRD])
def test_the_contact_opens_below_its_threshold_and_from_the_edge(poisson_ratio):
    threshold, material = opening_threshold(poisson_ratio), Material(1.0, 1.0, poisson_ratio)
    above, below = (opening_point(poisson_ratio, 1, part * threshold) for part in (1.001, 0.999))
    assert (above.inner, above.outer) == (0, 0)
    assert below.inner < material.rayleigh_speed < below.outer
    assert below.outer - below.inner < 0.1
    edge = opening_point(poisson_ratio, -1, 0.7)
    assert edge.inner == 0
    assert edge.outer == pytest.approx(edge_speed_of_opening(material, 0.7), rel=1e-8)


@pytest.mark.slow
def test_an_interrupted_map_continues(tmp_path, monkeypatch):
    quickly(monkeypatch)
    monkeypatch.setattr(regimes, "_COUNTS", {True: (2, 6, 2)})

    def interrupt(done: int, total: int) -> None:
        if done == total:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_regimes(tmp_path, size=2, loading="remote", quick=True, progress=interrupt)
    (part,) = tmp_path.iterdir()
    assert part.suffix == ".part"
    kept = part.read_text().splitlines()
    assert len(kept) == 2  # the column before the one that was interrupted
    seen: list[tuple[int, int]] = []
    write_regimes(
        tmp_path, 2, "remote", quick=True, progress=lambda done, total: seen.append((done, total))
    )
    assert seen[-1][0] == seen[-1][1] == len(seen)
    assert not part.exists()
    with (tmp_path / "regimes-remote.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 4
    assert all(
        any(line.startswith(f"remote,{row['poisson_ratio']}") for row in rows) for line in kept
    )
    written = {path.name for path in tmp_path.iterdir()}
    assert written == {
        "regimes-remote.csv",
        "regimes-remote.png",
        "boundaries.csv",
        "front-speeds.csv",
        "front-speeds.png",
        "openings.csv",
        "openings.png",
    }


@pytest.mark.slow
def test_all_figures_and_tables_are_written_and_agree(tmp_path, monkeypatch):
    monkeypatch.setattr(regimes, "_OPENING_COUNTS", {False: (6, 9)})
    monkeypatch.setattr(regimes, "_COUNTS", {False: (17, 36, 9)})
    write_regimes(tmp_path, size=12)
    names = {path.name for path in tmp_path.iterdir()}
    tables = {"regimes-preload", "regimes-remote", "front-speeds", "reverse-slip", "openings"}
    assert names == {f"{name}.{form}" for name in tables for form in ("csv", "png")} | {
        "boundaries.csv"
    }
    for loading in ("preload", "remote"):
        with (tmp_path / f"regimes-{loading}.csv").open() as stream:
            rows = list(csv.DictReader(stream))
        assert len(rows) == 144
        for row in rows:
            curves = {p.curve: 10**p.log10_chi for p in trace(loading, float(row["poisson_ratio"]))}
            assert row["regime"] in expected(loading, float(row["chi"]), curves)


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


def test_sizes_and_loadings_out_of_range_are_refused(tmp_path):
    with pytest.raises(SceneError, match="size"):
        write_regimes(tmp_path, size=1)
    with pytest.raises(SceneError, match="loading"):
        write_regimes(tmp_path, loading="sideways")


def test_tasks_run_in_processes_and_report_progress_and_errors():
    seen: list[tuple[int, int]] = []
    tasks = [(math.sqrt, (float(n),)) for n in range(5)]
    results = dict(run_tasks(tasks, 2, lambda done, total: seen.append((done, total))))
    assert results == {n: math.sqrt(n) for n in range(5)}
    assert seen == [(n, 5) for n in range(1, 6)]
    with pytest.raises(ValueError, match="math domain"):
        dict(run_tasks([(math.sqrt, (-1.0,)), (math.sqrt, (1.0,))], 2))
