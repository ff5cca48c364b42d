"""What may be said of a file beforehand, so that nothing has to be guessed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import SceneError

SLIPS = ("relative", "half", "face")
"""What is recorded of slip: both faces, half of it, or how one face moves."""
SIGNS = ("as-given", "reversed")
PRESSURES = ("compression", "tension")
UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "stress": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
}
"""Units that have names, in those of the SI."""
SCALED: Mapping[str, tuple[float, float, float]] = {
    "x": (1, 0, 0),
    "t": (0, 1, 0),
    "slip": (1, 0, 0),
    "slip_rate": (1, -1, 0),
    "shear_traction": (0, 0, 1),
    "pressure": (0, 0, 1),
}
"""Powers of length, time and stress in what is recorded."""


@dataclass(frozen=True)
class Conventions:
    """What is known of a file.  Whatever is left out is taken as given, or detected and said.

    Parameters
    ----------
    scale : mapping from str to float
        What numbers of the file are multiplied by to be in units of the scene: "length", "time",
        "stress", or single quantities, "x", "t", "slip", "slip_rate", "shear_traction",
        "pressure".
    sign : str or None
        Of slip, slip rate and shear traction: "as-given" or "reversed".
    slip : str or None
        "relative", "half", or "face": the motion of one face.
    pressure : str or None
        Which is positive, "compression" or "tension".
    time_shift : float
        To be added to the times, in units of the scene.
    rate_from_slip : bool
        Whether a slip rate is made of differences of slip where a file has none.
    threshold : float or None
        Slip rate at which slip counts as begun [length / time]; a hundredth of
        the largest load over rho c_t unless given.

    Raises
    ------
    SceneError
        If a word or a name is unknown, or a scale is not positive.
    """

    scale: Mapping[str, float] = field(default_factory=dict)
    sign: str | None = None
    slip: str | None = None
    pressure: str | None = None
    time_shift: float = 0.0
    rate_from_slip: bool = False
    threshold: float | None = None

    def __post_init__(self) -> None:
        for name, words in (("sign", SIGNS), ("slip", SLIPS), ("pressure", PRESSURES)):
            value = getattr(self, name)
            if value is not None and value not in words:
                raise SceneError(
                    f"validate: {name} must be one of {', '.join(words)}, got {shown(value)}."
                )
        for name, value in self.scale.items():
            if name not in ("length", "time", "stress", *SCALED):
                raise SceneError(
                    f"validate: there is nothing called {shown(name)} to scale; it takes length, "
                    f"time, stress, {', '.join(SCALED)}."
                )
            checked_size(f"validate: scale of {name}", value)
        checked_number("validate: time_shift", self.time_shift)
        if self.threshold is not None:
            checked_size("validate: threshold", self.threshold)

    def factors(self) -> dict[str, float]:
        """What each of `SCALED` is multiplied by, by the scales given."""
        sizes = [self.scale.get(name, 1.0) for name in ("length", "time", "stress")]
        return {
            name: self.scale.get(name, _product(sizes, powers)) for name, powers in SCALED.items()
        }


def named_scale(kind: str, name: str) -> float:
    """A unit of length, time or stress in that of the SI.

    Raises
    ------
    SceneError
        If it has no such name.
    """
    if name not in UNITS[kind]:
        raise SceneError(f"{kind}_unit must be one of {', '.join(UNITS[kind])}, got {shown(name)}.")
    return UNITS[kind][name]


def _product(sizes: list[float], powers: tuple[float, float, float]) -> float:
    result = 1.0
    for size, power in zip(sizes, powers, strict=True):
        result *= size**power
    return result
