"""Measure what half and twice the value of a tuning constant do to answers and to work.

``python -m docs.studies.constants LOOSEST_RULE RULE_SHARE`` measures constants of the solver, with
``--hard`` on scenes whose search is long, and ``python -m docs.studies.constants --sweeps NEAR``
constants of sweeps.  Without names all numbers of the module are measured.  The docstrings in
`semianalytic.selfsimilar.zones.tuning` and `semianalytic.sweeps.tuning` state the results in words.
Work is counted in values of Cauchy's kernel, a number that does not depend on what else the machine
computes.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from types import ModuleType
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from compare.studies.tables import shown_rows
from docs.studies.trials.draws import drawn, random_step_scene, random_wide_scene
from semianalytic import (
    CoulombFriction,
    Scene,
    SlipfrontError,
    Solution,
    find_scene,
    solve,
    sweep,
)
from semianalytic.cut.quadrature import panels
from semianalytic.selfsimilar.zones import tuning as solver_tuning
from semianalytic.sweeps import tuning as sweep_tuning

Array = NDArray[np.float64]

SEED, HARD_SEED = 5, 11
OF_EACH, HARD_FOUND, HARD = 24, 60, 30
"""Scenes of either kind; scenes whose search is long that are found, and that are kept."""
RTOL, REFERENCE_RTOL = 1e-8, 1e-11
SWEPT = ("preloaded", "remote-shock", "auxetic", "antiplane")
FRICTIONS = np.geomspace(0.05, 1.5, 60)
SAME = 1e-12
"""Distance of edges, over c_t, below which they are the same."""
MANY_STEPS = 6
"""Newton steps beyond which a search counts as hard."""


@dataclass(frozen=True)
class Answer:
    """The numbers of an answer that are compared: no edges, and no convergence, of a refused scene.

    Attributes
    ----------
    edges : tuple of float
        Velocities of edges over c_t.
    senses : tuple of int
        Sense of each zone.
    estimate : float
        Error estimate.
    converged : bool
        Whether the answer has converged.
    """

    edges: tuple[float, ...] = ()
    senses: tuple[int, ...] = ()
    estimate: float = np.inf
    converged: bool = False

    @classmethod
    def of(cls, solution: Solution) -> Answer:
        """Return the answer of a solution."""
        speed = solution.scene.material.shear_speed
        edges = [edge / speed for zone in solution.zones for edge in (zone.inner, zone.outer)]
        senses = tuple(zone.sense for zone in solution.zones)
        converged = solution.status == "converged"
        return cls(tuple(edges), senses, solution.error_estimate, converged)

    def apart(self, other: Answer) -> float:
        """Return the largest distance of edges; infinite if zones differ in number or sense."""
        if self.senses != other.senses:
            return np.inf
        pairs = zip(self.edges, other.edges, strict=True)
        return max((abs(one - two) for one, two in pairs if one != two), default=0.0)


@dataclass(frozen=True)
class ConstantRow:
    """The effect of one value of a constant on answers and on work.

    Attributes
    ----------
    constant : str
        Name of the constant.
    value : float
        Value in this row.
    answers, failed : int
        Number of answers, and of those that converge at the usual value alone.
    zones, changed : int
        Answers with other zones than a strict solution, and with other edges than at the usual
        value.
    worst : float
        Largest error of an edge over its estimate.
    work : float
        Values of Cauchy's kernel over their number at the usual value.
    """

    constant: str
    value: float
    answers: int
    failed: int
    zones: int
    changed: int
    worst: float
    work: float


def random_scenes(each: int = OF_EACH) -> list[Scene]:
    """Return random scenes with Coulomb friction: steps, and steps on bases of any size."""
    wide = [drawn(SEED, index, random_wide_scene)[0] for index in range(20 * each)]
    coulomb = [one for one in wide if isinstance(one.friction_law, CoulombFriction)]
    return [drawn(SEED, index, random_step_scene)[0] for index in range(each)] + coulomb[:each]


def hard_scenes(found: int = HARD_FOUND, kept: int = HARD) -> list[Scene]:
    """Return random scenes that take a second set of zones or many Newton steps.

    They are those of the least work among the first that are found: a single scene that takes a
    hundred steps would outweigh all others.
    """
    hard: list[tuple[int, Scene]] = []
    index = 0
    while len(hard) < found:
        for draw in (random_step_scene, random_wide_scene):
            scene = drawn(HARD_SEED, index, draw)[0]
            try:
                with kernel_values() as count:
                    seen = solve(scene, rtol=RTOL).statistics
            except SlipfrontError:
                continue
            if seen.zone_sets > 1 or seen.newton_steps > MANY_STEPS:
                hard.append((count[0], scene))
        index += 1
    return [scene for _, scene in sorted(hard[:found], key=lambda one: one[0])[:kept]]


def solved(scenes: Sequence[Scene], rtol: float) -> list[Answer]:
    """Return the answers of scenes."""
    answers = []
    for scene in scenes:
        try:
            answers.append(Answer.of(solve(scene, rtol=rtol)))
        except SlipfrontError:
            answers.append(Answer())
    return answers


def swept(frictions: Array, rtol: float) -> list[Answer]:
    """Return the answers of sweeps of four scenes over friction."""
    sweeps = (sweep(find_scene(name), frictions, rtol) for name in SWEPT)
    return [Answer.of(one[index]) for one in sweeps for index in range(len(frictions))]


@contextmanager
def kernel_values() -> Iterator[list[int]]:
    """Yield a list whose only number counts the values of Cauchy's kernel that are formed."""
    count, summed = [0], panels._summed

    def counting(weights: Array, own: Array, other: Array) -> Array:
        count[0] += own.size * other.shape[-1]
        return summed(weights, own, other)

    with mock.patch.object(panels, "_summed", counting):
        yield count


def measured(
    compute: Callable[[float], list[Answer]], rtol: float, module: ModuleType, values: Any
) -> tuple[list[Answer], int]:
    """Return the answers at values of constants of a module, and their work."""
    changed = mock.patch.multiple(module, **values) if values else nullcontext()
    with changed, kernel_values() as count:
        return compute(rtol), count[0]


def constant_rows(
    module: ModuleType, names: Sequence[str], compute: Callable[[float], list[Answer]]
) -> Iterator[ConstantRow]:
    """Yield two rows for each constant of a module, at half and at twice its value."""
    # A process for each value: functions that remember results must not carry them over.
    with get_context().Pool(1, maxtasksperchild=1) as pool:
        strict, _ = pool.apply(_in_process, (compute, REFERENCE_RTOL, module.__name__, {}))
        base, work = pool.apply(_in_process, (compute, RTOL, module.__name__, {}))
        for name in names:
            value = getattr(module, name)
            for factor in (0.5, 2.0):
                scaled = max(1, int(value * factor)) if isinstance(value, int) else value * factor
                task = compute, RTOL, module.__name__, {name: scaled}
                answers, formed = pool.apply(_in_process, task)
                yield _row(name, scaled, answers, base, strict, formed / work)


def _in_process(compute: Any, rtol: float, module: str, values: Any) -> tuple[list[Answer], int]:
    modules = {one.__name__: one for one in (solver_tuning, sweep_tuning)}
    return measured(compute, rtol, modules[module], values)


def _row(
    name: str,
    value: float,
    answers: Sequence[Answer],
    base: Sequence[Answer],
    strict: Sequence[Answer],
    work: float,
) -> ConstantRow:
    sound = [pair for pair in zip(answers, strict, strict=True) if all(x.converged for x in pair)]
    alike = [pair for pair in sound if pair[0].senses == pair[1].senses]
    beside = list(zip(answers, base, strict=True))
    return ConstantRow(
        name,
        value,
        len(answers),
        sum(usual.converged and not one.converged for one, usual in beside),
        len(sound) - len(alike),
        sum(not one.apart(usual) <= SAME for one, usual in beside),
        max((one.apart(exact) / one.estimate for one, exact in alike), default=0.0),
        work,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the constants that the command line names, and print a row for each value."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.constants")
    parser.add_argument("names", nargs="*", metavar="CONSTANT")
    parser.add_argument("--sweeps", action="store_true", help="constants of sweeps")
    parser.add_argument("--hard", action="store_true", help="scenes whose search is long")
    options = parser.parse_args(arguments)
    module = sweep_tuning if options.sweeps else solver_tuning
    known = [name for name in vars(module) if isinstance(getattr(module, name), int | float)]
    for name in options.names:
        if name not in known:
            parser.error(f"{name} is no number of {module.__name__}")
    compute: Callable[[float], list[Answer]] = partial(swept, FRICTIONS)
    if not options.sweeps:
        scenes = hard_scenes() if options.hard else random_scenes()
        compute = partial(solved, scenes)
    rows = list(constant_rows(module, options.names or known, compute))
    Console(width=140).print(shown_rows("constants", rows))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
