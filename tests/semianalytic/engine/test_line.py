"""The memory of the line over steps of any length, and the order of the steps."""

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.engine.stepping import line
from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Antiplane, InPlane
from semianalytic.memory.line_memory import LineMemory, phi
from tests.semianalytic.engine.runs import one_run

mpmath = pytest.importorskip("mpmath")
UNIT = sf.Material(1.0, 1.0, 1 / 3)


@pytest.mark.parametrize("z", [1e-6j - 1e-7, 0.0999 - 0.001j, -0.1001 + 0j, -3 + 2j, -500 + 1j])
def test_phi_functions_keep_all_digits(z):
    grown, first, second = (value[0] for value in phi(np.array([z])))
    with mpmath.workdps(40):
        exact = mpmath.mpc(z)
        power = mpmath.exp(exact)
        assert abs(grown - complex(power)) < 1e-15
        assert abs(first - complex((power - 1) / exact)) < 1e-15 * (1 + abs(first))
        assert abs(second - complex((power - 1 - exact) / exact**2)) < 1e-14 * abs(second)


@pytest.mark.parametrize("private", [True, False])
@pytest.mark.parametrize("even", [False, True])
@pytest.mark.parametrize("between", [False, True])
def test_transforms_and_their_inverses(even, between, private, monkeypatch):
    grid = Grid(3.0, 16, between, even)
    if not private:  # a version of scipy without the function behind scipy.fft
        monkeypatch.setattr(line, "_transforms", line._transforms.__wrapped__)
        monkeypatch.setattr(line, "import_module", lambda name: None)
    values = np.cos(2 * np.pi * grid.x / 3) + 0.3 + (0 if even else np.sin(4 * np.pi * grid.x / 3))
    assert np.allclose(grid.values(grid.amplitudes(values)), values, atol=1e-14)
    assert grid.amplitudes(values).shape[1] == len(grid.wavenumbers)


@pytest.mark.parametrize(("double", "error"), [(None, 1e-13), (0, 1e-6), (2, 1e-6)])
def test_memory_does_not_depend_on_how_a_linear_rate_is_cut_into_steps(double, error):
    grid = Grid(2 * np.pi, 8)
    fit = fit_memory(InPlane(0.5), 1000.0, 1e-7)
    shape = grid.amplitudes(np.cos(grid.x))
    results = []
    cuts = [2.0], [0.5, 0.25, 1.25], [1.0, 0.125, 0.125, 0.75], [0.125] * 14 + [0.25]
    for steps in cuts:
        memory, at = LineMemory(fit, grid.wavenumbers, rows=2, double=double), 0.0
        for step in steps:
            past = memory.advance(at * shape, step)
            at += step
        results.append(grid.values((past + memory.feedback * at * shape)[0]))
    for other in results[1:]:
        assert np.allclose(other, results[0], atol=error * np.abs(results[0]).max())


@pytest.mark.parametrize("double", [None, 0, 2])
def test_a_memory_is_put_back_to_the_last_bit(double):
    fit, q = fit_memory(Antiplane(), 1000.0, 1e-7), np.arange(6.0)
    rates = np.random.default_rng(0).normal(size=(12, 1, 6))

    def new():
        return LineMemory(fit, q, double=double)

    whole, seen = new(), []
    for rate in rates:
        seen.append((whole.past(), whole.advance(rate, 0.3), whole.convolution(rate)))
    for begin, (past, _, _) in enumerate(seen):
        other = new()
        other.put_back(past)
        for rate, (_, convolved, held) in zip(rates[begin:], seen[begin:], strict=True):
            assert np.array_equal(other.advance(rate, 0.3), convolved)
            assert np.array_equal(other.convolution(rate), held)


def test_a_step_much_longer_than_waves_is_static():
    """Poles add up to minus the damping: what is left is stiffness times slip."""
    fit = fit_memory(Antiplane(), 1e5, 1e-7)
    memory = LineMemory(fit, np.array([1.0]))
    assert memory.table(1e5).feedback[0, 0] == pytest.approx(fit.static * 1e5 / 2 - 1, abs=1e-4)


def test_second_order_with_state():
    """Rate-and-state, ageing, in plane: slip of a pushed fault on four step lengths."""
    law = sf.RateAndState(a=0.01, b=0.014, f0=0.6, v0=1e-3, distance=0.02)
    push = sf.InterfaceLoad(
        lambda x: 0.08 * np.exp(-(x**2)), history=lambda t: min(t, 2.0) ** 2 / 4
    )
    fault = scene_along(
        sf.Material(1.0, 1.0, 0.25), law, 16.0, shear=0.6, rate=1e-3, loads=[push], even=True
    )
    slips = []
    for count in (50, 100, 200, 800):
        stepper = Stepper(fault, 64, 0.5, end_time=4.0)
        now = stepper.begin()
        for _ in range(count):
            now = stepper.step(now, 4.0 / count, 0)
        slips.append(now.slip)
    errors = [np.abs(slip - slips[-1]).max() for slip in slips[:-1]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 4e-4 * slips[-1].max()
    assert orders.min() > 1.7


def test_odd_sweeps_are_unstable_on_a_free_face_and_even_ones_are_not():
    def largest(sweeps):
        slot = sf.InterfaceLoad(1.0, on="slot")
        scene = scene_along(
            UNIT, sf.Coulomb(9.0), 8.0, loads=[slot], contact=sf.Contact([(1.0, 3.0)])
        )
        done = one_run(scene, 8.0, 64, step_ratio=0.6, sweeps=sweeps)
        return np.abs(done.interface.slip_rate).max()

    assert largest(2) < 10
    assert largest(3) > 1e6


@pytest.mark.parametrize(("poisson", "stable"), [(0.499, 0.5), (1 / 3, 0.65), (-0.9, 1.0)])
def test_steps_beyond_the_stable_range_are_refused(poisson, stable):
    """The face of a slot would grow to 1e57 within the run, with finite values all along."""
    scene = scene_along(
        sf.Material(1.0, 1.0, poisson),
        sf.Coulomb(0.3),
        8.0,
        pressure=1.0,
        contact=sf.Contact([(-2.0, -0.5), (0.5, 2.0)]),
        loads=[sf.InterfaceLoad(0.5, on="slot")],
    )
    fine, coarse = (one_run(scene, 4.0, 64, step_ratio=step) for step in (0.2, stable))
    largest = np.abs(fine.interface.slip_rate).max()
    assert np.abs(coarse.interface.slip_rate).max() < 1.1 * largest
    assert (
        np.abs(coarse.interface.slip[-1] - fine.interface.slip[-1]).max()
        < 0.01 * fine.interface.slip.max()
    )
    with pytest.raises(sf.SceneError, match="march: `step_ratio` is beyond the stable range"):
        sf.solve(scene, end_time=4.0, nodes=64, step_ratio=10.0 if poisson < 0 else stable + 0.15)
