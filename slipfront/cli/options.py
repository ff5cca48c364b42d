"""Options that several commands share: scene parameters, settings of solvers, output, quietness."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import typer
from rich.markup import escape

from semianalytic.results.memory import GIGABYTE
from semianalytic.scene.checks import checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import in_units_of
from semianalytic.scene.tables.units import si_size
from semianalytic.scene.units import PARAMETERS, SI, measure
from slipfront.cli.scenes.completion import LOADED, MESH_NAMES, METHODS, MODES, one_of, scene_names

SECONDS = {"": 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}
"""Units of time on the command line, in seconds."""


def measured(dimension: str) -> Callable[[str], float]:
    """Return a parser of numbers that a unit of a dimension may follow, as 5cm, for typer."""

    def parsed(text: str) -> float:
        try:
            return measure(text, dimension, si_size)
        except SceneError as error:
            raise typer.BadParameter(str(error)) from None

    return parsed


def option(
    text: str,
    panel: str | None = None,
    *,
    flag: str = "",
    complete: Callable[[str], list[str]] | None = None,
    **given: Any,
) -> Any:
    """Return a typer option with a help text and, if it is not named as its argument, its flag."""
    return typer.Option(
        *((flag,) if flag else ()),
        help=escape(text),  # rich would take units in brackets for markup
        rich_help_panel=panel,
        autocompletion=complete,
        **given,
    )


def measured_option(dimension: str, text: str, panel: str | None = None, **given: Any) -> Any:
    """Return a typer option for a number that a unit may follow, as 5cm; None unless given."""
    return option(text, panel, **{"parser": measured(dimension), "metavar": "NUMBER", **given})


def asked(scene: Any, name: str, value: Any, dimension: str) -> Any:
    """Return the value of an option in the units of a scene.

    A unit is refused by a SceneError where the scene does not say its own.
    """
    return in_units_of(scene.units, option_name(name), value, dimension)


def read_number(scene: Any, name: str, text: str, dimension: str, said: str = "") -> float:
    """Return the number of an option's text, which a unit may follow, in the units of a scene.

    Anything else, or a unit that cannot be taken, is refused by a SceneError; `said` comes before
    the reason.
    """
    try:
        number = measure(text, dimension, si_size)
    except SceneError as error:
        raise SceneError(f"{option_name(name)} {said}{error}") from None
    found: float = asked(scene, name, number, dimension)
    return found


def read_pair(name: str, text: str, form: str, example: str) -> tuple[str, str]:
    """Return name and value of NAME=VALUE; SceneError says the form of both, and an example."""
    key, _, value = (part.strip() for part in text.partition("="))
    if not (key and value):
        raise SceneError(
            f"{option_name(name)} must be a name and {form} as {example}, got {shown(text)}."
        )
    return key, value


def read_numbers(
    scene: Any, name: str, texts: Iterable[str], known: Mapping[str, str]
) -> dict[str, float]:
    """Return the numbers of NAME=NUMBER, which may have units, by names of known dimension."""
    result = {}
    for text in texts:
        key, number = read_pair(name, text, "a number", f"{next(iter(known))}=0.01")
        if key not in known:
            raise SceneError(f"{option_name(name)} knows {', '.join(known)}, got {key!r}.")
        said = f"must be NAME=NUMBER; {key}: the number "
        result[key] = read_number(scene, name, number, known[key], said)
    return result


def option_dimension(name: str) -> str:
    """Return the dimension of the option of a scene's parameter, by the parameter's name."""
    return PARAMETERS[re.sub("^(base|load|lower)_", "", name)]


def optional(
    type_: Any, panel: str | None, text: str, *names: str, dimension: str = "", **given: Any
) -> Any:
    """Return the annotation of an option that is None unless given, with names to choose from."""
    if dimension:
        return Annotated[float | None, measured_option(dimension, text, panel, **given)]
    complete = one_of(*names) if names else None
    return Annotated[type_ | None, option(text, panel, complete=complete, **given)]


SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="Name of a scene, or a TOML file.", autocompletion=scene_names
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show results without progress.")]
AsJson = Annotated[bool, option("Print JSON and nothing else.", flag="--json")]
NoSnapshots = Annotated[bool, option("Write no field snapshots.", flag="--no-snapshots")]
NoCompanions = Annotated[
    bool,
    option("Skip the runs on coarser meshes, which give error bars.", flag="--no-companions"),
]
Budget = Annotated[
    str | None,
    option(
        "Time for the simulation, such as 60s, 5min or 1h, which decides the mesh; about that of a "
        "resolution of 100 by default.",
        "Finite elements",
        metavar="TIME",
    ),
]
Output = Annotated[
    Path | None,
    option(
        "Folder to write to; by default results/SCENE, such as results/SCENE-friction-0.2.",
        metavar="DIR",
    ),
]
FORMS = ("png", "pdf", "svg")
FiguresForm = Annotated[
    str,
    option(
        f"Format of figures: {', '.join(FORMS[:-1])} or {FORMS[-1]}.",
        flag="--figures",
        metavar="FORMAT",
        callback=lambda form: checked_word("--figures", form, FORMS),
    ),
]
Method = Annotated[
    str,
    option(
        "self-similar, space-time, or auto, which chooses by the scene.", complete=one_of(*METHODS)
    ),
]

_SCENE_PANEL = "Scene (in place of the scene's own values)"

SCENE_OPTIONS: Mapping[str, Any] = {
    name: optional(str, _SCENE_PANEL, text, *names)
    for name, text, names in (
        ("mode", "Direction of shear: in-plane or antiplane.", MODES),
        (
            "load_on",
            "Where the load acts: on the faces of the slot, or arriving from far away (remote).",
            LOADED,
        ),
        (
            "wave",
            "Kind of a plane wave that arrives, in place of the load: P or SV, SH in antiplane "
            "shear.",
            ("P", "SV", "SH"),
        ),
        ("wave_from", "Body from which the wave arrives: below or above.", ("below", "above")),
        (
            "units",
            "SI: all numbers of the scene are in m, s, kg and Pa, and so are the answers.",
            (SI,),
        ),
    )
} | {
    name: optional(float, _SCENE_PANEL, text, dimension=option_dimension(name))
    for name, text in {
        "shear_modulus": "Shear modulus [stress].",
        "density": "Mass density [mass / length³].",
        "poisson_ratio": "Poisson ratio.",
        "friction": "Coulomb friction coefficient.",
        "base_pressure": "Pressure in place before t = 0, everywhere [stress].",
        "base_shear": "Shear traction in place before t = 0, everywhere [stress].",
        "load_pressure": "Pressure taken off the slot faces at t = 0; negative adds it [stress].",
        "load_shear": "Shear taken off the slot faces at t = 0; negative adds it [stress].",
        "angle": "Angle of the wave from the normal [degrees]; negative: it meets the contact "
        "first.",
        "wave_velocity": "Step of particle velocity of the wave [length / time].",
        "wave_stress": "Impedance times that step, as an alternative [stress].",
        "load_speed": "Speed of the load over the slot, away from its tip [length / time]; "
        "negative: towards the tip.",
        "viscosity": "Viscosity of a film: shear strength over slip rate [stress time / length].",
    }.items()
}

LOWER_OPTIONS: Mapping[str, Any] = {
    f"lower_{name}": optional(float, _SCENE_PANEL, text, dimension=PARAMETERS[name])
    for name, text in {
        "shear_modulus": "Shear modulus of the lower block [stress].",
        "density": "Mass density of the lower block [mass / length³].",
        "poisson_ratio": "Poisson ratio of the lower block.",
    }.items()
}
"""Options of the lower block; numbers that are not given are those of the upper block."""

MESH_OPTIONS: Mapping[str, Any] = {
    name: optional(
        type_,
        "Finite elements",
        text,
        *MESH_NAMES.get(name, ()),
        dimension={"end_time": "time", "size": "length"}.get(name, ""),
    )
    for name, (type_, text) in {
        "end_time": (float, "Time T at which the simulation ends [time]; 1 / c_t by default."),
        "resolution": (int, "Elements per c_t T; 100 by default, and compare can choose it."),
        "size": (float, "Side of the squares of a specimen [length]."),
        "damping": (float, "Kelvin–Voigt time over h / c_t; 0.02 by default."),
        "step_ratio": (float, "Time step over the critical one; 0.95 by default."),
        "model": (str, "Blocks to mesh; auto by default."),
        "mesh": (str, "Bilinear squares or linear triangles; squares by default."),
        "frames": (int, "Number of field snapshots; 10 by default."),
        "every": (int, "Store every n-th step of the histories; 1 by default."),
        "memory": (float, "Largest memory to use [GB]; 70 % of the free memory by default."),
    }.items()
}

MARCH_OPTIONS: Mapping[str, Any] = {
    name: optional(
        type_,
        "Space-time solver",
        text,
        dimension={"length": "length", "latest": "time", "entry": "length"}.get(name, ""),
        **({"flag": "--no-estimate"} if type_ is bool else {}),
    )
    for name, (type_, text) in {
        "nodes": (int, "Contact nodes; 1000 by default, or as many as the loads need."),
        "rtol": (float, "Largest error estimate; chooses the nodes."),
        "length": (float, "Part of the contact that is observed [length]; c_l T by default."),
        "step_ratio": (float, "c_t times the step over the node distance; 0.4 by default."),
        "every": (int, "Store every n-th step."),
        "latest": (float, "Time to which a saved march can be continued [time]; T by default."),
        "entry": (float, "Distance before the tip at which a load along the slot begins [length]."),
        "memory": (float, "Largest memory to use [GB]; 70 % of the free memory by default."),
        "no_estimate": (bool, "Skip the second march, on half the nodes, that gives the error."),
        "save": (Path, "File to save the answer to: .h5, or .nc for NetCDF of a march."),
        "go_on": (Path, "File of a saved march to continue."),
    }.items()
}

CHECKPOINT_OPTIONS: Mapping[str, Any] = {
    "checkpoint_every": optional(
        int, "Checkpoints", "Steps between checkpoints, written to DIR/checkpoint.h5; 0 for none."
    ),
    "checkpoint_seconds": optional(
        float, "Checkpoints", "Seconds between checkpoints; one is written when either is due."
    ),
    "resume": optional(
        bool,
        "Checkpoints",
        "Resume from DIR/checkpoint.h5 if it exists; give the same options again.",
        flag="--resume",
    ),
}


def with_options(
    own: Mapping[str, Any] = MappingProxyType({}), /, **groups: Mapping[str, Any]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Give a command the options of its own arguments, and one option per entry of each group.

    Its own options are given by argument, those of a group as annotations by name.  The command
    itself takes each group as one keyword argument: a dictionary of the options that were given on
    the command line.  Numbers that are not finite are refused.
    """
    options = {name: hint for group in groups.values() for name, hint in group.items()}

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def run(**given: Any) -> Any:
            collected: dict[str, dict[str, Any]] = {}
            for argument, group in groups.items():
                values = {name: given.pop(name) for name in group}
                collected[argument] = {k: v for k, v in values.items() if v is not None}
                for name, value in collected[argument].items():
                    if isinstance(value, float) and not math.isfinite(value):
                        named = option_name(name)
                        raise SceneError(f"{named} must be a finite number, got {value}.")
            return command(**given, **collected)

        parameters = [
            p.replace(annotation=Annotated[p.annotation, own[p.name]]) if p.name in own else p
            for p in inspect.signature(command, eval_str=True).parameters.values()
            if p.name not in groups
        ]
        parameters += [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=hint)
            for name, hint in options.items()
        ]
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {p.name: p.annotation for p in parameters}
        return run

    return decorate


def option_name(argument: str) -> str:
    """Return the option of an argument as it is typed."""
    return "--" + argument.replace("_", "-")


def in_seconds(time: str | None) -> float | None:
    """Convert a time as it is typed, such as 90, 60s, 1.5min or 2h, to seconds, or refuse it."""
    if time is None:
        return None
    match = re.fullmatch(r"(\d+\.?\d*|\.\d+)\s*([a-z]*)", time.strip().lower())
    seconds = float(match[1]) * SECONDS.get(match[2], math.nan) if match else math.nan
    if not 0 < seconds < math.inf:
        raise SceneError(f"--budget must be a time such as 60s, 5min or 1h, got {shown(time)}.")
    return seconds


def in_bytes(gigabytes: float | None) -> float | None:
    """Convert an amount of memory from gigabytes to bytes, as the solvers expect it."""
    return None if gigabytes is None else gigabytes * GIGABYTE
