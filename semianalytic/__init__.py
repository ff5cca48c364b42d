"""Slip on a frictional interface after a sudden load: the semi-analytic Wiener-Hopf solver."""

from semianalytic.errors import (
    ComputationError,
    DataFileError,
    MissingLibraryError,
    SceneError,
    SlipfrontError,
    TensionError,
)
from semianalytic.history import InterfaceHistory
from semianalytic.scene import Material, Scene, Tractions
from semianalytic.solution import SlipZone, Solution, Statistics
from semianalytic.solver import solve

__all__ = [
    "ComputationError",
    "DataFileError",
    "InterfaceHistory",
    "Material",
    "MissingLibraryError",
    "Scene",
    "SceneError",
    "SlipZone",
    "SlipfrontError",
    "Solution",
    "Statistics",
    "TensionError",
    "Tractions",
    "solve",
]
