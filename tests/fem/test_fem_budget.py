"""What a simulation takes, predicted before it starts, and refused if it is too much."""

import dataclasses
import json
import subprocess
import sys

import pytest
from catalogue import PRELOADED as SHEARED
from catalogue import UNIT, unit_scene

from fem import cost, simulate
from fem.stepping import critical_step, highest_frequency
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material
from tests.fem.runs import MIXED, prepare

NEARLY_INCOMPRESSIBLE = unit_scene(nu=0.4999)

PEAK = """
import json, sys
from pathlib import Path
from fem import cost, simulate
from semianalytic import find

def peak_memory():  # not ru_maxrss, which includes that of the process this was started from
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))

folder, options = Path(sys.argv[1]), json.loads(sys.argv[2])
scene = find("preloaded")
predicted = cost(scene, **options, snapshots=True, frames=2, checkpoint=True)
before = peak_memory()
run = simulate(
    scene, **options, snapshots=folder / "fields", frames=2, checkpoint=folder / "checkpoint.h5"
)
run.save(folder)
frames = sum(frame.stat().st_size for frame in (folder / "fields").glob("*.vtu"))
print(json.dumps({
    "memory": predicted.memory / (peak_memory() - before),
    "frames": predicted.frames / frames,
}))
"""


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("scene", "options"),
    [
        (SHEARED, {}),
        (SHEARED, {"damping": 0.2, "step_ratio": 0.5}),
        (MIXED, {"end_time": 0.3}),
        (MIXED, {"model": "two-blocks"}),
        (dataclasses.replace(MIXED, lower_material=Material(4.0, 1.0, 0.2)), {}),
        (dataclasses.replace(SHEARED, material=Material(3.0, 2.0, 0.49)), {"resolution": 8}),
        (dataclasses.replace(SHEARED, material=Material(3.0, 2.0, -0.8)), {}),
    ],
)
def test_unknowns_and_steps_are_those_of_the_run(scene, options):
    options = {"resolution": 20, **options}
    predicted, run = cost(scene, **options), simulate(scene, **options)
    assert (predicted.unknowns, predicted.steps) == (run.unknowns, run.steps)


@pytest.mark.thinned(4)
@pytest.mark.parametrize("nu", [-0.5, 1 / 3, 0.49])
@pytest.mark.parametrize("options", [{}, {"damping": 0.2}])
def test_critical_step_of_a_patch_is_that_of_the_blocks(nu, options):
    model = prepare(
        dataclasses.replace(MIXED, material=Material(2.0, 0.5, nu)), resolution=24, **options
    )
    matrix = model.bodies[0].matrix / model.time_step**2
    exact = critical_step(highest_frequency(matrix), model.plan.damping_time)
    assert model.critical_step == pytest.approx(exact, rel=5e-4)


@pytest.mark.gmsh
def test_unknowns_of_unstructured_triangles_are_nearly_those_of_the_run():
    options = {"resolution": 30, "mesh": "triangles"}
    predicted, run = cost(SHEARED, **options), simulate(SHEARED, **options)
    assert predicted.unknowns == pytest.approx(run.unknowns, rel=0.03)
    assert predicted.steps == pytest.approx(run.steps, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("resolution", [60, 100, 200])
def test_memory_and_size_of_files_are_predicted(resolution, tmp_path, monkeypatch):
    """Measured in a process of its own, which nothing has used memory in before."""
    monkeypatch.setenv("SLIPFRONT_CACHE", str(tmp_path / "cache"))
    command = [sys.executable, "-c", PEAK, str(tmp_path), json.dumps({"resolution": resolution})]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    ratios = json.loads(run.stdout)
    assert 0.7 < ratios["memory"] < 1.3
    assert 0.8 < ratios["frames"] < 1.3


def test_every_step_counts_in_memory_and_files():
    all_steps, few = (cost(SHEARED, every=every, step_ratio=0.01) for every in (1, 100))
    assert all_steps.memory > few.memory
    assert all_steps.history > 50 * few.history
    assert all_steps.seconds == few.seconds


def refusal(**options):
    with pytest.raises(SceneError, match=r"simulate: [\d,]+ unknowns and [\d,]+ steps") as caught:
        simulate(**options)
    return str(caught.value)


def named_number(sentence, before):
    return int(sentence.split(before)[1].split()[0].rstrip(".thnds"))


def test_too_much_memory_is_refused_with_a_resolution_that_fits():
    limit = 150e6
    sentence = refusal(scene=SHEARED, resolution=1000, memory=limit)
    assert "are allowed" in sentence
    fitting = named_number(sentence, "lower `resolution` to ")
    assert cost(SHEARED, resolution=fitting).memory <= 1.02 * limit
    assert cost(SHEARED, resolution=fitting + 2).memory > 0.98 * limit


def test_histories_too_long_for_memory_may_be_thinned():
    options = {"scene": SHEARED, "resolution": 60, "step_ratio": 1e-3}
    sentence = refusal(**options, memory=400e6)
    every = named_number(sentence, "raise `every` to ")
    assert cost(**options, every=every).memory <= 400e6 < cost(**options).memory


def test_run_that_never_fits_says_so():
    assert "shorten `end_time` or raise `memory`" in refusal(scene=SHEARED, memory=1e6)


@pytest.mark.parametrize("memory", [0, -1e9, float("nan"), "much", True])
def test_limit_must_be_a_number_of_bytes(memory):
    with pytest.raises(SceneError, match=r"memory must be a (positive |finite )?number"):
        simulate(SHEARED, resolution=8, memory=memory)


def test_nearly_incompressible_blocks_cost_hours_and_gigabytes():
    """c_l / c_t is 71: unknowns go with its square."""
    usual, extreme = cost(SHEARED, resolution=40), cost(NEARLY_INCOMPRESSIBLE, resolution=40)
    ratio = NEARLY_INCOMPRESSIBLE.material.longitudinal_speed / UNIT.longitudinal_speed
    assert extreme.unknowns == pytest.approx(ratio**2 * usual.unknowns, rel=0.2)
    assert extreme.steps > ratio * usual.steps  # the damping of so stiff elements shortens steps
    assert extreme.seconds > 100 * usual.seconds
    sentence = refusal(scene=NEARLY_INCOMPRESSIBLE, resolution=40, memory=4e9)
    assert 8 <= named_number(sentence, "lower `resolution` to ") < 40
