"""Unknowns of a fit: parameters of a scene, and of the set-up that recorded it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

from semianalytic.inversion.gauges import Gauge
from semianalytic.parameters.numbers import numbers_of, spelled, with_numbers
from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import GRAZING, OF_FRONT, IncidentWave, MovingLoad
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.derivatives.parameters import PARAMETERS, parameter

MATERIAL = ("shear_modulus", "density")
"""Parameters of the scene that by similarity change nothing but units."""
SOLVED = (*PARAMETERS, *MATERIAL)
"""All parameters of the scene: another value needs another solution."""
SETUP = ("t0", "x0", "gain")
"""Parameters of the set-up; "gain:NAME" is the gain of one gauge."""
_LONE_GAIN = "gain:"


@checking_methods
@dataclass(frozen=True)
class Setup:
    """The set-up of gauges: how the times, positions and amplitudes of records relate to the scene.

    Attributes
    ----------
    t0 : float
        Time, on the clock of the records, at which the load begins to act [time]; positive if the
        trigger came early.
    x0 : float
        Position of the contact edge in the coordinates of the gauges [length].
    gain : float
        Factor by which all records are too large.
    gains : mapping
        Further factors for single gauges, by name; a record is multiplied by both.

    Examples
    --------
    >>> from semianalytic import Gauge, Setup
    >>> gauge = Gauge(x=0.2, t=[1.0], values=[0.1], noise=0.01, quantity="slip", name="A")
    >>> Setup(gain=2.0, gains={"A": 1.5}).gain_of(gauge)
    3.0
    """

    t0: float = 0.0
    x0: float = 0.0
    gain: float = 1.0
    gains: Mapping[str, float] = field(default_factory=dict)

    def gain_of(self, gauge: Gauge) -> float:
        """Return the factor by which the record of a gauge is too large."""
        return self.gain * self.gains.get(gauge.name, 1.0)


@dataclass(frozen=True)
class Unknowns:
    """The unknowns of a fit, a scene and set-up that hold the others, and records' duration."""

    names: tuple[str, ...]
    scene: Scene
    setup: Setup
    duration: float
    _made: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False, repr=False)

    def value(self, name: str) -> float:
        """Return the value at which the search begins."""
        if name in SOLVED:
            return parameter(self.scene, name)
        if name in SETUP:
            return float(getattr(self.setup, name))
        return self.setup.gains.get(name.removeprefix(_LONE_GAIN), 1.0)

    def at(self, values: Sequence[float]) -> tuple[Any, Setup]:
        """Return scene and set-up with these values; errors are those of `Scene`."""
        given = dict(zip(self.names, map(float, values), strict=True))
        of_setup = {name: given.pop(name) for name in self.names if is_of_setup(name)}
        key = tuple(given.items())
        scene = self._made.get(key)
        if scene is None:
            # all at once, for pressure and shear changed in turn might pass a base that slides
            scene = with_numbers(self.scene, given)
            self._made.clear()  # trials of the set-up alone, one after another, share the last
            self._made[key] = scene
        setup = self.setup
        for name, value in of_setup.items():
            changed: Any = {name: value}
            if name not in SETUP:
                changed = {"gains": {**setup.gains, name.removeprefix(_LONE_GAIN): value}}
            setup = replace(setup, **changed)
        return scene, setup

    def alone(self, name: str, scene: Any, setup: Setup) -> Self:
        """Return one of the unknowns, with another scene and set-up that hold all others."""
        return replace(self, names=(name,), scene=scene, setup=setup)

    def size(self, name: str) -> float:
        """Return the size by which an unknown is divided: its value, or one that would matter."""
        # A value of 0 has no size of its own: `_least` is a change that would be seen in records.
        return max(abs(self.value(name)), self._least(name))

    def _least(self, name: str) -> float:
        scene = self.scene
        if name in ("friction", "poisson_ratio"):
            return 0.1
        if name == "viscosity":
            return 0.1 * scene.material.shear_impedance
        if name == "t0":
            return 0.1 * self.duration
        if name == "x0":
            return 0.1 * self.duration * scene.material.shear_speed
        if name == "angle":
            return 5.0
        if name == "wave_velocity":
            return 0.1 * self._stress / scene.material.shear_impedance
        if name == "load_speed":
            return 0.1 * scene.material.shear_speed
        return 0.1 * self._stress if name in PARAMETERS else 0.0

    @property
    def _stress(self) -> float:
        """The largest traction of the scene [stress]."""
        parts = (self.scene.base, self.scene.superposition.taken_off)
        return max(abs(value) for part in parts for value in (part.pressure, part.shear)) or 1.0

    def bounds(self, name: str) -> tuple[float, float]:
        """Return the least and largest admissible value of an unknown."""
        if name == "poisson_ratio":
            # Near -1 and 0.5 solutions lose digits, long before they are refused.
            return -0.95, 0.499
        if name in ("friction", "base_pressure", "viscosity"):
            return 0.0, float("inf")
        if name == "angle":
            return -GRAZING, GRAZING
        if name == "load_speed":  # no front of no speed lies between
            least = 1e-3 * self.scene.material.shear_speed
            return (least, float("inf")) if self.value(name) >= 0 else (float("-inf"), -least)
        if name in MATERIAL or name.startswith("gain"):
            # Zero would make no solid and no record; a thousandth of the guess is below anything
            # plausible.
            return 1e-3 * self.size(name), float("inf")
        return float("-inf"), float("inf")

    def plausible(self, name: str) -> tuple[float, float]:
        """Return the range that a search without a prior considers."""
        value = self.value(name)
        if name == "friction":
            # From well lubricated to rough rock, and beyond the guess if that is larger.
            return 0.02, max(1.2, 1.5 * value)
        if name == "poisson_ratio":
            # Auxetic solids are looked for only where the guess is one.
            return (0.02, 0.48) if value >= 0 else (-0.9, 0.48)
        if name == "viscosity":
            return 0.0, 4 * self.size(name)
        if name in MATERIAL:
            return 0.6 * value, 1.6 * value
        if name == "angle":
            return max(value - 25.0, -80.0), min(value + 25.0, 80.0)
        if name.startswith("gain"):
            return 0.5 * value, 2 * value
        if name in SETUP:
            return value - 2 * self._least(name), value + 2 * self._least(name)
        if not value:
            return (0.0 if name == "base_pressure" else -self._stress), self._stress
        # Sorted, for a negative traction turns the two around.
        low, high = sorted((value / 3, 2.5 * value))
        return low, high


def _of_front(scene: Scene) -> tuple[str, ...]:
    """Return the numbers of an incident wave or moving load of a scene, besides tractions."""
    if isinstance(scene.load, IncidentWave):
        return "angle", "wave_stress" if scene.load.velocity is None else "wave_velocity"
    return ("load_speed",) if isinstance(scene.load, MovingLoad) else ()


def has_similarity(scene: Scene) -> bool:
    """Return whether modulus and density enter through units only, and through no friction law.

    The velocity of a wave and the speed of a moving load are in units of the solid too.
    """
    if isinstance(scene.load, MovingLoad) or getattr(scene.load, "velocity", None) is not None:
        return False
    return isinstance(scene.friction, float)


def is_of_setup(name: object) -> bool:
    """Return whether a name is that of a parameter of the set-up, which needs no new solution."""
    return str(name) in SETUP or _is_lone_gain(name)


def _is_lone_gain(name: object) -> bool:
    """Return whether a name is that of the gain of one gauge."""
    return isinstance(name, str) and name.startswith(_LONE_GAIN)


def is_fitted_on_line(scene: Scene) -> bool:
    """Return whether trials of a scene are marches along a line: where no exact answer is known."""
    return bool(scene.on_line) or (scene.kind == "Scene" and not scene.is_self_similar)


def plain_name(given: object) -> str:
    """Return a name with underscores, but for names of the set-up, which hold those of gauges."""
    return str(given) if is_of_setup(given) else spelled(str(given))


def number_name(scene: Scene, given: object) -> str:
    """Return the name of a parameter that is spelled as in TOML, dotted, or with underscores.

    Raises SceneError if the scene has no such number, and the set-up neither.
    """
    known = tuple(numbers_of(scene)) if is_fitted_on_line(scene) else SOLVED
    name = plain_name(given)
    if name not in known and not is_of_setup(name):
        raise SceneError(
            f"fit: parameters must be among {', '.join((*known, *SETUP))} and gain:NAME, got "
            f"{shown(given)}."
        )
    return name


def check_names(names: tuple[str, ...], gauges: tuple[Gauge, ...]) -> None:
    """Raise SceneError unless there are names, each of them once, and gains of gauges."""
    if not names or len(set(names)) < len(names):
        raise SceneError("fit: name at least one parameter, and each one once.")
    called = {gauge.name for gauge in gauges} - {""}
    for name in names:
        if _is_lone_gain(name) and name.removeprefix(_LONE_GAIN) not in called:
            known = ", ".join(sorted(called)) or "none of them has a name"
            raise SceneError(f"fit: {shown(name)} belongs to no gauge; their names: {known}.")


def check_exact(names: tuple[str, ...], scene: Scene) -> None:
    """Raise SceneError for names that a scene with an exact answer does not have."""
    for name in names:
        if name in OF_FRONT and name not in _of_front(scene):
            known = ", ".join(_of_front(scene)) or "none"
            raise SceneError(
                f"fit: the load of the scene has no {name}; of {', '.join(OF_FRONT)} it has "
                f"{known}."
            )
    if isinstance(scene.load, IncidentWave) and {"load_pressure", "load_shear"} & set(names):
        raise SceneError(
            f"fit: the load is an incident wave; fit {' and '.join(_of_front(scene))}."
        )
    if "viscosity" in names and not parameter(scene, "viscosity"):
        raise SceneError("fit: viscosity needs a scene with friction of a positive viscosity.")
