"""The preloaded scene by both methods, which most comparisons begin with."""

import pytest
from catalogue import solved
from compare_cases import simulated

from semianalytic.scene.given.finding import find_scene


@pytest.fixture(scope="session")
def solution():
    """The exact answer to the preloaded scene."""
    return solved(find_scene("preloaded"))


@pytest.fixture(scope="session")
def coarse():
    """A finite-element run of the preloaded scene, with its companions."""
    return simulated(find_scene("preloaded"), 60)
