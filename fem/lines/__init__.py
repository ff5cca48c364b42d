"""Finite elements of a periodic interface: contacts, fields along x, any friction, two bodies."""

from fem.lines.line import Line
from fem.lines.march import LineSimulation, simulate_line

__all__ = ["Line", "LineSimulation", "simulate_line"]
