"""Derivatives of misfits with respect to all that can be fitted, what priors add, and fits of
interfaces."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic import Gauge, LogNormal, Normal, SceneError, Setup, Uniform, fit, solve
from semianalytic.inversion import on_line
from semianalytic.inversion.gauges import FIELDS, INTERFACE
from semianalytic.inversion.on_line import RecordedRun, recorded
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.trials import Trials
from semianalytic.inversion.unknowns import MATERIAL, SETUP, SOLVED, Unknowns
from semianalytic.scene.incident import OF_FRONT

T = np.linspace(0.3, 2.0, 9)
SHIFTED = Setup(0.01, 0.02, 1.1, {"beside": 0.9})
IN_PLANE = [name for name in FIELDS if "z" not in name]
OF_SCENE = ("friction", "poisson_ratio", "load_shear", "base_pressure")


def trials(gauges, names, scene=PRELOADED, setup=SHIFTED, priors=None, rtol=1e-9):
    unknowns = Unknowns(names, scene, setup, 2.0)
    return Trials(Samples(tuple(gauges)), unknowns, priors or {}, rtol)


def silent(quantity, x=0.37, **place):
    return Gauge(x, T, np.zeros(len(T)), 1.0, quantity, **place)


def differences(trial, number, step):
    """Derivatives of misfits by differences, to the fourth order (Richardson)."""

    def central(h):
        moved = np.zeros(len(trial.start))
        moved[number] = h
        ends = [trial.misfit(trial.start + sign * moved) for sign in (1, -1)]
        return (ends[0] - ends[1]) / (2 * h)

    return (4 * central(step) - central(2 * step)) / 3


def check_derivatives(trial, count, step, most):
    """Medians over the samples of each record: those on an edge have no derivative, and are few."""
    by_step = differences(trial, 0, step)
    errors = np.abs(trial.jacobian(trial.start)[:, 0] - by_step).reshape(count, len(T))
    assert np.abs(by_step).max() > 0.1
    assert np.median(errors, axis=1).max() < most


@pytest.mark.slow
@pytest.mark.parametrize("name", [*OF_SCENE, *MATERIAL, *SETUP, "gain:beside"])
def test_derivatives_are_those_of_differences_whatever_is_recorded(name):
    """On the interface and beside it."""
    gauges = [silent(quantity) for quantity in INTERFACE]
    gauges += [silent(quantity, y=0.21, name="beside") for quantity in IN_PLANE]
    most = 1e-7 if name in OF_SCENE else 1e-5
    check_derivatives(trials(gauges, (name,)), len(gauges), 2e-3, most)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["load_shear", "load_pressure", "base_pressure", "friction"])
def test_derivatives_of_a_remote_load_are_those_of_differences(name):
    """It moves what the contact carries, too; tractions jump at t = 0, which is no sample."""
    scene = unit_scene(1.2, (0.5, 0.2), (0.6, 0.9), load_on="remote")
    trial = trials([silent(quantity) for quantity in INTERFACE], (name,), scene)
    check_derivatives(trial, len(INTERFACE), 1e-3, 1e-7)


@pytest.mark.slow
def test_errors_of_differences_in_the_bodies_are_told():
    trial = trials([silent("sxy", y=0.2)], ("friction",))
    own = trial.difference_error(trial.start)
    exact = differences(trial, 0, 2e-3)
    away = trial.jacobian(trial.start)[:, 0] - exact
    assert np.linalg.norm(away) < max(3 * own, 1e-8) * np.linalg.norm(exact) + 1e-7
    assert 0 < own < 1e-4
    assert trials([silent("slip")], ("friction",)).difference_error(np.ones(1)) == 0


def test_a_rough_solution_is_differenced_over_a_longer_step():
    gauge = silent("sxy", y=0.2)
    errors = [
        trials([gauge], ("friction",), rtol=rtol).difference_error(np.array([1.0]))
        for rtol in (1e-4, 1e-10)
    ]
    assert errors[1] < errors[0] < 0.1


@pytest.mark.slow
def test_trigger_gain_and_edge_are_recovered_with_friction():
    setup = Setup(t0=0.05, x0=-0.1, gain=1.2)
    solution, random = solve(PRELOADED), np.random.default_rng(3)
    gauges = []
    for x in (0.3, 0.6, 1.0):
        t = np.linspace(0.02, 3 * x, 60)
        clean = 1.2 * solution.slip_rate(x + 0.1, t - 0.05)
        gauges.append(Gauge(x, t, clean + random.normal(scale=0.01, size=60), 0.01))
    names = ("friction", "t0", "x0", "gain")
    found = fit(gauges, replace(PRELOADED, friction=0.45), names, rtol=1e-6)
    away = found.values - [0.3, setup.t0, setup.x0, setup.gain]
    assert found.status == "converged"
    assert away @ np.linalg.solve(found.covariance, away) < 18  # all but a thousandth
    assert np.all(found.standard_errors < 0.05)
    assert (found.setup.t0, found.setup.gain) == pytest.approx((found.values[1], found.values[3]))


@pytest.mark.slow
@pytest.mark.parametrize("prior", [Normal(0.34, 0.002), LogNormal(0.34, 1.006)])
def test_a_narrow_prior_pulls_and_enters_the_errors(prior):
    solution = solve(PRELOADED)
    gauge = Gauge(0.4, T, solution.slip_rate(0.4, T), 0.05)
    alone = fit([gauge], PRELOADED, ("friction",), rtol=1e-6)
    found = fit([gauge], PRELOADED, ("friction",), rtol=1e-6, priors={"friction": prior})
    assert alone.values[0] == pytest.approx(0.3, abs=1e-3)
    weights = 1 / np.array([alone.standard_errors[0], 0.002]) ** 2
    assert found.values[0] == pytest.approx(weights @ [0.3, 0.34] / weights.sum(), abs=2e-3)
    assert found.standard_errors[0] == pytest.approx(weights.sum() ** -0.5, rel=0.1)
    assert found.freedom == alone.freedom + 1


def test_a_uniform_prior_is_a_bound():
    gauge = Gauge(0.4, T, solve(PRELOADED).slip_rate(0.4, T), 0.05)
    found = fit([gauge], PRELOADED, ("friction",), priors={"friction": Uniform(0.33, 0.5)})
    assert found.values[0] == pytest.approx(0.33, abs=1e-3)


@pytest.mark.slow
def test_what_the_data_leave_free_a_prior_may_hold():
    solution = solve(PRELOADED)
    gauge = Gauge(0.4, T, solution.slip_rate(0.4, T), 0.02)
    names, prior = ("friction", "base_pressure"), {"base_pressure": Normal(1.0, 0.05)}
    free = fit([gauge], PRELOADED, names)
    assert free.unconstrained == names
    assert "do not constrain friction and base_pressure apart" in free.status
    assert np.all(np.isinf(free.standard_errors))
    held = fit([gauge], PRELOADED, names, priors=prior)
    assert held.unconstrained == ()
    assert held.standard_errors[1] == pytest.approx(0.05, rel=0.02)
    assert held.correlation[0, 1] < -0.5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Normal(0.3, 0.0), "sd must be positive"),
        (lambda: LogNormal(-1.0, 2.0), "median must be positive"),
        (lambda: LogNormal(1.0, 0.5), "factor must be above 1"),
        (lambda: Uniform(2.0, 1.0), "low must be below high"),
        (lambda: silent("speed", y=0.1), "quantity must be one of slip"),
        (lambda: silent("vx"), "give y"),
        (lambda: silent("slip", y=0.1), "leave y out"),
        (lambda: Gauge(0.3, T, T, T[:3]), "noise must be positive"),
        (lambda: fit([silent("vz", y=0.1)], PRELOADED, ("friction",)), "antiplane"),
        (
            lambda: fit([silent("slip")], PRELOADED, ("friction",), priors={"friction": 0.3}),
            "must be Normal, LogNormal or Uniform",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(SceneError, match=message):
        make()


def test_every_unknown_has_a_start_bounds_and_a_range():
    names = tuple(name for name in (*SOLVED, *SETUP) if name not in ("viscosity", *OF_FRONT))
    trial = trials([silent("slip")], names, setup=Setup())
    low, high = trial.bounds
    least, most = trial.ranges
    assert np.all((low < trial.start) & (trial.start < high))
    assert np.all((low <= least) & (least < most) & (most <= high))
    scene, setup = trial.at(trial.start)
    assert scene == PRELOADED
    assert setup == Setup()


@pytest.mark.parametrize("quantity", ["slip", "slip_rate", "shear_traction"])
def test_misfits_over_base_pressure_come_from_a_sweep_over_friction(quantity):
    """Friction and base pressure act by their product, unless a load changes the pressure."""
    trial = trials([silent(quantity)], ("friction", "base_pressure", "t0"))
    points = trial.start * np.array([[1.0, 1.0, 1.0], [1.2, 1.1, 0.5], [0.7, 1.4, 2.0]])
    found = trial.misfits(points)
    assert trial.count == 0
    np.testing.assert_allclose(found, [trial.misfit(point) for point in points], atol=1e-3)


@pytest.mark.parametrize(("quantity", "load"), [("pressure", 0.0), ("slip", -0.2)])
def test_misfits_over_base_pressure_are_solved_one_by_one_where_it_matters_itself(quantity, load):
    scene = unit_scene(0.4, (1.0, 0.1), (load, 0.8))
    trial = trials([silent(quantity)], ("base_pressure",), scene)
    trial.misfits(trial.start * np.array([[1.0], [1.2]]))
    assert trial.count == 2


# --- fits of interfaces to records ----------------------------------------------------------------


SOLID = sf.Material(1.0, 1.0, 0.25)


def fault(dynamic=0.2, distance=1.0):
    load = sf.InterfaceLoad(lambda x: 1.2 * np.exp(-(x**2)), sf.Ramp(1.0))
    law = sf.SlipWeakening(0.6, dynamic, distance)
    return scene_along(SOLID, law, 12.0, shear=0.3, loads=[load], even=True)


def gauges(run, noise):
    t, random = np.linspace(0.6, 2.4, 7), np.random.default_rng(1)
    slips = {x: run.slip(x, t) + noise * random.standard_normal(7) for x in (-1.0, 0.0, 1.5)}
    return [sf.Gauge(x, t, slip, noise, "slip") for x, slip in slips.items()]


@pytest.fixture(scope="module")
def truth():
    return sf.solve(fault(), end_time=2.5, nodes=128, estimate=False, frames=1000)


def in_bodies(run, noise=0.0, t=None):
    """Gauges in both bodies, with a share of noise, whose load acts at 0.2."""
    random, found = np.random.default_rng(0), []
    t = np.linspace(0.3, 2.4, 30) if t is None else t
    for of, x, y in (("exx", 1.2, 0.4), ("exy", -1.2, -0.4), ("eyy", 1.6, 0.4), ("vx", 0.8, -0.4)):
        fields = run.strain(x, y, t) if of[0] == "e" else run.velocity(x, y, t)
        values = fields[{"exx": 0, "eyy": 1, "exy": 2, "vx": 0}[of]]
        size = (noise or 1e-9) * float(np.abs(values).max())
        noisy = values + size * random.standard_normal(len(t))
        found.append(sf.Gauge(x, t + 0.2, noisy, size, of, y))
    return found


def test_a_law_and_the_time_of_the_load_are_found_from_slip_and_gauges_in_both_bodies():
    """So are stress drop, fracture energy and S, from a guess that is far off, and what comes."""
    true = sf.solve(fault(distance=0.4), end_time=3.2, nodes=128, estimate=False, frames=1000)
    slip = [replace(gauge, t=gauge.t + 0.2) for gauge in gauges(true, 0.02)]
    prior = {"friction_law_dynamic": sf.Uniform(0.0, 0.5), "t0": sf.Uniform(0.1, 0.3)}
    names = "friction_law.dynamic", "t0"
    records = [*slip, *in_bodies(true, 0.03)]
    found = sf.fit(records, fault(0.35, 0.4), names, nodes=128, priors=prior)
    assert found.parameters == ("friction_law_dynamic", "t0")
    assert found.status == "converged"
    assert np.all(np.abs(found.values - 0.2) < 3 * found.standard_errors)
    assert np.all((found.standard_errors > 0) & (found.standard_errors < 0.01))
    assert found.scene.law.dynamic == found.values[0]
    # a period that only suits the records would send false waves to later times
    assert found.scene.period == fault().period
    assert replace(found, trials=replace(found.trials, lengthens=True)).scene.period == np.inf
    assert 0 < found.derivative_error < 0.1
    quoted = found.quoted
    assert quoted.x.tolist() == pytest.approx([-1.2, -0.5, 0.2, 0.9, 1.6])
    known = {"stress_drop": 0.1, "fracture_energy": 0.4 * 0.4 / 2, "strength_ratio": 3.0}
    for name, value in known.items():
        values = getattr(quoted, name)
        assert np.all(np.abs(values.value - value) < 2 * values.error)
        assert np.all(values.error < 0.13 * value)
    # slip begins at once near x = 0, and so has no speed
    assert np.isnan(quoted.front_speed.value).tolist() == [False, True, True, False, False]
    later = np.linspace(2.5, 3.2, 6)
    bands = found.forecast(later)[len(slip) :]
    for gauge, band in zip(in_bodies(true, t=later - 0.2), bands, strict=True):
        assert np.all(np.abs(gauge.values - band.value) < 3 * band.error)
        assert np.all(band.error < 0.02 * np.abs(band.value))


def test_a_fit_ends_with_a_march_that_is_interrupted(truth, monkeypatch):
    whole = on_line.march

    def interrupted(*given, **options):
        return replace(whole(*given, **options), status="interrupted at t = 1")

    monkeypatch.setattr(on_line, "march", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sf.fit(gauges(truth, 1e-4), fault(), "gain", nodes=32)


def test_a_grid_that_gauges_can_see_is_not_converged(truth):
    records = gauges(truth, 1e-4)
    found = sf.fit(records, fault(), "gain", nodes=32)
    assert not found.status.startswith("converged")
    found = sf.fit(gauges(truth, 0.05), fault(), "gain", nodes=64)
    assert found.status == "converged"


def test_gauges_see_what_was_in_place_before_the_load(truth):
    seen = RecordedRun(fault(), truth)
    assert seen.slip(np.array([0.0, 0.3]), np.array([-1.0, 2.0])).tolist() == [
        0.0,
        float(truth.slip(0.3, 2.0)),
    ]
    assert seen.shear_traction(np.array([0.0]), np.array([-1.0])).tolist() == [0.3]
    described = replace(fault(0.5), run={"end_time": 2.5})
    other = recorded(described, 32, estimate=False)
    assert other.run.interface.slip.max() < truth.interface.slip.max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameters": "law.dist"}, "parameters must be among .*friction_law_distance"),
        ({"parameters": ("friction_law_distance", "friction_law.distance")}, "each one once"),
        ({"scene": sf.find("preloaded"), "parameters": "friction"}, "no effect on a scene"),
        ({"quantity": "exx", "y": 0.1}, "nearer to the interface than nodes"),
        ({"quantity": "vz", "y": 0.1}, "zero in this scene"),
        ({"t": [-2.0, -1.0, -0.5]}, "before the load"),
    ],
)
def test_what_cannot_be_fitted_is_refused(change, message):
    record = {"x": 1.0, "t": [0.5, 1.0, 1.5], "values": [0.0, 0.1, 0.2], "noise": 0.01}
    record |= {"quantity": "slip"}
    record |= {name: change_ for name, change_ in change.items() if name in ("quantity", "y", "t")}
    asked = {"scene": fault(), "parameters": "friction_law_dynamic", "nodes": 32}
    asked |= {name: change_ for name, change_ in change.items() if name not in record}
    with pytest.raises(sf.SceneError, match=message):
        sf.fit([sf.Gauge(**record)], **asked)


def test_gauges_of_scenes_stand_on_the_contact():
    record = sf.Gauge(x=-0.1, t=[1.0], values=[0.1], noise=0.1, quantity="slip")
    with pytest.raises(sf.SceneError, match=r"slip at x = -0.1: x must be"):
        sf.fit([record], sf.find("preloaded"), "friction")
    punch = sf.find("punch")
    off = sf.Gauge(x=2.0, t=[1.0], values=[0.1], noise=0.1, quantity="slip")
    with pytest.raises(sf.SceneError, match="do not touch at x = 2"):
        sf.fit([off], punch, "friction", priors={"friction": Normal(0.4, 0.1)})
    with pytest.raises(
        sf.SceneError, match="prior of 'friction_law_cohesion', which is not fitted"
    ):
        sf.fit([off], punch, "friction", priors={"friction_law.cohesion": Normal(0.4, 0.1)})


@pytest.mark.slow
def test_a_law_of_a_march_beside_a_slot_is_found():
    """Trials along a line find what a march beside the slot was made with."""
    base, load = sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0)
    slot = sf.Scene(SOLID, sf.SlipWeakening(0.6, 0.3, 0.5), base, load)
    t, made = np.linspace(0.4, 1.0, 7), sf.solve(slot, end_time=1.0, nodes=400)
    records = [
        sf.Gauge(x=x, t=t, values=made.slip(x, t), noise=2e-3, quantity="slip") for x in (0.05, 0.2)
    ]
    guess = replace(slot, friction=sf.SlipWeakening(0.6, 0.4, 0.5))
    found = sf.fit(records, guess, "friction_law.dynamic", nodes=512)
    assert found.values[0] == pytest.approx(0.3, abs=3 * found.standard_errors[0])
    assert found.standard_errors[0] < 0.01


@pytest.mark.slow
def test_rate_and_state_is_recovered_from_slip_rates_and_strain():
    """A march of twice the nodes makes the records; the grid's error is part of the errors."""
    rock, t = sf.Material(20e9, 2222.0, 0.25), np.linspace(0.2e-3, 3e-3, 29)
    kick = sf.InterfaceLoad(lambda x: 1e6 * np.exp(-(x**2)), sf.Ramp(2e-4))
    line = {"contact": sf.Contact(), "period": 24.0, "rate": 1e-6, "even": True}

    def rupture(a, b, distance):
        law = sf.RateAndState(a=a, b=b, f0=0.6, v0=1e-6, distance=distance)
        return sf.Scene(rock, law, sf.Tractions(5e6, 3e6), kick, **line)

    true, random, records = np.array([0.010, 0.014, 2e-6]), np.random.default_rng(1), []
    made = sf.solve(rupture(*true), end_time=3e-3, nodes=256, estimate=False, frames=1000)
    for x in (1.5, 3.0, 4.5):
        seen = (made.slip_rate(x, t), "slip_rate", None), (made.strain(x, 0.4, t)[2], "exy", 0.4)
        for values, of, y in seen:
            noise = 0.02 * float(np.abs(values).max())
            noisy = values + noise * random.standard_normal(len(t))
            records.append(sf.Gauge(x, t, noisy, noise, of, y))
    names = [f"friction_law.{name}" for name in ("a", "b", "distance")]
    found = sf.fit(records, rupture(0.012, 0.015, 3e-6), names, nodes=128)
    assert np.all(np.abs(found.values - true) < 2 * found.standard_errors)
    assert np.all(found.standard_errors < 0.06 * true)
    assert found.solutions < 600
