"""Surveys: what each point holds is what the solvers say of its scene, refused or not."""

import json
import re

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import slipfront as sf
from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import scene_document
from slipfront.surveys import survey

SOLID = sf.Material(80e9, 7800.0, 0.29)
STEEL = sf.Scene(SOLID, 0.25, sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 5e6), units="SI")
FALLING = {"shear_history": sf.Ramp(0.5), "law": sf.SlipWeakening(1.0, 0.8, 0.5)}
WEAKENING = unit_scene(nu=0.3, **FALLING)


def assert_holds(point, solution):
    """Fail unless a point is a solution, within their estimates."""
    off = float(point.error_estimate) + solution.error_estimate
    speed = solution.scene.material.shear_speed
    count = len(solution.zones)
    assert point.sense.values[:count].tolist() == [zone.sense for zone in solution.zones]
    assert not point.sense.values[count:].any()
    edges, known = point.edges.values[:count], solution.edge_speeds
    finite = np.isfinite(known)
    assert np.array_equal(np.isfinite(edges), finite)
    assert np.abs(edges - known)[finite].max(initial=0) <= off * speed
    assert np.isnan(point.edges.values[count:]).all()
    assert float(point.edge_slip_rate) == pytest.approx(solution.edge_slip_rate, rel=off, abs=1e-15)
    intensity = np.stack(solution.stress_intensity(1.0))
    assert point.stress_intensity.values == pytest.approx(intensity, rel=off, abs=1e-15)
    assert str(point.status.values) == solution.status
    opening = [(opening.inner, opening.outer) for opening in solution.openings]
    if "opening" in point:
        expected = np.array(opening[0]) if opening else np.full(2, np.nan)
        assert point.opening.values == pytest.approx(expected, abs=off * speed, nan_ok=True)
    else:
        assert not opening


def test_a_grid_holds_what_single_solutions_say():
    """Zones are one or two here: rows of edges are ragged."""
    data = survey(STEEL, friction=[0.1, 0.2, 0.9], poisson_ratio=[0.1, 0.4])
    assert dict(data.sizes) == {"friction": 3, "poisson_ratio": 2, "zone": 2, "edge": 2, "mode": 2}
    for friction in (0.1, 0.2, 0.9):
        for ratio in (0.1, 0.4):
            scene = with_numbers(STEEL, {"friction": friction, "poisson_ratio": ratio})
            assert_holds(data.sel(friction=friction, poisson_ratio=ratio), sf.solve(scene))
    counts = (data.sense != 0).sum("zone").values
    assert {1, 2} <= set(counts.ravel().tolist())
    solids = [with_numbers(STEEL, {"poisson_ratio": number}).material for number in (0.1, 0.4)]
    for name in ("rayleigh", "shear", "longitudinal"):
        speeds = [getattr(solid, f"{name}_speed") for solid in solids]
        assert data[f"{name}_speed"].dims == ("poisson_ratio",)
        assert data[f"{name}_speed"].values == pytest.approx(speeds, rel=1e-13)


def test_every_variable_has_unit_and_meaning():
    data = survey(
        STEEL, friction=[0.2, 0.3], base_shear=[0.0, 1e5], load_pressure=0.0, x=[0.1], t=[1e-4]
    )
    units = {name: variable.attrs.get("units") for name, variable in data.variables.items()}
    assert units["edges"] == units["shear_speed"] == units["edge_slip_rate"] == "m/s"
    assert units["stress_intensity"] == "Pa sqrt(m)"
    assert units["base_shear"] == units["load_pressure"] == units["pressure"] == "Pa"
    assert (units["x"], units["t"], units["friction"]) == ("m", "s", "1")
    words = ("edge", "mode")
    assert all(unit for name, unit in units.items() if name not in words)
    assert all(row.attrs["long_name"] for name, row in data.variables.items() if name not in words)
    assert json.loads(data.attrs["scene"]) == scene_document(STEEL)
    assert data.attrs["source"] == f"slipfront {sf.__version__}"
    assert "friction=[0.2, 0.3]" in data.attrs["command"]
    assert data.attrs["rtol"] == 1e-6


def test_fields_and_totals_are_those_of_solutions():
    x, t = [0.1, 0.25], [5e-5, 1e-4]
    data = survey(STEEL, friction=[0.2, 0.3], x=x, t=t, fields=["slip_rate", "slip"], rtol=1e-9)
    solution = sf.solve(with_numbers(STEEL, {"friction": 0.3}))
    there = data.sel(friction=0.3)
    for name in ("slip_rate", "slip"):
        known = getattr(solution, name)(np.array(x), np.array(t)[:, None])
        assert there[name].dims == ("t", "x")
        assert there[name].values == pytest.approx(known, rel=1e-6)
    assert "pressure" not in data
    assert float(there.largest_slip) == pytest.approx(float(solution.max_slip(1e-4)), rel=1e-6)
    assert float(there.end_time) == 1e-4


def test_refused_points_say_why_and_lose_nothing_else():
    data = survey(PRELOADED, friction=[0.2, -0.1], poisson_ratio=[0.3, 0.5], base_pressure=[0, 1])
    kinds = data.status.values.ravel().tolist()
    assert kinds.count("converged") == 2
    refused = data.sel(friction=0.2, poisson_ratio=0.5, base_pressure=1)
    assert str(refused.status.values).startswith("material: poisson_ratio must lie strictly")
    assert str(refused.method.values) == "none"
    assert np.isnan(refused.edges.values).all()
    assert np.isnan(data.rayleigh_speed.values[1])
    tension = survey(sf.find("tap"), friction=[0.2, 0.3], base_pressure=[0.0, 0.02])
    statuses = tension.sel(base_pressure=0.0).status.values
    assert all(status.startswith("scene: under a base pressure of 0") for status in statuses)
    for friction in (0.2, 0.3):
        scene = with_numbers(sf.find("tap"), {"friction": friction, "base_pressure": 0.02})
        where = tension.sel(friction=friction, base_pressure=0.02)
        assert_holds(where, sf.solve(scene, rtol=1e-6))


def test_a_plane_of_which_a_part_is_refused_is_swept_ratio_by_ratio(monkeypatch):
    """Sweeps that fail for some Poisson ratio are tried without it."""
    from slipfront.surveys import points

    whole = points.sweep

    def fragile(scene, friction, rtol, poisson_ratio):
        if np.any(poisson_ratio == 0.2):
            raise sf.TensionError("scene: torn open.")
        return whole(scene, friction, rtol, poisson_ratio=poisson_ratio)

    monkeypatch.setattr(points, "sweep", fragile)
    data = survey(PRELOADED, friction=[0.2, 0.3], poisson_ratio=[0.1, 0.2], workers=1)
    assert set(data.status.values.ravel()) == {"converged"}
    alone = survey(PRELOADED, friction=[0.2, 0.3], poisson_ratio=[0.2, 0.3], workers=1)
    a, b = data.sel(poisson_ratio=0.2), alone.sel(poisson_ratio=0.2)
    assert a.drop_vars("seconds").equals(b.drop_vars("seconds"))


def test_marches_hold_their_numbers():
    values = {"friction_law.reduction": [0.0, 0.3], "shear_history_rise_time": 0.4}
    data = survey(WEAKENING, **values, end_time=0.8, nodes=60)
    assert data.friction_law_reduction.dims == ("friction_law_reduction",)
    assert float(data.shear_history_rise_time) == 0.4
    scene = with_numbers(WEAKENING, {"friction_law_reduction": 0.3, "shear_history_rise_time": 0.4})
    march = sf.solve(scene, end_time=0.8, nodes=60)
    there = data.sel(friction_law_reduction=0.3)
    assert float(there.largest_slip) == march.totals.max_slip.max()
    assert float(there.onset) == march.seen.onset.min()
    assert float(there.frictional_work) == march.frictional_work(0.8)
    assert float(there.error_estimate) == march.error_estimate
    assert str(there.status.values) == (march.caution or "resolved")
    assert str(there.method.values) == "space-time"
    assert data.frictional_work.attrs["units"] == "stress length^2"


def test_a_viscosity_turns_friction_viscous_and_back():
    data = survey(PRELOADED, viscosity=[0.0, 0.2], friction=[0.2, 0.4])
    for viscosity in (0.0, 0.2):
        scene = with_numbers(PRELOADED, {"viscosity": viscosity, "friction": 0.4})
        assert isinstance(scene.friction, sf.Coulomb) == bool(viscosity)
        assert_holds(data.sel(viscosity=viscosity, friction=0.4), sf.solve(scene, rtol=1e-6))


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(
        st.tuples(st.floats(0.02, 1.5), st.floats(-0.4, 0.45), st.floats(0.2, 3.0)),
        min_size=2,
        max_size=5,
        unique=True,
    )
)
def test_lists_of_points_are_single_solutions_within_estimates(points):
    """In whatever order, and however zones differ among them."""
    friction, ratio, pressure = np.array(points).T
    values = {"friction": friction, "poisson_ratio": ratio, "base_pressure": pressure}
    data = survey(PRELOADED, together=True, workers=1, **values)
    assert data.sizes["point"] == len(points)
    for i, numbers in enumerate(zip(*values.values(), strict=True)):
        scene = with_numbers(PRELOADED, dict(zip(values, numbers, strict=True)))
        assert_holds(data.isel(point=i), sf.solve(scene, rtol=1e-6))


@pytest.mark.slow
def test_many_points_of_a_plane_are_single_solutions():
    """Enough of them for points between to be followed and evaluated together."""
    friction, ratio = np.linspace(0.05, 0.9, 20), np.linspace(-0.2, 0.45, 20)
    data = survey(PRELOADED, friction=friction, poisson_ratio=ratio, workers=1)
    assert (data.origin == "interpolated").sum() > 50
    for i, j in np.random.default_rng(1).integers(0, 20, (12, 2)):
        values = {"friction": friction[i], "poisson_ratio": ratio[j]}
        assert_holds(data.sel(**values), sf.solve(with_numbers(PRELOADED, values), rtol=1e-6))


@pytest.mark.parametrize(
    ("values", "options", "said"),
    [
        ({"frction": [0.1]}, {}, "no parameter 'frction'; did you mean friction?"),
        ({"rise_time": [0.1]}, {}, "no parameter 'rise_time'; it has friction, "),
        ({"friction": []}, {}, "must be a number or a row of finite"),
        ({"friction": [np.nan]}, {}, "must be a number or a row of finite"),
        ({}, {}, "give values of at least one"),
        ({"viscosity": [1], "friction_law.viscosity": [1]}, {}, "viscosity is given twice"),
        (
            {"friction": [1, 2], "density": [1]},
            {"together": True},
            "equal lengths, got 2 of friction, 1 of density",
        ),
        ({"friction": [0.1]}, {"rtol": -1}, "rtol must be positive"),
        ({"friction": [0.1]}, {"chunk": 0}, "chunk must be a whole number"),
        ({"friction": [0.1]}, {"x": [1.0]}, "give x and t"),
        ({"friction": [0.1]}, {"x": [-1.0], "t": [1.0]}, "x must be positions on the contact"),
        ({"friction": [0.1]}, {"x": "a", "t": 1.0}, "x must be a number or an array of numbers"),
        ({"friction": [0.1]}, {"x": 1, "t": 1, "fields": ["speed"]}, "fields must be some of"),
        ({"friction": [0.1]}, {"path": "a.csv"}, "let its name end in .nc"),
        # what no machine can hold
        ({"friction": np.zeros(10**7 + 1)}, {}, "1e+07 values of friction are too many"),
        (
            {"friction": np.ones(10**6), "poisson_ratio": np.zeros(10**6)},
            {},
            "1e+12 points are too many; take at most 1e+08",
        ),
        (
            {"base_pressure": np.ones(10**4), "load_shear": np.ones(2000)},
            {},
            "2e+05 chunks are too many; raise `chunk` to 200",
        ),
        (
            {"friction": [0.1, 0.2]},
            {"x": np.ones(40_000), "t": np.ones(40_000)},
            "a chunk of 2 points of 4,800,000,000 numbers would take 192 GB",
        ),
    ],
)
def test_what_cannot_be_surveyed_is_refused_in_one_sentence(values, options, said):
    with pytest.raises(SceneError, match=re.escape(said)) as raised:
        survey(PRELOADED, workers=1, **values, **options)
    assert "\n" not in str(raised.value)


def test_every_number_of_a_scene_is_a_parameter():
    assert set(numbers_of(WEAKENING)) == {
        *("friction", "shear_modulus", "density", "poisson_ratio"),
        *("lower_shear_modulus", "lower_density", "lower_poisson_ratio"),
        *("base_pressure", "base_shear", "load_pressure", "load_shear"),
        *("shear_history_rise_time", "friction_law_reduction", "friction_law_distance"),
        "friction_law_dynamic",
    }
    assert {"viscosity"} == set(numbers_of(PRELOADED)) - set(numbers_of(WEAKENING))
    changed = with_numbers(WEAKENING, {"base_pressure": 2.0, "friction_law_distance": 0.1})
    assert changed.base.pressure == 2.0
    assert changed.friction == sf.SlipWeakening(0.3, 0.24, 0.1)


@pytest.mark.parametrize("name", [None, "a.nc"])
def test_a_survey_that_does_not_fit_is_refused_before_anything_is_solved(
    name, monkeypatch, tmp_path
):
    monkeypatch.setattr("semianalytic.results.memory.available_memory", lambda: 300_000)
    monkeypatch.setattr("slipfront.surveys.run.run_tasks", None)
    asked = {"friction": np.linspace(0.2, 0.9, 1000), "path": name and tmp_path / name}
    with pytest.raises(SceneError, match=r"1,000 points would take .* each in a file of its own"):
        survey(PRELOADED, chunk=500, **asked)
    with pytest.raises(SceneError, match=r"a chunk of 1,000 points would .* or lower `chunk`"):
        survey(PRELOADED, chunk=1000, **asked)
