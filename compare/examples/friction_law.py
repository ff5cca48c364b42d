"""Constant, rate-weakening and slip-weakening friction under one ramp, and a refused law.

``python -m compare.examples.friction_law [FOLDER]`` writes friction_law.csv.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from semianalytic import (
    CoulombFriction,
    Material,
    Ramp,
    RateWeakening,
    Scene,
    SceneError,
    SlipWeakening,
    Tractions,
    march,
)

MATERIAL = Material(1.0, 1.0, 1 / 3)
SCENE = Scene(MATERIAL, 0.3, Tractions(1.0, 0.0), Tractions(0.0, 1.0), shear_history=Ramp(0.5))
LAWS = (CoulombFriction(), RateWeakening(0.4, 1.0), SlipWeakening(0.6, 0.05))


def main(folder: Path = Path(".")) -> list[float]:
    """Write slip at the end along the interface by law; return the largest slip of each."""
    marches = [march(replace(SCENE, friction_law=law), nodes=400) for law in LAWS]
    slips = [marched.interface.slip[-1] for marched in marches]
    table = np.column_stack([marches[0].grid.x, *slips])
    head = "x," + ",".join(type(law).__name__ for law in LAWS)
    np.savetxt(folder / "friction_law.csv", table, delimiter=",", header=head, comments="")
    try:
        replace(SCENE, friction_law=RateWeakening(0.9, 0.1))
    except SceneError as error:
        refused = str(error).split(";")[0]
    largest = [float(slip.max()) for slip in slips]
    shown = ", ".join(f"{slip:.4f}" for slip in largest)
    print(f"largest slip {shown}; reduction 0.9 at rate 0.1 refused: {refused}")
    return largest


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
