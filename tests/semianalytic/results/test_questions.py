"""Every answer takes the same questions, and refuses in one sentence what it cannot say."""

import pickle
from functools import cache
from itertools import pairwise

import matplotlib
import numpy as np
import pytest

import slipfront as sf
from docs.studies.lines import scene_along
from semianalytic.dissimilar_slot.solver import coupled
from semianalytic.results.answer import ARRIVALS

matplotlib.use("agg")

ANSWERS = {
    "exact": lambda: sf.solve("preloaded"),
    "rated": lambda: sf.solve(
        sf.Scene(UNIT, sf.RateWeakening(0.3, 0.285, 10.0), BASE, SHEAR),
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
    "no load": lambda: sf.solve(scene_along(UNIT, sf.Coulomb(0.5), 8.0), end_time=1.2, nodes=128),
    "contacts": lambda: sf.solve(
        scene_along(UNIT, sf.Coulomb(0.3), 8.0, contact=sf.Contact.half_line(), loads=[PUSH]),
        end_time=1.2,
        nodes=128,
    ),
    "rate-and-state": lambda: sf.solve(
        scene_along(UNIT, SLOWING, 8.0, shear=0.6, loads=[BUMP], rate=1e-6),
        end_time=1.2,
        nodes=128,
    ),
    "simulation": lambda: sf.with_companions(sf.simulate("preloaded", resolution=16)),
}
BUMP = sf.InterfaceLoad(sf.Table([-8.0, -0.7, -0.5, 0.5, 0.7, 8.0], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]))
SLOWING = sf.RateAndState(0.01, 0.006, 0.6, 1e-6, 1e-3)
UNIT, BASE, SHEAR = sf.Material(1.0, 1.0, 1 / 3), sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0)
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap", "path", "work_density")
TOTALS = ("max_slip", "accumulated_slip", "frictional_work")
IN_BODIES = ("velocity", "stress", "strain", "displacement")
X, T = np.array([0.1, 0.25]), np.array([[0.4], [0.9]])

answer = cache(lambda name: ANSWERS[name]())
every = pytest.mark.parametrize("name", ANSWERS)


@every
def test_fields_and_totals_are_functions(name):
    result = answer(name)
    for field in FIELDS:
        values = getattr(result, field)(X, T)
        assert values.shape == (2, 2)
        assert np.isfinite(values).all(), field
        assert getattr(result, field)(0.1, 0.4).shape == ()
    # of an answer to a rough accuracy both are sums of pieces that are known no better
    accuracy = result.error_estimate if name == "rated" else 1e-9
    assert (result.path(X, T) >= np.abs(result.slip(X, T)) * (1 - accuracy)).all()
    assert (result.work_density(X, T) >= 0).all()
    for total in TOTALS:
        assert getattr(result, total)(0.9).shape == (), total
    assert result.history(X, [0.4, 0.9]).slip.tolist() == result.slip(X, T).tolist()
    assert result.to_xarray(X, [0.4, 0.9]).slip.shape == (2, 2)


@every
def test_zones_arrivals_and_readings(name):
    result = answer(name)
    assert isinstance(result.zones_at(0.9), tuple)
    assert isinstance(result.openings_at(0.9), tuple)
    for of in ARRIVALS:
        assert result.arrival(X, of).shape == X.shape
    reading = result.reading(X, 0.9)
    np.testing.assert_array_equal(reading.slip.value, result.slip(X, 0.9))
    speed = result.front_speed(X)
    assert speed.shape == X.shape
    when = result.arrival(X)
    assert (np.isnan(speed) | (speed > 0))[np.isfinite(when)].all()
    with pytest.raises(sf.SceneError, match="of must be one of"):
        result.arrival(X, "else")


@every
def test_status_error_and_looks(name, tmp_path):
    result = answer(name)
    assert isinstance(result.status, str)
    assert float(result.error_estimate) >= 0
    assert "<table" in result._repr_html_()
    slip_rate, tractions = result.plot(t=0.9)
    assert len(slip_rate.lines) >= 1
    assert len(tractions.lines) >= 2
    assert result.plot(ax=slip_rate, t=0.5) is slip_rate
    result.animate(tmp_path / "a.gif", [0.4, 0.9])
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF89a")
    if hasattr(result, "interface"):  # slip rate over (x, t), and three waves from each end of slip
        ends = 2 * np.isfinite(result.seen.onset).any() if result.scene.on_line else 1
        assert len(result.plot().lines) == 3 * ends
    matplotlib.pyplot.close("all")


@every
def test_what_is_not_known_is_refused_in_one_sentence(name, tmp_path):
    result = answer(name)
    for field in IN_BODIES:
        if result.has_bodies:
            assert np.isfinite(getattr(result, field)(0.3, 0.2, 0.5)).all()
        else:
            with pytest.raises(sf.SceneError, match=f"{field}: a {type(result).__name__} does not"):
                getattr(result, field)(0.3, 0.2, 0.5)
    travelled = pickle.loads(pickle.dumps(result))
    assert travelled.slip(X, T).tolist() == result.slip(X, T).tolist()
    result.save(tmp_path / "saved")
    functions = name == "rate-and-state"  # which no file holds
    loaded = sf.load(tmp_path / "saved", result.scene if functions else None)
    assert loaded.slip(X, T).tolist() == result.slip(X, T).tolist()


def test_path_and_work_of_a_pair_are_those_of_one_body():
    """The solver of two bodies, of equal ones, against the closed form with its own totals."""
    scene = sf.Scene(sf.Material(1.0, 1.0, 0.25), 0.4, BASE, sf.Tractions(0.0, 0.8))
    pair = sf.Scene(scene.material, 0.4, scene.base, scene.load, lower_material=scene.material)
    first, two, x = sf.solve(scene), coupled(pair, 1e-9), np.linspace(0.03, 1.6, 12)
    for name in ("path", "work_density"):
        known, found = (getattr(each, name)(x, 1.3) for each in (first, two))
        np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-8 * known.max())


@pytest.mark.parametrize("name", ["whole-line-patch", "point-load", "growing-load"])
def test_work_at_all_places_is_the_work_of_the_whole(name):
    result = sf.solve(name)
    edge, (share, weight) = result.edge_speed, np.polynomial.legendre.leggauss(60)
    x = edge * ((1 + share) / 2) ** 2  # crowded at the load, where a patch's rate is infinite
    rule = edge * weight * (1 + share) / 2
    sides = 1 if name == "growing-load" else 2
    assert sides * rule @ result.work_density(x, 1.0) == pytest.approx(
        float(result.frictional_work(1.0)), rel=2e-3
    )
    assert sides * rule @ result.path(x, 1.0) == pytest.approx(
        float(result.accumulated_slip(1.0)), rel=2e-3
    )


def test_a_march_adds_up_path_and_work_as_its_steps_do():
    run = sf.solve("harmonic", nodes=100)
    x = run.interface.x[: run.nodes]
    np.testing.assert_allclose(run.path(x, run.end_time), run.final_path, rtol=0.02, atol=1e-4)
    work = run.work_density(x, run.end_time)
    np.testing.assert_allclose(work, run.final_work_density, rtol=0.02, atol=1e-5)


RUNS = {
    "patch": lambda: scene_along(UNIT, sf.Coulomb(0.5), 8.0, loads=[PATCH]),
    "even": lambda: scene_along(UNIT, sf.Coulomb(0.5), 8.0, loads=[PATCH], even=True),
    "contacts": lambda: scene_along(
        UNIT, sf.Coulomb(0.3), 16.0, contact=sf.Contact([(-4.0, -1.0), (1.0, 4.0)]), loads=[PUSH]
    ),
    "two bodies": lambda: scene_along(
        UNIT, sf.Coulomb(0.5), 8.0, loads=[PATCH], lower_material=sf.Material(0.3, 1.0, 0.25)
    ),
    "rate-and-state": lambda: scene_along(UNIT, SLOWING, 8.0, shear=0.6, loads=[BUMP], rate=1e-6),
}
PATCH = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 0.6))
PUSH = sf.InterfaceLoad(0.5, on="slot")

run_of = cache(lambda name: sf.solve(RUNS[name](), end_time=1.2, nodes=128, estimate=False))
every_run = pytest.mark.parametrize("name", RUNS)


@every_run
def test_a_run_answers_between_its_nodes_and_frames(name):
    run = run_of(name)
    on = np.flatnonzero(run.interface.touching & (run.interface.x > 0))
    frame, x = len(run.interface.t) // 2, run.interface.x[on]
    sides = (1, -1) if run.scene.even else (1,)
    for side in sides:
        seen = run.history(side * x, run.interface.t[[frame, -1]])
        for field in ("slip", "slip_rate", "shear_traction", "pressure", "gap"):
            known = getattr(run.interface, field)[[frame, -1]][:, on]
            np.testing.assert_allclose(getattr(seen, field), known, rtol=1e-12, atol=1e-14)
    neighbours = x[:2] if np.diff(on)[0] == 1 else x[1:3]
    times = run.interface.t[[frame, frame + 1]]
    corners = run.history(neighbours, times).slip
    middle = run.history(neighbours.mean(), times.mean()).slip
    np.testing.assert_allclose(middle, corners.mean(), rtol=1e-12, atol=1e-14)


@every_run
def test_arrivals_zones_and_openings_of_a_run_follow_its_nodes(name):
    run = run_of(name)
    on = run.interface.touching
    when = run.arrival(run.interface.x[on])
    np.testing.assert_array_equal(when, run.seen.onset[on])
    senses = [run.arrival(run.interface.x[on], of) for of in ("forward", "reverse")]
    assert np.isfinite(senses).any()
    assert np.isinf(run.arrival(run.interface.x[on], "opening")).all()
    assert run.openings_at(1.2) == ()
    rate, zones = run.interface.slip_rate[-1], run.zones_at(1.2)
    assert len(zones) > 0
    assert all(zone.end <= two.start for zone, two in pairwise(zones))
    sense = np.where(
        on & (np.abs(rate) > 1e-6 * np.abs(run.interface.slip_rate[:, on]).max()), rate, 0.0
    )
    sense = np.sign(sense)
    pairs = np.flatnonzero((sense[1:] == sense[:-1]) & (sense[1:] != 0))  # one node is no zone
    for node in (*pairs, *(pairs + 1)):
        (around,) = [zone for zone in zones if zone.start < run.interface.x[node] < zone.end]
        assert around.sense == sense[node]
    for entry in zones if not run.scene.even else zones[-1:]:
        assert (
            sense[(run.interface.x > entry.start) & (run.interface.x < entry.end)] == entry.sense
        ).sum() >= 2


@every_run
def test_a_run_adds_up_path_and_work_as_its_steps_do(name):
    run = run_of(name)
    x, end = run.interface.x[run.interface.touching], run.end_time
    slip = np.abs(run.interface.slip[-1][run.interface.touching])
    assert (run.path(x, end) >= slip * (1 - 1e-9)).all()
    total = run._weights[run.interface.touching] @ run.work_density(x, end)
    assert total == pytest.approx(run.work["friction"], rel=0.03)


def test_what_a_run_does_not_know_it_refuses_in_one_sentence():
    run = run_of("contacts")
    with pytest.raises(sf.SceneError, match=r"this answer reaches to \|x\| = 8, got 8.5; ask for"):
        run.history(8.5, 1.0)
    with pytest.raises(sf.SceneError, match=r"the bodies do not touch at x = 0.5; ask for"):
        run.arrival(0.5)
    for ask in (lambda: run.path(2.0, 1.3), lambda: run.zones_at(1.3)):
        with pytest.raises(sf.SceneError, match=r"this answer ends at t = 1.2; ask for earlier"):
            ask()
    with pytest.raises(sf.SceneError, match="of must be one of"):
        run.arrival(2.0, "else")
    few = sf.solve(RUNS["patch"](), end_time=1.2, nodes=128, estimate=False, times=[0.6, 1.2])
    for total in TOTALS:  # of every step, stored or not
        assert getattr(few, total)(1.1) == getattr(run_of("patch"), total)(1.1) > 0
    for ask in (few.path, few.work_density):
        with pytest.raises(sf.SceneError, match="stored times are too few"):
            ask(0.1, 1.2)


def test_openings_of_a_run_lie_where_its_gap_is_open():
    lift = sf.InterfaceLoad(0.0, pressure=lambda x: -2.0 * (abs(x) < 1))
    face = scene_along(UNIT, sf.Coulomb(0.5), 16.0, pressure=1.0, loads=[lift])
    run = sf.solve(face, end_time=0.5, nodes=128, estimate=False)
    (opening,) = run.openings_at(0.5)
    open_at = run.interface.x[run.interface.gap[-1] > 0]
    spacing = run.interface.x[1] - run.interface.x[0]
    assert open_at[0] - 2 * spacing <= opening.start < open_at[0]
    assert open_at[-1] < opening.end <= open_at[-1] + 2 * spacing
    assert run.arrival(0.0, "opening") <= run.interface.t[1]
