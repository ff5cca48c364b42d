"""The stability study: its own methods, its closed forms, its rows and table."""

import math

import mpmath
import pytest

from docs.studies.pages import read_data
from docs.studies.stability.grids import by_active_set, by_pivoting, grid_problem
from docs.studies.stability.solver import (
    closed_form,
    estimate_rows,
    grid_rows,
    limit_rows,
    narrow_gap_rows,
    near_rayleigh_rows,
    rule_rows,
)
from semianalytic.halfplane.rayleigh import rayleigh_factors

THIRD = 1 / 3


def values(rows, quantity, **wanted):
    return [
        row["value"]
        for row in rows
        if row["quantity"] == quantity and all(row[k] == v for k, v in wanted.items())
    ]


def test_pivoting_and_active_set_agree_where_both_end():
    problem = grid_problem("preload", THIRD, 0.2, 40, "galerkin")
    pivoted, active = by_pivoting(problem), by_active_set(problem)
    assert pivoted.status == active.status == "solved"
    assert active.slip_rate == pytest.approx(pivoted.slip_rate, abs=1e-12)
    assert active.rounds < pivoted.rounds


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
    rows = sorted(narrow_gap_rows(THIRD), key=lambda row: row["parameter"])
    assert rows[0]["parameter"] < 1e-6
    assert rows[0]["value"] < 1e-5
    assert rows[-1]["value"] > rows[0]["value"]


def test_limits_of_the_poisson_ratio_are_solved():
    for limit in ("0.5", "0-", "-1"):
        rows = limit_rows(limit, 4)
        assert {row["status"] for row in rows} == {"converged"}
        assert max(values(rows, "edge error") + values(rows, "slip rate error")) < 1e-10


# --- what docs/stability.md says, in its table ------------------------------------------------


@pytest.fixture(scope="module")
def kept():
    """The rows of the page."""
    numbers = ("parameter", "value")
    rows = read_data("stability-solver")[1]
    return [row | {name: float(row[name]) for name in numbers} for row in rows]


def statuses(rows, **wanted):
    """The statuses of rows, and their number."""
    found = [row["status"] for row in rows if all(row[k] == v for k, v in wanted.items())]
    return set(found), len(found)


def test_pivoting_solves_every_grid_but_those_of_mid_points(kept):
    for placement, words in (("galerkin", "solved"), ("nodes", "solved"), ("midpoints", "ray")):
        found, count = statuses(kept, study="grid", method=f"{placement}, pivoting")
        assert count >= 54
        assert all(words in status for status in found)


def test_the_active_set_does_not_end_on_fine_grids_and_cycles_on_nodes(kept):
    case = {"study": "grid", "case": "preload, ν = 0.333, χ = 0.2"}
    assert statuses(kept, **case, method="galerkin, active set", parameter=640.0)[0] == {"no end"}
    (cycling,) = statuses(kept, **case, method="nodes, active set", parameter=40.0)[0]
    assert cycling.startswith("cycles")


def test_rules_need_up_to_twice_the_nodes_where_there_is_a_root_on_the_other_sheet(kept):
    needed = {}
    for row in kept:
        wanted = ("rule", "slip rate error")
        if (row["study"], row["quantity"]) == wanted and row["value"] < 1e-9:
            case = row["case"]
            needed[case] = min(row["parameter"], needed.get(case, math.inf))
    less, more = (
        sorted(needed[f"ν = {nu}"] for nu in pair) for pair in (("-0.99", "0"), ("0.333", "0.499"))
    )
    assert 1.2 * less[1] < more[0] <= more[1] <= 2 * less[0]


def test_true_errors_are_below_their_estimates_in_all_scenes(kept):
    named = {}
    for row in kept:
        if row["study"] == "estimate":
            named.setdefault((row["case"], row["parameter"]), {})[row["quantity"]] = row["value"]
    assert len({case for case, _ in named}) == 5
    assert all(pair["true error"] < pair["error estimate"] for pair in named.values())


def test_all_thresholds_converge_but_next_to_that_of_the_edge(kept):
    near = [row for row in kept if row["study"] == "threshold"]
    failed = {(row["case"], row["parameter"]) for row in near if row["status"] != "converged"}
    allowed = {("edge slips, ν = 1/3", -(10.0**-n)) for n in (8, 9, 10)}
    assert failed <= allowed | {("edge slips, ν = −0.5", -1e-10)}


@pytest.mark.parametrize(
    ("limits", "edge", "rate"), [(("-1",), 2e-16, 2e-15), (("0+", "0-"), 3e-13, 5e-13)]
)
def test_accuracy_is_kept_at_limits_of_the_poisson_ratio(limits, edge, rate, kept):
    rows = [row for row in kept if row["study"].removeprefix("nu to ") in limits]
    assert {row["status"] for row in rows} == {"converged"}
    assert max(values(rows, "edge error")) < edge
    assert max(values(rows, "slip rate error")) < rate


def test_next_to_one_half_only_some_remote_scenes_are_without_zones(kept):
    rows = [row for row in kept if row["study"] == "nu to 0.5"]
    assert max(values(rows, "edge error")) < 2e-15
    assert max(values(rows, "slip rate error")) < 1e-14
    failed = [row for row in rows if row["status"] != "converged"]
    assert all(row["case"].startswith("remote") and row["parameter"] < 1.1e-5 for row in failed)
    for row in failed:
        if "no set of slip zones was found" in row["status"]:
            assert row["parameter"] < 1.1e-6
        else:
            assert row["value"] < 2.2e-4
