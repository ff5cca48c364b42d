"""Compare constant, rate-weakening and slip-weakening friction under a ramp; refuse a wrong law.

``python -m docs.examples.friction_law [FOLDER]`` writes friction_law.csv and .png.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look

MATERIAL = sf.Material(1.0, 1.0, 1 / 3)
LOAD = sf.Tractions(0.0, 1.0)
SCENE = sf.Scene(MATERIAL, 0.3, sf.Tractions(1.0, 0.0), LOAD, shear_history=sf.Ramp(0.5))
LAWS = (sf.Coulomb(0.3), sf.RateWeakening(0.3, 0.18, 1.0), sf.SlipWeakening(0.3, 0.12, 0.05))


@look()
def main(folder: Path = Path(".")) -> list[float]:
    """Write the final slip along the interface for each law; return the largest slip of each."""
    marches = [
        sf.solve(replace(SCENE, friction=law), method="space-time", nodes=400) for law in LAWS
    ]
    slips = [marched.interface.slip[-1] for marched in marches]
    x, names = marches[0].interface.x, [type(law).__name__ for law in LAWS]
    head = ",".join(["x", *names])
    table = np.column_stack([x, *slips])
    np.savetxt(folder / "friction_law.csv", table, delimiter=",", header=head, comments="")
    figure = describe(Figure(figsize=(6, 3.4), layout="constrained"), SCENE)
    axes = figure.subplots()
    words = ("constant", "falls with slip rate", "falls with slip")
    for name, slip, style in zip(words, slips, ("-", "--", ":"), strict=True):
        axes.plot(x, slip, style, label=f"friction {name}")
    axes.set(xlabel="$x / (c_t T)$", ylabel="slip at T", xlim=(0, 1.2), ylim=(0, None))
    axes.legend()
    figure.savefig(folder / "friction_law.png", dpi=100)
    try:
        replace(SCENE, friction=sf.RateWeakening(0.3, 0.03, 0.1))
    except sf.SceneError as error:
        refused = str(error).split(";")[0]
    largest = [float(slip.max()) for slip in slips]
    shown = ", ".join(f"{slip:.4f}" for slip in largest)
    print(f"largest slip {shown}; reduction 0.9 at rate 0.1 refused: {refused}")
    return largest


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
