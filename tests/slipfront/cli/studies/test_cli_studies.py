"""The longer commands through their entry point; what they compute is tested elsewhere."""

import numpy as np
import pytest

from compare.studies.chart.benchmark import TOLERANCES, measure, median_times
from compare.studies.chart.costs import FILMS, OPENINGS, measure_costs
from semianalytic.cut.load import contact_opens


@pytest.mark.slow
def test_benchmark_reports_time_next_to_error():
    assert len(median_times([lambda: None, lambda: sum(range(1000))], 3)) == 2
    rows = measure(repetitions=1)
    assert {row.rtol for row in rows} == set(TOLERANCES)
    for row in rows:
        assert row.error < row.rtol
        assert row.warm > 0
        assert row.cold > 0


@pytest.mark.parametrize("kind", OPENINGS)
def test_scenes_that_open_are_timed_beside_some_that_do_not(kind):
    for _, (scene, plain) in zip(range(20), OPENINGS[kind](np.random.default_rng(1)), strict=False):
        assert contact_opens(scene)
        assert not contact_opens(plain)
        assert (scene.friction, scene.material) == (plain.friction, plain.material)


@pytest.mark.slow
def test_costs_are_reported_next_to_errors():
    for row in measure_costs(FILMS | OPENINGS, scenes=4):
        assert 0 < row.median <= row.ninth_decile <= row.worst
        assert 0 < row.error < 1
