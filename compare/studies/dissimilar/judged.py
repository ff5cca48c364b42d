"""Exact answers for two different bodies, right and wrong on purpose, judged by finite elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from compare.comparison.judgement import Judgement, judge
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from compare.studies.dissimilar.pairs import SCENES, random_pair
from fem import Simulation, simulate, with_companions
from semianalytic import Pair, SceneError, find, solve
from semianalytic.scene.given.named import NAMED_PAIRS

RESOLUTION = 100
"""Elements over the way of a shear wave of the upper body, as `slipfront compare` takes by
default; its companions have 50 and 25."""
DRAWN, SEED = 20, 31
"""Random pairs that have an answer, and the first number of their seeds."""
OFF, STIFFER = 1.03, 1.1
"""Friction, and shear modulus of the lower body, of wrong answers over the right ones."""
REFUSED = "refused"


@dataclass(frozen=True)
class JudgedRow:
    """An exact answer held against finite elements: its verdict, the numbers of rows that agree,
    differ and are unresolved, the largest difference of what agrees in error bars and where it is;
    then the verdicts on wrong answers of 3 % more friction, of exchanged bodies, and of a lower
    body that is 10 % stiffer, "refused" where friction then leaves nothing to solve for."""

    scene: str
    verdict: str
    agree: int
    differ: int
    unresolved: int
    over_bar: float
    what: str
    friction: str
    exchanged: str
    stiffer: str


def judged_rows() -> list[JudgedRow]:
    """Judge the named pairs, and the scenes that between them have all kinds of zones."""
    named = {name: find(name) for name in NAMED_PAIRS}
    return [judged_row(name, pair) for name, pair in (named | dict(SCENES)).items()]


def drawn_rows(pairs: int = DRAWN, resolution: int = RESOLUTION) -> list[JudgedRow]:
    """Judge random pairs; those that friction leaves without an answer are passed over."""
    drawn = _drawn()
    return [judged_row(*next(drawn), resolution) for _ in range(pairs)]


def _drawn() -> Iterator[tuple[str, Pair]]:
    number = 0
    while True:
        pair = random_pair(np.random.default_rng([SEED, number]))
        number += 1
        if verdict_on(pair, None) != REFUSED:
            yield f"random {number - 1}", pair


def wrong_ones(pair: Pair) -> Mapping[str, Pair]:
    """Return pairs whose answers are wrong for a pair, by the name of what is wrong."""
    lower = replace(pair.lower, shear_modulus=STIFFER * pair.lower.shear_modulus)
    return {
        "friction": replace(pair, friction=OFF * pair.friction),
        "exchanged": replace(pair, upper=pair.lower, lower=pair.upper),
        "stiffer": replace(pair, lower=lower),
    }


def verdict_on(pair: Pair, run: Simulation | None) -> str:
    """Return the verdict on the answer for a pair, or whether it is refused; "" without a run."""
    try:
        answer = solve(pair)
    except SceneError:
        return REFUSED
    return "" if run is None else judge(answer, run).verdict


def judged_row(name: str, pair: Pair, resolution: int = RESOLUTION) -> JudgedRow:
    """Simulate a pair until a shear wave of the upper body has come a length of 1, and judge."""
    time = 1 / pair.upper.shear_speed
    run = simulate(pair.alike, time, resolution=resolution, lower_material=pair.lower)
    run = with_companions(run)
    judgement = judge(solve(pair), run)
    counts, (far, what) = judgement.counts, _farthest(judgement)
    wrong = {which: verdict_on(other, run) for which, other in wrong_ones(pair).items()}
    return JudgedRow(
        name,
        judgement.verdict,
        counts[AGREES],
        counts[DIFFERS],
        counts[UNRESOLVED],
        far,
        what,
        **wrong,
    )


def _farthest(judgement: Judgement) -> tuple[float, str]:
    """Return the largest difference of what agrees, in error bars, and the name of its row."""
    return max((row.over_bar, row.name) for row in judgement.having(AGREES))
