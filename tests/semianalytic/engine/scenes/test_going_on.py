"""Marches that are saved, interrupted and continued, and options that are refused."""

from dataclasses import fields

import numpy as np
import pytest
from catalogue import gone_on, unit_scene

import semianalytic as sf
from semianalytic.engine.stepping import blocks
from tests.semianalytic.engine.scenes.runs import march, preloaded, relative_l1


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    "history",
    [
        sf.Pulse(0.5),
        sf.Step(),
        sf.Ramp(0.4),
        sf.Harmonic(1.3),
        sf.Tabulated((0.0, 0.5, 0.5, 1.0), (0, 1, 0.2, 0)),
    ],
)
def test_continued_march_equals_one_march(history, tmp_path):
    """Its fields, totals, extremes and companion; from a file as from memory, to the bit.

    One march does not round its memory, of single precision here, where the other is continued.
    """
    rounding = 1e-7
    scene = preloaded(shear_history=history)
    whole = march(scene, end_time=1.0, nodes=200, length=1.0)
    part = march(scene, end_time=0.4321, nodes=200, length=1.0, latest=1.0)
    part.save(tmp_path / "march.h5")
    loaded = sf.Marched.load(tmp_path / "march.h5")
    assert loaded.scene == scene
    assert loaded.error_estimate == part.error_estimate
    assert loaded.companion.companion is None
    continued, stored = gone_on(part, 1.0), gone_on(loaded, 1.0)
    for name in ("interface", "seen", "totals"):
        left, other, all_at_once = (getattr(run, name) for run in (continued, stored, whole))
        for field in fields(left):
            every = (getattr(each, field.name) for each in (left, other, all_at_once))
            first, found, wanted = (np.array(each, dtype=float) for each in every)
            np.testing.assert_array_equal(first, found)
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=rounding)
    np.testing.assert_allclose(stored.final_path, whole.final_path, atol=rounding)
    assert stored.error_estimate == pytest.approx(whole.error_estimate, rel=1e-6)
    found, wanted = (run.companion.interface.slip[-1] for run in (stored, whole))
    np.testing.assert_allclose(found, wanted, atol=rounding)


def test_what_a_march_cannot_go_on_to_is_refused(tmp_path):
    part = march(preloaded(), end_time=0.5, nodes=100, latest=0.8, estimate=False)
    part.save(tmp_path / "alone.h5")
    assert np.isnan(gone_on(sf.Marched.load(tmp_path / "alone.h5"), 0.8).error_estimate)
    at_jump = march(preloaded(shear_history=sf.Pulse(0.5)), end_time=0.5, nodes=60, latest=0.8)
    assert gone_on(at_jump, np.nextafter(0.5, 1.0)).end_time == at_jump.end_time == 0.5
    with pytest.raises(sf.SceneError, match=r"end_time must be above 0\.5"):
        gone_on(part, 0.5)
    with pytest.raises(sf.SceneError, match="start again with a later `latest`"):
        gone_on(part, 0.9)
    with pytest.raises(sf.SceneError, match="keeps its grid and steps; leave out `nodes`"):
        gone_on(part, 0.8, nodes=200)
    with pytest.raises(sf.SceneError, match="is a march of another scene"):
        sf.solve(unit_scene(0.31), method="space-time", go_on=part, end_time=0.8)


@pytest.mark.parametrize("steps", [1, 3])
def test_blocks_of_steps_change_nothing(steps, monkeypatch):
    """Blocks end anywhere: at a jump, at a stop, between levels of the companion."""
    scene = preloaded(shear_history=sf.Pulse(0.5), law=sf.SlipWeakening(1.0, 0.5, 0.5))

    def marches():
        stopped = march(scene, nodes=60, every=5, progress=lambda time, end: time > 0.547 * end)
        return stopped, gone_on(stopped, 1.0)

    found = marches()
    monkeypatch.setattr(blocks, "BLOCK_STEPS", steps)
    for answer, other in zip(found, marches(), strict=True):
        assert answer.steps == other.steps
        assert answer.error_estimate == pytest.approx(other.error_estimate, rel=1e-10)
        for part in ("interface", "totals", "seen"):
            for name, values in vars(getattr(answer, part)).items():
                both = (
                    np.array(each, float) for each in (values, vars(getattr(other, part))[name])
                )
                np.testing.assert_allclose(*both, rtol=1e-10, atol=1e-12, err_msg=name)


def test_solver_is_chosen_by_the_scene():
    exact, forced = sf.solve(preloaded()), march(preloaded(), nodes=50)
    assert isinstance(exact, sf.Solution)
    assert isinstance(forced, sf.Marched)
    x = forced.interface.x
    assert relative_l1(forced.slip(x, 1.0), exact.slip(x, 1.0)) < 0.01
    ramp = preloaded(shear_history=sf.Ramp(0.3))
    marched = sf.solve(ramp, end_time=0.4, nodes=50, length=1.0)
    assert (marched.end_time, marched.nodes, marched.interface.t[0]) == (0.4, 50, 0)
    assert marched.interface.x[-1] == pytest.approx(0.99)
    with pytest.raises(sf.SceneError, match=r"space-time solver.*docs/limits"):
        sf.solve(ramp, method="self-similar")
    with pytest.raises(sf.SceneError, match="method must be one of"):
        sf.solve(ramp, method="fem")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"end_time": 0.0}, "end_time must be above 0"),
        ({"nodes": 8}, "whole number from 16"),
        ({"step_ratio": 1.2}, "beyond the stable range .* lower it by"),
        ({"step_ratio": 0.0}, "step_ratio must be above 0"),
        ({"damping": 1.5}, "damping must lie between"),
        ({"every": 0}, "whole number of at least 1"),
        ({"tolerance": 1.0}, "at most 0.01"),
        ({"nodes": 100, "rtol": 1e-2}, "leave out `nodes`, or `rtol`"),
        ({"rtol": 1e-2, "estimate": False}, "`rtol` needs the estimate"),
        ({"rtol": 2.0}, "rtol must be above 0 and at most 1"),
    ],
)
def test_bad_options(options, message):
    with pytest.raises(sf.SceneError, match=message):
        march(preloaded(), **options)


@pytest.mark.parametrize(
    ("options", "solved"),
    [
        ({}, True),
        ({"pressure_history": sf.Pulse(0.5)}, False),
        ({"law": sf.RateWeakening(1.0, 0.9, 5.0)}, False),
    ],
)
def test_tension_is_refused_and_sends_nobody_to_a_solver_that_refuses(options, solved):
    scene = unit_scene(0.3, (0.02, 0.0), (1.0, 0.0), **options)
    with pytest.raises(sf.TensionError, match=r"turn tensile at x.*docs/limits") as refusal:
        march(scene, nodes=100, length=1.0)
    assert ("use `solve`" in str(refusal.value)) == solved
