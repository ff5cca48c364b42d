"""Surveys of interfaces: every number is a parameter, and values are those of single runs."""

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.parameters.numbers import numbers_of, with_numbers
from slipfront.surveys.run import survey

FAULT = """
period = 16.0
base = {pressure = 1.0, shear = "0.2 + 0.1 * exp(-x**2)"}
even = true
contact = {intervals = [[-inf, -5.0], [-3.0, 3.0], [5.0, inf]]}
[numbers]
radius = 1.0
[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.25
[friction_law]
kind = "slip-weakening"
static = 0.6
dynamic = 0.2
distance = 1.0
[[load]]
shear = "0.6 * (abs(x) < radius)"
on = "line"
history = {kind = "ramp", rise_time = 0.5}
[[load]]
shear = 0.1
on = "slot"
[run]
end_time = 2.0
nodes = 32
"""


@pytest.fixture
def fault(tmp_path, monkeypatch):
    (tmp_path / "fault.toml").write_text(FAULT)
    monkeypatch.chdir(tmp_path)
    return sf.find("fault.toml")


def test_every_number_can_be_changed_alone(fault):
    known = numbers_of(fault)
    assert {"friction", "radius", "load_1_shear_factor", "load_1_history_rise_time"} <= set(known)
    assert {"contact_1_end", "contact_2_begin", "base_shear_factor", "load_2_shear"} <= set(known)
    for name, parameter in known.items():
        value = parameter.value * 1.1 + 0.01 * (parameter.value == 0)
        changed = numbers_of(with_numbers(fault, {name: value}))
        others = {key for key in known if changed[key].value != known[key].value}
        # the ratio of dynamic to static friction stays; a lower body is like the upper one
        along = {"friction_law_dynamic", "friction_law_reduction", f"lower_{name}"}
        assert {name} <= others <= {name, *along}
        assert changed[name].value == pytest.approx(value, rel=1e-13)
    moved = with_numbers(fault, {"contact_1_end": 2.5, "contact_2_begin": 4.5})
    assert moved.contact.intervals[1:] == ((-2.5, 2.5), (4.5, np.inf))
    assert moved.contact.intervals[0][1] == -4.5
    wide = with_numbers(fault, {"radius": 2.0, "base_shear_factor": 3.0})
    assert wide.loads[0].traction([1.5], 1.0).tolist() == [0.6]
    assert wide.base.shear(np.array([0.0])) == pytest.approx(0.9)


def test_points_are_those_of_single_runs(fault):
    places = {"x": [-1.0, 4.0], "t": [1.0]}
    found = survey(
        "fault.toml", friction_law_distance=[0.8, 1.2], radius=[1.5, 0.5], **places, workers=1
    )
    for distance, radius in ((0.8, 1.5), (1.2, 0.5)):
        point = found.sel(friction_law_distance=distance, radius=radius)
        own = with_numbers(fault, {"friction_law_distance": distance, "radius": radius})
        done = sf.solve(own, end_time=2.0, nodes=32, times=[1.0])
        assert point.status == done.status
        assert point.error_estimate == done.error_estimates["slip"]
        assert point.frictional_work == done.work["friction"]
        assert point.largest_slip_rate == done.totals.peak_rate.max() > 0
        assert point.slipped_length == done.slipped_length > 0
        near = np.interp(1.0, done.interface.x, done.interface.slip_rate[0])
        assert point.slip_rate.sel(x=-1.0, t=1.0) == pytest.approx(near, rel=1e-12)
        assert np.isnan(point.slip_rate.sel(x=4.0, t=1.0))  # a slot
        begun = np.interp(1, done.interface.x, done.seen.onset)
        assert np.nan_to_num(point.arrival.sel(x=-1.0), nan=np.inf) == pytest.approx(begun)
    # the narrow patch does not break x = 1
    arrivals = found.arrival.sel(x=-1.0, friction_law_distance=1.2).values
    assert arrivals[0] > 0
    assert np.isnan(arrivals[1])
    assert found.friction_law_distance.attrs["units"] == "length"


def test_an_interrupted_survey_of_functions_goes_on(tmp_path):
    """Functions stay in this process; another function is another survey."""

    def fault(height):
        load = sf.InterfaceLoad(lambda x: height * np.exp(-(x**2)))
        return scene_along(sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.5), 8.0, loads=[load])

    calls = []

    def stop(done, count):
        calls.append(done)
        if done == 1:
            raise KeyboardInterrupt

    options = {"end_time": 0.5, "nodes": 16, "path": tmp_path / "a.nc", "workers": 2}
    with pytest.raises(KeyboardInterrupt):
        survey(fault(1.0), **options, friction=[0.3, 0.5], progress=stop)
    with pytest.raises(sf.DataFileError, match="another survey"):
        survey(fault(1.1), **options, friction=[0.3, 0.5])
    data = survey(fault(1.0), **options, friction=[0.3, 0.5], progress=stop)
    assert calls == [1, 2]
    assert data.largest_slip[0] > data.largest_slip[1] > 0
    endless = survey(fault(1.0), friction=[0.3], nodes=16)
    assert "end_time is missing" in endless.status.values[0]


def test_the_command_writes_and_a_refused_point_says_why(fault, printed):
    shown = printed("survey fault.toml --vary friction_law.distance=-1,1 --output a.nc --workers 1")
    assert shown["methods"] == {"none": 1, "space-time": 1}
    assert any("distance must be positive" in status for status in shown["statuses"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("radius = 1.0", "radius = 1.0\nwidth = 2.0", "width appears in no expression"),
        ("radius = 1.0", "rate = 1.0", "is a reserved name"),
        ("radius = 1.0", 'radius = "1"', "finite number"),
        ("< radius", "< size", "size is not known here"),
    ],
)
def test_numbers_that_mean_nothing_are_refused(old, new, message, tmp_path):
    (tmp_path / "bad.toml").write_text(FAULT.replace(old, new))
    with pytest.raises(sf.SceneError, match=message):
        sf.find(tmp_path / "bad.toml")
