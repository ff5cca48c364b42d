"""Find a scene by its name, by the path of its file, or in another package that brings it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from os import PathLike, fspath
from pathlib import Path

from semianalytic.scene.arguments import Function, taking_quantities
from semianalytic.scene.checks import meant, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.named import NAMED_LINES, NAMED_SCENES, NAMED_SPECIMENS
from semianalytic.scene.plugins import SCENES, Plugin, find_plugin, plugin_names
from semianalytic.scene.scene import Scene


def find_scene(source: str | PathLike[str]) -> Scene:
    """Find a scene with a slot by its name or by the path of a TOML file.

    Errors are those of `find` and `check_slot`.
    """
    scene = find(source)
    check_slot(fspath(source), scene)
    return scene


def check_slot(what: str, scene: Scene) -> None:
    """Raise SceneError unless a scene is a slot next to a contact, under a load that does not grow:
    `solve` alone takes others."""
    if scene.on_line:
        raise SceneError(
            f"{what}: this takes only a slot next to a contact, and the scene has {scene.on_line}, "
            "which is marched along a line; use slipfront solve or compare, or `solve` in "
            "Python (docs/engine.md)."
        )
    if not scene.has_slot or scene.grows:
        raise SceneError(
            f"{what}: this takes only scenes with a slot, under loads that do not grow as a power "
            "of time; use slipfront solve, or `solve` in Python (docs/whole_line.md)."
        )


def find(source: str | PathLike[str]) -> Scene:
    """Find a problem by its name or by the path of a TOML file.

    Parameters
    ----------
    source : str or path
        A name that ``slipfront scenes`` lists (docs/scenes.md, docs/engine.md), also one from an
        installed package, or a path: anything that ends in .toml or exists as a file.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If there is no such name or file, or the file does not describe a scene; the message says
        which name is similar, or which key to change.
    PluginError
        If the package that brings the name is broken, or two packages bring it.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.find("preloaded").friction
    0.3
    >>> sa.find("whole-line-patch").load
    Patch(speed=0.3, pressure=0.0, shear=1.0)
    >>> sa.find("tpv101").run["end_time"]
    15.0
    """
    if not isinstance(source, str | PathLike):
        raise SceneError(f"find: give a name or the path of a TOML file, got {shown(source)}.")
    source = fspath(source)
    named = NAMED_SCENES.get(source)
    if named is not None:
        return named.scene
    if is_file(source) or source in NAMED_LINES or source in NAMED_SPECIMENS:
        from semianalytic.scene.given.files import read_scene  # most scenes are named

        named_files = {**NAMED_LINES, **NAMED_SPECIMENS}
        return read_scene(source if is_file(source) else named_files[source])
    plugin = find_plugin(SCENES, source)
    if plugin is not None:
        return brought_scene(plugin)
    hint = meant(source, names(), f"choose {', '.join(names())}", 0.5)
    raise SceneError(f"There is no scene called {source!r}; {hint} (or give a .toml file).")


def any_scene(function: str, given: object) -> Scene:
    """Return the scene that a function was given, itself or as its name or file.

    Raises SceneError for anything else; other errors are those of `find`.
    """
    found = find(given) if isinstance(given, str | PathLike) else given
    if isinstance(found, Scene):
        return found
    raise SceneError(
        f"{function}: scene must be a Scene, or the name or file of one, got {shown(given)}."
    )


def checked_scene(function: str, given: object) -> Scene:
    """Return the scene that a function of slots was given, as `any_scene` and `check_slot` do."""
    scene = any_scene(function, given)
    check_slot(function if isinstance(given, Scene) else str(given), scene)
    return scene


def scene_of_one_solid(function: str, given: object) -> Scene:
    """Return the scene that a function of equal bodies was given, as `checked_scene` does.

    Raises SceneError if the bodies are different ones; other errors are those of `checked_scene`.
    """
    scene = checked_scene(function, given)
    if scene.lower_material is not None:
        raise SceneError(
            f"{function}: this takes identical bodies only, and the scene has a lower_material; "
            "solve a step on the slot exactly, slipfront solve or survey, or simulate the scene "
            "with finite elements, slipfront simulate; slipfront compare does both "
            "(docs/dissimilar.md)."
        )
    return scene


def of_scene(function: Function) -> Function:
    """Let a function of a scene, or of the name or file of one, take quantities."""
    return taking_quantities(function, partial(checked_scene, function.__name__))


def names() -> list[str]:
    """Return every name that there is, those of other packages last."""
    own = (*NAMED_SCENES, *NAMED_LINES)
    return [*own, *plugin_names(SCENES, own)]


def is_file(source: str) -> bool:
    """Return whether a source is meant as a file, not as a name."""
    path = Path(source)
    return path.suffix == ".toml" or path.is_file()


def brought_scene(plugin: Plugin) -> Scene:
    """Return the scene that a package brings, either itself or by a function without arguments.

    Raises PluginError if it is neither, or the function fails.
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
    named = source in NAMED_SCENES or not is_file(source)
    return source if named else Path(source).stem


def scene_folder(source: str, overrides: Mapping[str, float | str]) -> Path:
    """Return the folder for the results of a scene, such as results/preloaded-friction-0.31.

    The source is that of `find`; overrides replace the scene's own values, as in `override_scene`.
    """
    changes = (
        f"{name.replace('_', '-')}-{str(value).removesuffix('.0')}"
        for name, value in overrides.items()
    )
    return Path("results", "-".join((scene_label(source), *changes)))
