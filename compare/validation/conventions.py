"""Units and conventions of a file that are given beforehand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from compare.records.record import QUANTITIES, Stated
from semianalytic.scene.checks import checked_number, checked_size, checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.tables.units import DIMENSIONS

BASIC = ("length", "time", "stress")
WORDS: Mapping[str, tuple[str, ...]] = {
    "sign": ("as-given", "reversed"),
    "slip": ("relative", "half", "face"),  # half of relative slip, or the motion of one face
    "pressure": ("compression", "tension"),
    "tractions": ("total", "changes"),  # those since t = 0
    "rate": ("point", "before", "after"),  # at its time, or the mean over the step next to it
}
"""Words that each convention takes."""


@dataclass(frozen=True)
class Conventions:
    """Known units and conventions of a file.

    Units that neither the file nor a scale states are those of the scene.  Conventions that neither
    states are as given, or the only ones that explain the records, which is then reported.

    Parameters
    ----------
    scale : mapping from str to float
        Factors from numbers of the file to units of the scene, by name: "length", "time",
        "stress", or single quantities, "x", "t", "slip", "slip_rate", "shear_traction",
        "pressure", which may be negative where a sense is the other one.
    sign : str or None
        Sense of slip, slip rate and shear traction together: "as-given" or "reversed".
    slip : str or None
        "relative", "half", or "face": the motion of one face.
    pressure : str or None
        Which is positive, "compression" or "tension".
    tractions : str or None
        "total", or "changes": those since t = 0, without the base.
    rate : str or None
        Meaning of a slip rate: that at its time, "point", or the mean over the step "before" or
        "after" it.
    noise : mapping from str to float
        Standard deviation of the errors of samples by quantity, in units of the file.
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
        If a word or a name is unknown, or a scale or noise is no such number.
    """

    scale: Mapping[str, float] = field(default_factory=dict)
    sign: str | None = None
    slip: str | None = None
    pressure: str | None = None
    tractions: str | None = None
    rate: str | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    time_shift: float = 0.0
    rate_from_slip: bool = False
    threshold: float | None = None

    def __post_init__(self) -> None:
        for name, words in WORDS.items():
            if (value := getattr(self, name)) is not None:
                checked_word(f"validate: {name}", value, words)
        for what, named in (("scale", self.scale), ("noise", self.noise)):
            if not isinstance(named, Mapping):
                raise SceneError(f"validate: {what} must be a mapping, got {shown(named)}.")
        for name, value in self.scale.items():
            if name not in (*BASIC, *DIMENSIONS):
                raise SceneError(
                    f"validate: there is nothing called {shown(name)} to scale; it takes length, "
                    f"time, stress, {', '.join(DIMENSIONS)}."
                )
            size = abs(value) if name in QUANTITIES and isinstance(value, float) else value
            checked_size(f"validate: scale of {name}", size)
        for name, value in self.noise.items():
            if name not in QUANTITIES:
                raise SceneError(
                    f"validate: there is no noise of {shown(name)}; it takes "
                    f"{', '.join(QUANTITIES)}."
                )
            checked_size(f"validate: noise of {name}", value)
        checked_number("validate: time_shift", self.time_shift)
        if self.threshold is not None:
            checked_size("validate: threshold", self.threshold)

    def scales(self, stated: Stated) -> dict[str, float]:
        """Factors of the columns by the scales given.

        Columns whose unit the file names are in units of the SI, and are left as they are; a scale
        that is given for one of them is refused.
        """
        for name, unit in stated.units.items():
            if name in self.scale:
                raise SceneError(
                    f"validate: the file says that {name} is in {unit.name}; leave out the scale "
                    f"of {name}, or the unit in the file."
                )
        length, time, stress = (self.scale.get(name, 1.0) for name in BASIC)
        sizes = {"length": length, "time": time, "stress": stress, "length / time": length / time}
        return {
            name: 1.0 if name in stated.units else self.scale.get(name, sizes[dimension])
            for name, dimension in DIMENSIONS.items()
        }
