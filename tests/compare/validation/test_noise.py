"""Noise of the data, error of the grid and of the answer are told apart in every bar."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.records.record import Stated, Unit
from compare.validation import Conventions, validate
from compare.validation.bars import MEAN_NOISE, Bar, noise_mean, pooled_bar
from compare.validation.data import as_runs
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_scene

pytestmark = pytest.mark.usefixtures("exact_once")

SCENE = find_scene("preloaded")
NAMES = ("slip_rate", "slip", "shear_traction", "pressure")


@pytest.fixture(scope="module")
def exact():
    t, x = np.linspace(0.0, 1.0, 401), np.array([0.1, 0.25, 0.5])
    history = solved(SCENE).history(x, t)
    return {"t": t, "x": x, **{name: getattr(history, name) for name in NAMES}}


def noisy(data, seed, share=0.01):
    """Records with independent errors of a part of the largest value, and their size."""
    random = np.random.default_rng(seed)
    sizes = {name: share * np.abs(data[name]).max() for name in NAMES}
    noise = {name: sizes[name] * random.normal(size=data[name].shape) for name in NAMES}
    return {**data, **{name: data[name] + noise[name] for name in NAMES}}, sizes


@pytest.mark.thinned(6)
@pytest.mark.parametrize("seed", range(6))
def test_a_gauge_with_one_per_cent_of_noise_does_not_differ(exact, seed):
    data, sizes = noisy(exact, seed)
    said = Conventions(noise=sizes)
    for spacing in (0.01, 0.0):  # of a point nothing is smeared
        found = validate(data, SCENE, spacing=spacing, conventions=said)
        assert found.verdict == "agrees"
        assert found.counts["differs"] == 0
    assert found.detection.inferred == ()
    assert validate(data, SCENE, spacing=0.001).verdict == "differs"


def test_what_is_wrong_beyond_the_noise_still_differs(exact):
    data, sizes = noisy(exact, 1)
    said = Conventions(noise=sizes)
    more = {**data, "slip": 1.1 * data["slip"], "slip_rate": 1.1 * data["slip_rate"]}
    assert validate(more, SCENE, spacing=0.0, conventions=said).verdict == "differs"
    other = replace(SCENE, friction=1.05 * SCENE.friction)
    assert validate(data, other, spacing=0.0, conventions=said).verdict == "differs"


def test_bars_are_made_of_three_parts(exact):
    said = Conventions(noise={"slip": 1e-3})
    found = validate(exact, SCENE, spacing=0.01, conventions=said)
    for row in found.rows:
        assert row.bar == pytest.approx(row.grid_bar + row.data_bar + row.answer_bar)
        # an arrival is known to the interval of its samples, without noise as well
        sampled = exact["t"][1] / exact["t"][-1] if row.kind == "arrival" else 0.0
        assert row.data_bar == pytest.approx(sampled) or row.kind == "slip"
        assert row.data_bar > 0 or row.kind not in ("arrival", "slip")
    rows = {row.name: row for row in found.rows}
    slip, rate = rows["slip at 0.1 c_t T"], rows["slip rate at 0.1 c_t T"]
    mean = exact["slip"][:, 0].mean()
    assert MEAN_NOISE * 1e-3 < slip.data_bar * mean < 1.2 * MEAN_NOISE * 1e-3
    assert 0 < rate.answer_bar < 1e-6
    assert found.grids.noise == {"slip": pytest.approx(1e-3)}


def test_noise_is_in_the_unit_of_the_file(exact):
    (run,) = as_runs(exact)
    run = replace(run, stated=Stated({"slip": Unit("mm", 1e-3)}))
    said = Conventions(noise={"slip": 1.0}, slip="half")
    found = validate(run, SCENE, spacing=0.01, conventions=said)
    assert found.grids.noise == {"slip": pytest.approx(2e-3)}


def test_a_mean_of_noise_is_what_samples_show():
    random = np.random.default_rng(5)
    means = np.abs(random.normal(size=(4000, 50))).mean(axis=1)
    assert means.mean() == pytest.approx(MEAN_NOISE, rel=0.01)
    assert (means > noise_mean(1 / 50)).mean() < 0.01
    assert (means > MEAN_NOISE + 0.5 * (noise_mean(1 / 50) - MEAN_NOISE)).mean() > 0.03


def test_bars_of_all_stations_are_those_of_each_by_their_size():
    bars = [Bar(0.1, 0.2, 0.3, 1.0), Bar(0.3, 0.0, 0.0, 2.0)]
    whole = pooled_bar(bars, [1.0, 3.0], 2.0)
    assert (whole.grid, whole.data) == pytest.approx((0.25, 0.05))
    assert whole.whole == pytest.approx(0.25 + 0.05 + 0.075)
    assert pooled_bar([bars[0], Bar(None)], [1.0, 1.0], 1.0).whole is None


def test_noise_that_hides_everything_is_what_stands_in_the_way(exact):
    said = Conventions(noise={"slip": 1.0})
    found = validate(exact, SCENE, spacing=0.01, conventions=said)
    (row,) = (one for one in found.rows if one.name == "slip all stations")
    assert row.verdict == "unresolved"
    assert row.obstacle.startswith("the noise of the data leaves it open by")


def test_a_spacing_of_nothing_takes_noise(exact):
    with pytest.raises(SceneError, match="spacing must be positive, or 0 where noise is given"):
        validate(exact, SCENE, spacing=0.0)
    with pytest.raises(SceneError, match="no noise of 'gap'"):
        Conventions(noise={"gap": 1.0})


@pytest.mark.parametrize("seed", range(2))
def test_whatever_is_unresolved_says_why(exact, seed):
    """Noise three times as large as said lies between agreement and difference in some rows."""
    data, sizes = noisy(exact, seed)
    said = Conventions(noise={name: size / 3 for name, size in sizes.items()})
    found = validate(data, SCENE, spacing=0.0, conventions=said)
    between = [row for row in found.having("unresolved") if row.bar and row.over_bar > 1]
    assert between
    assert all(row.obstacle for row in found.having("unresolved"))
    assert all("stated as it is" in row.obstacle for row in between if row.bar < 0.05)


def test_records_of_one_time_are_refused(exact):
    once = {"t": exact["t"][200:201], "x": exact["x"]}
    once |= {name: exact[name][200:201] for name in NAMES}
    with pytest.raises(DataFileError, match=r"record at x = 0\.1 has 1 times; it takes 2 at least"):
        validate(once, SCENE, spacing=0.01)
