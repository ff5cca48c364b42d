"""Finite-element simulation of a loaded slot: scikit-fem blocks, contact without a penalty."""

from semianalytic.scene.extras import needing

with needing("the finite-element model"):
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
