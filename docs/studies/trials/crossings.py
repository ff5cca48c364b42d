"""Random problems answered in two ways: ``python -m docs.studies.trials.crossings --output docs``.

The answer to each of 1,360 problems is compared with that of another method, another statement of
the problem, a finer grid or a file.  Differences are counted over what both answers say
that they may be; problems that are refused or unresolved are drawn anew.  An interrupted run goes
on where it stopped.
"""

from __future__ import annotations

import math
import pickle
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.random import Generator

import slipfront as sf
from docs.studies.accuracy.march import rate_error
from docs.studies.golden import one_of, random_line, random_march, random_pair, random_scene
from docs.studies.runner import Row, Study, grouped, main
from docs.studies.trials.campaign import on_the_interface, over
from docs.studies.trials.draws import random_step_scene, random_steps
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.given.template import scene_text

SEED, CLAIMED_SEED, NODES, END = 6190, 6131, 200, 1.0
FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
_X, _T = np.linspace(0.03, 0.95, 24), 0.9
_ROUNDING = 1e-12
"""Of an answer to mirrored loads over the largest value of a field, and of changes."""
_SHEARED = dict.fromkeys(("slip", "slip_rate", "shear_traction"), -1.0)
"""Factors of fields where shear acts the other way."""


class Unresolved(Exception):
    """There is nothing to compare: an answer says that it is none, or a draw is of another kind."""


@dataclass(frozen=True)
class Seen:
    """An answer in the units, and with the signs, of another problem."""

    answer: Any
    scene: sf.Scene
    factors: Mapping[str, float]
    velocity: float = 1.0

    def __getattr__(self, name: str) -> Any:
        if name == "error_estimate":
            return self.answer.error_estimate
        factor, field = self.factors.get(name, 1.0), getattr(self.answer, name)
        return lambda x, t: field(self.velocity * np.asarray(x), t) / factor


def solved(scene: Any, **settings: Any) -> Any:
    """Solve a problem, or raise `Unresolved`."""
    answer = sf.solve(scene, **settings)
    if answer.status not in ("converged", "resolved", "done"):
        raise Unresolved(answer.status)
    return answer


def between(first: Any, other: Any, random: Generator) -> float:
    """The largest difference of fields on the interface over what both answers allow."""
    return max(on_the_interface(first, other, random).values())


def differs(first: Any, other: Any, allowed: float) -> float:
    """The largest difference of five fields over their sizes and what is allowed."""
    pairs = ([getattr(answer, name)(_X, _T) for answer in (first, other)] for name in FIELDS)
    return max(over(np.abs(b - a), allowed * np.abs(a).max()) for a, b in pairs)


def _turned(scene: sf.Scene, **changes: Any) -> sf.Scene:
    """The scene whose shear acts the other way, with other changes."""
    if not isinstance(scene.load, sf.Tractions):
        raise Unresolved("waves are turned with their sides")
    base, load = (sf.Tractions(pair.pressure, -pair.shear) for pair in (scene.base, scene.load))
    return replace(scene, base=base, load=load, **changes)


def marched(random: Generator) -> float:
    """The march of a scene, with films of any strength and openings of any width, against its exact
    answer: slip rate over all nodes and times."""
    scene = random_step_scene(random)
    viscosity = float(10 ** random.uniform(-1, 3.5)) if random.random() < 0.3 else 0.0
    load = scene.load
    if random.random() < 0.2 and not scene.arrives:
        load = sf.Tractions(-float(10 ** random.uniform(-2.5, -0.5)), load.shear)
    law = sf.Coulomb(scene.coefficient, viscosity=viscosity)
    scene = replace(scene, friction=law, load=load)
    exact = solved(scene)
    if not exact.zones:
        raise Unresolved("nothing slips")
    march = solved(scene, method="space-time", end_time=END, nodes=NODES)
    if not isinstance(march, sf.Marched):
        raise Unresolved("a contact that opens over nodes is marched on a line")
    return over(rate_error(march, exact), march.error_estimate + exact.error_estimate)


def two_bodies(random: Generator) -> float:
    """Bodies that are equal, or all but equal, against one; different ones, exchanged, at another
    accuracy."""
    if random.random() < 0.5:
        scene = random_steps(random)
        stiffer = scene.material.shear_modulus * (1 + float(random.choice([0.0, 1e-9, 1e-7])))
        other = replace(scene.material, shear_modulus=stiffer)
        pair = solved(replace(scene, lower_material=other), rtol=1e-5)
        return between(pair, solved(scene), random)
    scene = random_pair(random)
    upper, lower = scene.bodies
    rough = solved(_turned(scene, material=lower, lower_material=upper), rtol=1e-5)
    return between(Seen(rough, scene, _SHEARED), solved(scene, rtol=1e-8), random)


def swept(random: Generator) -> float:
    """One that a sweep over friction has found from its neighbours, against an answer to it."""
    scene, count = random_step_scene(random), int(random.integers(20, 100))
    answers = sf.sweep(scene, np.sort(scene.coefficient * np.exp(random.uniform(-1, 1, count))))
    found = np.flatnonzero(~answers.from_scratch & (np.array(answers.status) == "converged"))
    if not len(found):
        raise Unresolved("all solved one by one")
    answer = answers[int(random.choice(found))]
    return between(answer, solved(answer.scene), random)


def differentiated(random: Generator) -> float:
    """A derivative against central differences, whose own error two steps show."""
    scene = random_steps(random)
    answer, solid = solved(scene, rtol=1e-10), scene.material
    values = {"friction": scene.coefficient, "poisson_ratio": solid.poisson_ratio}
    values |= {"base_pressure": scene.base.pressure, "load_shear": scene.load.shear}
    name = str(random.choice([*values]))
    derivative, step = answer.derivative(name), 1e-4 * (abs(values[name]) or 1.0)
    if derivative.status != "converged":
        raise Unresolved(derivative.status)

    def moved(by: float) -> Any:
        changes: dict[str, Any] = {name: values[name] + by}
        found = solved(override_scene(scene, **changes), rtol=1e-10)
        if len(found.zones) != len(answer.zones):
            raise Unresolved("zones change nearby")
        return found

    marks = [solid.rayleigh_speed, solid.shear_speed, solid.longitudinal_speed]
    marks += [edge for cut in (*answer.zones, *answer.openings) for edge in (cut.inner, cut.outer)]
    x = random.uniform(0.05, 1.1 * solid.longitudinal_speed, 60)
    x = x[np.abs(x[:, None] - marks).min(axis=1) > 0.05]
    sides, worst = [(h, moved(h), moved(-h)) for h in (step, step / 2)], 0.0
    for field in ("slip_rate", "slip"):
        exact = getattr(derivative, field)(x, 1.0)
        wide, near = (
            (getattr(up, field)(x, 1.0) - getattr(down, field)(x, 1.0)) / (2 * h)
            for h, up, down in sides
        )
        size = np.abs(getattr(answer, field)(x, 1.0)).max(initial=0.0)
        noise = (2 * answer.error_estimate + _ROUNDING) * size / step
        own = derivative.error_estimate * np.abs(exact).max(initial=0.0)
        worst = max(worst, over(np.abs(exact - near), own + np.abs(wide - near) + noise))
    return worst


def rescaled(random: Generator) -> float:
    """A scene in other units, up to those of SI and beyond."""
    scene = random_scene(random)
    if not isinstance(scene.load, sf.Tractions):
        raise Unresolved("waves and moving loads have speeds of their own")
    stiff, dense, stress = (float(size) for size in 10 ** random.uniform((3, -3, -6), (11, 4, 9)))
    old, speed = scene.material, math.sqrt(stiff / dense)
    solid = sf.Material(stiff * old.shear_modulus, dense * old.density, old.poisson_ratio)
    parts = (scene.base, scene.load)
    base, load = (sf.Tractions(stress * part.pressure, stress * part.shear) for part in parts)
    law, slip = scene.law, stress * speed / stiff
    if isinstance(law, sf.RateWeakening):
        law = replace(law, rate=law.rate * slip)
    elif isinstance(law, sf.Coulomb):
        law = replace(law, viscosity=law.viscosity * stiff / speed)
    given = replace(scene, material=solid, friction=law, base=base, load=load, units="SI")
    factors = dict.fromkeys(FIELDS, stress) | dict.fromkeys(("slip", "slip_rate", "gap"), slip)
    ours, other = (solved(problem, method="self-similar") for problem in (given, scene))
    return between(Seen(ours, scene, factors, speed), other, random)


def mirrored(random: Generator) -> float:
    """Shear that acts the other way, exact and marched: slip is the other way, to rounding."""
    scene = random_scene(random) if random.random() < 0.5 else random_march(random)
    settings: dict[str, Any] = {"end_time": END, "nodes": NODES}
    if scene.is_self_similar:
        settings = {"method": "self-similar"}
    other = solved(_turned(scene), **settings)
    return differs(solved(scene, **settings), Seen(other, scene, _SHEARED), _ROUNDING)


def filed(random: Generator) -> float:
    """A scene written to a file is the same and has the same answer, which pickles and is saved: 0
    or inf."""
    draw = one_of(random, random_scene, random_march, random_line, random_pair)
    scene = draw(random)
    settings = {"end_time": END, "nodes": 64} if draw is random_march else {}
    answer = solved(scene, **settings)
    with tempfile.TemporaryDirectory() as folder:
        path, saved = Path(folder, "scene.toml"), Path(folder, "answer.h5")
        path.write_text(scene_text(scene), encoding="utf-8")
        answer.save(saved)
        again, found = [sf.load(saved), pickle.loads(pickle.dumps(answer))], sf.find(path)
        again.append(solved(found, **settings))
    # a march of a contact that opens has a period, as a scene along a line
    same = all(point.scene == answer.scene and differs(answer, point, 0.0) == 0 for point in again)
    return 0.0 if same and found == scene else math.inf


def _line(random: Generator) -> sf.Scene:
    """A scene along a line: patches, contacts, barriers, two bodies, laws that stick, weaken or
    creep."""
    solid = sf.Material(1.0, 1.0, float(random.uniform(-0.3, 0.45)))
    f = float(random.uniform(0.2, 0.7))
    weak = sf.SlipWeakening(f, f * random.uniform(0.3, 0.9), random.uniform(0.1, 0.6))
    creeping = sf.RateAndState(a=0.05, b=random.uniform(0.01, 0.04), f0=f, v0=1e-3, distance=0.2)
    film = sf.Coulomb(f, viscosity=float(10 ** random.uniform(-1, 3)))
    half = float(random.uniform(0.5, 2.0))
    strong = sf.Coulomb(lambda x: np.where(np.abs(x) < half, f, 30.0))
    law = one_of(random, f, film, weak, creeping, strong)
    width, shear = float(random.uniform(0.3, 1.0)), one_of(random, -1, 1) * random.uniform(0.5, 2)
    other = sf.Material(float(random.uniform(0.5, 2.0)), 1.0, 0.25)
    return sf.Scene(
        solid,
        law,
        sf.Tractions(1.0, f if law is creeping else float(random.uniform(-0.6, 0.6)) * f),
        sf.InterfaceLoad(lambda x: shear * np.exp(-np.square(x / width)), sf.Ramp(0.4), "line"),
        contact=one_of(random, sf.Contact(), sf.Contact(), sf.Contact([(-half, 1.0)])),
        lower_material=other if random.random() < 0.2 else None,
        rate=1e-3 if law is creeping else 0.0,
        period=8.0,
    )


def halved(random: Generator) -> float:
    """A march along a line against one of four times the nodes, over frames and contact."""
    scene, settings = _line(random), {"end_time": 1.6, "times": [0.45, 0.8, 1.2, 1.6]}
    rough = solved(scene, nodes=128, **settings)
    fine = solved(scene, nodes=512, **settings)
    on, worst = rough.interface.touching, 0.0
    for name in ("slip", "slip_rate", "shear_traction"):
        values = getattr(rough.interface, name)[:, on]
        other = fine.at(getattr(fine.interface, name), rough.interface.x[on])
        size = np.abs(other - scene.base.shear * (name == "shear_traction")).sum()
        allowed = size * (rough.error_estimates[name] + fine.error_estimates[name])
        worst = max(worst, over(np.abs(values - other).sum(), allowed + _ROUNDING * on.sum()))
    return worst


def continued(random: Generator) -> float:
    """A march, of a slot or along a line, with a stop on its way against the one without: 0 or inf
    along a line."""
    stop, along = float(random.uniform(0.2, 0.8)), random.random() < 0.5
    scene = _line(random) if along else random_march(random)
    settings: dict[str, Any] = {"nodes": NODES, "latest": END}
    if not along:
        settings["length"] = scene.fastest_speed * END
    whole = solved(scene, end_time=END, **settings)
    begun = sf.solve(scene, end_time=stop, **settings)
    gone = sf.solve(scene, end_time=END, go_on=begun)
    if along:
        same = np.array_equal(whole.interface.slip[-1], gone.interface.slip[-1])
        return 0.0 if same else math.inf
    return over(rate_error(gone, whole), whole.error_estimate + gone.error_estimate)


def without_slot(random: Generator) -> float:
    """Patches and growing loads against marches along a line, forces against narrow patches."""
    scene = random_line(random)
    exact, load = solved(scene), scene.load
    if isinstance(load, sf.PointForce):
        slow = 1e-3
        narrow = sf.Patch(slow, load.pressure / (2 * slow), load.shear / (2 * slow))
        other = solved(replace(scene, load=narrow))
        # a patch is a force but for the square of its speed over that of its edges
        allowed = 4 * (slow / exact.edge_speed) ** 2 + exact.error_estimate + other.error_estimate
        return over(abs(other.edge_speed - exact.edge_speed), exact.edge_speed * allowed)
    wide = 4 * scene.material.longitudinal_speed

    def spread(x: Any, t: float) -> Any:
        return load.shear * np.clip((load.speed * t - np.abs(x)) * 1024 / wide + 0.5, 0, 1)

    def grown(of: float) -> Callable[..., Any]:
        return lambda x, t: of * t**load.power + 0 * x

    if isinstance(load, sf.Patch):
        loads: Any = sf.InterfaceLoad(spread, history=None)
    else:  # the faces of the slot bear the pressure too
        pressed, kept = grown(load.pressure), grown(-load.pressure)
        loads = (
            sf.InterfaceLoad(pressure=pressed, history=None, on="line"),
            sf.InterfaceLoad(grown(load.shear), history=None, on="slot", pressure=kept),
        )
    times = np.linspace(0.5, 1.0, 6)
    line = replace(scene, load=loads, period=wide)
    run = solved(line, end_time=END, nodes=1024, times=list(times))
    x = run.interface.x[run.interface.touching & (np.abs(run.interface.x) < wide / 4)]
    right, found = (answer.slip(x, times[:, None]) for answer in (exact, run))
    allowed = (run.error_estimates["slip"] + exact.error_estimate) * np.abs(right).sum()
    return over(np.abs(found - right).sum(), allowed)


def simulated(random: Generator) -> float:
    """Exact answers against finite elements, by the judge: 0, or inf where both differ."""
    verdict = sf.compare(random_steps(random), resolution=40).verdict
    if verdict == "unresolved":
        raise Unresolved(verdict)
    return 0.0 if verdict == "agrees" else math.inf


CHECKS: Mapping[Callable[[Generator], float], int] = {
    marched: 400,
    two_bodies: 140,
    swept: 110,
    differentiated: 110,
    rescaled: 110,
    mirrored: 100,
    filed: 100,
    halved: 200,
    continued: 50,
    without_slot: 30,
    simulated: 10,
}
"""What is held against what, and how many problems of each."""
CLAIMED = ("marched", "halved")
"""Checks of estimates of marches, which have a table of their own."""


def crossed(name: str, index: int, seed: int = SEED) -> Row:
    """Draw problems until one is answered twice, and hold both answers against one another."""
    order, check = next(check for check in enumerate(CHECKS) if check[1].__name__ == name)
    random, began = np.random.default_rng([seed, order, index]), process_time()
    row: Row = {"check": name, "seeds": f"{seed}, {order}, 0", "index": index}
    row |= {"refused": 0, "unresolved": 0, "raised": ""}
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


def claimed(name: str, index: int) -> Row:
    """Return the row of one check of estimates, on a seed on which nothing was chosen."""
    return crossed(name, index, CLAIMED_SEED)


def summary(rows: list[Row]) -> list[Row]:
    """Count problems and differences beyond the estimates of each check."""
    return [
        {
            "check": name.replace("_", " "),
            "seeds": f"{own[-1]['seeds']} to {own[-1]['index']}",
            "refused": sum(row["refused"] for row in own),
            "unresolved": sum(row["unresolved"] for row in own),
            "compared": len(own),
            "beyond": sum(not row["ratio"] <= 1 for row in own),
            "largest": f"{max(row['ratio'] for row in own):.2g}",
        }
        for (name,), own in grouped(rows, "check")
    ]


def claims(rows: list[Row]) -> list[Row]:
    """Return a row for each check of estimates, with the median of estimates over errors."""
    found = {
        name: np.array([row["ratio"] for row in own]) for (name,), own in grouped(rows, "check")
    }
    medians = [f"{1 / np.median(ratios[ratios > 0]):.2g}" for ratios in found.values()]
    return [row | {"claim": median} for row, median in zip(summary(rows), medians, strict=True)]


def points(quick: bool, claimed: bool = False) -> list[tuple[str, int]]:
    """Return the name of each check with the number of each of its problems."""
    counts = {
        check.__name__: max(1, count // 50 if quick else count)
        for check, count in CHECKS.items()
        if (check.__name__ in CLAIMED) == claimed
    }
    return [(name, index) for name, count in counts.items() for index in range(count)]


STUDIES = [
    Study("campaign-crossings", points, crossed, summary),
    Study("march-claims", partial(points, claimed=True), claimed, claims),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.crossings", STUDIES))
