"""Fits of interfaces to records: the truth is found, and what cannot be fitted is refused."""

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.inversion.interfaces import RecordedRun, TrialInterface, recorded

SOLID = sf.Material(1.0, 1.0, 0.25)


def fault(dynamic=0.2):
    load = sf.InterfaceLoad(lambda x: 1.2 * np.exp(-(x**2)), sf.Ramp(1.0))
    law = sf.SlipDependent(0.6, dynamic, 1.0)
    return sf.Interface(SOLID, law, 12.0, shear=0.3, loads=[load], even=True)


def gauges(run, noise, quantity="slip"):
    t, random = np.linspace(0.6, 2.4, 7), np.random.default_rng(1)
    return [
        sf.Gauge(
            x=x,
            t=t,
            values=np.interp(t, run.t, run.at(getattr(run, quantity), [x])[:, 0])
            + noise * random.standard_normal(len(t)),
            noise=noise,
            quantity=quantity,
        )
        for x in (-1.0, 0.0, 1.5)
    ]


@pytest.fixture(scope="module")
def truth():
    return sf.run(fault(), 2.5, 128, estimate=False, frames=1000)


def test_a_law_is_found_from_slip(truth):
    """Friction within three standard errors, from a guess that is far off."""
    records = gauges(truth, 0.02)
    prior = {"law_dynamic": sf.Uniform(0.0, 0.5)}
    found = sf.fit(records, fault(0.35), "law.dynamic", nodes=64, priors=prior)
    assert found.parameters == ("law_dynamic",)
    assert found.status == "converged"
    assert found.values[0] == pytest.approx(0.2, abs=3 * found.standard_errors[0])
    assert 0 < found.standard_errors[0] < 0.02
    assert found.scene.interface.law.dynamic == found.values[0]
    assert 0 < found.derivative_error < 0.1


def test_a_grid_that_gauges_can_see_is_not_converged(truth):
    records = gauges(truth, 1e-4)
    found = sf.fit(records, fault(), "gain", nodes=32)
    assert not found.status.startswith("converged")
    found = sf.fit(gauges(truth, 0.05), fault(), "gain", nodes=64)
    assert found.status == "converged"


def test_gauges_see_between_frames_and_nodes(truth):
    """Slip between frames is the integral of the rate; t < 0 is before the load."""
    described = TrialInterface(fault(), 2.5, {})
    few = sf.run(fault(), 2.5, 128, estimate=False, frames=12)
    seen = RecordedRun(described, few)
    t = np.linspace(0.1, 2.4, 40)
    known = np.interp(t, truth.t, truth.at(truth.slip, [0.3])[:, 0])
    assert len(few.t) < 20
    assert seen.slip(np.full(40, 0.3), t) == pytest.approx(known, abs=2e-3 * known.max())
    assert seen.slip(np.array([0.0]), np.array([-1.0])).tolist() == [0.0]
    assert seen.shear_traction(np.array([0.0]), np.array([-1.0])).tolist() == [0.3]
    other = recorded(described.changed({"law_dynamic": 0.5}), 32, estimate=False)
    assert other.run.slip.max() < truth.slip.max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameters": "law.dist"}, "parameters must be among .*law_distance"),
        ({"parameters": ("law_static", "law.static")}, "each of them once"),
        ({"parameters": "gain:A"}, "of no gauge"),
        ({"scene": sf.find_scene("preloaded"), "parameters": "friction"}, "no effect on a scene"),
        ({"quantity": "vx", "y": 0.1}, "known on y = 0"),
        ({"t": [-2.0, -1.0, -0.5]}, "before the load"),
    ],
)
def test_what_cannot_be_fitted_is_refused(change, message):
    record = {"x": 1.0, "t": [0.5, 1.0, 1.5], "values": [0.0, 0.1, 0.2], "noise": 0.01}
    record |= {"quantity": "slip"}
    record |= {name: one for name, one in change.items() if name in ("quantity", "y", "t")}
    asked = {"scene": fault(), "parameters": "law_dynamic", "nodes": 32}
    asked |= {name: one for name, one in change.items() if name not in record}
    with pytest.raises(sf.SceneError, match=message):
        sf.fit([sf.Gauge(**record)], **asked)


def test_gauges_of_scenes_stand_on_the_contact():
    record = sf.Gauge(x=-0.1, t=[1.0], values=[0.1], noise=0.1, quantity="slip")
    with pytest.raises(sf.SceneError, match=r"slip at x = -0.1: x must be"):
        sf.fit([record], sf.find_scene("preloaded"), "friction")
    punch = sf.find_interface("punch").interface
    off = sf.Gauge(x=2.0, t=[1.0], values=[0.1], noise=0.1, quantity="slip")
    with pytest.raises(sf.SceneError, match="do not touch at x = 2"):
        sf.fit([off], punch, "law.friction")
