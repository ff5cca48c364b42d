"""Plugins: scenes, laws, load histories, figures and methods that other packages bring.

A package names them by entry points (docs/extending.md).  They are looked up only if this package
has nothing of the name, so that its own cannot be replaced.  A package is imported when one of its
plugins is used.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from semianalytic.scene.checks import checked_kind, shown
from semianalytic.scene.errors import PluginError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

SCENES, LAWS, HISTORIES, FIGURES, METHODS = GROUPS = (
    "slipfront.scenes",
    "slipfront.laws",
    "slipfront.histories",
    "slipfront.figures",
    "slipfront.methods",
)
"""Groups of entry points."""

_NOUNS = {
    SCENES: "scene",
    LAWS: "friction law",
    HISTORIES: "load history",
    FIGURES: "figure",
    METHODS: "method",
}


@dataclass(frozen=True)
class Plugin:
    """One scene, law, history, figure or method that another package brings.

    Attributes
    ----------
    group : str
        Group of entry points, one of `GROUPS`.
    name, package : str
        Its name, and that of the package.
    entry : EntryPoint
        Entry point that is loaded when it is used.
    """

    group: str
    name: str
    package: str
    entry: EntryPoint

    @property
    def noun(self) -> str:
        """The kind of plugin, in a word or two."""
        return _NOUNS[self.group]

    @property
    def what(self) -> str:
        """Kind, name and package, for messages."""
        return f"the {self.noun} {self.name!r} of the package {self.package}"

    def load(self) -> Any:
        """Import and return the object that the entry point names; PluginError if that fails."""
        return self.guarded("cannot be imported", self.entry.load)

    def guarded(self, failing: str, run: Callable[[], Any]) -> Any:
        """Return the result of a function of the package.

        Whatever it raises becomes a PluginError, in which `failing` says what went wrong.
        """
        try:
            return run()
        # A package may raise anything, also SystemExit from a script that is imported.
        except (Exception, SystemExit) as error:
            raise self.error(f"{failing} ({_words(error)})") from error

    def error(self, failing: str) -> PluginError:
        """Make the error that says what is wrong with the plugin, and what to do."""
        return PluginError(
            f"{self.what[0].upper()}{self.what[1:]} {failing}; repair or uninstall that package."
        )


def plugin_at_fault(error: BaseException) -> PluginError | None:
    """Return the error that names the plugin in which another error arose; None if in none.

    The innermost call inside the modules of a plugin decides, also if that called this package.
    """
    brought = {
        found.entry.module.partition(".")[0]: found for group in GROUPS for found in plugins(group)
    }
    calls, trace = [], error.__traceback__
    while trace is not None:
        calls.append(str(trace.tb_frame.f_globals.get("__name__", "")).partition(".")[0])
        trace = trace.tb_next
    plugin = next((brought[name] for name in reversed(calls) if name in brought), None)
    return None if plugin is None else plugin.error(f"failed ({_words(error)})")


@cache
def plugins(group: str) -> tuple[Plugin, ...]:
    """Return the plugins of a group, in the order of their names; nothing is imported."""
    from importlib.metadata import entry_points

    # Entry points are metadata: nothing of a package is imported to list it.
    brought = (
        Plugin(group, entry.name, entry.dist.name if entry.dist else "?", entry)
        for entry in entry_points(group=group)
    )
    return tuple(sorted(brought, key=lambda plugin: (plugin.name, plugin.package)))


def plugin_names(group: str, own: Collection[str] = ()) -> list[str]:
    """Return the names of plugins in a group that are not among the package's own names."""
    return [name for name in dict.fromkeys(mod.name for mod in plugins(group)) if name not in own]


def find_plugin(group: str, name: str) -> Plugin | None:
    """Return the plugin of a name in a group; None if no package has it.

    Raises PluginError if two packages bring a plugin of that name.
    """
    named = [plugin for plugin in plugins(group) if plugin.name == name]
    if len(named) > 1:
        packages = " and ".join(plugin.package for plugin in named)
        raise PluginError(
            f"The packages {packages} each bring a {_NOUNS[group]} called {name!r}; uninstall all "
            "but one of them."
        )
    return named[0] if named else None


def known_class(name: str, group: str, base: type, own: Mapping[str, type], kind: Any) -> type:
    """Return the class that a kind stands for, from this package or a plugin.

    The name is that of the table that gives the kind, for messages; the group is `LAWS` or
    `HISTORIES`, `base` what classes of plugins must inherit, and `own` has the classes of this
    package, whose kinds no other one can take.  Raises SceneError if there is no such kind, and
    PluginError if the class of a plugin lacks something that solvers need.
    """
    if isinstance(kind, str) and "." in kind:  # of the program that runs; nothing is imported
        module, _, attribute = kind.rpartition(".")
        found = getattr(sys.modules.get(module), attribute, None)
        if isinstance(found, type) and issubclass(found, base):
            return found
    kind = checked_kind(name, kind, (*own, *plugin_names(group, own)))
    plugin = None if kind in own else find_plugin(group, kind)
    if plugin is None:
        return own[kind]
    described: type = plugin.load()
    for failing in _failings(described, base, own.values()):
        raise plugin.error(failing)
    return described


def kind_of(group: str, base: type, own: Mapping[str, type], described: type) -> str | None:
    """Return the kind of a class, the reverse of `known_class`; None if it has none."""
    # The class itself, not a subclass: its solvers know its parameters by heart.
    for kind, known in own.items():
        if known is described:
            return kind
    for kind in plugin_names(group, own):
        with suppress(PluginError):  # another package is broken; that does not concern this class
            if known_class("", group, base, own, kind) is described:
                return kind
    return None


def _words(error: BaseException) -> str:
    """Return the class and the message of an error on one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _failings(described: Any, base: type, own: Collection[type]) -> Iterator[str]:
    """Yield what a class of a plugin lacks, in words that follow its name in a message."""
    if not (isinstance(described, type) and issubclass(described, base)):
        yield f"must be a class that inherits {base.__name__}, not {shown(described)}"
        return
    if ours := [base.__name__ for base in described.__mro__ if base in own]:
        yield f"must inherit {base.__name__} itself, not {ours[0]}, which solvers treat as it is"
    # Python would refuse such a class only when it is made, in the middle of reading a scene.
    asked: frozenset[str] = getattr(described, "__abstractmethods__", frozenset())
    if asked:
        yield f"lacks {', '.join(sorted(asked))}"
    if not (is_dataclass(described) and described.__dataclass_params__.frozen):  # type: ignore[attr-defined]
        yield "must be a dataclass with frozen=True"
    for parent in described.__mro__[1:]:
        for name in getattr(parent, "__abstractmethods__", ()):
            if not _same_arguments(getattr(described, name), getattr(parent, name)):
                arguments = ", ".join(list(inspect.signature(getattr(parent, name)).parameters)[1:])
                yield f"must take the arguments ({arguments}) in {name}"


def _same_arguments(method: Any, asked: Any) -> bool:
    """Return whether a method can be called like the abstract one; values need not be methods."""
    if not callable(asked):
        return True
    try:
        inspect.signature(method).bind(*inspect.signature(asked).parameters)
    except TypeError:
        return False
    return True
