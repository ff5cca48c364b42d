"""The trial of ``slipfront validate``: what it makes of right files, wrong ones and junk.

``python -m docs.studies.validate.study --csv docs/data`` runs the program on every file, as a
user does, and writes the tables of docs/validate.md: how many right files it judges wrong, how many
wrong ones it accepts, how often it takes numbers for others than they are, and what it makes of
junk.  ``--program`` runs another installation on the same files; validate-files-before.csv is what
that of commit 860c1cd made of them, before units and conventions were read as one; its scene files
said a load from afar as base and load alike.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import NoReturn

import numpy as np

from compare.output.tables import write_rows
from compare.records.record import QUANTITIES
from docs.studies.validate.cases import RIGHT, WRONG, Case, cases
from docs.studies.validate.settings import recorded
from docs.studies.validate.writers import written_case, written_junk
from semianalytic.scene.given.template import scene_text
from slipfront.cli.commands import main as command_line
from slipfront.cli.endings.faults import CRASHED

COMMAND = "python -m docs.studies.validate.study --csv docs/data"
JUNK_KIND = "junk"
SECONDS = 120.0
"""Time that a file may take [s]."""
BYTES = 2**30
"""Memory that the program may take for junk: a small file takes a third of it."""
SENTENCE = 500
CONVERSIONS = ("dimension", "other units", "sign", "half", "tension", "the base", "positions are")
"""Words by which the program said that it had converted numbers, before its reports said so."""
GUESS = 0.05
"""Relative error of a quantity that no reading may leave beyond the true one."""


FILES, BEFORE, TABLE = "validate-files", "validate-files-before", "validate-trial"
"""Tables of what became of each file now, with the earlier program, and of how many failed."""
OWN = ()
"""The command line of this installation, in a fork of this process, which spares imports."""
SHARED = ("compare.validation.figure", "h5py")
"""Modules that the command line imports late, and that forks should not import each."""


@dataclass(frozen=True)
class Outcome:
    """Verdict of the program on a file, and whether that is right.

    Attributes
    ----------
    family, name, kind : str
    verdict : str
        Of the program; "refused", "traceback", "killed".
    exit_code : int
    guessed : bool
        Whether it took numbers for what they are not.
    seconds, megabytes : float
    failure : str
        What is wrong with that; "" if nothing is.
    """

    family: str
    name: str
    kind: str
    verdict: str
    exit_code: int
    guessed: bool
    seconds: float
    megabytes: float
    failure: str


@dataclass(frozen=True)
class Failures:
    """How many files the program failed on, before and now."""

    what: str
    files: int
    before: int
    now: int


@dataclass(frozen=True)
class Ran:
    """A run of the program."""

    code: int
    out: str
    err: str
    seconds: float
    megabytes: float


def run(program: Sequence[str], arguments: Sequence[str], cwd: Path) -> Ran:
    """Run a program, with an end to its time and its memory; this one if none is named."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        began = time.monotonic()
        pid = os.fork()
        if not pid:
            _become(program, arguments, cwd, (out.fileno(), err.fileno()))
        while True:
            ended, status, used = os.wait4(pid, os.WNOHANG)
            if ended:
                break
            if time.monotonic() - began > SECONDS:
                os.kill(pid, signal.SIGKILL)
                _, status, used = os.wait4(pid, 0)
                break
            time.sleep(0.02)
        seconds = time.monotonic() - began
        out.seek(0), err.seek(0)
        said, wrong = (stream.read().decode("utf-8", "replace") for stream in (out, err))
        code = os.waitstatus_to_exitcode(status)
        return Ran(code, said, wrong, seconds, used.ru_maxrss / 1024)


def _become(
    program: Sequence[str], arguments: Sequence[str], cwd: Path, streams: tuple[int, int]
) -> NoReturn:
    """Run a program in the place of this process, which has been forked; it does not return."""
    code = CRASHED
    try:
        resource.setrlimit(resource.RLIMIT_AS, (8 * BYTES, 8 * BYTES))
        os.chdir(cwd)
        for number, stream in enumerate(streams, 1):
            os.dup2(stream, number)
        if program:
            os.execvp(program[0], [*program, *arguments])
        with os.fdopen(1, "w") as sys.stdout, os.fdopen(2, "w") as sys.stderr:
            code = command_line(arguments)
    finally:
        os._exit(code)


def judged(program: Sequence[str], case: Case, folder: Path) -> Outcome:
    """Outcome of the program on a case."""
    path, options = written_case(case, folder)
    scene = folder / "scene.toml"
    scene.write_text(scene_text(case.setting.scene), encoding="utf-8")
    arguments = ["validate", str(path), "--scene", str(scene), *options, "--json"]
    arguments += ["--output", str(folder / "out")]
    ran = run(program, arguments, folder)
    if "No such option" in ran.err:  # an earlier program does without
        arguments = [word for word in arguments if word not in case.options]
        ran = run(program, arguments, folder)
    verdict, guessed = _verdict(ran), False
    if verdict.startswith(("agrees", "differs", "unresolved")):
        guessed = _is_guessed(case, json.loads(ran.out))
    accepted = verdict.startswith("agrees")
    failure = ""
    if verdict in ("traceback", "killed"):
        failure = verdict
    elif case.kind == RIGHT and not accepted:
        failure = "right, judged wrong"
    elif case.kind != RIGHT and accepted:
        failure = "wrong, accepted"
    elif guessed:
        failure = "guessed wrongly"
    return Outcome(
        case.family,
        case.name,
        case.kind,
        verdict,
        ran.code,
        guessed,
        round(ran.seconds, 1),
        round(ran.megabytes),
        failure,
    )


def _verdict(ran: Ran) -> str:
    failed = _failed(ran)
    if failed:
        return failed
    if ran.code in (0, 1):
        return str(json.loads(ran.out)["verdict"])
    return "refused"


def _is_guessed(case: Case, report: dict[str, object]) -> bool:
    """Whether something was converted, and an error that is told is not that of the numbers."""
    reading = report.get("reading")
    notes = " ".join(report["notes"])  # type: ignore[arg-type]
    converted = reading["inferred"] if reading else any(map(notes.__contains__, CONVERSIONS))  # type: ignore[index]
    if not converted:
        return False
    said = {
        norm["quantity"]: float(norm["L1"])
        for norm in report["norms"]  # type: ignore[attr-defined]
        if norm["x"] is None
    }
    true = errors_of(case)
    return any(
        abs(said[name] - error) > GUESS + 0.2 * min(error, said[name])
        for name, error in true.items()
        if name in said
    )


def errors_of(case: Case) -> dict[str, float]:
    """Relative L1 errors of what a case holds, in its own units, over all stations.

    None where times or positions are wrong, and where headers are.
    """
    values, exact = case.values(), recorded(case.setting)
    if case.family == "units named wrongly":
        return {}
    if not all(np.array_equal(values[name], exact[name]) for name in ("t", "x")):
        return {}
    errors = {}
    for name in QUANTITIES:
        size = np.trapezoid(np.abs(exact[name]), exact["t"], axis=0).sum()
        wrong = np.trapezoid(np.abs(values[name] - exact[name]), exact["t"], axis=0).sum()
        if size > 0 and not (case.style.mean and name == "slip_rate"):
            errors[name] = float(wrong / size)
    return errors


def junk(program: Sequence[str], folder: Path) -> Iterator[Outcome]:
    """Outcomes of junk, for which one sentence and exit code 3 are right, in little memory."""
    for what, path in written_junk(folder):
        arguments = ["validate", str(path), "--scene", "preloaded", "--output", str(folder / "out")]
        ran = run(program, arguments, folder)
        verdict = _verdict_of_junk(ran)
        failure = ""
        if verdict != "refused":
            failure = verdict
        elif ran.code != 3 or ran.err.count("\n") != 1 or len(ran.err) > SENTENCE:
            failure = f"exit code {ran.code}"
        elif ran.megabytes * 2**20 > BYTES:
            failure = f"{ran.megabytes:.0f} MB"
        yield Outcome(
            "junk",
            what,
            JUNK_KIND,
            verdict,
            ran.code,
            False,
            round(ran.seconds, 1),
            round(ran.megabytes),
            failure,
        )


def _verdict_of_junk(ran: Ran) -> str:
    return _failed(ran) or ("refused" if ran.code > 1 else "read")


def _failed(ran: Ran) -> str:
    """How a run failed for which the program alone is to blame; "" if it did not."""
    if ran.code < 0:
        return "killed"
    return "traceback" if ran.code == CRASHED or "Traceback" in ran.err else ""


def tried(program: Sequence[str], chosen: Iterable[Case], folder: Path) -> Iterator[Outcome]:
    """Outcomes of cases and of junk, said while they come."""
    for number, case in enumerate(chosen):
        yield judged(program, case, folder / f"case{number}")
    yield from junk(program, folder)


def read_outcomes(path: Path) -> list[dict[str, str]]:
    """Outcomes of a table as they are written."""
    with path.open(newline="", encoding="utf-8") as stream:
        stream.readline()
        return list(csv.DictReader(stream, strict=True))


def failures(
    before: Sequence[Mapping[str, str]], now: Sequence[Mapping[str, str]]
) -> list[Failures]:
    """Failures of each kind, before and now."""
    kinds: Mapping[str, tuple[Sequence[str], Callable[[Mapping[str, str]], bool]]] = {
        "right files judged wrong": ((RIGHT,), lambda one: "judged wrong" in one["failure"]),
        "wrong files accepted": ((WRONG,), lambda one: "accepted" in one["failure"]),
        "units or conventions guessed wrongly": (
            (RIGHT, WRONG),
            lambda one: one["guessed"] == str(True),
        ),
        "junk not refused, or at the cost of 1 GB or more": (
            (JUNK_KIND,),
            lambda one: one["verdict"] != "refused" or float(one["megabytes"]) * 2**20 > BYTES,
        ),
        "tracebacks": (
            (RIGHT, WRONG, JUNK_KIND),
            lambda one: one["verdict"] == "traceback",
        ),
    }
    return [
        Failures(
            what,
            sum(one["kind"] in among for one in now),
            *(sum(one["kind"] in among and fails(one) for one in table) for table in (before, now)),
        )
        for what, (among, fails) in kinds.items()
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Try the program on every file and write what it made of each."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.validate.study")
    parser.add_argument("--csv", type=Path, default=Path("."), metavar="DIR")
    parser.add_argument("--program", help="run in the place of this installation")
    parser.add_argument("--name", default=FILES, help="of the table of outcomes")
    parser.add_argument("--only", default="", help="cases whose family or name holds these words")
    options = parser.parse_args(arguments)
    program = (options.program,) if options.program else OWN
    for name in () if program else SHARED:
        import_module(name)
    chosen = [one for one in cases() if options.only in f"{one.family}: {one.name}"]
    outcomes = []
    with tempfile.TemporaryDirectory() as folder:
        for one in tried(program, chosen, Path(folder)):
            outcomes.append(one)
            print(one.failure or "-", "|", one.family, "|", one.name, "|", one.verdict, flush=True)
    write_rows(options.csv / f"{options.name}.csv", outcomes, command=COMMAND)
    if (options.csv / f"{BEFORE}.csv").exists() and not options.only:
        tables = (read_outcomes(options.csv / f"{name}.csv") for name in (BEFORE, options.name))
        write_rows(options.csv / f"{TABLE}.csv", failures(*tables), command=COMMAND)


if __name__ == "__main__":
    main()
