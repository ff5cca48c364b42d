"""Hold every answer to the last bit: ``python -m docs.studies.golden --check``, or ``--write``.

The file docs/data/golden.json.gz has the answers to all named scenes and interfaces, 200 random
scenes of all loads and laws, 60 random pairs of bodies and 20 whole lines: edges, five fields at 40
points, totals, error estimates and status, numbers as the hexadecimal digits of their bits.
``--check`` computes them anew and lists what differs, by how much, and against which estimate; it
ends with 1 if anything does.  Another processor may round differently: ``--write`` on the commit
to be compared with, then ``--check`` on the other one.
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

import semianalytic as sa
from compare.tasks.workers import run_tasks
from semianalytic.dissimilar.pair import check_bodies
from semianalytic.engine.marched import Marched
from semianalytic.methods import chosen
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.named import NAMED_LINES, NAMED_SCENES
from semianalytic.scene.loads import PULSE_SHAPES
from semianalytic.whole_line.drive import Drive

FILE = Path(__file__).resolve().parents[1] / "data" / "golden.json.gz"
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
TOTALS = ("max_slip", "accumulated_slip", "frictional_work")
SCENES, MARCHES, PAIRS, LINES = 140, 60, 60, 20
"""Random scenes that are solved, random scenes that are marched, pairs, and whole lines."""
POINTS = 40
NAMED_NODES, NODES, RUN_NODES = 400, 200, 512
"""Nodes of marches of named and of random scenes, and of runs of interfaces."""
RUN_TIME = {"rate-and-state": 0.2, "cattaneo": 0.1, "supershear": 0.5, "tpv101": 0.5}
"""Parts of their end times until which long runs of interfaces are made."""

Answer = dict[str, Any]
"""Words, and hexadecimal digits of numbers, by the name of what they say."""
Random = np.random.Generator


def bits(values: Any) -> str:
    """Return the bits of numbers, sixteen hexadecimal digits each."""
    return np.atleast_1d(np.asarray(values, dtype=">f8")).tobytes().hex()


def numbers(digits: str) -> Array:
    """Return the numbers whose bits are given."""
    return np.frombuffer(bytes.fromhex(digits), dtype=">f8").astype(float)


def one_of(random: Random, *values: Any) -> Any:
    """Return one of the values, all of them equally likely."""
    return values[random.integers(len(values))]


def friction_of(random: Random) -> float:
    """Return a friction coefficient between 0.02 and 2."""
    return float(np.exp(random.uniform(np.log(0.02), np.log(2.0))))


def random_scene(random: Random) -> sa.Scene:
    """Return a self-similar scene: any mode, law and load, closed or opening."""
    solid = sa.Material(1.0, 1.0, float(random.uniform(-0.6, 0.48)))
    mode = str(random.choice(["in-plane", "antiplane"], p=[0.75, 0.25]))
    law: sa.Law = sa.Coulomb(1.0)
    if random.random() < 0.3:
        law = sa.Coulomb(1.0, viscosity=float(10 ** random.uniform(-1.5, 1.5)))
    elif random.random() < 0.1:
        law = sa.RateWeakening(1.0, 1 - random.uniform(0, 0.6), random.lognormal(1.0, 1.0))
    friction = friction_of(random)
    base = sa.Tractions(1.0, friction * float(random.choice([0.0, random.uniform(-0.9, 0.9)])))
    pressure = float(random.choice([0.0, random.uniform(-0.9, 3.0)]))
    load: Any = sa.Tractions(pressure, float(random.normal()))
    place, kind = "slot", random.random()
    if kind < 0.15:
        base, place = sa.Tractions(float(random.choice([0.0, 1.0])), 0.0), "remote"
        load = sa.Tractions(float(random.uniform(0.5, 2.0)), float(random.normal()))
    elif kind < 0.35:
        waves = ("SH",) if mode == "antiplane" else ("P", "SV")
        load = sa.IncidentWave(
            one_of(random, *waves),
            float(random.uniform(-70, 70)),
            stress=0.4 * friction * float(random.normal()),
            from_=one_of(random, "below", "above"),
        )
    elif kind < 0.45:
        load = sa.MovingLoad(float(random.uniform(0.2, 5.0)), load.pressure, load.shear)
    return sa.Scene(solid, law.with_coefficient(friction), base, load, mode=mode, load_on=place)


def random_history(random: Random) -> sa.LoadHistory:
    """Return a ramp, pulse, oscillation or table that lasts a tenth of the time 1 or more."""
    length = float(random.uniform(0.1, 1.0))
    times = np.unique(random.uniform(0, 1, 6).round(6))
    return one_of(
        random,
        sa.Ramp(length),
        sa.Pulse(length, one_of(random, *PULSE_SHAPES)),
        sa.Harmonic(float(random.uniform(0.3, 4.0))),
        sa.Tabulated(tuple(times.tolist()), tuple(random.normal(size=len(times)).tolist())),
    )


def random_march(random: Random) -> sa.Scene:
    """Return a scene whose loads change in time, under any law."""
    law: sa.Law = one_of(
        random,
        sa.Coulomb(1.0),
        sa.RateWeakening(1.0, 1 - random.uniform(0, 0.6), random.lognormal(1.0, 1.0)),
        sa.SlipWeakening(1.0, 1 - random.uniform(0, 0.8), random.lognormal(-2.0, 0.7)),
        sa.Coulomb(1.0, viscosity=10 ** random.uniform(-1.0, 1.0)),
    )
    friction = friction_of(random)
    return sa.Scene(
        sa.Material(1.0, 1.0, float(random.uniform(-0.6, 0.48))),
        law.with_coefficient(friction),
        sa.Tractions(1.0, float(random.choice([0.0, random.uniform(-0.9, 0.9)])) * friction),
        sa.Tractions(float(random.choice([0.0, random.uniform(0, 0.8)])), float(random.normal())),
        pressure_history=random_history(random),
        shear_history=random_history(random),
        mode=str(random.choice(["in-plane", "antiplane"], p=[0.8, 0.2])),
    )


def random_pair(random: Random) -> sa.Scene:
    """Return two different bodies with a slot, whose contact slips, opens or both."""
    density, ratio = float(random.uniform(0.5, 2.0)), float(np.exp(random.uniform(-1.5, 1.5)))
    friction = float(random.uniform(0.1, 0.8))
    viscous = random.random() < 0.25
    upper = sa.Material(1.0, 1.0, float(random.uniform(0.1, 0.4)))
    lower = sa.Material(density * ratio**2, density, float(random.uniform(0.1, 0.4)))
    base = sa.Tractions(1.0, friction * float(random.choice([0.0, random.uniform(-0.8, 0.8)])))
    pressure = float(random.choice([0.0, 0.0, random.uniform(-0.9, 2.0)]))
    load = sa.Tractions(pressure, random.normal())
    law = sa.Coulomb(friction, viscosity=random.lognormal() if viscous else 0.0)
    scene = sa.Scene(upper, law, base, load, lower_material=lower)
    check_bodies(scene)
    return scene


def random_line(random: Random) -> sa.Scene:
    """Return a problem without a slot, or a slot whose load grows."""
    solid = sa.Material(1.0, 1.0, float(random.uniform(-0.5, 0.45)))
    mode = one_of(random, "in-plane", "antiplane")
    friction = friction_of(random)
    if random.random() < 0.3:
        load = sa.Tractions(1.0, float(random.uniform(1.0, 4.0)) * friction)
        growing = sa.GrowingLoad(load.pressure, load.shear, int(random.integers(1, 3)))
        return sa.Scene(solid, friction, sa.Tractions(0.0, 0.0), growing, mode=mode)
    shear = float(random.uniform(0.5, 3.0))
    spread: Any = one_of(
        random, sa.Patch(float(random.uniform(0.05, 0.8)), shear=shear), sa.PointForce(shear=shear)
    )
    base = sa.Tractions(1.0, 0.3 * friction)
    scene = sa.Scene(solid, friction, base, spread, mode=mode)
    Drive(scene)  # which refuses what moves nothing
    return scene


TAP: Mapping[str, Any] = {"period": 10.0, "run": {"end_time": 1.0, "nodes": 1024}}
"""What makes of the scene "tap" one on a line."""
DRAWS: Mapping[str, tuple[Callable[[Random], Any], int]] = {
    "random scene": (random_scene, SCENES),
    "random march": (random_march, MARCHES),
    "random pair": (random_pair, PAIRS),
    "random line": (random_line, LINES),
}
"""How problems are drawn, and how many of them, by what they are called."""


def drawn(kind: str, index: int) -> Any:
    """Return the first admissible problem of a draw."""
    random = np.random.default_rng([4207, list(DRAWS).index(kind), index])
    while True:
        try:
            return DRAWS[kind][0](random)
        except SceneError:
            continue


def recorded(found: Any, x: Array, t: Array) -> Answer:
    """Return what an answer says at points of the contact."""
    answer: Answer = {"status": found.status, "estimate": bits(found.error_estimate)}
    edges = [zone for name in ("zones", "openings") for zone in getattr(found, name, ())]
    answer["edges"] = bits([speed for zone in edges for speed in (zone.inner, zone.outer)])
    for name in FIELDS:
        answer[name] = bits(getattr(found, name)(x, t))
    for name in TOTALS:
        answer[name] = bits(getattr(found, name)(np.array([0.4, 0.9]) * t.max()))
    return answer


def recorded_run(found: Marched) -> Answer:
    """Return what a run of an interface says at 40 nodes of as many frames."""
    frame = np.linspace(1, len(found.interface.t) - 1, POINTS).astype(int)
    node = np.linspace(0, len(found.interface.x) - 1, POINTS).astype(int)[
        np.arange(POINTS) * 7 % POINTS
    ]
    answer: Answer = {name: bits(getattr(found.interface, name)[frame, node]) for name in FIELDS}
    answer["estimate"] = bits(sorted(found.error_estimates.values()))
    onset = found.seen.onset[node]
    answer["edges"] = bits(np.where(np.isfinite(onset), onset, np.nan))
    work = found.work
    return answer | {"status": found.status, "work": bits([work["friction"], work["closing"]])}


def labels() -> list[str]:
    """Return what the problems are called: names, and kinds of draws with their numbers."""
    names = [*NAMED_SCENES]
    lines = [*NAMED_LINES]
    lines.insert(3, "tap")
    names += [f"interface {name}" for name in lines]
    return names + [f"{kind} {at}" for kind, (_, count) in DRAWS.items() for at in range(count)]


def problem_of(label: str) -> Any:
    """Return a problem: that of a draw, or a named one."""
    kind, _, last = label.rpartition(" ")
    if kind in DRAWS:
        return drawn(kind, int(last))
    if kind == "interface":
        scene = sa.find(last)
        return scene if scene.on_line else replace(scene, **TAP)
    return sa.find(label)


def answered(label: str) -> Answer:
    """Solve, march or run a problem, and return what is compared; what it refuses is recorded."""
    problem = problem_of(label)
    try:
        if isinstance(problem, sa.Scene) and problem.on_line:
            name = label.partition(" ")[2]
            end_time = problem.run["end_time"] * RUN_TIME.get(name, 1.0)
            problem = replace(problem, run={})  # nodes and steps are the same for all
            return recorded_run(sa.solve(problem, end_time=end_time, nodes=RUN_NODES))
        reach, unit = 1.5, 1.0
        settings: dict[str, Any] = {}
        if getattr(problem, "lower_material", None) is not None:
            settings, unit = {"rtol": 1e-6}, problem.material.shear_speed
        elif chosen(problem).name == "space-time":
            nodes, reach = (NODES if label.startswith("random") else NAMED_NODES), 0.98
            settings = {"end_time": 1.0 / problem.material.shear_speed, "nodes": nodes}
        found = sa.solve(problem, **settings)
        x = np.linspace(0.02, reach, POINTS) * unit
        return recorded(found, x, np.where(np.arange(POINTS) % 2, 1.0, 0.7))
    except Exception as error:  # faults of the program are answers of this commit too
        return {"status": f"{type(error).__name__}: {error}"}


def computed() -> dict[str, Answer]:
    """Return all answers by label, computed on all cores with one thread each."""
    called = labels()
    done = dict(track(run_tasks([(answered, (name,)) for name in called]), "answers", len(called)))
    return {label: done[index] for index, label in enumerate(called)}


def differences(label: str, before: Answer, now: Answer) -> Iterator[str]:
    """Yield what differs between two answers: size, scale, and the estimate of the former one."""
    if before["status"] != now["status"]:
        yield f"{label}: status {before['status']!r} is {now['status']!r}"
    estimate = max(numbers(before.get("estimate", "")), default=math.nan)
    for name in sorted((before.keys() | now.keys()) - {"status"}):
        old, new = numbers(before.get(name, "")), numbers(now.get(name, ""))
        if before.get(name) == now.get(name):
            continue
        if old.shape != new.shape:
            yield f"{label}: {name} has {new.size} numbers, {old.size} before"
            continue
        change = np.abs(new - old)
        scale = np.nanmax(np.abs(old), initial=0.0) or 1.0
        worst = "nan" if np.isnan(change).any() else f"{change.max(initial=0.0) / scale:.1e}"
        yield f"{label}: {name} differs by {worst} of {scale:.3g}, estimate {estimate:.1e}"


def read(path: Path) -> dict[str, Answer]:
    """Return the stored answers."""
    with gzip.open(path, "rt", encoding="utf-8") as file:
        stored: dict[str, Answer] = json.load(file)
    return stored


def write(path: Path, answers: Mapping[str, Answer]) -> None:
    """Store answers, the same bytes for the same answers."""
    text = json.dumps(answers, indent=0)
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the golden file, or hold the answers of this commit against it."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.golden", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--write", action="store_true", help="store the answers of this commit")
    what.add_argument("--check", action="store_true", help="say which answers differ")
    options = parser.parse_args(arguments)
    answers = computed()
    if options.write:
        write(FILE, answers)
        return 0
    stored = read(FILE)
    found = [f"{label}: not in both" for label in stored.keys() ^ answers.keys()]
    for label in stored.keys() & answers.keys():
        found += differences(label, stored[label], answers[label])
    print(*sorted(found), f"{len(stored)} answers, {len(found)} differences", sep="\n")
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
