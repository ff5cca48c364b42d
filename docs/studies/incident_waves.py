"""Draw P and SV waves that arrive at 30 degrees, and map what slips first over angle and friction.

``python -m docs.studies.incident_waves docs/figures`` writes incident_waves.png.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from textwrap import fill

import numpy as np
import scipy
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.fields import draw_front, draw_interface
from compare.figures.fronts import fronts
from compare.figures.style import look

SOLID, BASE = sf.Material(1.0, 1.0, 0.25), sf.Tractions(pressure=1.0, shear=0.0)
WAVES = (sf.IncidentWave("P", -30.0, stress=1.0), sf.IncidentWave("SV", -30.0, stress=0.4))
FRICTION, TIME, FAR = 0.2, 1.0, 2.1
ANGLES, FRICTIONS = np.linspace(-80, 80, 321), np.linspace(0.0, 1.0, 201)
STEPS = (8, 4, 2, 1)
"""Every which of these angles and frictions is solved, as far as states differ in between."""
STATES = (
    "sticks",
    "edge slips",
    "edge and shear front",
    "opens at the edge",
    "no self-similar answer",
)


def state(wave: sf.IncidentWave, friction: float) -> int:
    """Return which of `STATES` follows a wave."""
    try:
        solution = sf.solve(sf.Scene(SOLID, friction, BASE, wave), rtol=1e-4)
    except sf.SceneError:  # it slips ahead of everything, or comes too slowly along the slot
        return 4
    if solution.openings:
        return 3
    zones = solution.zones
    return 0 if not zones else 2 if zones[-1].outer > SOLID.rayleigh_speed else 1


def maps() -> Iterator[np.ndarray]:
    """Yield the states (frictions, angles) of both kinds of waves.

    A scene among neighbours of one state is of this state; all others are solved.
    """
    for kind, stress in (("P", 1.0), ("SV", 0.3)):
        waves = [sf.IncidentWave(kind, float(angle), stress=stress) for angle in ANGLES]
        states = np.full((FRICTIONS.size, ANGLES.size), -1)
        for step in STEPS:
            part = states[::step, ::step]
            most = scipy.ndimage.maximum_filter(part, 3, mode="nearest")
            least = -scipy.ndimage.maximum_filter(np.where(part < 0, -9, -part), 3, mode="nearest")
            alike = (part < 0) & (most == least)
            part[alike] = most[alike]
            for row, column in np.argwhere(part < 0):
                part[row, column] = state(waves[column * step], float(FRICTIONS[row * step]))
        yield states


@look()
def main(folder: Path) -> None:
    """Draw both waves and both maps."""
    figure = Figure(figsize=(9.6, 8.8), layout="constrained")
    words = (
        "ν = 1/4, base pressure p, stress p (P) and 0.4 p above, 0.3 p below (SV), f = 0.2 above"
    )
    figure.suptitle(words, fontsize=10)
    above, below = figure.subplots(2, 2, height_ratios=(1.25, 1))
    middles = (np.arange(300) + 0.5) / 150 * FAR - FAR
    x, y = np.meshgrid(middles, middles)
    solutions = [sf.solve(sf.Scene(SOLID, FRICTION, BASE, wave)) for wave in WAVES]
    for panel, solution, wave in zip(above, solutions, WAVES, strict=True):
        speed = np.hypot(*solution.velocity(x, y, TIME))
        most = float(np.quantile(speed[np.isfinite(speed)], 0.995))
        window = (-FAR, FAR, -FAR, FAR)
        shown = np.minimum(speed, most)
        image = panel.imshow(shown, extent=window, origin="lower", cmap="viridis", vmin=0)
        label = "particle speed / (p / ρ c_t)"
        figure.colorbar(image, ax=panel, label=label, shrink=0.8, extend="max")
        for front in fronts(solution, TIME):
            draw_front(panel, front, (-FAR, FAR, -FAR, 0.92 * FAR), "white", "black")
        handles = draw_interface(panel, solution, TIME)
        panel.set(xlim=(-FAR, FAR), ylim=(-FAR, FAR), xlabel="x / c_t t", ylabel="y / c_t t")
        panel.set_title(f"{wave.kind} wave from below at {-wave.angle:.0f}°")
        panel.legend(handles=handles, loc="lower left", fontsize="small")
    for panel, states, kind in zip(below, maps(), ("P wave", "SV wave"), strict=True):
        image = panel.pcolormesh(ANGLES, FRICTIONS, states, vmin=-0.5, vmax=4.5, cmap="Set2")
        image.set_cmap(image.get_cmap().resampled(5))
        panel.set(xlabel="angle of incidence [degrees]", ylabel="friction")
        panel.set_title(f"{kind}: what slips first")
        bar = figure.colorbar(image, ax=panel, ticks=range(5), location="bottom", aspect=40)
        bar.ax.set_xticklabels([fill(state, 9) for state in STATES], fontsize=8)
    figure.savefig(folder / "incident_waves.png", dpi=120)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
