"""Errors that users may meet, each with the exit code that the command line reports for it."""

from __future__ import annotations


class SlipfrontError(Exception):
    """Base class of all errors of this package; the message, one sentence, states what to change.

    Examples
    --------
    >>> from semianalytic import SlipfrontError, find
    >>> try:
    ...     find("preloadde")
    ... except SlipfrontError as error:
    ...     print(error)
    There is no scene called 'preloadde'; did you mean preloaded? (or give a .toml file).
    """

    exit_code = 4


class SceneError(SlipfrontError, ValueError):
    """A scene, a parameter or an option is outside the range of the method or the friction law."""

    exit_code = 2


class TensionError(SceneError):
    """The contact pressure would turn tensile somewhere on the interface."""


class DataFileError(SlipfrontError):
    """A file (mesh, history, checkpoint, snapshot) is damaged, foreign or from another scene."""

    exit_code = 3


class ComputationError(SlipfrontError):
    """A computation failed: it became unstable or did not converge."""

    exit_code = 4


class PluginError(SlipfrontError):
    """A package with scenes, laws, histories or figures is broken, or two have the same name."""

    exit_code = 5


class MissingLibraryError(SlipfrontError, ImportError):
    """A package of an optional extra, or a system library it needs, is not installed."""

    exit_code = 5
