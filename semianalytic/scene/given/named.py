"""Find scenes by name, read them from TOML files, and override single parameters."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, FrictionLaw, ViscousFriction
from semianalytic.scene.given.documents import scene_from_document
from semianalytic.scene.given.load_tables import with_tables
from semianalytic.scene.incident import IncidentWave, MovingLoad, overridden_load
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.loads import Harmonic, Pulse, Ramp
from semianalytic.scene.plugins import SCENES, Plugin, find_plugin, plugin_names
from semianalytic.scene.quantities import Function, in_units_of, taking_quantities
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.scene.units import PARAMETERS

TABLES = {
    "material": ("shear_modulus", "density", "poisson_ratio"),
    "base": ("pressure", "shear"),
    "load": ("pressure", "shear"),
}
LOWER_MATERIAL = "lower_material"
OPTIONAL_TABLES = ("pressure_history", "shear_history", "friction_law", LOWER_MATERIAL)
LINES = ("whole-line-patch", "point-load", "growing-load")
"""Names of problems without a slot, or with a load that grows, that are no scenes."""
LINE_KEYS = ("contact", "growth")
"""Keys by which files of such problems are known."""
INTERFACE_KEY = "law"
"""Key by which files of interfaces are known."""
_LINE_HINT = (
    "has no slot, or a load that grows as a power of time, and only the exact solver knows it: "
    "slipfront solve, or find_line in Python (docs/whole_line.md)."
)
WORDS = ("mode", "load_on", "units")
"""Optional keys whose values are words; the scene checks them."""


@dataclass(frozen=True)
class NamedScene:
    """A scene that comes with the package, and a line that says what it shows.

    Attributes
    ----------
    scene : Scene
    summary : str
    lower : Material or None
        The lower body of a pair of two different ones.
    """

    scene: Scene
    summary: str
    lower: Material | None = None


_UNIT_SOLID = Material(shear_modulus=1.0, density=1.0, poisson_ratio=1 / 3)
_NOTHING, _PRELOAD = Tractions(0.0, 0.0), Tractions(1.0, 0.0)
_SHEAR, _BOTH = Tractions(0.0, 1.0), Tractions(1.0, 1.0)

DEFAULT_SCENE = "preloaded"

NAMED_SCENES: dict[str, NamedScene] = {
    "preloaded": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1.0)),
        "constant pressure, sudden shear: two slip zones, one ahead of the shear wave",
    ),
    "remote-shock": NamedScene(
        Scene(_UNIT_SOLID, 1.25, base=_NOTHING, load=_BOTH, load_on=REMOTE),
        "sudden remote pressure and shear, friction just low enough for the edge to slip",
    ),
    "stuck": NamedScene(
        Scene(_UNIT_SOLID, 2.0, base=_NOTHING, load=_BOTH, load_on=REMOTE),
        "sudden remote pressure and shear, friction high enough to hold everywhere",
    ),
    "auxetic": NamedScene(
        Scene(Material(1.0, 1.0, -0.5), 0.005, base=_PRELOAD, load=_SHEAR),
        "nu = -0.5 and little friction: reverse slip in a strip around the Rayleigh front",
    ),
    "ramp": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, _SHEAR, shear_history=Ramp(0.5)),
        "constant pressure, shear rising evenly until t = 0.5, then constant",
    ),
    "unload": NamedScene(
        Scene(_UNIT_SOLID, 0.15, _PRELOAD, _SHEAR, shear_history=Pulse(0.6, "triangle")),
        "constant pressure, shear that ramps up and down again: slip reverses",
    ),
    "pulse": NamedScene(
        Scene(_UNIT_SOLID, 0.15, _PRELOAD, _SHEAR, shear_history=Pulse(0.4)),
        "constant pressure, shear on and off again suddenly",
    ),
    "harmonic": NamedScene(
        Scene(_UNIT_SOLID, 0.1, _PRELOAD, _SHEAR, shear_history=Harmonic(3.0)),
        "constant pressure, shear that oscillates: slip reverses each half cycle",
    ),
    "pressure-drop": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(1.0, 0.295), load=Tractions(1.0, 0.0)),
        "constant shear, sudden loss of pressure on the slot: slip ahead of the shear wave",
    ),
    "viscous": NamedScene(
        Scene(_UNIT_SOLID, 0.2, _PRELOAD, _SHEAR, friction_law=ViscousFriction(0.1)),
        "constant pressure, sudden shear, a viscous film: one slip zone across the Rayleigh front",
    ),
    "antiplane": NamedScene(
        Scene(_UNIT_SOLID, 0.5, _PRELOAD, _SHEAR, mode="antiplane"),
        "constant pressure, sudden antiplane shear: one slip zone, all of it in closed form",
    ),
    "incident-p": NamedScene(
        Scene(_UNIT_SOLID, 0.4, _PRELOAD, IncidentWave("P", angle=-30.0, stress=-0.6)),
        "a wave of tension at 30 degrees: the contact opens from its edge, slip runs ahead",
    ),
    "incident-sv": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, IncidentWave("SV", angle=-20.0, stress=0.3)),
        "a shear wave at 20 degrees that meets the contact first: slip from the edge",
    ),
    "incident-pulse": NamedScene(
        Scene(
            _UNIT_SOLID,
            0.25,
            _PRELOAD,
            IncidentWave("SV", angle=-20.0, stress=0.3),
            pressure_history=Pulse(0.6),
            shear_history=Pulse(0.6),
        ),
        "a pulse of that wave: slip from the edge ends where the end of the pulse meets it",
    ),
    "moving-load": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, MovingLoad(speed=0.5, pressure=0.0, shear=1.0)),
        "shear that advances over the slot at half the shear wave's speed",
    ),
    "lift-off": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=_PRELOAD, load=Tractions(-1.0, 0.0)),
        "pressure put on the slot: the contact opens from its edge",
    ),
    "lift-off-shear": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=_PRELOAD, load=Tractions(-1.0, 1.0)),
        "pressure and shear put on the slot: slip runs ahead of the opening",
    ),
    "tap": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(0.02, 0.0), load=Tractions(1.0, 0.0)),
        "sudden pressure on a base of a fiftieth of it: the contact opens ahead and closes again",
    ),
}

_GOUGE, _ROCK = Material(1.0, 1.0, 0.25), Material(2.5, 1.2, 0.25)
"""A slow solid on a fast one, with the ratios of gouge and rock."""
NAMED_PAIRS: dict[str, NamedScene] = {
    "pair-slip": NamedScene(
        Scene(_GOUGE, 0.2, base=Tractions(2.0, 0.0), load=Tractions(0.3, 1.0)),
        "two different bodies, sudden pressure and shear: slip changes the pressure",
        _ROCK,
    ),
    "pair-opening": NamedScene(
        Scene(_GOUGE, 0.3, base=_PRELOAD, load=Tractions(-1.0, 0.5)),
        "two different bodies, pressure and shear put on the slot: slip ahead of an opening",
        _ROCK,
    ),
}
"""Problems of two different bodies, in units of the upper one."""


def find_scene(source: str | PathLike[str]) -> Scene:
    """Find a scene by its name or by the path of a TOML file.

    Parameters
    ----------
    source : str or path
        A key of `NAMED_SCENES` (docs/scenes.md), a path (anything that ends in .toml or exists as a
        file), or the name of a scene that another package brings (docs/extending.md).

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If there is no such scene or file, or the file does not describe a scene, or describes a
        scene of two materials.
    PluginError
        If the package that brings the scene is broken, or two packages bring it.

    Examples
    --------
    >>> from semianalytic import find_scene
    >>> scene = find_scene("preloaded")
    >>> scene.friction, scene.load
    (0.3, Tractions(pressure=0.0, shear=1.0))
    """
    if not isinstance(source, str | PathLike):
        raise SceneError(
            f"find_scene: give the name of a scene or the path of a TOML file, got {shown(source)}."
        )
    source = fspath(source)
    return _identical(source, *find_blocks(source))


def checked_scene(function: str, given: object) -> Scene:
    """Return the scene that a function was given, itself or as a source of `find_scene`.

    Raises
    ------
    SceneError
        "{function}: scene must be a Scene, ...", or for the reasons given at `find_scene`.
    PluginError
        For those given there.
    """
    if isinstance(given, Scene):
        return given
    if isinstance(given, str | PathLike):
        return find_scene(given)
    # pairs and interfaces of two bodies are described elsewhere, and not imported here
    two = " (two bodies are for solve_pair, survey, run and simulate)"
    other = two if hasattr(given, "lower") or hasattr(given, "lower_material") else ""
    raise SceneError(
        f"{function}: scene must be a Scene, or the name or file of one{other}, got {shown(given)}."
    )


def of_scene(function: Function) -> Function:
    """Let a function of a scene, or of the name or file of one, take quantities."""
    return taking_quantities(function, partial(checked_scene, function.__name__))


def find_blocks(source: str) -> tuple[Scene, Material | None]:
    """Find a scene like `find_scene`, with the lower material of its file; None without one."""
    named = NAMED_SCENES.get(source) or NAMED_PAIRS.get(source)
    if named is not None:
        return named.scene, named.lower
    if is_file(source):
        return read_blocks(source)
    if source in LINES:
        raise SceneError(f"{source} {_LINE_HINT}")
    plugin = find_plugin(SCENES, source)
    if plugin is not None:
        return brought_scene(plugin), None
    own = (*NAMED_SCENES, *NAMED_PAIRS)
    names = [*own, *plugin_names(SCENES, own)]
    close = difflib.get_close_matches(source, names, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]}?" if close else f"choose {', '.join(names)}"
    raise SceneError(f"There is no scene called {source!r}; {hint} (or give a .toml file).")


def is_file(source: str) -> bool:
    """Return whether a source is meant as a file, not as a name."""
    path = Path(source)
    return path.suffix == ".toml" or path.is_file()


def describes_line(source: str) -> bool:
    """Return whether a source names a whole line or a growing load, or is a file of one.

    Raises
    ------
    SceneError
        If it is a file that cannot be read.
    """
    if source in LINES:
        return True
    if not is_file(source):
        return False
    document = read_document(source)
    return INTERFACE_KEY not in document and any(key in document for key in LINE_KEYS)


def brought_scene(plugin: Plugin) -> Scene:
    """Return the scene that a package brings, either itself or by a function without arguments.

    Raises
    ------
    PluginError
        If it is neither, or the function fails.
    """
    brought = plugin.load()
    scene = plugin.guarded("cannot be made", brought) if callable(brought) else brought
    if not isinstance(scene, Scene):
        raise plugin.error(f"must be a Scene, or a function that returns one, not {shown(scene)}")
    return scene


def brought_summary(plugin: Plugin) -> str:
    """Return a line that says what the scene of a package shows.

    It is the first line of the docstring of the function that makes the scene.
    """
    brought = plugin.load()
    lines = (brought.__doc__ or "").strip().splitlines() if callable(brought) else []
    return lines[0] if lines else ""


def scene_label(source: str) -> str:
    """Return a short name of a scene for titles: its name, or the stem of its file."""
    # Names of packages are no files either.
    named = source in (*NAMED_SCENES, *NAMED_PAIRS) or not is_file(source)
    return source if named else Path(source).stem


def scene_folder(source: str, overrides: Mapping[str, float | str]) -> Path:
    """Return the folder for the results of a scene, such as results/preloaded-friction-0.31.

    Parameters
    ----------
    source : str
        Name or file of the scene, as for `find_scene`.
    overrides : mapping
        Values that replace the scene's own, as for `override_scene`.
    """
    changes = (
        f"{name.replace('_', '-')}-{str(value).removesuffix('.0')}"
        for name, value in overrides.items()
    )
    return Path("results", "-".join((scene_label(source), *changes)))


def read_scene(path: str | Path) -> Scene:
    """Read the scene that a TOML file describes.

    The file holds ``friction``, ``[material]`` with shear_modulus, density and poisson_ratio, and
    ``[base]`` and ``[load]`` with pressure and shear, in any consistent set of units.  ``[load]``
    may hold ``kind = "incident-wave"`` with wave ("P", "SV" or "SH"), angle, velocity or stress,
    and from ("below" or "above"), or ``kind = "moving"`` with speed, pressure and shear.
    It may hold ``[pressure_history]``, ``[shear_history]`` (``kind = "ramp"``, ``rise_time =
    0.5``) and ``[friction_law]`` (``kind = "slip-weakening"``, ``reduction = 0.5``, ``distance =
    1e-5``).  A history of kind "tabulated" may name a table, ``file = "pulse.csv"``, whose header
    has units.  Before the tables, ``mode = "antiplane"`` turns shear and slip along z, ``load_on =
    "remote"`` lets the load arrive from far away, and ``units = "SI"`` makes all output say m, s
    and Pa.

    Raises
    ------
    SceneError
        If the file cannot be read, if a key is missing, unknown, of the wrong type or out of range,
        or if the file describes two materials; the message names file and key.
    """
    return _identical(path, *read_blocks(path))


def _identical(source: str | Path, scene: Scene, lower: Material | None) -> Scene:
    """Return the scene; raise SceneError if its lower block is of another material."""
    if lower not in (None, scene.material):
        raise SceneError(
            f"{source}: this knows identical bodies only, and there are two; solve a step on the "
            "slot exactly, slipfront solve or survey or solve_pair in Python, or simulate the "
            "scene with finite elements, slipfront simulate; slipfront compare does both "
            "(docs/dissimilar.md)."
        )
    return scene


def read_blocks(path: str | Path) -> tuple[Scene, Material | None]:
    """Read a scene like `read_scene`, with the material of ``[lower_material]``; None without one.

    That table has the keys of ``[material]``, for the lower block.
    """
    document = read_document(path)
    if INTERFACE_KEY in document:
        raise SceneError(
            f"{path} describes an interface, not a scene: slipfront run, or find_interface in "
            "Python (docs/engine.md)."
        )
    # Before keys are checked, which would call those of a line unknown one by one.
    if any(key in document for key in LINE_KEYS):
        raise SceneError(f"{path} {_LINE_HINT}")
    _check_keys(path, "", document, ("friction", *TABLES), (*OPTIONAL_TABLES, *WORDS))
    for table, keys in TABLES.items():
        if table != "load" or "kind" not in document[table]:  # else `load_from_document` checks it
            _check_keys(path, f"{table}.", document[table], keys)
    lower = document.get(LOWER_MATERIAL)
    if lower is not None:
        _check_keys(path, f"{LOWER_MATERIAL}.", lower, TABLES["material"])
    try:
        # Whatever is out of range raises here, and gets the name of the file in front.
        scene = scene_from_document(with_tables(path, document))
        return scene, None if lower is None else Material(**lower)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from error


def read_document(path: str | Path) -> dict[str, Any]:
    """Read a TOML file; raise SceneError if it cannot be read, or is none."""
    text = ""
    try:
        text = Path(path).read_text(encoding="utf-8")
        return tomllib.loads(text)
    except OSError as error:
        reason = error.strerror or str(error)
        raise SceneError(f"Cannot read the scene file {path}: {reason}.") from error
    except ValueError as error:  # TOML syntax and UTF-8 errors alike
        # The parser names a line and column; that a table was appended to a file that has it
        # already is the usual reason, and easier to mend by name.
        twice = [head for head, count in Counter(_headings(text)).items() if count > 1]
        if twice:
            raise SceneError(
                f"{path} has the table {twice[0]} twice; delete or replace the first one."
            ) from error
        raise SceneError(f"{path} is not a valid TOML file: {error}.") from error
    except RecursionError as error:
        raise SceneError(f"{path} nests brackets too deeply; give a scene file.") from error


def _headings(text: str) -> list[str]:
    """Return the headings of a TOML text that may stand once: [name], not [[name]] or values."""
    lines = (line.partition("#")[0].strip() for line in text.splitlines())
    return [line for line in lines if re.fullmatch(r"\[[A-Za-z_][\w.-]*\]", line)]


def override_scene(
    scene: Scene,
    *,
    shear_modulus: float | None = None,
    density: float | None = None,
    poisson_ratio: float | None = None,
    friction: float | None = None,
    base_pressure: float | None = None,
    base_shear: float | None = None,
    load_pressure: float | None = None,
    load_shear: float | None = None,
    viscosity: float | None = None,
    mode: str | None = None,
    load_on: str | None = None,
    wave: str | None = None,
    angle: float | None = None,
    wave_velocity: float | None = None,
    wave_stress: float | None = None,
    wave_from: str | None = None,
    load_speed: float | None = None,
    units: str | None = None,
) -> Scene:
    """Return a scene with every parameter replaced that is not None.

    Dimensions are those of `Scene`, `Material` and `Tractions`.  A viscosity turns constant
    friction into viscous friction, and 0 turns it back.  `wave`, `angle`, `wave_velocity` or
    `wave_stress` and `wave_from` are those of an `IncidentWave`, in place of whatever the scene's
    load is; `load_speed` is that of a `MovingLoad`, which takes the scene's tractions.  Numbers
    with units, as quantities of pint, need a scene in SI units.

    Raises
    ------
    SceneError
        If the resulting scene is not admissible, or a viscosity is given for friction that weakens.
    """
    # First, since quantities with units are allowed in a scene in SI units alone.
    scene = scene if units is None else replace(scene, units=units)
    given = {
        "shear_modulus": shear_modulus,
        "density": density,
        "poisson_ratio": poisson_ratio,
        "friction": friction,
        "base_pressure": base_pressure,
        "base_shear": base_shear,
        "load_pressure": load_pressure,
        "load_shear": load_shear,
        "load_speed": load_speed,
        "angle": angle,
        "wave_velocity": wave_velocity,
        "wave_stress": wave_stress,
        "viscosity": viscosity,
    }
    for name, value in given.items():
        parameter = name.removeprefix("base_").removeprefix("load_")
        in_units_of(scene.units, name.replace("_", " "), value, PARAMETERS[parameter])
    return replace(
        scene,
        material=_replace_given(
            scene.material,
            shear_modulus=shear_modulus,
            density=density,
            poisson_ratio=poisson_ratio,
        ),
        base=_replace_given(scene.base, pressure=base_pressure, shear=base_shear),
        load=overridden_load(
            scene.load,
            {"pressure": load_pressure, "shear": load_shear, "speed": load_speed},
            {
                "kind": wave,
                "angle": angle,
                "velocity": wave_velocity,
                "stress": wave_stress,
                "from_": wave_from,
            },
        ),
        friction=scene.friction if friction is None else friction,
        friction_law=_with_viscosity(scene.friction_law, viscosity),
        mode=scene.mode if mode is None else mode,
        load_on=scene.load_on if load_on is None else load_on,
    )


def _with_viscosity(law: FrictionLaw, viscosity: float | None) -> FrictionLaw:
    """Return a law with this viscosity; Coulomb friction if it is 0, the same law if it is None."""
    if viscosity is None:
        return law
    if not isinstance(law, CoulombFriction | ViscousFriction):
        raise SceneError(
            "viscosity goes with constant or viscous friction only, and this scene's weakens; "
            "leave viscosity out, or take out the scene's friction law."
        )
    # Zero viscosity is Coulomb's law itself, so that such scenes compare as equal.
    return ViscousFriction(viscosity) if viscosity else CoulombFriction()


def _replace_given(description: Any, **values: float | None) -> Any:
    """Return a dataclass with the fields replaced that are not None."""
    return replace(description, **{key: v for key, v in values.items() if v is not None})


_NAMED_OTHERWISE = {"step": "what is loaded goes into the table [load]."}
"""Hints for keys that may be mistaken for others but are spelt too differently to be guessed."""


def _check_keys(
    path: str | Path,
    prefix: str,
    table: Mapping[str, object],
    expected: tuple[str, ...],
    optional: tuple[str, ...] = (),
) -> None:
    """Raise SceneError unless a table has all expected keys, and besides only optional ones."""
    known = (*expected, *optional)
    for key, value in table.items():
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1)
            others = f"known are {', '.join(known)} (docs/not_here.md)."
            hint = f"did you mean {close[0]}?" if close else others
            hint = _NAMED_OTHERWISE.get(prefix + key, hint)
            raise SceneError(f"{path}: unknown key {prefix}{key}; {hint}")
        if key in (*TABLES, *OPTIONAL_TABLES):
            if not isinstance(value, dict):
                raise SceneError(f"{path}: {key} must be a table, [{key}], got {shown(value)}.")
        elif key not in WORDS and finite(value) is None:
            raise SceneError(f"{path}: {prefix}{key} must be a number, got {shown(value)}.")
    for key in expected:
        if key not in table:
            raise SceneError(f"{path}: {prefix}{key} is missing.")
