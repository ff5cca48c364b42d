"""What the trials of the judge come to: false alarms, error bars, power."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from compare.comparison.rows import ALARM, DIFFERS, UNRESOLVED
from docs.studies.judge.spoils import SPOILS, Spoil
from docs.studies.judge.trials import COUNTS, TRUTH, JudgedRow, SpoiltRow

SURE = ALARM + 1
"""Bars from which on a mistake shows whatever the simulation errs within its bar."""


@dataclass(frozen=True)
class AlarmRow:
    """Judgements of right answers to a group of scenes.

    Attributes
    ----------
    group : str, "steps", "histories" or "openings"
    scenes : int
    refusals : int, draws that have no answer, or open the contact
    rows : int
    false_rows, false_scenes : parts of them said to differ
    unresolved_rows : part of the rows
    """

    group: str
    scenes: int
    refusals: int
    rows: int
    false_rows: float
    false_scenes: float
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
    """What becomes of one mistake.

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
    """One row a group."""
    return [_alarms(group, _part(rows, group)) for group in _groups(rows)]


def _alarms(group: str, rows: Sequence[JudgedRow]) -> AlarmRow:
    refusals = {row.index: row.refusals for row in rows}
    verdicts = Counter(row.verdict for row in rows)
    alarmed = {row.index for row in rows if row.verdict == DIFFERS}
    return AlarmRow(
        group=group,
        scenes=len(refusals),
        refusals=sum(refusals.values()),
        rows=len(rows),
        false_rows=verdicts[DIFFERS] / len(rows),
        false_scenes=len(alarmed) / len(refusals),
        unresolved_rows=verdicts[UNRESOLVED] / len(rows),
    )


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


def _power(spoil: Spoil, rows: Sequence[SpoiltRow]) -> PowerRow:
    size = abs(spoil.size) * (100 if spoil.unit == "%" else 1)
    least = float(np.quantile(least_shares(rows), 0.5, method="higher"))
    usual = [row for row in rows if row.share == 1]
    beyond, sure = ([row for row in usual if row.over_bar > bars] for bars in (ALARM, SURE))
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
    return float(np.mean([row.verdict == DIFFERS for row in rows])) if rows else math.nan


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
