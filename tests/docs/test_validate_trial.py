"""The trial of validate tells failures for what they are."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.records.options import ReadingOptions
from compare.records.read import read_records
from compare.validation import bars, grids, validate
from docs.studies.validate import power, study
from docs.studies.validate.cases import RIGHT, WRONG, cases
from docs.studies.validate.writers import written_case
from semianalytic.scene.given.finding import find_scene

EVERY = 9
"""Files between two that are tried here without starting the program."""


def case_of(words):
    return next(one for one in cases() if words in f"{one.family}: {one.name}")


@pytest.mark.slow
def test_files_have_names_of_their_own():
    names = [(one.family, one.name) for one in cases()]
    assert len(set(names)) == len(names)
    assert {one.kind for one in cases()} == {RIGHT, WRONG}


@pytest.mark.slow
def test_the_command_line_is_run_and_its_failures_are_told(tmp_path):
    right = case_of("units: rock, SI, named")
    outcome = study.judged(study.OWN, right, tmp_path / "right")
    assert (outcome.verdict, outcome.exit_code, outcome.failure) == ("agrees", 0, "")
    accepted = study.judged(study.OWN, replace(right, kind=WRONG), tmp_path / "accepted")
    assert accepted.failure == "wrong, accepted"
    wrong = case_of("mistakes: plain shear, slip rate halved")
    outcome = study.judged(study.OWN, replace(wrong, kind=RIGHT), tmp_path / "wrong")
    assert (outcome.verdict, outcome.exit_code) == ("differs", 1)
    assert outcome.failure == "right, judged wrong"


@pytest.mark.parametrize(
    ("words", "verdict"),
    [("exit 70", "traceback"), ("kill -9 $$", "killed"), ("exit 3", "refused")],
)
def test_other_programs_are_run_and_their_faults_are_told(words, verdict, tmp_path):
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\n{words}\n")
    program.chmod(0o700)
    outcome = study.judged([str(program)], case_of("rock, SI, named"), tmp_path / "case")
    assert outcome.verdict == verdict
    assert outcome.failure


def test_failures_are_counted_by_what_was_tried():
    def row(kind, verdict, failure, guessed=False):
        return {
            "kind": kind,
            "verdict": verdict,
            "failure": failure,
            "guessed": str(guessed),
            "megabytes": "80",
        }

    before = [
        row(RIGHT, "differs", "right, judged wrong", True),
        row(WRONG, "agrees", "wrong, accepted"),
        row("junk", "traceback", "traceback"),
    ]
    now = [row(RIGHT, "agrees", ""), row(WRONG, "differs", ""), row("junk", "refused", "")]
    counts = [(one.files, one.before, one.now) for one in study.failures(before, now)]
    assert counts == [(1, 1, 0), (1, 1, 0), (2, 1, 0), (1, 1, 0), (3, 1, 0)]


@pytest.mark.slow
def test_files_of_the_trial_are_judged_rightly(tmp_path):
    for number, one in enumerate(list(cases())[::EVERY]):
        path, options = written_case(one, tmp_path / f"case{number}")
        if "--noise" in options:
            continue
        (run,) = read_records([path], ReadingOptions())
        found = validate(run, one.setting.scene, spacing=float(options[1]))
        assert found.verdict.startswith("agrees") == (one.kind == RIGHT), one.name


def recorded(cells):
    scene, t = find_scene("preloaded"), np.linspace(0.0, 1.0, 201)
    history = solved(scene).history(np.array([0.1, 0.25, 0.5]), t)
    values = {name: getattr(history, name) for name in ("slip_rate", "slip")}
    return power.Recorded(
        "tried", "steps", "fem", scene, (cells,), ({"t": t, "x": history.x, **values},)
    )


@pytest.mark.slow
def test_other_constants_change_verdicts_and_are_put_back():
    one = recorded(100)
    (whole,) = (row for row in one.judged().rows if row.name == "slip all stations")
    (data,) = one.data
    found = one.judged(data=[{**data, "slip": (1 + 1.2 * whole.bar) * data["slip"]}])
    assert found.verdict != "differs"
    trial = [power.tried(one, one.judged()), power.tried(one, found, "slip times 1.1")]
    changed = {(row.constant, row.value): row for row in power.changed(trial)}
    assert changed["as they are", 1.0].caught == 0
    assert changed["ALARM", 0.5 * bars.ALARM].caught == 1
    assert {row.alarms for row in changed.values()} == {0}
    narrow = changed["SMEAR of slip", 0.5 * grids.SMEAR["slip"]]
    assert narrow.slip_bar < changed["as they are", 1.0].slip_bar == whole.bar
    (alarms,) = power.alarms(trial)
    assert (alarms.cells, alarms.runs, alarms.differs) == ("100", 1, 0)
    counts = {row.mistake: (row.scenes, row.caught) for row in power.power(trial)}
    assert counts["slip times 1.1"] == (1, 0)
