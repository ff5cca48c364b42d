"""Finite-element simulation of a loaded slot: scikit-fem blocks, contact without a penalty."""

import logging

from semianalytic.scene.extras import needing

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

with needing("the finite-element model"):
    from fem.budget import Cost, cost
    from fem.companions import with_companions
    from fem.interface import BACKWARD, FORWARD, OPEN, STICK
    from fem.model import Model, prepare
    from fem.results import (
        EnergyHistory,
        Opening,
        Simulation,
        SlotHistory,
        load_simulation,
        opening_sentence,
    )
    from fem.run import simulate
    from fem.settings import Settings

__all__ = [
    "BACKWARD",
    "FORWARD",
    "OPEN",
    "STICK",
    "Cost",
    "EnergyHistory",
    "Model",
    "Opening",
    "Settings",
    "Simulation",
    "SlotHistory",
    "cost",
    "load_simulation",
    "opening_sentence",
    "prepare",
    "simulate",
    "with_companions",
]
