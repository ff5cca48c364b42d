"""Readings of a file weighed against each other: what each leaves of all quantities together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from compare.records.record import QUANTITIES, Records
from compare.validation.conventions import Conventions
from compare.validation.exact import Exact
from compare.validation.norms import weights
from compare.validation.readings import (
    MOTION,
    TRACTIONS,
    Choice,
    Reading,
    base_of,
    chosen_reading,
)
from compare.validation.systems import systems
from semianalytic import Scene
from semianalytic.scene.errors import SceneError

LITTLE = 0.25
"""Relative error of a quantity above which a reading does not explain it.

Right runs of UGUCA and SEM2DPACK on 40 to 200 cells leave up to 0.16, and readings are a factor of
`systems.APART` or more apart, which leaves 0.47 at least.  With half of it coarse runs in other
units are not read; with twice of it a factor of two passes."""
TELLING = 1e-5
"""Mean of a quantity over its unit below which it says nothing of units; with half or twice of it
every tenth file of the trial is read as it is."""
HAPPENS = 0.01
"""Mean change of a quantity over its unit that is seen to happen; with half or twice of it every
tenth file of the trial is read as it is."""
NEAREST, FARTHEST = 0.02, 1.0
"""Range of the outermost station, over c_l T, in which units are inferred."""
MOST_MARCHES = 6
"""Units of positions and times that are tried where the answer has to be marched for each."""


@dataclass(frozen=True)
class Left:
    """Errors of the quantities that a reading leaves unexplained.

    Attributes
    ----------
    largest : float
        The largest relative error of one; infinite where nothing can be compared.
    unexplained : int
        How many are off by more than `LITTLE`.
    together : float
        Sum of the errors; of what is not explained, `LITTLE` and how many powers of ten its size is
        off, whatever its sense.
    """

    largest: float
    unexplained: int
    together: float


@dataclass(frozen=True)
class Weighed:
    """A choice, what it makes of the numbers, and what it leaves of them."""

    choice: Choice
    reading: Reading
    left: Left

    @property
    def rank(self) -> tuple[int, float, int]:
        """Key by which readings are ordered: of those that fit alike the plainest comes first."""
        return self.left.unexplained, round(self.left.together, 6), self.choice.count


class Residuals:
    """Errors that readings leave of each quantity, for one choice of positions and times.

    Parameters
    ----------
    sample : Records
        Stations and times that are looked at, in units of the file.
    exact : Exact
        Until the end of the records as they are read.
    reading : Reading
        That says where and when they are.
    """

    def __init__(self, sample: Records, exact: Exact, reading: Reading) -> None:
        self.exact = exact
        self._columns: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self._known: dict[tuple[str, float, float], float] = {}
        for name in QUANTITIES:
            parts = list(self._parts(sample, name, reading))
            if parts:
                values, weight, expected = map(np.concatenate, zip(*parts, strict=True))
                self._columns[name] = values, weight, expected

    def _parts(
        self, sample: Records, name: str, reading: Reading
    ) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Numbers of the file, weights and exact values at each station that waves may reach."""
        for record in sample.stations:
            values = record.values.get(name)
            x, t = reading.place(record), reading.times(record)
            if values is None or x > self.exact.scene.material.longitudinal_speed * t[-1]:
                continue
            weight = weights(t, values)
            if weight.any():
                expected = self.exact.record(name, x, t)
                yield np.where(weight > 0, values, 0.0), weight, expected

    def tells(self, name: str, base: float = 0.0) -> bool:
        """Whether the answer has something to say of a quantity, besides its base."""
        if name not in self._columns:
            return False
        _, weight, expected = self._columns[name]
        size = float(weight @ np.abs(expected - base))
        return size > TELLING * self.exact.unit(name) * float(weight.sum())

    def left(self, name: str, factor: float, base: float = 0.0) -> float:
        """Relative error of a quantity, of what the file would hold of it without a base.

        Where that is nothing, over the quantity with its base, or over its unit.
        """
        key = (name, factor, base)
        if key not in self._known:
            values, weight, expected = self._columns[name]
            wrong = float(weight @ np.abs(factor * values + base - expected))
            size = float(weight @ np.abs(expected - base))
            if not self.tells(name, base):
                unit = self.exact.unit(name) * float(weight.sum())
                size = max(float(weight @ np.abs(expected)), unit)
            self._known[key] = wrong / size
        return self._known[key]

    def of(self, reading: Reading) -> Left:
        """Errors that a reading leaves unexplained."""
        parts = {
            name: self.left(name, reading.factor(name), reading.offset(name))
            for name in self._columns
        }
        return Left(
            max(parts.values(), default=np.inf),
            sum(part >= LITTLE for part in parts.values()),
            sum(
                part if part < LITTLE else LITTLE + self._decades(name, reading)
                for name, part in parts.items()
            ),
        )

    def _decades(self, name: str, reading: Reading) -> float:
        """How many powers of ten a quantity is too large or too small."""
        values, weight, expected = self._columns[name]
        read = reading.factor(name) * values + reading.offset(name)
        seen, true = (float(weight @ np.abs(one)) for one in (read, expected))
        return abs(math.log10(seen / true)) if seen > 0 and true > 0 else 0.0

    def admits(self, choice: Choice, reading: Reading) -> bool:
        """Whether the records may speak for a choice at all.

        Slip is in the unit of positions, and whole, where the answer does not slip.  Tractions are
        changes only if one that has a base is seen to change, and not to begin with its base.
        """
        system = choice.system
        moves = any(self.tells(name) for name in MOTION)
        if not moves and (choice.half or system.motion != system.length):
            return False
        return not choice.changes or any(self._is_change(name, reading) for name in TRACTIONS)

    def _is_change(self, name: str, reading: Reading) -> bool:
        """Whether a traction is seen to be a change since t = 0, and not to be all of it."""
        base, factor = base_of(self.exact.scene, name), reading.factor(name)
        if name not in self._columns or not base or not self.tells(name, base):
            return False
        return self.left(name, factor, base) < LITTLE < self.left(name, factor)


@dataclass(eq=False)
class Ranking:
    """All readings of a run that neither the file nor conventions rule out.

    Attributes
    ----------
    run, sample : Records
        As the file has them: all, and what readings are tried on.
    scene : Scene
    given : Reading
        By the file and conventions.
    conventions : Conventions
    answer : callable
        The answer for a run in units of the scene; raises a SceneError where there is none.
    """

    run: Records
    sample: Records
    scene: Scene
    given: Reading
    conventions: Conventions
    answer: Callable[[Records], Exact]

    def __post_init__(self) -> None:
        self._placed: dict[tuple[float, float], Residuals | None] = {}
        self._marches = 0

    def ranked(self) -> list[Weighed]:
        """All readings, the best first; of those that fit alike the one nearest to as given."""
        weighed = []
        for choice in self._choices():
            reading = chosen_reading(
                choice, self.given, self.conventions, self.run.stated, self.scene
            )
            here = self.residuals(reading)
            if here is not None and here.admits(choice, reading):
                weighed.append(Weighed(choice, reading, here.of(reading)))
        return sorted(weighed, key=lambda one: one.rank)

    def residuals(self, reading: Reading) -> Residuals | None:
        """Residuals for the positions and times of a reading; None where nothing happens there."""
        key = reading.factor("x"), reading.factor("t")
        if key not in self._placed:
            exact = self._exact(reading)
            self._placed[key] = None if exact is None else Residuals(self.sample, exact, reading)
        return self._placed[key]

    def _exact(self, reading: Reading) -> Exact | None:
        read = reading.apply(self.run)
        end = max((float(record.t[-1]) for record in read.stations if len(record.t)), default=0.0)
        farthest = self.scene.material.longitudinal_speed * end
        places = [reading.place(record) for record in self.sample.stations]
        if not places or end <= 0 or not NEAREST * farthest <= max(places) <= FARTHEST * farthest:
            return None
        if not self.scene.is_self_similar:
            self._marches += 1
            if self._marches > MOST_MARCHES:
                return None
        try:
            exact = self.answer(read)
        except SceneError:  # a march that long, or that short, does not follow the loads
            return None
        return exact if self._happens(exact, reading) else None

    def _happens(self, exact: Exact, reading: Reading) -> bool:
        """Whether anything is seen to happen at the stations: before it any unit would do."""
        for record in self.sample.stations:
            x, t = reading.place(record), reading.times(record)
            for name in record.values:
                base = base_of(exact.scene, name)
                change = np.abs(exact.record(name, x, t) - base)
                if change.mean() > HAPPENS * exact.unit(name):
                    return True
        return False

    def _choices(self) -> Iterator[Choice]:
        """All choices among what neither the file nor conventions settle, each once."""
        stated, said = self.run.stated, self.conventions
        names = {name for record in self.run.stations for name in record.values}
        free = (
            said.slip is None and not stated.faces and bool(names & set(MOTION)),
            said.sign is None,
            said.pressure is None and "pressure" in names,
            said.tractions is None and not stated.changes and bool(names & set(TRACTIONS)),
        )
        seen: set[tuple[float, ...]] = set()
        for system in systems(self.scene):
            used = [name for name in system.sizes if name in ("x", "t") or name in names]
            key = tuple(1.0 if said.settles(n, stated) else system.sizes[n] for n in used)
            if key in seen:
                continue
            seen.add(key)
            for flags in itertools.product(*((False, True) if one else (False,) for one in free)):
                yield Choice(system, *flags)


def differ(one: Reading, other: Reading, names: tuple[str, ...], residuals: Residuals) -> bool:
    """Whether two readings differ in anything that the answer has something to say of.

    A self-similar answer is the same where lengths and times are multiplied by one number.
    """
    common = 1.0
    if residuals.exact.scene.is_self_similar:
        common = other.factor("t") / one.factor("t")
    for name in ("x", "t", *names):
        if name in names and not residuals.tells(name, one.offset(name)):
            continue
        expected = one.factor(name) * (common if name in ("x", "t", "slip") else 1.0)
        alike = math.isclose(other.factor(name), expected, rel_tol=1e-9)
        if not alike or (name in names and other.offset(name) != one.offset(name)):
            return True
    return False
