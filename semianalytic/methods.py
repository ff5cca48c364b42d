"""The table of methods, and the verb `solve`, which asks the first that takes a problem."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from os import PathLike
from typing import Any, NamedTuple

from semianalytic.scene import plugins
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find


class Method(NamedTuple):
    """A method, the class of problems it takes, its module, and what they are.

    The module has ``solve(problem, **settings)``, and ``refuses(problem)``: None, or a sentence
    that says why the method does not take the problem unless it is asked for by name.
    """

    name: str
    problem: str
    module: str
    takes: str


METHODS = (
    Method("self-similar", "Scene", "selfsimilar.solver", "a slot next to a contact: step loads"),
    Method("self-similar", "Scene of two solids", "dissimilar_slot.solver", "between two bodies"),
    Method("self-similar", "Scene without a slot", "whole_line.solver", "a patch or a force"),
    Method("self-similar", "Scene that grows", "whole_line.growing", "load and strength grow"),
    Method("space-time", "Scene", "engine.march", "a slot: any history, slip weakening"),
    Method("space-time", "Scene on a line", "engine.march", "contacts, fields and laws along x"),
)
"""The methods in the order in which they are asked; those of installed packages come last."""
_OWN = list(dict.fromkeys(row.name for row in METHODS))


def solve(problem: Any, *, method: str = "auto", **settings: Any) -> Any:
    """Solve a problem by the first method that applies to it.

    Parameters
    ----------
    problem : Scene, str or path
        The scene, or its name or file as for `find`.
    method : str
        "auto", or the name of a method (docs/methods.md).
    **settings
        Settings of that method, such as rtol or end_time; the page lists them.

    Returns
    -------
    Solution, PairSolution, LineSolution, GrowingSolution or Marched
        An answer with the methods of `Answer`.

    Raises
    ------
    SceneError, TensionError, ComputationError
        If there is no such problem, method or setting, or no method takes the problem; if the
        contact would open to infinity, or a march fails.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.solve("preloaded").status, sa.solve("ramp", nodes=128).status
    ('converged', 'resolved')
    """
    problem = find(problem) if isinstance(problem, str | PathLike) else problem
    name, solver = chosen(problem, method)
    own = dict(getattr(problem, "run", {}))  # settings of a march, which exact answers pass over
    if "go_on" in settings:
        own.pop("nodes", None)  # which are those of the march that goes on
    names = settings_of(solver, problem)
    settings = {name: value for name, value in own.items() if name in names} | settings
    unknown = sorted(settings.keys() - {*names})
    if unknown and "**" not in names:
        takes = ", ".join(names) or "none"
        kind = type(problem).__name__
        what = f"{name} for a {'scene on a line' if getattr(problem, 'on_line', '') else kind}"
        raise SceneError(f"solve: {unknown[0]} is no setting of {what}, which takes {takes}.")
    answer = solver.solve(problem, **settings)
    if getattr(answer, "method", "") == _OWN[0]:  # which is saved as its question
        object.__setattr__(answer, "settings", settings)
    logging.getLogger(__name__).info("a %s by %s: %r", type(problem).__name__, name, answer)
    return answer


def settings_of(solver: Any, problem: object) -> list[str]:
    """Return the settings that the module of a method takes for a problem, by name.

    A method that takes any others has "**" among them.
    """
    if hasattr(solver, "settings_of"):
        return list(solver.settings_of(problem))
    known = [*inspect.signature(solver.solve).parameters.values()][1:]
    return ["**" if entry.kind is entry.VAR_KEYWORD else entry.name for entry in known]


class Chosen(NamedTuple):  # the method that answers a problem, and its module
    name: str
    solver: Any


def chosen(problem: object, method: str = "auto") -> Chosen:
    """Return the method by which `solve` answers a problem; raises what it raises."""
    if not isinstance(method, str):
        raise SceneError(f"method must be a word, got {shown(method)}.")
    refusals: dict[str, str] = {}
    for name, load in _rows(problem):
        if method in ("auto", name):
            solver = load()
            refusal = solver.refuses(problem) if method == "auto" else None
            if refusal is None:
                return Chosen(name, solver)
            refusals.setdefault(refusal, name)  # two may say the same
    if refusals:
        raise SceneError(" ".join(f"{name}: {sentence}" for sentence, name in refusals.items()))
    names = ["auto", *_OWN, *plugins.plugin_names(plugins.METHODS, _OWN)]
    if method not in names:
        raise SceneError(f"method must be one of {', '.join(names)}, got {shown(method)}.")
    got = shown(problem) if (kind := getattr(problem, "kind", "Scene")) == "Scene" else f"a {kind}"
    subject = "solve: problem must be" if method == "auto" else f"`method` {method} is for"
    raise SceneError(f"{subject} a Scene, or the name or file of one, got {got}.")


def _rows(problem: object) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the methods for such problems, each with what imports its module."""
    for row in METHODS:
        if row.problem == getattr(problem, "kind", ""):
            yield row.name, partial(import_module, f"semianalytic.{row.module}")
    for name in plugins.plugin_names(plugins.METHODS, _OWN):
        if plugin := plugins.find_plugin(plugins.METHODS, name):
            yield name, plugin.load
