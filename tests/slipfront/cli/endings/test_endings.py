"""No exit code is that of another meaning: faults of the program end with 70 and a report."""

import os
import re
import subprocess
import sys
import tempfile
import time

import pytest

from slipfront.cli import commands
from slipfront.cli.commands import main
from slipfront.cli.entry import interrupt_again

SENTENCE = re.compile(
    r"slipfront met a fault of its own \((.+)\); please report it: (\S+\.txt) holds what is "
    r"needed for that\.\n"
)


@pytest.fixture
def reports(tmp_path, monkeypatch):
    """Where reports are written."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def failing(monkeypatch, error):
    """`slipfront scenes` raises an exception."""

    def fail(*_):
        raise error

    monkeypatch.setattr("slipfront.cli.scenes.commands.scene_document", fail)


def report(capsys, folder):
    """What was said went wrong, and what the report says."""
    said = SENTENCE.fullmatch(capsys.readouterr().err)
    (path,) = folder.iterdir()
    assert said[2] == str(path)
    return said[1], path.read_text()


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (AttributeError("no such thing"), "AttributeError: no such thing"),
        (ValueError("shapes (8, 4)\nand (7, 4)"), "ValueError: shapes (8, 4) and (7, 4)"),
        (EOFError("No data left in file"), "RuntimeError: a file ends before it should"),
        (SystemExit(1), "RuntimeError: a library ended the program with 1"),
        (SystemExit("gone"), "RuntimeError: a library ended the program with 'gone'"),
        (RecursionError("x" * 500), "RecursionError: " + "x" * 184 + "…"),
    ],
)
def test_what_nothing_catches_is_a_fault_of_the_program(error, words, monkeypatch, reports, capsys):
    failing(monkeypatch, error)
    assert main(["scenes"]) == 70
    said, text = report(capsys, reports)
    assert said == words
    for part in ("open an issue", "command:  slipfront scenes\n", "numpy ", "Traceback (most"):
        assert part in text
    assert f"{type(error).__name__}: {str(error)[:10]}" in text


def test_a_report_that_cannot_be_written_is_shown(monkeypatch, capsys):
    failing(monkeypatch, ValueError("lost"))
    monkeypatch.setattr(tempfile, "tempdir", "/nonexistent/folder")
    assert main(["scenes"]) == 70
    *lines, last = capsys.readouterr().err.splitlines()
    assert "ValueError: lost" in lines
    assert last.endswith("what is needed for that stands above.")


def test_too_little_memory_is_a_computation_that_failed(monkeypatch, refused):
    failing(monkeypatch, MemoryError())
    assert refused("scenes", 4) == commands.NO_MEMORY + "\n"


def run(line, **options):
    command = [sys.executable, "-m", "slipfront", *line.split()]
    return subprocess.run(command, stderr=subprocess.PIPE, text=True, **options)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("line", ["scenes --json", "--help"])
def test_a_reader_that_has_gone_is_no_difference(line):
    """rich and typer end with 1 then."""
    reading, writing = os.pipe()
    os.close(reading)
    ended = run(line, stdout=writing)
    os.close(writing)
    assert (ended.returncode, ended.stderr) == (141, "")


def test_output_that_cannot_be_written_is_a_file_that_cannot():
    with open("/dev/full", "w") as full:
        ended = run("scenes --json", stdout=full)
    assert ended.returncode == 3
    assert ended.stderr == "Cannot use a file: No space left on device.\n"


def test_a_program_that_cannot_be_imported_says_so(tmp_path):
    (tmp_path / "typer.py").write_text("import nothing_of_that_name\n")
    ended = run("scenes", env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert ended.returncode == 5
    assert "cannot start (No module named 'nothing_of_that_name')" in ended.stderr
    (tmp_path / "typer.py").write_text("raise ValueError('broken')\n")
    ended = run("scenes", env={**os.environ, "PYTHONPATH": str(tmp_path), "TMPDIR": str(tmp_path)})
    assert ended.returncode == 70
    assert SENTENCE.fullmatch(ended.stderr)[1] == "ValueError: broken"


@pytest.mark.parametrize("name", ["fem", "semianalytic"])
def test_a_file_that_hides_a_package_of_ours_is_named_and_not_run(name, tmp_path):
    hiding = tmp_path / f"{name}.py"
    hiding.write_text("print('ran')\n")
    sentence = f"{hiding} hides the package '{name}' of slipfront; rename or move it.\n"
    ended = run("scenes", stdout=subprocess.PIPE, cwd=tmp_path)
    assert (ended.returncode, ended.stdout, ended.stderr) == (5, "", sentence)


def test_a_file_that_hides_a_package_is_named_after_it_was_imported(tmp_path):
    (tmp_path / "fem.py").write_text("")
    program = tmp_path / "program.py"
    program.write_text("import fem\nimport slipfront as sf\nsf.simulate\n")
    ended = subprocess.run(
        [sys.executable, program], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert ended.returncode == 1
    told = (
        f"ImportError: {tmp_path / 'fem.py'} hides the package 'fem' of slipfront; rename or move"
    )
    assert ended.stderr.splitlines()[-1].startswith(told)


def test_an_interruption_that_python_drops_comes_again(monkeypatch, capfd):
    class Closing:
        def __del__(self):
            raise KeyboardInterrupt

    monkeypatch.setattr(sys, "unraisablehook", interrupt_again)
    Closing()
    with pytest.raises(KeyboardInterrupt):
        time.sleep(10)
    assert capfd.readouterr().err == ""
