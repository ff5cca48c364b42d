"""Random problems answered in two ways: ``python -m docs.studies.trials.crossings --output docs``.

Each of the 1,000 problems is one that a method takes, of any kind.  Its answer is held against what
another method, another statement of the same problem, a finer grid or a file makes of it.  The
difference is counted over what both answers say that it may be; problems that are refused or
unresolved are drawn anew.  An interrupted run goes on where it stopped.
"""

from __future__ import annotations

import math
import pickle
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.random import Generator

import slipfront as sf
from docs.studies.accuracy.march import rate_error
from docs.studies.golden import one_of, random_line, random_march, random_pair, random_scene
from docs.studies.runner import Row, Study, grouped, main
from docs.studies.trials.campaign import on_the_interface
from docs.studies.trials.draws import random_step_scene, random_steps
from semianalytic.scene.given.template import scene_text

SEED, NODES, END = 11, 200, 1.0
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
_X, _T = np.linspace(0.03, 0.95, 24), 0.9
_ROUNDING = 1e-12
"""Of an answer in other units, or of mirrored loads, over the largest value of a field."""


class Unresolved(Exception):
    """An answer says that it is none."""


@dataclass(frozen=True)
class Seen:
    """An answer in the units of another problem, as `on_the_interface` asks it."""

    answer: Any
    scene: sf.Scene
    velocity: float
    factors: Mapping[str, float]

    @property
    def error_estimate(self) -> float:
        return float(self.answer.error_estimate)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        factor = self.factors.get(name, 1.0)
        return lambda x, t: getattr(self.answer, name)(self.velocity * np.asarray(x), t) / factor


def solved(scene: Any, **settings: Any) -> Any:
    """Solve a problem, or raise `Unresolved`."""
    answer = sf.solve(scene, **settings)
    if answer.status not in ("converged", "resolved", "done"):
        raise Unresolved(answer.status)
    return answer


def between(one: Any, other: Any, random: Generator) -> float:
    """The largest difference of fields on the interface over what both answers allow."""
    return max(on_the_interface(one, other, random).values())


def over(apart: Any, allowed: Any) -> float:
    """The largest share of what is allowed; inf where nothing is and there is a difference."""
    apart, allowed = np.broadcast_arrays(apart, allowed)
    share = np.divide(apart, allowed, out=np.where(apart > 0, np.inf, 0.0), where=allowed > 0)
    return float(share.max(initial=0.0))


def differs(one: Any, other: Any, allowed: float) -> float:
    """The largest difference of five fields over their sizes and what is allowed."""
    pairs = ([getattr(answer, name)(_X, _T) for answer in (one, other)] for name in FIELDS)
    return max(over(np.abs(b - a), allowed * np.abs(a).max()) for a, b in pairs)


def marched(random: Generator) -> float:
    """The march of a scene against its exact answer: slip rate over all nodes and times."""
    scene = random_step_scene(random)
    exact = solved(scene)
    if not exact.zones:
        raise Unresolved("nothing slips")
    march = solved(scene, method="space-time", end_time=END, nodes=NODES)
    return over(rate_error(march, exact), march.error_estimate + exact.error_estimate)


def two_bodies(random: Generator) -> float:
    """Equal bodies, or of contrast 1e-9, as two against one; different ones, exchanged, at another
    accuracy."""
    if random.random() < 0.5:
        scene = random_steps(random)
        solid = scene.material
        contrast = float(random.choice([0.0, 1e-9, 1e-7]))
        other = replace(solid, shear_modulus=solid.shear_modulus * (1 + contrast))
        return between(
            solved(replace(scene, lower_material=other), rtol=1e-5), solved(scene), random
        )
    scene = random_pair(random)
    base, load = (sf.Tractions(one.pressure, -one.shear) for one in (scene.base, scene.load))
    upper, lower = scene.bodies
    swapped = replace(scene, material=lower, lower_material=upper, base=base, load=load)
    rough, fine = solved(swapped, rtol=1e-5), solved(scene, rtol=1e-8)
    signs = dict.fromkeys(("slip", "slip_rate", "shear_traction"), -1.0)
    return between(Seen(rough, scene, 1.0, signs), fine, random)


def swept(random: Generator) -> float:
    """A sweep over friction against answers one by one."""
    scene, count = random_step_scene(random), int(random.integers(20, 100))
    friction = np.sort(scene.coefficient * np.exp(random.uniform(-1, 1, count)))
    answers = sf.sweep(scene, friction)
    found = ~answers.from_scratch & (np.array(answers.status) == "converged")
    if not found.any():
        raise Unresolved("all solved one by one")
    at = int(random.choice(np.flatnonzero(found)))
    return between(answers[at], solved(replace(scene, friction=float(friction[at]))), random)


def differentiated(random: Generator) -> float:
    """A derivative against central differences, whose own error two steps show."""
    scene = random_steps(random)
    answer = solved(scene, rtol=1e-10)
    name = str(random.choice(["friction", "poisson_ratio", "base_pressure", "load_shear"]))
    derivative = answer.derivative(name)
    if derivative.status != "converged":
        raise Unresolved(derivative.status)
    part, _, kind = name.partition("_")
    whole = {"friction": scene, "poisson": scene.material}.get(part) or getattr(scene, part)
    key = name if part in ("friction", "poisson") else kind
    value = float(getattr(whole, key))

    def moved(by: float) -> Any:
        varied = replace(whole, **{key: value + by})
        owner = {"friction": varied, "poisson": None}.get(part)
        field = "material" if part == "poisson" else part
        found = solved(owner or replace(scene, **{field: varied}), rtol=1e-10)
        if [len(one.zones) for one in (found, answer)] != 2 * [len(answer.zones)]:
            raise Unresolved("zones change nearby")
        return found

    step = 1e-4 * (abs(value) or 1.0)
    edges = [
        edge for zone in (*answer.zones, *answer.openings) for edge in (zone.inner, zone.outer)
    ]
    material = scene.material
    marks = [*edges, material.rayleigh_speed, material.shear_speed, material.longitudinal_speed]
    x = random.uniform(0.05, 1.1 * material.longitudinal_speed, 60)
    x = x[np.abs(x[:, None] - marks).min(axis=1) > 0.05]
    worst = 0.0
    sides = [[moved(by) for by in (h, -h)] for h in (step, step / 2)]
    for name in ("slip_rate", "slip"):
        exact = getattr(derivative, name)(x, 1.0)
        wide, near = (
            (getattr(up, name)(x, 1.0) - getattr(down, name)(x, 1.0)) / (2 * h)
            for (up, down), h in zip(sides, (step, step / 2), strict=True)
        )
        size = np.abs(getattr(answer, name)(x, 1.0)).max(initial=0.0)
        noise = 2 * answer.error_estimate * size / step + 1e-13 * size / step
        allowed = derivative.error_estimate * np.abs(exact).max(initial=0.0)
        allowed = allowed + np.abs(wide - near) + noise
        worst = max(worst, over(np.abs(exact - near), allowed))
    return worst


def rescaled(random: Generator) -> float:
    """A scene in other units, up to those of SI and beyond."""
    scene = random_scene(random)
    if not isinstance(scene.load, sf.Tractions):
        raise Unresolved("waves and moving loads have speeds of their own")
    stiff, dense, stress = 10 ** random.uniform((3, -3, -6), (11, 4, 9))
    old, speed = scene.material, math.sqrt(stiff / dense)
    solid = sf.Material(stiff * old.shear_modulus, dense * old.density, old.poisson_ratio)
    base, load = (
        sf.Tractions(stress * one.pressure, stress * one.shear) for one in (scene.base, scene.load)
    )
    law: Any = scene.law
    if isinstance(law, sf.RateWeakening):
        law = replace(law, rate=law.rate * stress * speed / stiff)
    elif law.viscosity:
        law = replace(law, viscosity=law.viscosity * stiff / speed)
    given = replace(scene, material=solid, friction=law, base=base, load=load, units="SI")
    slip = stress * speed / stiff
    factors = dict.fromkeys(("slip", "slip_rate", "gap"), slip)
    factors |= dict.fromkeys(("shear_traction", "pressure"), stress)
    one, other = solved(given, method="self-similar"), solved(scene, method="self-similar")
    return between(Seen(one, scene, speed, factors), other, random)


def mirrored(random: Generator) -> float:
    """Shear that acts the other way, exact and marched: slip is the other way, to rounding."""
    scene = random_scene(random) if random.random() < 0.5 else random_march(random)
    if not isinstance(scene.load, sf.Tractions):
        raise Unresolved("waves are mirrored with their sides")
    base, load = (sf.Tractions(one.pressure, -one.shear) for one in (scene.base, scene.load))
    settings = {} if scene.is_self_similar else {"end_time": END, "nodes": NODES}
    settings |= {"method": "self-similar"} if scene.is_self_similar else {}
    one = solved(scene, **settings)
    other = solved(replace(scene, base=base, load=load), **settings)
    signs = dict.fromkeys(("slip", "slip_rate", "shear_traction"), -1.0)
    return differs(one, Seen(other, scene, 1.0, signs), _ROUNDING)


def filed(random: Generator) -> float:
    """A scene written to a file is the same and has the same answer, which pickles and, of a march,
    is saved; 0 or inf."""
    draw = (random_scene, random_march, random_line, random_pair)[random.integers(4)]
    scene = draw(random)
    settings = {"end_time": END, "nodes": 64} if draw is random_march else {}
    answer = solved(scene, **settings)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "scene.toml")
        path.write_text(scene_text(scene), encoding="utf-8")
        found = sf.find(path)
        again = [solved(found, **settings), pickle.loads(pickle.dumps(answer))]
        if settings:
            answer.save(path.with_suffix(".h5"))
            again.append(sf.load(path.with_suffix(".h5")))
    same = found == scene and all(differs(answer, one, 0.0) == 0 for one in again)
    return 0.0 if same else math.inf


def _line(random: Generator) -> sf.Scene:
    """A scene along a line: patches, contacts, two bodies, laws that stick, weaken or creep."""
    solid = sf.Material(1.0, 1.0, float(random.uniform(-0.3, 0.45)))
    f = float(random.uniform(0.2, 0.7))
    law: Any = one_of(
        random,
        f,
        sf.Coulomb(f, viscosity=0.3),
        sf.SlipWeakening(f, f * random.uniform(0.3, 0.9), random.uniform(0.1, 0.6)),
        sf.RateAndState(a=0.05, b=random.uniform(0.01, 0.04), f0=f, v0=1e-3, distance=0.2),
    )
    creeps = isinstance(law, sf.RateAndState)
    width, shear = float(random.uniform(0.3, 1.0)), one_of(random, -1, 1) * random.uniform(0.5, 2)
    other = sf.Material(float(random.uniform(0.5, 2.0)), 1.0, 0.25)
    return sf.Scene(
        solid,
        law,
        sf.Tractions(1.0, f if creeps else float(random.uniform(-0.6, 0.6)) * f),
        sf.InterfaceLoad(lambda x: shear * np.exp(-np.square(x / width)), sf.Ramp(0.4), "line"),
        contact=sf.Contact([(-1.0, 1.0)]) if random.random() < 0.3 else sf.Contact(),
        lower_material=other if random.random() < 0.2 else None,
        rate=1e-3 if creeps else 0.0,
        period=8.0,
    )


def halved(random: Generator) -> float:
    """A run of an interface against one of four times the nodes, over frames and contact."""
    scene = _line(random)
    settings = {"end_time": 1.6, "times": [0.4, 0.8, 1.2, 1.6]}
    rough = solved(scene, nodes=128, **settings)
    fine = solved(scene, nodes=512, **settings)
    on, worst = rough.interface.touching, 0.0
    for name in ("slip", "slip_rate", "shear_traction"):
        one, other = (getattr(run.interface, name) for run in (rough, fine))
        # nodes lie midway between ends of contacts, or else on one another
        other = other[:, ::4] if on.all() else other.reshape(len(other), -1, 4).mean(axis=-1)
        size = np.abs(other - scene.base.shear * (name == "shear_traction"))[:, on].sum()
        allowed = size * (rough.error_estimates[name] + fine.error_estimates[name])
        worst = max(worst, over(np.abs(one - other)[:, on].sum(), allowed + 1e-12 * on.sum()))
    return worst


def continued(random: Generator) -> float:
    """A march or a run with a stop on its way against the one without."""
    stop = float(random.uniform(0.2, 0.8))
    if random.random() < 0.5:
        line = _line(random)
        whole = solved(line, end_time=END, nodes=128, times=[END])
        begun = solved(line, end_time=stop, nodes=128, latest=END)
        gone = solved(line, end_time=END, go_on=begun, times=[END])
        same = np.array_equal(whole.interface.slip[-1], gone.interface.slip[-1])
        return 0.0 if same else math.inf
    scene = random_march(random)
    settings = {"nodes": NODES, "length": scene.fastest_speed * END, "latest": END}
    whole = solved(scene, end_time=END, **settings)
    begun = sf.solve(scene, end_time=stop, **settings)
    gone = sf.solve(scene, end_time=END, go_on=begun)
    return over(rate_error(gone, whole), whole.error_estimate + gone.error_estimate)


def without_slot(random: Generator) -> float:
    """Patches against runs of a line, forces against narrow patches, growing loads by two laws."""
    scene = random_line(random)
    exact, load = solved(scene), scene.load
    if isinstance(load, sf.PointForce):
        speed = 1e-3
        narrow = sf.Patch(speed, load.pressure / (2 * speed), load.shear / (2 * speed))
        other = solved(replace(scene, load=narrow))
        # a patch is a force but for the square of its speed over that of its edges
        allowed = 4 * (speed / exact.edge_speed) ** 2 + exact.error_estimate + other.error_estimate
        return abs(other.edge_speed - exact.edge_speed) / (exact.edge_speed * allowed)
    wide = 4 * scene.material.longitudinal_speed
    if isinstance(load, sf.Patch):
        step = wide / 1024

        def spread(x: Any, t: float) -> Any:
            return load.shear * np.clip((load.speed * t - np.abs(x)) / step + 0.5, 0, 1)

        loads: Any = sf.InterfaceLoad(spread, history=None)
    else:

        def grown(of: float) -> Callable[..., Any]:
            return lambda x, t: of * t**load.power + 0 * x

        pressed, kept = grown(load.pressure), grown(-load.pressure)  # on the slot's faces too
        loads = (
            sf.InterfaceLoad(pressure=pressed, history=None),
            sf.InterfaceLoad(grown(load.shear), history=None, on="slot", pressure=kept),
        )
    times = np.linspace(0.5, 1.0, 6)
    line = replace(scene, load=loads, period=wide)
    run = solved(line, end_time=END, nodes=1024, times=list(times))
    x = run.interface.x[run.interface.touching & (np.abs(run.interface.x) < wide / 4)]
    right, found = (one.slip(x, times[:, None]) for one in (exact, run))
    allowed = (run.error_estimates["slip"] + exact.error_estimate) * np.abs(right).sum()
    return over(np.abs(found - right).sum(), allowed)


def simulated(random: Generator) -> float:
    """Exact answers against finite elements, by the judge: 0, or inf where both differ."""
    verdict = sf.compare(random_steps(random), resolution=40).verdict
    if verdict == "unresolved":
        raise Unresolved(verdict)
    return 0.0 if verdict == "agrees" else math.inf


CHECKS: Mapping[Callable[[Generator], float], int] = {
    marched: 150,
    two_bodies: 140,
    swept: 120,
    differentiated: 120,
    rescaled: 120,
    mirrored: 110,
    filed: 110,
    halved: 50,
    continued: 40,
    without_slot: 30,
    simulated: 10,
}
"""What is held against what, and how many problems of each."""


def crossed(name: str, index: int) -> Row:
    """Draw problems until one is answered twice, and hold both answers against one another."""
    (check,) = (one for one in CHECKS if one.__name__ == name)
    order = [one.__name__ for one in CHECKS].index(name)
    random, began = np.random.default_rng([SEED, order, index]), process_time()
    row: Row = {"check": name, "index": index, "refused": 0, "unresolved": 0, "raised": ""}
    while True:
        try:
            ratio = check(random)
        except (sf.SceneError, sf.TensionError):
            row["refused"] += 1
            continue
        except Unresolved:
            row["unresolved"] += 1
            continue
        except Exception as error:  # what a campaign is for
            row["raised"], ratio = f"{type(error).__name__}: {error}", math.inf
        return {**row, "ratio": ratio, "seconds": process_time() - began}


def summary(rows: list[Row]) -> list[Row]:
    """Count problems and differences beyond the estimates of each check."""
    return [
        {
            "check": name,
            "seed": f"{SEED}, {list(CHECKS).index(check)}, 0 ... {CHECKS[check] - 1}",
            "compared": len(own),
            "refused": sum(row["refused"] for row in own),
            "unresolved": sum(row["unresolved"] for row in own),
            "beyond": sum(not row["ratio"] <= 1 for row in own),
            "raised": sum(bool(row["raised"]) for row in own),
            "largest": f"{max(row['ratio'] for row in own):.2g}",
        }
        for (name,), own in grouped(rows, "check")
        for check in CHECKS
        if check.__name__ == name
    ]


def points(quick: bool) -> list[tuple[str, int]]:
    """Return the name of each check with the number of each of its problems."""
    return [
        (check.__name__, index)
        for check, count in CHECKS.items()
        for index in range(max(1, count // 50) if quick else count)
    ]


STUDIES = [Study("campaign-crossings", points, crossed, summary)]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.crossings", STUDIES))
