"""Field snapshots of both bodies: exact, simulated, and their difference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import KDTree

from compare.comparison.fields.errors import FieldErrors
from compare.comparison.fields.frames import Places
from compare.comparison.scales import slip_rate_scale
from compare.figures.style import (
    BLACK,
    PLACE_LABEL,
    describe,
    new_figure,
    outline,
    scene_words,
    styled,
)

if TYPE_CHECKING:
    from fem import Simulation

HEIGHT_LABEL = r"$y/(c_t T)$"
SPEED_LABEL = r"particle speed $|v|\ /\ V_0$"
DIFFERENCE_LABEL = r"difference of $|v|\ /\ V_0$"
PIXELS = 500
"""Pixels of a picture along each axis; an even number keeps pixels off y = 0."""
COVERED = 0.995
"""Fraction of a picture within the range of colours; speeds are infinite at some points."""


@styled
def snapshot_figure(errors: FieldErrors, simulation: Simulation) -> Figure:
    """Draw the particle speed in both bodies in the last frame: exact, simulated, difference."""
    scene = simulation.scene
    length = scene.material.shear_speed * simulation.end_time
    pairs = [pair for name, pair in errors.last.items() if name.startswith("v_")]
    side = float(pairs[0].places.y.max()) / length
    shown = _nearest(pairs[0].places, side * length)
    exact, seen = (
        np.linalg.norm(parts, axis=0)[shown] / slip_rate_scale(scene)
        for parts in ([pair.predicted for pair in pairs], [pair.simulated for pair in pairs])
    )
    top = float(np.quantile(exact, COVERED)) or 1.0
    most = float(np.quantile(np.abs(seen - exact), COVERED)) or 1.0
    figure = describe(new_figure(11, 3.9), scene_words(scene))
    mesh = f"finite elements, h = {simulation.element_size / length:.3g} $c_t T$"
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    for panel, title, values, low, high, colours in (
        (panels[0], "semi-analytic", exact, 0.0, top, "viridis"),
        (panels[1], mesh, seen, 0.0, top, "viridis"),
        (panels[2], "finite elements − semi-analytic", seen - exact, -most, most, "RdBu_r"),
    ):
        image = panel.imshow(
            values,
            extent=(-side, side, -side, side),
            origin="lower",
            cmap=colours,
            vmin=low,
            vmax=high,
            interpolation="nearest",
        )
        panel.plot(
            [0, side], [0, 0], color=BLACK, linewidth=0.6, path_effects=outline("white", 1.4)
        )
        panel.plot([-side, 0], [0, 0], color=BLACK, linewidth=1.2, path_effects=outline())
        panel.set(title=title, xlabel=PLACE_LABEL)
        if panel is not panels[0]:
            label = SPEED_LABEL if panel is panels[1] else DIFFERENCE_LABEL
            beside = panels[:2] if panel is panels[1] else panel
            figure.colorbar(
                image,
                ax=beside,
                label=label,
                shrink=0.8,
                extend="max" if panel is panels[1] else "both",
            )
    panels[0].set_ylabel(HEIGHT_LABEL)
    return figure


def _nearest(places: Places, reach: float) -> NDArray[np.int64]:
    """Return the nearest place in the same body for each pixel of a square about the edge."""
    middle = reach * (2 * np.arange(PIXELS) + 1 - PIXELS) / PIXELS
    apart = np.copysign(1e-6 * reach / PIXELS, places.y)  # separates the two faces
    tree = KDTree(np.stack([places.x, places.y + apart], axis=1))
    x, y = np.meshgrid(middle, middle)
    return np.asarray(tree.query(np.stack([x, y], axis=-1))[1])
