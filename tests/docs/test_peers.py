"""What docs/peers.md is made from: rows that stay, differences, and input without its comments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from docs.studies.peers import adhesion, cracklet, rows, sem2dpack
from semianalytic.interface.law import check_law

ROW = rows.Row("A", "case", "slip", "1 m", "2 m", 0.01, None, 0.02, None, 3.0, 4.0, "command")


def test_rows_replace_those_of_their_command_and_case_alone(tmp_path: Path) -> None:
    """Rows of others survive, with their numbers and their gaps."""
    file = tmp_path / "peers.csv"
    other = replace(ROW, case="other")
    rows.replace_rows([ROW, other], file)
    rows.replace_rows([replace(ROW, our_seconds=5.0)], file)
    text = file.read_text().splitlines()
    assert [line.split(",")[1] for line in text[2:]] == ["case", "other"]
    assert text[2].split(",")[5:11] == ["0.01", "", "0.02", "", "3.0", "5.0"]
    assert text[3].split(",")[10] == "4.0"


def test_difference_is_relative_to_the_mean_of_both() -> None:
    """1 against 1.1 is off by 0.1/1.05, whichever comes first."""
    one, other = np.full(3, 1.0), np.full(3, 1.1)
    assert rows.off(one, other) == pytest.approx(0.1 / 1.05)
    assert rows.off(other, one) == rows.off(one, other)


def test_input_of_sem2dpack_loses_what_gfortran_would_read_in_its_comments(tmp_path: Path) -> None:
    """A namelist behind a # is none, the one in force gets the elements of the grid."""
    (tmp_path / "Par.inp").write_text(
        "#&MESH_CART nelem=102,160 /\n&MESH_CART nelem=70,40/ # a comment\n"
        " title = 'Test#3', ItInfo = 400/\n&SNAP_DEF itd=200 /\n"
    )
    text = sem2dpack.their_input(tmp_path, sem2dpack.PROBLEMS[0], 35)
    assert text.splitlines() == ["&MESH_CART nelem=35,20/", " title = 'Test#3', ItInfo=100000/"]


def test_fault_of_sem2dpack_is_read_with_its_marks(tmp_path: Path) -> None:
    """Two points, two times, depths from the surface downwards."""
    (tmp_path / "Flt_sem2d.hdr").write_text(
        " NPTS NDAT NSAMP DELT\n 2 3 2 0.5\n Slip:Slip_Rate:Shear_Stress\n XPTS ZPTS\n"
        " 0.0 -2.0\n 0.0 -1.0\n"
    )
    mark = np.array([8], dtype="<i4").tobytes()
    lines = np.arange(12, dtype="<f4").reshape(6, 2)
    content = b"".join(mark + line.tobytes() + mark for line in lines)
    (tmp_path / "Flt_sem2d.dat").write_bytes(content)
    fields = sem2dpack.read_fault(tmp_path / "Flt_sem2d.hdr", depth=True)
    assert fields.x.tolist() == [1.0, 2.0]
    assert fields.values["slip"].tolist() == [[1.0, 0.0], [7.0, 6.0]]
    assert fields.at("slip rate", np.array([0.25]), np.array([1.5])).tolist() == [[5.5]]


@pytest.mark.parametrize("rest", [0.0, 1e-9])
def test_friction_of_cracklet_is_steady_at_the_slip_rate_it_prints(rest: float) -> None:
    """At theta = L/V the friction is that of their load, and the state stays."""
    problem = cracklet.PROBLEMS[1 if rest else 0]
    rate = np.array([0.00193049 if rest else 0.000398213])
    law = cracklet.Pmma(problem.f, problem.a, 0.0, rest)
    state = cracklet.DISTANCE / rate
    assert law.friction(rate, state)[0] == pytest.approx(problem.load / 1e6, rel=2e-5)
    assert law.evolved(state, rate, 1e-3)[0] == pytest.approx(state[0], rel=1e-9)
    check_law(law, np.full(1, 1e6), state)


def fields_of(error: float, nodes: int = 240) -> rows.GridRun:
    return rows.GridRun(f"{nodes} nodes", {"slip rate": np.full((2, nodes // 2 + 1), 1 + error)}, 3)


def test_errors_are_held_against_the_other_code_and_changes_against_the_own() -> None:
    """Errors of h and h^2 about 1: the limit of their two grids is exact, ours is our finest."""
    theirs = [fields_of(10 / nodes, nodes) for nodes in (1440, 2880)]
    ours = [fields_of(1e3 / nodes**2, nodes) for nodes in (720, 1440)]
    pairs = list(zip(theirs, ours, strict=True))
    first, row = rows.compared("A", "case", "command", pairs, fields_of(0.0, 1440).fields)
    fine, ours_fine = 10 / 2880, 1e3 / 1440**2
    assert (row.quantity, row.their_grid, row.our_grid) == ("slip rate", "2880 nodes", "1440 nodes")
    assert row.their_error == pytest.approx(fine - ours_fine, rel=1e-2)
    assert row.our_error == pytest.approx(ours_fine, rel=1e-2)
    assert row.their_change == pytest.approx(fine, rel=1e-2)
    assert row.our_change == pytest.approx(3 * ours_fine, rel=1e-2)
    assert (first.their_change, first.our_change) == (None, None)
    assert first.our_error == pytest.approx(4 * ours_fine, rel=1e-2)
    assert first.their_error == pytest.approx(2 * fine - ours_fine, rel=1e-2)


def test_a_peer_with_one_grid_has_no_error_of_its_own() -> None:
    """Nothing tells whose error the difference of both is."""
    known = fields_of(0.0)
    first, second = rows.compared(
        "A", "case", "command", [(known, fields_of(0.02)), (known, fields_of(0.01, 480))]
    )
    assert (first.their_error, first.their_change, second.their_change) == (None, None, None)
    assert second.our_error == pytest.approx(0.01, rel=0.02)
    assert second.our_change == pytest.approx(0.01, rel=0.02)


def test_our_cut_grows_under_tension() -> None:
    """The cut of the comparison with UGUCA has grown to four times its length at the end."""
    fields = adhesion.ours(256).fields
    assert fields["gap"].shape == (20, 256)
    assert (fields["gap"][-1] > adhesion.GAP).sum() > 4 * 32
    assert -1.0 <= fields["pressure"].min() < -0.8
