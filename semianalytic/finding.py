"""One catalogue of names: whatever slips, found by its name or by the path of a TOML file."""

from __future__ import annotations

from os import PathLike, fspath

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import described_scene
from semianalytic.scene.scene import Scene


def find(source: str | PathLike[str]) -> Scene:
    """Find a problem by its name or by the path of a TOML file.

    Parameters
    ----------
    source : str or path
        A name that ``slipfront scenes`` lists (docs/scenes.md, docs/engine.md), also of an
        installed package, or a path: anything that ends in .toml or exists as a file.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If there is no such name or file, or the file describes none of them; the message says which
        name is nearest, or which key to change.
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
    return described_scene(source)


def kinds_of(problem: object) -> set[str]:
    """Return what the table of methods calls a problem: its class and those it derives from."""
    if not isinstance(problem, Scene):
        return {one.__name__ for one in type(problem).__mro__}
    if problem.on_line:
        return {"Scene on a line"}
    if problem.grows:
        return {"Scene that grows"}
    if not problem.has_slot:
        return {"Scene without a slot"}
    return {"Scene" if problem.lower_material is None else "Scene of two solids"}
