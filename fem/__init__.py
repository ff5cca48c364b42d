"""Finite-element simulation of a loaded slot: scikit-fem blocks, contact without a penalty."""

from fem.budget import Cost, cost
from fem.results import EnergyHistory, Simulation, SlotHistory, load_simulation
from fem.run import simulate

__all__ = [
    "Cost",
    "EnergyHistory",
    "Simulation",
    "SlotHistory",
    "cost",
    "load_simulation",
    "simulate",
]
