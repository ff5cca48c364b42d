"""The stability study: its own methods, its closed forms, its rows, figures and table."""

import csv
import math

import mpmath
import numpy as np
import pytest
from matplotlib.figure import Figure

from compare.studies.stability import solver as solver_stability
from compare.studies.stability.figures import (
    grids_figure,
    limits_figure,
    rules_figure,
    thresholds_figure,
)
from compare.studies.stability.methods import (
    GridProblem,
    by_active_set,
    by_pivoting,
    grid_problem,
    zigzag,
)
from compare.studies.stability.solver import study_tasks, write_solver_stability
from compare.studies.stability.sweeps import (
    closed_form,
    estimate_rows,
    grid_rows,
    limit_rows,
    narrow_gap_rows,
    near_rayleigh_rows,
    rule_rows,
    threshold_rows,
)
from compare.tasks.workers import run_tasks
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.regimes import edge_threshold

THIRD = 1 / 3


def values(rows, quantity, **wanted):
    return [
        row.value
        for row in rows
        if row.quantity == quantity and all(getattr(row, k) == v for k, v in wanted.items())
    ]


def test_pivoting_and_active_set_agree_where_both_end():
    problem = grid_problem("preload", THIRD, 0.2, 40, "galerkin")
    pivoted, active = by_pivoting(problem), by_active_set(problem)
    assert pivoted.status == active.status == "solved"
    assert active.slip_rate == pytest.approx(pivoted.slip_rate, abs=1e-12)
    assert active.rounds < pivoted.rounds


def test_active_set_of_a_problem_solved_by_hand():
    xi = np.array([0.0, 1.0, 2.0])
    answer = by_active_set(GridProblem(xi, np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-4, 1.0])))
    assert answer.status == "solved"
    assert answer.slip_rate == pytest.approx([2.0, 0.0, 0.0])
    singular = by_active_set(GridProblem(xi, np.zeros((2, 2)), np.array([-1.0, 1.0])))
    assert singular.status == "singular"
    # -w = V1 + ... has no solution: the lone node swaps in and out.
    cycling = by_active_set(GridProblem(xi, -np.eye(2), np.array([-1.0, 1.0])))
    assert cycling.status == "cycles (period 2)"


def test_collocation_at_nodes_carries_an_odd_even_mode_that_galerkin_does_not():
    modes = {}
    for placement in ("galerkin", "nodes"):
        rows = grid_rows("remote", THIRD, 1.1, 80, placement, False)
        (modes[placement],) = values(rows, "odd-even mode")
        (error,) = values(rows, "slip rate error")
        assert error < 0.05
    assert modes["nodes"] > 20 * modes["galerkin"]


def test_collocation_at_mid_points_ends_on_a_ray():
    for size in (40, 80):
        assert "ray" in by_pivoting(grid_problem("preload", THIRD, 0.2, size, "midpoints")).status


def test_active_set_does_not_end_on_fine_grids_where_pivoting_does():
    problem = grid_problem("preload", THIRD, 0.5, 320, "galerkin")
    assert by_pivoting(problem).status == "solved"
    assert by_active_set(problem).status != "solved"


def test_odd_even_mode_is_told_from_smooth_error():
    xi = np.linspace(0, 1, 101)
    exact = np.maximum(0.8 - xi, 0)
    alternating = np.where(exact > 0, 0.01 * (-1.0) ** np.arange(101), 0)
    assert zigzag(xi, exact + alternating, exact) == pytest.approx(0.01 / 0.8, rel=1e-6)
    assert zigzag(xi, exact * (1 + 0.1 * xi), exact) < 1e-4


def test_closed_form_of_the_slip_rate_at_the_edge():
    """Values of the theory at nu = 1/3, one-sided there."""
    assert closed_form(THIRD, 1.0)[1] == pytest.approx(2 * 0.293203, abs=2e-6)
    assert closed_form(THIRD, 0.5)[1] == pytest.approx(2 * 0.370954, abs=2e-6)


def test_rules_reach_their_tolerance_on_the_closed_form():
    for poisson_ratio in (-0.99, 0.499):
        rows = rule_rows(poisson_ratio)
        tolerances, errors = values(rows, "tolerance"), values(rows, "slip rate error")
        for tolerance, error in zip(tolerances, errors, strict=True):
            assert error < max(3 * tolerance, 1e-13)


def test_errors_stay_within_their_estimates():
    rows = estimate_rows("remote", THIRD, 1.25)
    true, estimated = values(rows, "true error"), values(rows, "error estimate")
    assert len(true) == 10
    assert all(t <= e for t, e in zip(true, estimated, strict=True))


def test_impedance_beside_the_rayleigh_slowness_keeps_its_digits_from_the_distance():
    factors = rayleigh_factors(THIRD)
    with mpmath.workdps(40):
        # nu = 1/3 in double precision decides a; c follows from the cubic of its definition.
        nu = mpmath.mpf(THIRD)
        a2 = (1 - 2 * nu) / (2 * (1 - nu))
        r = mpmath.findroot(
            lambda r: ((r - 8) * r + 24 - 16 * a2) * r - 16 * (1 - a2), 1 / factors.c**2
        )
        c = 1 / mpmath.sqrt(r)
        for exponent in (2, 6, 10, 14):
            z = (c + mpmath.mpf(10) ** -exponent) ** 2
            root = mpmath.sqrt(z - 1)
            exact = 4 * z * mpmath.sqrt(z - a2) - (1 - 2 * z) ** 2 / root
            at = factors.beside("c", [10.0**-exponent])
            ratio = factors.impedance_on_cut(at).imag[0] / float(exact)
            assert ratio == pytest.approx(1, abs=1e-13)
    rows = near_rayleigh_rows(THIRD)
    for method in ("polynomial", "from v"):
        lost = values(rows, "impedance error", method=method, parameter=1e-12)
        assert 1e-7 < lost[0] < 1e-2


def test_narrow_gaps_follow_their_closed_form():
    rows = sorted(narrow_gap_rows(THIRD), key=lambda row: row.parameter)
    assert rows[0].parameter < 1e-6
    assert rows[0].value < 1e-5
    assert rows[-1].value > rows[0].value


def test_limits_of_the_poisson_ratio_are_solved():
    for limit in ("0.5", "0-", "-1"):
        rows = limit_rows(limit, 4)
        assert {row.status for row in rows} == {"converged"}
        assert max(values(rows, "edge error") + values(rows, "slip rate error")) < 1e-10


SMALL = [
    (grid_rows, ("preload", THIRD, 0.2, 20, "galerkin", True)),
    (grid_rows, ("preload", THIRD, 0.2, 40, "galerkin", True)),
    (grid_rows, ("preload", THIRD, 0.2, 40, "nodes", True)),
    (limit_rows, ("0.5", 1)),
    (limit_rows, ("0.5", 2)),
    (limit_rows, ("-1", 1)),
    (threshold_rows, ("edge slips", "remote", THIRD, math.sqrt(2))),
    (estimate_rows, ("preload", THIRD, 1.0)),
    (rule_rows, (0.0,)),
    (near_rayleigh_rows, (0.0,)),
    (narrow_gap_rows, (0.0,)),
]


@pytest.fixture(scope="module")
def rows():
    return [row for _, found in run_tasks(SMALL, 1) for row in found]


@pytest.mark.slow
def test_next_to_a_threshold_the_solver_ends_in_a_status(rows):
    rows = [row for row in rows if row.study == "threshold"]
    assert edge_threshold(THIRD) == pytest.approx(math.sqrt(2), rel=1e-14)
    assert len({row.parameter for row in rows}) == 21
    far_below = [row for row in rows if row.parameter == -0.01]
    assert {row.status for row in far_below} == {"converged"}
    assert values(far_below, "zones") == [1.0]
    assert values(rows, "zones", parameter=0.01) == [0.0]
    for row in rows:
        assert row.status == "converged" or math.isnan(row.value) or row.status


@pytest.mark.slow
def test_figures_hold_finite_data(rows):
    for draw in (limits_figure, thresholds_figure, grids_figure, rules_figure):
        figure = draw(rows)
        assert isinstance(figure, Figure)
        for panel in figure.axes:
            for line in panel.get_lines():
                assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all()


@pytest.mark.slow
def test_study_writes_its_table_and_figures(tmp_path, monkeypatch, rows):
    monkeypatch.setattr(solver_stability, "study_tasks", lambda quick: SMALL)
    monkeypatch.setattr(solver_stability, "run_tasks", lambda tasks, **_: [(0, list(rows))])
    write_solver_stability(tmp_path, quick=True)
    assert {path.name for path in tmp_path.iterdir()} == {
        "stability-solver.csv",
        "stability-limits.png",
        "stability-thresholds.png",
        "stability-grids.png",
        "stability-rules.png",
    }
    with (tmp_path / "stability-solver.csv").open() as stream:
        assert len(list(csv.DictReader(stream))) == len(rows)


@pytest.mark.slow
def test_quick_study_is_a_part_of_the_whole_and_runs(tmp_path):
    quick, whole = study_tasks(True), study_tasks(False)
    assert len(quick) < len(whole) / 2
    assert {function for function, _ in quick} == {function for function, _ in whole}
    seen: list[tuple[int, int]] = []
    write_solver_stability(tmp_path, True, lambda done, total: seen.append((done, total)))
    assert seen[-1] == (len(quick), len(quick))
