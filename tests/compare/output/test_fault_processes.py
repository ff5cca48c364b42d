"""Processes that are killed, interrupted, or meet others in the same place."""

import multiprocessing
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest
from fault_tasks import history, kill_me
from faults import ROOT, identity_of, start

import slipfront.cli.commands
from compare.output.places import working_folder
from compare.tasks.workers import run_tasks
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import ComputationError
from slipfront.cli.commands import main
from slipfront.cli.endings.faults import INTERRUPTION

PATIENCE = 120
"""Time that a test waits for a process that should end at once [s]; longer is a failure."""

WRITER = """
import sys
sys.path.insert(0, "tests")
from fault_tasks import history
from compare.output.places import working_folder
from pathlib import Path
one, path = history(), Path(sys.argv[1])
with working_folder(path.parent):
    one.save(path)
    print("ready", flush=True)
    while True:
        one.save(path)
"""

POOL = """
import os, sys, time
sys.path.insert(0, "tests")
from compare.tasks.workers import run_tasks
if __name__ == "__main__":
    from fault_tasks import say_and_sleep
    for _ in run_tasks([(say_and_sleep, (600,))] * 2, 2):
        pass
"""

ENTRY = """
import sys, time
awaited = sys.argv.pop(1)
class Teller:
    def find_spec(self, name, path=None, target=None):
        if name == awaited:
            print("ready", flush=True)
            time.sleep(2)  # the signal comes while the module is imported, on any machine
sys.meta_path.insert(0, Teller())
from slipfront.cli.entry import main
sys.exit(main())
"""
"""Runs the command line; says when it begins to import a certain module."""

COMMAND = "import sys; from slipfront.cli.entry import main; sys.exit(main())"


def test_a_killed_writer_leaves_a_whole_file_and_its_rests_are_removed(tmp_path):
    rng, path = random.Random(1), tmp_path / "a.h5"
    sound = identity_of(history())
    for _ in range(2):
        process = start(WRITER, path)
        assert process.stdout.readline() == "ready\n"
        time.sleep(rng.uniform(0, 0.05))
        process.kill()
        process.communicate(timeout=PATIENCE)
        assert identity_of(InterfaceHistory.load(path)) == sound
    with working_folder(tmp_path):  # the lock went with its process
        history().save(path)
    assert [path.name for path in tmp_path.iterdir()] == ["a.h5"]


def test_workers_end_with_their_parent():
    """Whoever reads their output sees its end, and no process is left."""
    process = start(POOL, env={**os.environ, "PYTHONPATH": str(ROOT / "tests")})
    workers = [int(process.stdout.readline()) for _ in range(2)]
    process.kill()
    process.communicate(timeout=PATIENCE)
    for _ in range(100):
        if not any(map(alive, workers)):
            break
        time.sleep(0.05)
    assert not any(map(alive, workers))


def test_an_interruption_does_not_wait_for_what_is_being_computed():
    """A task of an hour is not waited for."""

    def interrupt(done, count):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dict(run_tasks([(time.sleep, (0,)), (time.sleep, (3600,))], 2, interrupt))
    assert not multiprocessing.active_children()


def alive(pid):
    """Whether a process runs; one that has ended and is not yet collected does not."""
    if Path("/proc/self/stat").exists():  # bare systems lack ps, others have no /proc
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2]
        except (FileNotFoundError, ProcessLookupError):
            return False
    else:
        command = ["ps", "-o", "stat=", "-p", str(pid)]
        state = subprocess.run(command, capture_output=True, text=True).stdout
    return state.strip()[:1] not in ("", "Z", "X")


def test_a_worker_that_is_killed_is_one_sentence():
    with pytest.raises(ComputationError, match="a worker process was killed"):
        dict(run_tasks([(kill_me, ()), (kill_me, ())], 2))


IGNORING = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
"""Shells let jobs in the background ignore Ctrl-C."""


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("before", "module", "numbers", "code"),
    [
        ("", "slipfront.cli.commands", [signal.SIGINT], 130),
        ("", "slipfront.cli.commands", [signal.SIGTERM], 143),
        ("", "slipfront.surveys.run", [signal.SIGINT], 130),
        (IGNORING, "slipfront.surveys.run", [signal.SIGINT, signal.SIGTERM], 143),
    ],
    ids=["interrupted", "terminated", "at work", "in the background"],
)
def test_an_interruption_is_one_line_at_any_time(before, module, numbers, code, tmp_path):
    """While the first modules are imported, and when a command has just begun."""
    arguments = ["survey", "preloaded", "--friction", "0.1:0.9:99"]
    process = start(before + ENTRY, module, *arguments, "--output", tmp_path / "out")
    assert process.stdout.readline() == "ready\n"
    for number in numbers:
        process.send_signal(number)
    shown, errors = process.communicate(timeout=PATIENCE)
    assert (process.returncode, shown, errors) == (code, "", INTERRUPTION + "\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_sigterm_leaves_a_checkpoint_to_resume_from(tmp_path):
    arguments = ["preloaded", "--resolution", "60", "--no-snapshots", "--quiet"]
    arguments += ["--checkpoint-every", "1", "--output", str(tmp_path / "run")]
    process = start(COMMAND, "simulate", *arguments)
    deadline = time.monotonic() + PATIENCE
    while not (tmp_path / "run" / "checkpoint.h5").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.terminate()
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 143
    assert errors == INTERRUPTION + "\n"
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["checkpoint.h5"]


@pytest.mark.slow
def test_four_simulations_into_one_folder(tmp_path):
    options = ["--resolution", "60", "--no-snapshots", "--quiet", "--output", tmp_path / "one"]
    processes = [start(COMMAND, "simulate", "preloaded", *options) for _ in range(4)]
    said = [process.communicate(timeout=600)[1] for process in processes]
    codes = [process.returncode for process in processes]
    assert {0} <= set(codes) <= {0, 3}
    for code, words in zip(codes, said, strict=True):
        assert not code or words.startswith(f"another run is writing to {tmp_path / 'one'};")
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["simulation.h5"]


COMMANDS = {
    "solve preloaded --plot": "figure",
    "solve ramp --plot": "figure",
    "solve ramp --save": "file",
    "simulate preloaded --output": "folder",
    "compare preloaded --output": "folder",
    "chart --output": "folder",
}


class Computed(BaseException):
    """That something was computed; no Exception, which the commands report as a fault."""


@pytest.fixture
def no_computing(monkeypatch):
    """Every command fails with `Computed` as soon as it computes."""

    def compute(*_, **__):
        raise Computed

    for name in (
        "slipfront.cli.solve_command.solve",
        "slipfront.cli.marching.solve",
        "fem.simulate",
        "compare.chart.points.exact",
        "compare.chart.points.run_point",
    ):
        monkeypatch.setattr(name, compute)


@pytest.mark.thinned(12)
@pytest.mark.parametrize("command", COMMANDS)
def test_places_are_looked_at_before_anything_is_computed(
    command, no_computing, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.png").mkdir()
    wrong = {"folder": ["file", "file/new"], "file": ["folder.png", "file/new.png", "/dev/null"]}
    wrong["figure"] = [*wrong["file"][:2], "new.xyz", "new"]
    for place in wrong[COMMANDS[command]]:
        code = main([*command.split(), place])
        said = capsys.readouterr().err
        assert (code, said.count("\n")) == (3 if place.startswith("file") else 2, 1)
        assert place in said
    with pytest.raises(Computed):
        main([*command.split(), "good/place.png"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.png"]
    assert slipfront.cli.commands.INTERRUPTED == 130
