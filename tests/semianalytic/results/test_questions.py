"""Every answer takes the same questions, and refuses in one sentence what it cannot say."""

import pickle
from functools import cache

import matplotlib
import numpy as np
import pytest

import slipfront as sf
from semianalytic.dissimilar_slot.solver import coupled
from semianalytic.results.answer import ARRIVALS

matplotlib.use("agg")

ANSWERS = {
    "exact": lambda: sf.solve("preloaded"),
    "rated": lambda: sf.solve(
        sf.Scene(UNIT, 0.3, BASE, SHEAR, friction_law=sf.RateWeakening(0.05, 10.0)),
        method="self-similar",
        rtol=1e-4,
    ),
    "film": lambda: sf.solve("viscous"),
    "opening": lambda: sf.solve("lift-off-shear"),
    "antiplane": lambda: sf.solve("antiplane"),
    "incident wave": lambda: sf.solve("incident-sv"),
    "pair": lambda: sf.solve("pair-opening", rtol=1e-6),
    "patch": lambda: sf.solve("whole-line-patch"),
    "growing load": lambda: sf.solve("growing-load"),
    "march": lambda: sf.solve("ramp", nodes=100),
    "simulation": lambda: sf.with_companions(sf.simulate("preloaded", resolution=16)),
}
UNIT, BASE, SHEAR = sf.Material(1.0, 1.0, 1 / 3), sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0)
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap", "path", "work_density")
TOTALS = ("max_slip", "accumulated_slip", "frictional_work")
IN_BODIES = ("velocity", "stress", "displacement")
X, T = np.array([0.1, 0.25]), np.array([[0.4], [0.9]])

answer = cache(lambda name: ANSWERS[name]())
every = pytest.mark.parametrize("name", ANSWERS)


@every
def test_fields_and_totals_are_functions(name):
    one = answer(name)
    for field in FIELDS:
        values = getattr(one, field)(X, T)
        assert values.shape == (2, 2)
        assert np.isfinite(values).all(), field
        assert getattr(one, field)(0.1, 0.4).shape == ()
    assert (one.path(X, T) >= np.abs(one.slip(X, T)) * (1 - 1e-9)).all()
    assert (one.work_density(X, T) >= 0).all()
    for total in TOTALS:
        assert getattr(one, total)(0.9).shape == (), total
    assert one.history(X, [0.4, 0.9]).slip.tolist() == one.slip(X, T).tolist()
    assert one.to_xarray(X, [0.4, 0.9]).slip.shape == (2, 2)


@every
def test_zones_arrivals_and_readings(name):
    one = answer(name)
    assert isinstance(one.zones_at(0.9), tuple)
    assert isinstance(one.openings_at(0.9), tuple)
    for of in ARRIVALS:
        assert one.arrival(X, of).shape == X.shape
    reading = one.reading(X, 0.9)
    np.testing.assert_array_equal(reading.slip.value, one.slip(X, 0.9))
    speed = one.front_speed(X)
    assert speed.shape == X.shape
    when = one.arrival(X)
    assert (np.isnan(speed) | (speed > 0))[np.isfinite(when)].all()
    with pytest.raises(sf.SceneError, match="of must be one of"):
        one.arrival(X, "else")


@every
def test_status_error_and_looks(name, tmp_path):
    one = answer(name)
    assert isinstance(one.status, str)
    assert float(one.error_estimate) >= 0
    assert "<table" in one._repr_html_()
    slip_rate, tractions = one.plot(t=0.9)
    assert len(slip_rate.lines) >= 1
    assert len(tractions.lines) >= 2
    assert one.plot(ax=slip_rate, t=0.5) is slip_rate
    matplotlib.pyplot.close("all")


@every
def test_what_is_not_known_is_refused_in_one_sentence(name, tmp_path):
    one = answer(name)
    for field in IN_BODIES:
        if one.has_bodies:
            assert np.isfinite(getattr(one, field)(0.3, 0.2, 0.5)).all()
        else:
            with pytest.raises(sf.SceneError, match=f"{field}: a {type(one).__name__} does not"):
                getattr(one, field)(0.3, 0.2, 0.5)
    travelled = pickle.loads(pickle.dumps(one))
    assert travelled.slip(X, T).tolist() == one.slip(X, T).tolist()
    if name in ("march", "simulation"):
        one.save(tmp_path / "saved")
        assert any(tmp_path.iterdir())
    else:
        with pytest.raises(sf.SceneError, match=r"save: a \w+ does not know it; solve it again"):
            one.save(tmp_path / "saved")


def test_path_and_work_of_a_pair_are_those_of_one_body():
    """The solver of two bodies, of equal ones, against the closed form with its own totals."""
    scene = sf.Scene(sf.Material(1.0, 1.0, 0.25), 0.4, BASE, sf.Tractions(0.0, 0.8))
    pair = sf.Pair(scene.material, scene.material, 0.4, scene.base, scene.load)
    one, two, x = sf.solve(scene), coupled(pair, 1e-9), np.linspace(0.03, 1.6, 12)
    for name in ("path", "work_density"):
        known, found = (getattr(each, name)(x, 1.3) for each in (one, two))
        np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-8 * known.max())


@pytest.mark.parametrize("name", ["whole-line-patch", "point-load", "growing-load"])
def test_work_at_all_places_is_the_work_of_the_whole(name):
    one = sf.solve(name)
    edge, (share, weight) = one.edge_speed, np.polynomial.legendre.leggauss(60)
    x = edge * ((1 + share) / 2) ** 2  # crowded at the load, where a patch's rate is infinite
    rule = edge * weight * (1 + share) / 2
    sides = 1 if name == "growing-load" else 2
    assert sides * rule @ one.work_density(x, 1.0) == pytest.approx(
        float(one.frictional_work(1.0)), rel=2e-3
    )
    assert sides * rule @ one.path(x, 1.0) == pytest.approx(
        float(one.accumulated_slip(1.0)), rel=2e-3
    )


def test_a_march_adds_up_path_and_work_as_its_steps_do():
    run = sf.solve("harmonic", nodes=100)
    x = run.grid.x[: run.grid.observed]
    np.testing.assert_allclose(run.path(x, run.end_time), run.final_path, rtol=0.02, atol=1e-4)
    work = run.work_density(x, run.end_time)
    np.testing.assert_allclose(work, run.final_work_density, rtol=0.02, atol=1e-5)
