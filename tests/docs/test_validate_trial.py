"""The trial of validate tells failures for what they are."""

import numpy as np
from catalogue import solved

from docs.studies.trials import validate as trial
from semianalytic.scene.given.finding import find_scene


def test_right_records_are_summed_up_by_group():
    (steps,) = trial.alarms(
        [
            {"use": "set", "kind": "steps", "code": "fem", "cells": "50", "runs": 1, "rows": rows}
            | {"differs": differs, "unresolved": 0, "most": 0.5 + differs}
            | {"rate_bar": 0.1 * rows, "slip_bar": np.nan}
            for rows, differs in ((10, 0), (20, 1), (30, 0))
        ]
    )
    assert (steps["runs"], steps["rows"], steps["differs"], steps["most"]) == (3, 60, 1, 1.5)
    assert steps["rate_bar"] == 2.0
    assert np.isnan(steps["slip_bar"])


def test_mistakes_are_made_where_they_change_something():
    scene, t = find_scene("preloaded"), np.linspace(0.0, 1.0, 101)
    history = solved(scene).history(np.array([0.1, 0.25, 0.5]), t)
    data = {"t": t, "x": history.x, "slip": history.slip, "slip_rate": history.slip_rate}
    stuck = {**data, "slip": 0 * history.slip, "slip_rate": 0 * history.slip}
    assert trial.SPOILS["slip times 1.1"](stuck, scene) is None
    changed, _ = trial.SPOILS["no second zone"](data, scene)
    assert 0 < np.abs(changed["slip"]).sum() < np.abs(data["slip"]).sum()
    rows = [{"mistake": "friction +3 %", "verdict": verdict} for verdict in ("differs", "agrees")]
    friction, *others = trial.power(rows)
    assert (friction["scenes"], friction["caught"], friction["unresolved"]) == (2, 1, 0)
    assert all(row["scenes"] == 0 for row in others)
