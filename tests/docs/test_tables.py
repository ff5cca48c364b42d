"""Studies of accuracy and of speed, and their tables."""

import math

import numpy as np
import pytest

from docs.studies import ratios
from docs.studies.accuracy import scenes
from docs.studies.pages import read_data
from semianalytic.scene.given.named import NAMED_SCENES

SOLVE = "`solve` of `preloaded` to 1e-9"


@pytest.mark.slow
def test_scenes_have_a_summary_and_every_quantity():
    rows = {name: scenes.summary(name, 32) for name in ("preloaded", "stuck", "unload")}
    assert rows["unload"]["profile"] == rows["unload"]["slip_rate"] > 0
    assert rows["preloaded"]["profile"] != rows["preloaded"]["slip_rate"]
    assert np.isnan(rows["stuck"]["sense"])
    assert 0 < rows["stuck"]["pressure"] < 0.1
    assert rows["unload"]["solver"] == "space-time"
    for row in (rows["preloaded"], rows["unload"]):
        assert 0 <= row["sense"] <= row["sense_bar"]
        assert 0 < row["profile"] <= row["profile_bar"]
        missed = scenes.unresolved(row["scene"], 32)
        assert len(missed) == row["unresolved"]
        assert all(one["obstacle"] for one in missed)
    *_, work = scenes.quantities("preloaded", 32)
    assert abs(work["simulated"] - work["at_nodes"]) < work["bar"] < 0.1 * work["at_nodes"]
    assert work["verdict"] == "agrees"


def test_no_named_scene_differs_anywhere():
    """In the tables of docs/scenes.md, which says so."""
    _, rows = read_data("scenes-summary")
    assert [row["scene"] for row in rows] == list(NAMED_SCENES)
    for row in rows:
        assert row["verdict"] == "agrees"
        assert (int(row["agree"]) > 5, int(row["differ"])) == (True, 0)
    _, missed = read_data("scenes-unresolved")
    assert len(missed) == sum(int(row["unresolved"]) for row in rows)


@pytest.mark.slow
def test_every_quantity_of_every_scene_is_in_its_report():
    _, shown = read_data("scenes-quantities")
    found = [row for scene in scenes.QUANTITIES for row in scenes.quantities(scene, 60)]
    names = [[(row["scene"], row["quantity"]) for row in rows] for rows in (found, shown)]
    assert names[0] == names[1]


def test_a_job_runs_in_both_checkouts():
    (row,) = ratios.compared([SOLVE], ratios.ROOT, ratios.ROOT, times=0.1)
    assert row.job == SOLVE
    assert row.before > 0
    assert row.ratio == row.now / row.before
    assert row.error_before == row.error_now < 1e-9


def test_a_checkout_that_fails_is_named(tmp_path):
    (tmp_path / "slipfront.py").write_text("")  # a package without a single name
    with pytest.raises(SystemExit, match="`solve` of `preloaded`"):
        ratios.compared([SOLVE], tmp_path, ratios.ROOT, times=0.1)


@pytest.mark.parametrize(("ratio", "code"), [(1.2, 0), (1.3, 1), (0.5, 0)])
def test_exit_code_tells_of_a_slower_job(ratio, code, monkeypatch, tmp_path):
    row = ratios.RatioRow(SOLVE, 1.0, ratio, ratio, math.nan, 1e-10)
    packed = []
    monkeypatch.setattr(ratios, "unpacked", lambda commit, folder: packed.append(commit))
    monkeypatch.setattr(ratios, "compared", lambda *given: [row])
    assert ratios.main(["--against", "some", "--csv", str(tmp_path)]) == code
    assert packed == ["some"]
    assert (tmp_path / "speed-ratios.csv").read_text().startswith("# python -m docs.studies.ratios")


def test_all_jobs_are_in_the_table():
    _, rows = read_data("speed-ratios")
    assert [str(row["job"]) for row in rows] == list(ratios.JOBS)
