"""The files of the trial: settings, units, conventions, formats and mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from compare.records.record import QUANTITIES
from docs.studies.validate.settings import (
    Setting,
    Values,
    mean_rates,
    recorded,
    settings,
)
from semianalytic import Material, solve
from semianalytic.scene.loading import REMOTE

RIGHT, WRONG = "right", "wrong"
CELLS = 100
"""Cells over c_t T of the grid that the files say they are from."""

Units = Mapping[str, tuple[float, str]]
"""Size in the unit of the scene and name of the unit of each column."""


def _units(x: str, t: str, slip: str, rate: str, stress: str) -> Units:
    names = dict(zip(COLUMNS, (x, t, rate, slip, stress, stress), strict=True))
    return {column: (SIZES[name], name) for column, name in names.items()}


COLUMNS = ("x", "t", *QUANTITIES)
SIZES: Mapping[str, float] = {
    **{"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6},
    **{"in": 0.0254, "thou": 2.54e-5, "ft": 0.3048, "furlong": 201.168},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
    **{"m/s": 1.0, "mm/s": 1e-3, "km/s": 1e3, "in/s": 0.0254, "furlong/s": 201.168},
    **{"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "psi": 6894.757293168361, "bar": 1e5},
}
SYSTEMS: Mapping[str, Units] = {
    "SI": _units("m", "s", "m", "m/s", "Pa"),
    "km": _units("km", "s", "m", "m/s", "Pa"),
    "km and MPa": _units("km", "s", "m", "m/s", "MPa"),
    "MPa": _units("m", "s", "m", "m/s", "MPa"),
    "mm, µs, µm": _units("mm", "µs", "µm", "m/s", "MPa"),
    "mm, ms": _units("mm", "ms", "mm", "m/s", "MPa"),
    "mm, s": _units("mm", "s", "mm", "mm/s", "MPa"),
    "inches": _units("in", "us", "thou", "in/s", "psi"),
}


@dataclass(frozen=True)
class Style:
    """How a code writes what it computes.

    Attributes
    ----------
    units : mapping
        Size in the unit of the scene and name of each column.
    named : bool
        Whether the header names the units.
    half, turned, tension, changes : bool
        Half of slip and slip rate; slip and shear traction reversed; tension positive; tractions
        since t = 0.
    mean : str
        "before" or "after" where slip rates are means over steps.
    faces : str
        "both" or "upper": columns of the motion of faces.
    form : str
        A key of `writers.FORMS`.
    """

    units: Units = field(default_factory=dict)
    named: bool = False
    half: bool = False
    turned: bool = False
    tension: bool = False
    changes: bool = False
    mean: str = ""
    faces: str = ""
    form: str = "csv"


@dataclass(frozen=True)
class Case:
    """A file of the trial.

    Attributes
    ----------
    family : str
        What it is tried for.
    name : str
    kind : str
        `RIGHT` or `WRONG`.
    setting : Setting
    style : Style
    values : callable
        That makes what was recorded, in units of the scene.
    options : tuple of str
        Of the command, besides scene and spacing.
    """

    family: str
    name: str
    kind: str
    setting: Setting
    style: Style
    values: Callable[[], Values]
    options: tuple[str, ...] = ()


def cases() -> Iterator[Case]:
    """All files that hold records."""
    yield from _units_cases()
    yield from _conventions_cases()
    yield from _noise_cases()
    yield from _mistakes_cases()
    yield from _misnamed_cases()


FORMS = ("csv", "semicolon", "tab", "gz", "npz", "h5", "folder", "blanks")


def _form(number: int) -> str:
    return FORMS[number % len(FORMS)]


def _right(family: str, name: str, setting: Setting, style: Style, *options: str) -> Case:
    def values() -> Values:
        return recorded(setting)

    return Case(family, f"{setting.name}, {name}", RIGHT, setting, style, values, options)


def dimensionless(setting: Setting, stress: float) -> Units:
    """Units in which shear modulus over `stress`, density, c_t and T are 1."""
    material, end = setting.scene.material, setting.end_time
    slip = stress / material.shear_modulus * setting.length
    sizes = (setting.length, end, slip / end, slip, stress, stress)
    return {name: (size, "1") for name, size in zip(COLUMNS, sizes, strict=True)}


def plain(setting: Setting, stress: float) -> Units:
    """Units as `dimensionless` has them, but times in the unit of the scene."""
    return dimensionless(replace(setting, end_time=1.0), stress)


def _units_cases() -> Iterator[Case]:
    chosen = {
        "rock": ("SI", "km", "km and MPa", "MPa"),
        "rock under pressure": ("SI", "km", "km and MPa", "MPa", "mm, s"),
        "PMMA": ("SI", "mm, µs, µm", "mm, ms", "mm, s", "inches"),
        "steel, antiplane": ("SI", "mm, µs, µm", "inches"),
        "PMMA that opens": ("SI", "mm, µs, µm", "mm, ms"),
        "PMMA, a pulse": ("SI", "mm, µs, µm"),
    }
    number = 0
    for place, names in chosen.items():
        setting = settings()[place]
        for name in names:
            for named in (True, False):
                if name == "inches" and not named:
                    continue
                style = Style(SYSTEMS[name], named, form=_form(number))
                if named and style.form == "npz":
                    style = replace(style, form="h5")
                said = "named" if named else "not named"
                yield _right("units", f"{name}, {said}", setting, style)
                number += 1
        if setting.scene.is_self_similar and setting.scene.units:
            load = abs(setting.scene.superposition.taken_off.shear)
            modulus = setting.scene.material.shear_modulus
            for words, units in (
                ("over the load", dimensionless(setting, load)),
                ("over the load, times as they are", plain(setting, load)),
                (
                    "over the shear modulus",
                    dimensionless(setting, modulus),
                ),
            ):
                yield _right("units", words, setting, Style(units, form=_form(number)))
                number += 1


CONVENTIONS: Mapping[str, Style] = {
    "half": Style(half=True),
    "turned": Style(turned=True),
    "tension": Style(tension=True),
    "half, turned, tension": Style(half=True, turned=True, tension=True),
    "changes": Style(changes=True),
    "means before": Style(mean="before"),
    "means after": Style(mean="after"),
    "both faces": Style(faces="both"),
}


def _conventions_cases() -> Iterator[Case]:
    number = 0
    for place in ("plain", "plain shear", "rock under pressure", "PMMA", "PMMA that opens"):
        setting = settings()[place]
        scene = setting.scene
        for name, style in CONVENTIONS.items():
            held = scene.superposition.in_place
            changes_show = held.shear != 0 and held.pressure != 0
            if name == "changes" and not changes_show:
                continue
            system = "mm, µs, µm" if place == "PMMA" else "SI"
            units = SYSTEMS[system] if scene.units else {}
            yield _right(
                "conventions", name, setting, replace(style, units=units, form=_form(number))
            )
            number += 1
    setting = settings()["plain shear"]
    yield _right("conventions", "upper face", setting, Style(faces="upper"))


NOISE = 0.01
"""Standard deviation of samples over the largest value of their quantity."""


def _noise_cases() -> Iterator[Case]:
    for place in ("plain", "rock", "PMMA", "PMMA that opens"):
        for seed in range(3):
            setting = settings()[place]
            units = SYSTEMS["mm, µs, µm"] if place.startswith("PMMA") else {}
            style = Style(units, named=bool(units))
            clean = recorded(setting)
            said = []
            for name in QUANTITIES:
                size = units.get(name, (1.0, ""))[0]
                said += ["--noise", f"{name}={NOISE * np.abs(clean[name]).max() / size:.4g}"]

            def values(setting: Setting = setting, seed: int = seed) -> Values:
                return noisy(recorded(setting), seed)

            label = f"{setting.name}, noise {seed}"
            yield Case("noise", label, RIGHT, setting, style, values, tuple(said))


def noisy(values: Values, seed: int) -> Values:
    """Records with independent errors of `NOISE` of the largest value of each quantity."""
    random = np.random.default_rng(seed)
    return {
        name: value
        if name in ("t", "x")
        else value + NOISE * np.abs(value).max() * random.normal(size=value.shape)
        for name, value in values.items()
    }


def _times(**factors: float) -> Callable[[Setting], Values]:
    def spoil(setting: Setting) -> Values:
        values = recorded(setting)
        return {**values, **{name: factor * values[name] for name, factor in factors.items()}}

    return spoil


def _other(**changes: float) -> Callable[[Setting], Values]:
    def spoil(setting: Setting) -> Values:
        scene, solid = setting.scene, setting.scene.material
        friction = scene.friction * changes.get("friction", 1.0)
        ratio = solid.poisson_ratio + changes.get("poisson_ratio", 0.0)
        other = Material(solid.shear_modulus, solid.density, ratio)
        return recorded(setting, solve(replace(scene, friction=friction, material=other)))

    return spoil


def _late(setting: Setting) -> Values:
    values = recorded(setting)
    return {**values, "t": values["t"] + 0.1 * setting.end_time}


def _half_tensile(setting: Setting) -> Values:
    values = recorded(setting)
    late = values["t"][:, None] > 0.5 * setting.end_time
    return {**values, "pressure": np.where(late, -1, 1) * values["pressure"]}


def _mixed(setting: Setting) -> Values:
    values = recorded(setting)
    held = setting.scene.superposition.in_place
    return {**values, "shear_traction": values["shear_traction"] - held.shear}


def _no_outer(setting: Setting) -> Values:
    """The outer half of what slips before a shear wave passes is left out."""
    values = recorded(setting)
    outer = min(solve(setting.scene).zones[-1].outer, setting.scene.material.shear_speed)
    ahead = values["x"] > 0.5 * outer * values["t"][:, None]
    return {
        **values,
        **{name: np.where(ahead, 0.0, values[name]) for name in ("slip", "slip_rate")},
    }


def _gap_of_rates(setting: Setting) -> Values:
    values = recorded(setting)
    return {**values, "slip_rate": mean_rates(setting, values["t"], values["x"], "after") * 2}


MISTAKES: Mapping[str, Callable[[Setting], Values]] = {
    "slip × 1000, slip rate right": _times(slip=1e3),
    "slip × 1e-3, slip rate right": _times(slip=1e-3),
    "slip rate halved": _times(slip_rate=0.5),
    "slip halved": _times(slip=0.5),
    "slip rate × 1000": _times(slip_rate=1e3),
    "means of slip rate doubled": _gap_of_rates,
    "shear traction reversed": _times(shear_traction=-1.0),
    "slip and slip rate reversed": _times(slip=-1.0, slip_rate=-1.0),
    "pressure zero": _times(pressure=0.0),
    "pressure × 0.5": _times(pressure=0.5),
    "pressure × 30": _times(pressure=30.0),
    "pressure tensile in the second half": _half_tensile,
    "shear traction × 1000": _times(shear_traction=1e3),
    "shear traction without its base": _mixed,
    "slip and slip rate × 1.1": _times(slip=1.1, slip_rate=1.1),
    "slip and slip rate × 4": _times(slip=4.0, slip_rate=4.0),
    "tractions × 1.1": _times(shear_traction=1.1, pressure=1.1),
    "tractions × 2": _times(shear_traction=2.0, pressure=2.0),
    "times × 1.05": _times(t=1.05),
    "times 0.1 T late": _late,
    "positions × 1.1": _times(x=1.1),
    "friction + 5 %": _other(friction=1.05),
    "friction − 5 %": _other(friction=0.95),
    "ν + 0.05": _other(poisson_ratio=0.05),
    "outer slip left out": _no_outer,
}


def _mistakes_cases() -> Iterator[Case]:
    number = 0
    for place in ("plain", "plain shear", "rock under pressure", "PMMA"):
        setting = settings()[place]
        for name, spoil in MISTAKES.items():
            scene = setting.scene
            if name == "shear traction without its base" and not scene.superposition.in_place.shear:
                continue
            if name == "ν + 0.05" and scene.load_on == REMOTE:
                continue  # changes little where both tractions come from afar
            system = "mm, µs, µm" if place == "PMMA" else "SI"
            units = SYSTEMS[system] if scene.units else {}
            style = Style(units, form=_form(number), named=place == "PMMA" and number % 2 == 0)
            if style.named and style.form == "npz":
                style = replace(style, form="h5")

            def values(setting: Setting = setting, spoil: object = spoil) -> Values:
                return spoil(setting)  # type: ignore[operator]

            yield Case("mistakes", f"{place}, {name}", WRONG, setting, style, values)
            number += 1


MISNAMED: Mapping[str, Mapping[str, str]] = {
    "slip [m] in mm": {"slip": "mm m"},
    "slip [mm] in m": {"slip": "m mm"},
    "t [ms] in µs": {"t": "µs ms"},
    "tractions [psi] in Pa": {"shear_traction": "Pa psi", "pressure": "Pa psi"},
    "tractions [MPa] in kPa": {"shear_traction": "kPa MPa", "pressure": "kPa MPa"},
    "slip rate [furlong/s] in m/s": {"slip_rate": "m/s furlong/s"},
    "slip [thou] in m": {"slip": "m thou"},
    "t [min] in s": {"t": "s min"},
    "x [in] in m": {"x": "m in"},
    "x [ft] in m": {"x": "m ft"},
    "pressure [bar] in Pa": {"pressure": "Pa bar"},
    "slip rate [mm/s] in m/s": {"slip_rate": "m/s mm/s"},
}
"""Columns whose headers name a wrong unit: the unit that each is in, and the one it names."""


def _misnamed_cases() -> Iterator[Case]:
    for place in ("rock", "PMMA"):
        setting = settings()[place]
        for name, columns in MISNAMED.items():
            units = dict(SYSTEMS["SI"])
            for column, words in columns.items():
                really, said = words.split()
                units[column] = (SIZES[really], said)
            only = Style(units, named=True)
            right = _right("units named wrongly", name, setting, only)
            yield replace(right, kind=WRONG)
