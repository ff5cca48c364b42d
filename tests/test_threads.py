"""Answers may be read from several threads at once, and say what they say to one, to the last bit.

Each public method and property of an answer is asked many times, in another order by each thread;
the same questions put to an equal answer by one thread are the measure.
"""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue import unit_scene
from faults import identity_of

from fem import simulate
from semianalytic import Coulomb, Gauge, fit, solve, sweep
from semianalytic.scene.given.finding import find_scene

THREADS = 4
ARGUMENTS: dict[str, Any] = {
    "x": np.linspace(0.07, 1.3, 23),
    # in both bodies, and farther from the interface than the nodes of a march are apart
    "y": np.linspace(0.1, 0.9, 23) * (-1.0) ** np.arange(23),
    "t": np.linspace(0.05, 0.9, 23),
    "inner": 0.05,
    "outer": np.linspace(0.1, 1.3, 23),
    "of": "slip",
    "number": 0,
}
"""Arguments of methods, by the names of their parameters."""
ELSEWHERE = (
    "to_xarray",
    "save",
    "load",
    "derivative",
    "error_of",
    "seen",
    "trials",
    "plot",
    "animate",
    "at",
    "beside_edge",
)
"""Asked below with other arguments, or of other objects; pyplot draws in one thread alone."""
IN_BODIES = ("velocity", "stress", "strain", "displacement")
RANKED = {"zones_at": {"t": 0.4}, "openings_at": {"t": 0.4}}
FITTED = {
    "log_density": {"values": np.array([0.31])},
    "error_in_words": {"number": 0, "factor": 1.0},
}
SLOT = {"slot_velocity": {"x": -ARGUMENTS["x"]}}

Question = Callable[[Any], Any]


def questions(answer: Any) -> Iterator[tuple[str, Question]]:
    """All public methods and properties of an answer, each with two sets of arguments."""
    kind = type(answer)
    for name in dir(kind):
        member = inspect.getattr_static(kind, name)
        if name.startswith("_") or name in ELSEWHERE:
            continue
        if name in IN_BODIES and not getattr(answer, "has_bodies", True):
            continue
        if isinstance(member, property | cached_property):
            yield name, lambda answer, name=name: getattr(answer, name)
        elif inspect.isfunction(member):
            for step in (1, 3):
                given = arguments(name, member, step)
                yield f"{name}/{step}", lambda entry, name=name, g=given: getattr(entry, name)(**g)


def arguments(name: str, method: Any, step: int) -> dict[str, Any]:
    taken = [parameter for parameter in inspect.signature(method).parameters if parameter != "self"]
    given = {**ARGUMENTS, **{**RANKED, **SLOT, **FITTED}.get(name, {})}
    return {
        entry: given[entry][::step] if isinstance(given[entry], np.ndarray) else given[entry]
        for entry in taken
    }


def asked_by_one(answer: Any, asked: dict[str, Question]) -> dict[str, Any]:
    return {name: identity_of(entry(answer)) for name, entry in asked.items()}


def asked_by_threads(answer: Any, asked: dict[str, Question]) -> list[dict[str, Any]]:
    """What each of some threads hears, which ask at the same time and in different order."""

    def ask(seed: int) -> dict[str, Any]:
        names = list(asked)
        np.random.default_rng(seed).shuffle(names)
        return {name: identity_of(asked[name](answer)) for name in names}

    switching = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            return list(pool.map(ask, range(THREADS)))
    finally:
        sys.setswitchinterval(switching)


def differing(make: Callable[[], Any], asked: dict[str, Question] | None = None) -> set[str]:
    """Questions that threads were answered otherwise than one thread that asks an equal answer."""
    answer = make()
    asked = asked or dict(questions(answer))
    alone = asked_by_one(make(), asked)
    heard = asked_by_threads(answer, asked)
    late = asked_by_one(answer, asked)  # what threads left behind is right, too
    return {name for said in (*heard, late) for name in asked if said[name] != alone[name]}


def asked_of_some(like: Any, numbers: Iterable[int]) -> dict[str, Question]:
    """The questions to an answer, put to some of a row of its like."""
    return {
        f"{number}, {name}": lambda row, at=number, question=question: question(list(row)[at])
        for number in numbers
        for name, question in questions(like)
    }


SCENES = {
    "a viscous film": unit_scene(law=Coulomb(1.0, viscosity=0.1)),
    "two zones": unit_scene(),
    "antiplane": find_scene("antiplane"),
    "an opening": find_scene("lift-off-shear"),
}


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", SCENES)
def test_threads_hear_of_a_solution_what_one_hears(name):
    assert differing(lambda: solve(SCENES[name], rtol=1e-6)) == set()


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["two zones", "an opening"])
def test_threads_hear_of_derivatives_what_one_hears(name):
    """Those of one solution, which share what they are made of."""
    parameters = ("friction", "load_shear")

    def make() -> list[Any]:
        solution = solve(SCENES[name], rtol=1e-6)
        return [solution.derivative(parameter) for parameter in parameters]

    asked = asked_of_some(make()[0], range(len(parameters)))
    assert differing(make, asked) == set()


@pytest.mark.slow
def test_threads_hear_of_a_sweep_what_one_hears():
    frictions = np.linspace(0.2, 0.6, 7)
    asked = asked_of_some(solve(SCENES["two zones"]), (1, 4))
    assert differing(lambda: sweep(SCENES["two zones"], frictions), asked) == set()


@pytest.mark.slow
def test_threads_hear_of_a_march_what_one_hears():
    def make() -> Any:
        return solve(find_scene("ramp"), method="space-time", end_time=1.0, nodes=32, length=2.0)

    asked = dict(questions(make()))
    asked["error_of"] = lambda march: march.error_of(lambda each: each.slip(0.3, 0.8))
    assert differing(make, asked) == set()


@pytest.mark.slow
def test_threads_hear_of_a_fit_what_one_hears():
    """Misfits of values that are tried as well, of which only the last few solutions are kept."""
    t = np.linspace(0.1, 1.0, 12)
    gauge = Gauge(0.3, t, solve(unit_scene(0.31)).slip_rate(0.3, t), 0.05)
    found = fit([gauge], unit_scene(), ("friction",), rtol=1e-4)
    asked = dict(questions(found))
    asked["seen"] = lambda answer: answer.seen(gauge, np.linspace(0.1, 0.9, 5))
    for number in range(10):
        tried = np.array([0.9 + 0.01 * number])
        asked[f"trial {number}"] = lambda answer, tried=tried: answer.trials.misfit(tried)
    assert differing(lambda: found, asked) == set()


def test_threads_hear_of_a_simulation_what_one_hears():
    run = simulate(find_scene("lift-off-shear"), resolution=16)
    assert differing(lambda: run) == set()


UNLOCKED = """
import functools, threading
from collections import defaultdict

needed, asking = defaultdict(set), threading.local()

class Tracked(functools.cached_property):
    def __get__(self, instance, owner=None):
        if instance is None:
            return self
        if self.attrname not in instance.__dict__:
            outer = asking.__dict__.setdefault("outer", [])
            for one in outer:
                needed[one].add(self)
            outer.append(self)
            instance.__dict__[self.attrname] = self.func(instance)
            outer.pop()
        return instance.__dict__[self.attrname]

functools.cached_property = Tracked
import test_threads

opening = test_threads.SCENES["an opening"]
assert test_threads.differing(lambda: test_threads.solve(opening, rtol=1e-4)) == set()
test_threads.test_threads_hear_of_derivatives_what_one_hears("an opening")
test_threads.test_threads_hear_of_a_march_what_one_hears()

def circle(start):
    met, left = set(), list(needed[start] - {start})
    while left:
        one = left.pop()
        if start in needed[one]:
            return True
        left += needed[one] - met
        met |= needed[one]
    return False

print(len(needed), sorted(one.attrname for one in list(needed) if circle(one)))
"""


@pytest.mark.slow
def test_attributes_need_no_locks_and_wait_for_one_another_in_no_circle():
    """Python 3.11 locks an attribute of a class while it is worked out for any object, and two
    threads that come to a circle of attributes from two sides wait for ever; later ones do not."""
    shown = subprocess.run(
        [sys.executable, "-c", UNLOCKED],
        cwd=Path(__file__).parent,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parent), "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    assert shown.returncode == 0, shown.stderr
    count, _, circles = shown.stdout.strip().partition(" ")
    assert int(count) > 25  # those of `cut` and `halfplane` take no lock
    assert circles == "[]"
