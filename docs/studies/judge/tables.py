"""Results of the trials of the judge: false alarms, error bars and power."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from docs.studies.judge.faults import FAULTS
from docs.studies.judge.right_trials import COUNTS
from docs.studies.judge.rows import JudgedRow, SpoiltRow
from docs.studies.judge.spoils import SPOILS, Spoil
from docs.studies.judge.spoilt_trials import REFUSED, TRUTH

ALL = "all"
CONFIDENCE = 0.95
"""Confidence level of the upper limit of a rate."""
CATCHABLE, SURE = 1.5, 2.5
"""Number of bars from which a mistake ought to be caught, and from which it shows however the
simulation errs within its bar."""
STRENGTHS = (0.0, 0.5, 1.0, CATCHABLE, 2.0, SURE, math.inf)
"""Limits of the strength classes, over the bar; mistakes between two limits share a class."""


@dataclass(frozen=True)
class AlarmRow:
    """Judgements of right answers to a group of scenes.

    Attributes
    ----------
    group : str, kind of the draw, or the named scene that a map is around; "all" of them
    scenes : int, that have been run
    planned : int, of the whole trial
    refusals : int, draws that have no answer, or open the contact
    rows : int
    false_rows, false_scenes : int, said to differ
    rate : upper 95 % limit of the part of such scenes that is said to differ
    agreeing_scenes : part of the scenes said to agree; the others are unresolved
    unresolved_rows : part of the rows
    """

    group: str
    scenes: int
    planned: int
    refusals: int
    rows: int
    false_rows: int
    false_scenes: int
    rate: float
    agreeing_scenes: float
    unresolved_rows: float


@dataclass(frozen=True)
class BarRow:
    """Error bars of one kind of row.

    Attributes
    ----------
    group, kind : str
    rows : int, that are held against a bar
    without : int, that have none, or an obstacle
    covered : part of the rows that lie within their bar
    within_half : part that lies within half of it
    bar : median bar over what is compared; nan of what has no value of its own
    """

    group: str
    kind: str
    rows: int
    without: int
    covered: float
    within_half: float
    bar: float


@dataclass(frozen=True)
class PowerRow:
    """How often one mistake of a prediction is caught.

    Attributes
    ----------
    spoil, what : str, the mistake
    scenes : int, in which it can be made
    beyond : int, of these, its effect is beyond what counts as a difference, in any row
    caught_beyond : part of those that is caught; nan if there are none
    sure, caught_sure : the same of effects that no error within the bar can hide
    caught : part of all scenes
    least : size that is caught in half of the scenes; nan where it has no size, or eight times the
        usual one is caught in fewer
    unit : str, of the size
    """

    spoil: str
    what: str
    scenes: int
    beyond: int
    caught_beyond: float
    sure: int
    caught_sure: float
    caught: float
    least: float
    unit: str


def alarm_rows(rows: Sequence[JudgedRow]) -> list[AlarmRow]:
    """One row a group, and one of all."""
    groups = [_alarms(group, _part(rows, group)) for group in _groups(rows)]
    return [*groups, _alarms(ALL, rows)]


def _alarms(group: str, rows: Sequence[JudgedRow]) -> AlarmRow:
    scenes = {(row.group, row.index): row for row in rows}
    verdicts = Counter(row.verdict for row in rows)
    judgements = Counter(row.judgement for row in scenes.values())
    return AlarmRow(
        group=group,
        scenes=len(scenes),
        planned=sum(COUNTS.values()) if group == ALL else COUNTS[group],
        refusals=sum(row.refusals for row in scenes.values()),
        rows=len(rows),
        false_rows=verdicts[DIFFERS],
        false_scenes=judgements[DIFFERS],
        rate=upper_limit(judgements[DIFFERS], len(scenes)),
        agreeing_scenes=judgements[AGREES] / len(scenes),
        unresolved_rows=verdicts[UNRESOLVED] / len(rows),
    )


def upper_limit(count: int, trials: int) -> float:
    """Largest rate at which so few of the trials, or fewer, come about in one case out of twenty
    (Clopper and Pearson)."""
    if count >= trials:
        return 1.0
    return float(scipy.stats.beta.ppf(CONFIDENCE, count + 1, trials - count))


def bar_rows(rows: Sequence[JudgedRow]) -> list[BarRow]:
    """One row a group and kind."""
    return [
        _bars(group, kind, [row for row in _part(rows, group) if row.kind == kind])
        for group in _groups(rows)
        for kind in dict.fromkeys(row.kind for row in _part(rows, group))
    ]


def _bars(group: str, kind: str, rows: Sequence[JudgedRow]) -> BarRow:
    barred = [row for row in rows if row.tells]
    ratios = np.array([row.over_bar for row in barred])
    shares = [row.share for row in barred if math.isfinite(row.share)]
    return BarRow(
        group=group,
        kind=kind,
        rows=len(barred),
        without=len(rows) - len(barred),
        covered=float(np.mean(ratios <= 1)) if barred else math.nan,
        within_half=float(np.mean(ratios <= 0.5)) if barred else math.nan,
        bar=float(np.median(shares)) if shares else math.nan,
    )


def power_rows(rows: Sequence[SpoiltRow]) -> list[PowerRow]:
    """One row a mistake; scenes in which the right answer is said to differ are left out."""
    false = {row.scene for row in rows if row.spoil == TRUTH and row.verdict == DIFFERS}
    sound = [row for row in rows if row.scene not in false]
    return [
        _power(spoil, [row for row in sound if row.spoil == spoil.name])
        for spoil in SPOILS
        if any(row.spoil == spoil.name for row in sound)
    ]


@dataclass(frozen=True)
class FaultRow:
    """How often one fault of a simulation is caught.

    Attributes
    ----------
    fault, what : str
    scenes : int, in which it changes anything
    caught : part of those in which the simulation differs, or is refused
    beyond, caught_beyond : int, of these it is beyond what counts as a difference, in any row, and
        part of those that is caught; nan if there are none
    """

    fault: str
    what: str
    scenes: int
    caught: float
    beyond: int
    caught_beyond: float


def fault_rows(rows: Sequence[SpoiltRow]) -> list[FaultRow]:
    """One row a fault."""
    found = []
    for fault in FAULTS:
        some = [row for row in rows if row.spoil == fault.name]
        beyond = [row for row in some if row.over_bar > CATCHABLE]
        facts = (len(some), _part_caught(some), len(beyond), _part_caught(beyond))
        found += [FaultRow(fault.name, fault.what, *facts)] if some else []
    return found


def strength_rows(rows: Sequence[SpoiltRow]) -> list[StrengthRow]:
    """How many mistakes of a strength are caught, over all mistakes and sizes."""
    names = {spoil.name for spoil in SPOILS} | {fault.name for fault in FAULTS}
    tried = [row for row in rows if row.spoil in names]
    found = []
    for low, high in pairwise(STRENGTHS):
        some = [row for row in tried if low < row.over_bar <= high]
        found.append(StrengthRow(low, high, len(some), _part_caught(some)))
    return found


@dataclass(frozen=True)
class StrengthRow:
    """Mistakes by how far they move a row, over its bar, where that is most.

    Attributes
    ----------
    above, up_to : float, over the bar
    tried : int, mistakes of all kinds and sizes, in all scenes
    caught : part of them; nan if there are none
    """

    above: float
    up_to: float
    tried: int
    caught: float


def _power(spoil: Spoil, rows: Sequence[SpoiltRow]) -> PowerRow:
    size = abs(spoil.size) * (100 if spoil.unit == "%" else 1)
    least = float(np.quantile(least_shares(rows), 0.5, method="higher"))
    usual = [row for row in rows if row.share == 1]
    beyond, sure = ([row for row in usual if row.over_bar > bars] for bars in (CATCHABLE, SURE))
    return PowerRow(
        spoil=spoil.name,
        what=spoil.what,
        scenes=len(usual),
        beyond=len(beyond),
        caught_beyond=_part_caught(beyond),
        sure=len(sure),
        caught_sure=_part_caught(sure),
        caught=_part_caught(usual),
        least=least * size if size and math.isfinite(least) else math.nan,
        unit=spoil.unit,
    )


def _part_caught(rows: Sequence[SpoiltRow]) -> float:
    caught = [row.verdict in (DIFFERS, REFUSED) for row in rows]
    return float(np.mean(caught)) if caught else math.nan


def least_shares(rows: Sequence[SpoiltRow]) -> list[float]:
    """Least share of one mistake that is caught, scene by scene; inf where none is."""
    least = dict.fromkeys((row.scene for row in rows), math.inf)
    for row in rows:
        if row.verdict == DIFFERS:
            least[row.scene] = min(least[row.scene], row.share)
    return list(least.values())


def _groups(rows: Sequence[JudgedRow]) -> list[str]:
    return [group for group in COUNTS if any(row.group == group for row in rows)]


def _part(rows: Sequence[JudgedRow], group: str) -> list[JudgedRow]:
    return [row for row in rows if row.group == group]
