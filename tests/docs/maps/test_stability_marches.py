"""Where finite elements and space-time marches fail: refusals, errors, energy."""

import math

import pytest

from docs.studies.pages import read_data
from docs.studies.stability.__main__ import march_figure
from docs.studies.stability.marches import RAN, fem_points, fem_row, march_points, march_row


@pytest.mark.slow
def test_finite_elements_stop_above_the_critical_step_and_say_what_to_change():
    """Energy is not gained where the contact closes again."""
    points = fem_points(True)
    above = next(point for point in points if point[0] == "step" and point[3]["step_ratio"] == 1.05)
    # a run of few steps takes a multiple of four of them, which shortens each
    stopped = fem_row(*above[:3], above[3] | {"step_ratio": 1.15})
    reclosed = fem_row(*points[-1])
    assert stopped["outcome"] == "stopped"
    assert 0 < stopped["step"] < stopped["steps"]
    assert "lower `step_ratio`" in stopped["message"]
    assert math.isnan(stopped["error"])
    assert reclosed["study"] == "chatter"
    assert 0 < reclosed["switches"] <= 4
    assert reclosed["energy_gained"] < 1e-15
    kept = fem_row(*(above[:3]), above[3] | {"step_ratio": 0.95})
    assert kept["outcome"] == "completed"
    assert kept["error"] < 0.02


def test_damping_delays_the_end_of_steps_above_the_critical_one():
    _, rows = read_data("fem-stability")
    own = [row for row in rows if (row["study"], row["mesh"]) == ("step", "squares")]
    own.sort(key=lambda row: float(row["damping"]))
    steps = [float(row["step"]) for row in own]
    assert steps == sorted(steps)
    assert steps[-1] < float(own[-1]["steps"])


@pytest.mark.slow
def test_marches_are_refused_or_finish_and_damping_helps_small_steps():
    rows = [march_row(*point) for point in march_points(True)]
    for row in rows:
        assert (row["status"] == RAN) == math.isfinite(row["error"])
        assert row["status"] == RAN or "lower it by" in row["status"]
    damped, plain = (
        [row["error"] for row in rows if (row["study"], row["case"]) == ("step ratio", case)][:4]
        for case in ("damping 0.7", "damping 0")
    )
    assert max(damped) < min(plain)
    assert len(rows) == 69
    assert len(march_figure(rows).axes) == 4


def test_what_the_page_says_of_marches():
    """Refused steps, and no drift, at the full resolution."""
    _, rows = read_data("stability-space-time")
    found = {(row["study"], row["case"], float(row["parameter"])): row for row in rows}
    steps = [item for study, case, item in found if (study, case) == ("step ratio", "damping 0.7")]
    refused = [step for step in steps if found["step ratio", "damping 0.7", step]["status"] != RAN]
    assert refused == [0.7, 0.75, 0.8]
    times = [float(row["error"]) for row in rows if row["study"] == "end time"]
    assert times == sorted(times, reverse=True)
    errors = {
        nu: float(found["Poisson ratio", "damping 0.7", nu]["error"]) for nu in (-0.99, 0.2, 0.499)
    }
    assert errors[0.2] < errors[0.499] < 10 * errors[0.2]
    assert errors[0.2] < errors[-0.99] < 10 * errors[0.2]
