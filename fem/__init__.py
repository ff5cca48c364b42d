"""Finite-element simulation of the sudden load: scikit-fem blocks, exact Coulomb contact."""

from fem.results import EnergyHistory, Simulation, SlotHistory, load_simulation
from fem.run import simulate

__all__ = ["EnergyHistory", "Simulation", "SlotHistory", "load_simulation", "simulate"]
