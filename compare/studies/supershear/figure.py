"""Figure of rupture styles: the speed of the front over S and distance, and the transition."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from compare.figures.style import BLACK, SMALL, describe, new_figure, outline, styled
from compare.studies.supershear.points import SOLID, RupturePoint, TransitionPoint

_SLOWEST = 0.5  # c_t


@styled
def rupture_figure(
    points: Sequence[RupturePoint], transitions: Sequence[TransitionPoint]
) -> Figure:
    """Draw the speed of rupture fronts over S and distance, with the transition as a curve."""
    figure = new_figure(7, 5)
    describe(
        figure,
        "speed of spontaneous ruptures whose friction falls linearly with slip (in-plane, ν = 1/4)",
    )
    panel = figure.subplots()
    x = np.unique([point.strength for point in points])
    y = np.unique([point.distance for point in points])
    speeds = np.array([point.speed for point in points]).reshape(len(x), len(y)).T
    mesh = panel.pcolormesh(
        x,
        y,
        speeds,
        vmin=_SLOWEST,
        vmax=SOLID.longitudinal_speed,
        cmap="viridis",
        shading="nearest",
        rasterized=True,
    )
    figure.colorbar(mesh, ax=panel).set_label("speed of the front / $c_t$")
    panel.plot(
        [one.strength for one in transitions],
        [one.transition for one in transitions],
        "o-",
        color=BLACK,
        ms=3,
        label="overtakes shear waves",
        path_effects=outline(),
    )
    panel.set(
        ylim=(0, y[-1] + y[0]),
        xlabel="$S$ = (peak strength $-$ shear) / (shear $-$ dynamic strength)",
        ylabel="distance from the centre / $L_c$",
    )
    for text, place in (("supershear", (0.28, 0.75)), ("sub-Rayleigh", (0.8, 0.15))):
        panel.text(
            *place,
            text,
            transform=panel.transAxes,
            ha="center",
            fontsize=SMALL,
            path_effects=outline(),
        )
    panel.legend(loc="upper right", fontsize=SMALL)
    return figure
