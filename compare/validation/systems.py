"""Systems of units that the numbers of a file may be in: one length, one time, one stress."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from semianalytic import Scene
from semianalytic.scene.units import SI

NAMES: Mapping[str, Mapping[float, str]] = {
    "length": {1.0: "m", 1e3: "km", 1e-2: "cm", 1e-3: "mm", 1e-6: "µm"},
    "time": {1.0: "s", 1e-3: "ms", 1e-6: "µs"},
    "stress": {1.0: "Pa", 1e3: "kPa", 1e6: "MPa", 1e9: "GPa"},
}
"""Units that codes and laboratories use without saying so, by their size in that of the SI."""
APART = 1.9
"""Factor by which one unit at least has to be another than that of the scene to be inferred.

Units above are ten or more apart; tractions that numbers may be over can be any.  What an answer
may be wrong by, a tenth or a half, is then never taken for another unit: with 1.1 an answer wrong
by a tenth throughout would be, with 4 some right numbers over a load of 3 are not read."""
_SAME = 1e-9


@dataclass(frozen=True)
class System:
    """Units of one file.

    Attributes
    ----------
    length, time, motion, stress : float
        Units of positions, of times, of slip, and of tractions, in those of the scene; slip rate is
        in the unit of slip over that of time.
    words : str
        What they are; "" for those of the scene.
    """

    length: float = 1.0
    time: float = 1.0
    motion: float = 1.0
    stress: float = 1.0
    words: str = ""

    @property
    def sizes(self) -> dict[str, float]:
        """Factors of the columns."""
        return {
            "x": self.length,
            "t": self.time,
            "slip": self.motion,
            "slip_rate": self.motion / self.time,
            "shear_traction": self.stress,
            "pressure": self.stress,
        }

    @property
    def changes(self) -> int:
        """How many of the units are not those of the scene: of two alike the plainer is taken."""
        return sum(
            not math.isclose(size, 1.0, rel_tol=_SAME)
            for size in (self.length, self.time, self.motion, self.stress)
        )


def systems(scene: Scene) -> Iterator[System]:
    """All systems that are tried on the numbers of a file, that of the scene first.

    Slip may be in a finer unit than positions, as µm beside mm; it is never in one and slip rate in
    another.
    """
    lengths, times, stresses = (NAMES[name] for name in ("length", "time", "stress"))
    for length, time, motion, stress in itertools.product(lengths, times, lengths, stresses):
        if motion <= length:
            yield System(length, time, motion, stress, _words(scene, length, time, motion, stress))
    yield from _without_dimension(scene)


def _words(scene: Scene, length: float, time: float, motion: float, stress: float) -> str:
    """The units that are not those of the scene, in words."""
    parts = []
    for what, kind, size in (
        ("positions", "length", length),
        ("times", "time", time),
        ("slip", "length", motion),
        ("tractions", "stress", stress),
    ):
        if size != 1.0:
            name = NAMES[kind][size] if scene.units == SI else f"{size:g} of the scene's unit"
            parts.append(f"{what} in {name}")
    return ", ".join(parts)


def _without_dimension(scene: Scene) -> Iterator[System]:
    """Systems in which density and c_t are 1, and tractions are over one of the scene's.

    Times are as they are: a self-similar answer is the same over any, and another one has to be
    told how long its loads last.
    """
    material = scene.material
    speed, modulus = material.shear_speed, material.shear_modulus
    for stress, words in _references(scene):
        system = System(speed, 1.0, stress / modulus * speed, stress, words)
        if any(_is_apart(size) for size in (system.length, system.motion, system.stress)):
            yield system


def _references(scene: Scene) -> Iterator[tuple[float, str]]:
    """Stresses that numbers without dimension may be over."""
    seen: set[float] = set()
    for part, words in ((scene.superposition.taken_off, "load"), (scene.base, "base")):
        for name in ("shear", "pressure"):
            size = abs(getattr(part, name))
            if size and size not in seen:
                seen.add(size)
                yield (
                    size,
                    f"no dimension: tractions over the {name} of the {words}, lengths over c_t",
                )
    modulus = scene.material.shear_modulus
    if modulus not in seen:
        yield modulus, "no dimension: tractions over the shear modulus, lengths over c_t"


def _is_apart(size: float) -> bool:
    """Whether a unit is clearly another than that of the scene."""
    return abs(math.log(size)) >= math.log(APART)
