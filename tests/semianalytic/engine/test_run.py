"""Runs: restart, thinning, estimates, contacts against exact answers, refusals."""

import math

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.engine.run import run

UNIT = sf.Material(1.0, 1.0, 0.25)
COULOMB = sf.Coulomb(0.5)


def weakening_fault():
    law = sf.RateAndState(
        0.01, lambda x: 0.004 + 0.012 * (np.abs(x) < 2), 0.6, 1e-6, 1e-6, theta=1.3
    )
    rock = sf.Material(20e9, 2222.2, 0.25)
    return sf.Interface(rock, law, 16.0, 5e6, 3e6, rate=1e-6, plate_rate=1e-6, held=32.0, even=True)


def same(one, other):
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in (
            "t",
            "slip",
            "slip_rate",
            "shear_traction",
            "state",
            "pressure",
            "gap",
            "step_times",
        )
    )


@pytest.mark.parametrize("stop_at", [37, 90])
def test_a_run_goes_on_to_the_last_bit(stop_at, tmp_path):
    """Adaptive steps, thinned frames, through a file: as if it had not been interrupted."""
    counted = iter(range(10**6))
    options = {"nodes": 64, "estimate": False, "every": 3, "frames": 20}
    whole = run(weakening_fault(), 12.0, **options)
    part = run(weakening_fault(), 12.0, **options, progress=lambda *_: next(counted) == stop_at - 1)
    assert part.status.startswith("interrupted")
    assert part.steps == stop_at < whole.steps
    part.save(tmp_path / "a.npz")
    fault = weakening_fault()
    saved = sf.Run.load(tmp_path / "a.npz", fault)
    done = run(fault, 12.0, go_on=saved, **options)
    assert same(done, whole)
    assert len(whole.t) <= 22
    assert np.diff(whole.step_times).max() > 100 * np.diff(whole.step_times).min()


def test_another_interface_is_not_gone_on_with():
    part = run(weakening_fault(), 0.01, 32, estimate=False)
    other = sf.Interface(UNIT, COULOMB, 16.0, even=True)
    with pytest.raises(sf.DataFileError, match="another interface"):
        run(other, 1.0, 32, go_on=part)
    with pytest.raises(sf.SceneError, match="beyond"):
        run(weakening_fault(), 0.005, 32, go_on=part)


def test_what_is_done_is_kept_after_ctrl_c():
    import signal

    def press(time, end):
        if time > 0.5:
            signal.raise_signal(signal.SIGINT)

    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)))
    done = run(sf.Interface(UNIT, COULOMB, 8.0, loads=[load]), 2.0, 64, progress=press)
    assert done.status.startswith("interrupted at t = 0.5")
    assert done.slip[-1].max() > 0
    assert done.t[-1] == done.end_time < 0.6


def test_even_and_whole_lines_agree():
    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)))
    for contact in (sf.Contact(), sf.Contact([(-1.5, 1.5)])):
        halves = [
            run(
                sf.Interface(UNIT, COULOMB, 8.0, loads=[load], contact=contact, even=even),
                1.5,
                64,
                estimate=False,
            )
            for even in (True, False)
        ]
        right = halves[1].x >= 0
        count = right.sum()  # x = -length/2 is the last node of the even half
        assert halves[0].slip[-1][:count] == pytest.approx(halves[1].slip[-1][right], abs=1e-13)


def test_the_estimate_covers_the_error_and_rtol_is_met():
    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)), history=sf.Ramp(1.0))
    fault = sf.Interface(UNIT, sf.SlipDependent(0.6, 0.2, 1.0), 8.0, loads=[load], even=True)
    times = [0.5, 1.0, 2.0]
    best = run(fault, 2.0, 1024, times=times, estimate=False)
    done = run(fault, 2.0, 32, rtol=5e-3, times=times)
    assert done.nodes > 32
    assert done.error_estimates["slip"] <= 5e-3
    step = 1024 // done.nodes
    error = np.abs(done.slip - best.slip[:, ::step]).sum() / np.abs(done.slip).sum()
    assert 0 < error < done.error_estimates["slip"]


def test_two_edges_against_the_exact_solver():
    """A slot -2 < x < 0 beside a contact, until the wave of the other edge arrives."""
    scene = sf.find_scene("preloaded")
    exact = sf.solve(scene)
    fault = sf.Interface(
        scene.material,
        sf.Coulomb(0.3),
        16.0,
        loads=[sf.InterfaceLoad(1.0, on="slot")],
        contact=sf.Contact([(-math.inf, -2.0), (0.0, math.inf)]),
    )
    errors = []
    for nodes in (1024, 2048):
        done = run(fault, 1.0, nodes, times=[1.0], estimate=False)
        near = (done.x > 0) & (done.x < 3)
        rate = exact.slip_rate(done.x[near], 1.0)
        errors.append(np.abs(done.slip_rate[0][near] - rate).sum() / np.abs(rate).sum())
    assert errors[0] < 4e-3
    assert errors[1] < 1e-3


@pytest.mark.slow
def test_cattaneo_and_mindlin_in_the_slow_limit():
    """Stick |x| < c of a contact |x| < 1 under uniform pressure, on a periodic line of 8."""
    found = sf.find_interface("cattaneo")
    done = run(found.interface, found.end_time, 256, step_ratio=0.5, times=[62.0], estimate=False)
    tan = lambda x: np.tan(np.pi * x / 8)  # noqa: E731
    edge = 8 / np.pi * np.arccos(np.cos(np.pi / 8) / np.cos(np.pi * 0.15 / 2))
    assert edge == pytest.approx(0.807586, abs=1e-6)
    inside = done.x < edge
    root = (tan(1) ** 2 - tan(edge) ** 2) / (tan(edge) ** 2 - tan(done.x[inside]) ** 2)
    exact = 2 / np.pi * np.arctan(np.sqrt(root))
    error = np.abs(done.shear_traction[0][inside] - exact).sum() / exact.sum()
    assert error < 6e-3
    # the whole contact carries the load of the line
    force = done.shear_traction[0][done.touching].mean()
    assert force == pytest.approx(0.15 * 4, rel=2e-3)


def test_a_jump_of_strength_does_not_make_slip():
    """A barrier beside a slipping patch stays stuck, and its neighbour slips no faster."""
    strength = lambda x: np.where(np.abs(x) < 1, 0.5, 1e6)  # noqa: E731
    load = sf.InterfaceLoad(1.0)
    done = run(
        sf.Interface(UNIT, sf.Coulomb(strength), 8.0, loads=[load]), 1.0, 128, estimate=False
    )
    assert np.abs(done.slip_rate[:, np.abs(done.x) >= 1]).max() == 0
    # (load - strength) / (mu / 2 c_t) = 1, and what waves add; as if strength were linear: 1e5
    assert done.slip_rate.max() < 1.1


def test_slow_grids_are_called_unresolved():
    fault = sf.Interface(UNIT, sf.SlipDependent(0.6, 0.1, 0.01), 8.0, shear=0.3)
    done = run(fault, 0.1, 32, estimate=False)
    assert done.status.startswith("unresolved")
    least = int(done.status.split("use ")[1].split()[0])
    assert run(fault, 0.1, least, estimate=False).status == "done"


def test_to_xarray_has_units_and_errors():
    load = sf.InterfaceLoad(lambda x: np.exp(-(x**2)))
    data = run(sf.Interface(UNIT, COULOMB, 8.0, loads=[load]), 0.5, 32).to_xarray()
    assert data["slip"].dims == ("t", "x")
    assert data["slip_rate"].attrs["units"] == "length / time"
    assert data.attrs["error_slip"] > 0


def test_a_saved_run_is_loaded_with_its_own_interface_alone(tmp_path):
    """Another contact, period or symmetry lies on other nodes."""
    material, law = sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.3)
    strip = sf.Contact([(-2.0, 2.0)])
    own = sf.Interface(material, law, 8.0, contact=strip)
    sf.run(own, 0.2, 32, estimate=False).save(tmp_path / "own.npz")
    assert sf.Run.load(tmp_path / "own.npz", own).nodes == 32
    for other in (
        {"length": 16.0, "contact": strip},
        {"length": 8.0},
        {"length": 8.0, "contact": sf.Contact([(-1.0, 2.0)])},
        {"length": 8.0, "contact": strip, "even": True},
    ):
        with pytest.raises(sf.DataFileError, match="is a run of another interface"):
            sf.Run.load(tmp_path / "own.npz", sf.Interface(material, law, **other))
