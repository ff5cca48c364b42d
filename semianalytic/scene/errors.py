"""Errors a user can cause or meet, each with the exit code the command line reports for it."""

from __future__ import annotations


class SlipfrontError(Exception):
    """Base of all errors whose message is one sentence saying what to change."""

    exit_code = 4


class SceneError(SlipfrontError, ValueError):
    """A scene, a parameter or an option is outside what the method or the law admits."""

    exit_code = 2


class TensionError(SceneError):
    """The contact pressure would turn tensile somewhere on the interface."""


class DataFileError(SlipfrontError):
    """A file (mesh, history, checkpoint, snapshot) is damaged, foreign or from another scene."""

    exit_code = 3


class ComputationError(SlipfrontError):
    """A computation failed: it went unstable or did not converge."""

    exit_code = 4


class PluginError(SlipfrontError):
    """A package that brings scenes, laws, histories or figures is broken, or one of two alike."""

    exit_code = 5


class MissingLibraryError(SlipfrontError, ImportError):
    """A package of an extra, or a system library that one needs, is not installed."""

    exit_code = 5
