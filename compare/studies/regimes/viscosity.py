"""Slip of a preloaded interface over viscosity and friction, and the closing of its stick gap.

``python -m compare.studies.regimes.viscosity FOLDER`` draws the map, regimes_viscosity.png.  The
unit of viscosity is rho c_t / 2.  `viscous_closing` gives the friction below which slip covers
c_R; a map of solved scenes checks it.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.figures.saving import save_figure
from compare.figures.style import (
    BLACK,
    PURPLE,
    REGIME_COLOURS,
    cycle,
    describe,
    new_figure,
    outline,
    styled,
)
from compare.studies.regimes.figures import CHI, FRICTION
from compare.studies.regimes.points import REGIMES
from semianalytic import ViscousFriction, solve
from semianalytic.regimes import (
    closing_limit,
    regime,
    scene_of,
    viscous_closing,
    viscous_nucleation,
)

MAP_POISSON_RATIO = 1 / 3
POISSON_RATIOS = (-0.2, 0.0, 0.2, 1 / 3, 0.45)
DECADES, MOST_FRICTION = (-6.0, 2.0), 0.4
MAP_SIZE, CURVE_SIZE = 32, 41
RTOL = 1e-6


@dataclass(frozen=True)
class ViscosityRow:
    """Frictions of a preload below which the shear front slips and below which slip covers c_R.

    The second is nan if slip never covers c_R; viscosity is over rho c_t / 2.
    """

    poisson_ratio: float
    viscosity: float
    nucleation: float
    closing: float


def viscosity_row(poisson_ratio: float, viscosity: float) -> ViscosityRow:
    """Compute both thresholds."""
    closing = viscous_closing(poisson_ratio, viscosity)
    nucleation = viscous_nucleation(poisson_ratio, viscosity)
    return ViscosityRow(
        poisson_ratio, viscosity, nucleation, np.nan if closing is None else closing
    )


def viscosity_rows() -> list[ViscosityRow]:
    """Compute the table of docs/rate.md."""
    viscosities = (1e-4, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0)
    return [viscosity_row(nu, one) for nu in (0.0, 1 / 3, 0.45) for one in viscosities]


def solved_regime(viscosity: float, chi: float) -> str:
    """Return the regime of one scene of the map, by the solver."""
    scene = scene_of("preload", MAP_POISSON_RATIO, chi)
    law = ViscousFriction(viscosity * scene.material.shear_impedance / 2)
    return regime(solve(replace(scene, friction_law=law), rtol=RTOL))


def solved_regimes(size: int) -> list[list[str]]:
    """Return the regimes of the map at the centres of cells, a list per friction."""
    middles = (np.arange(size) + 0.5) / size
    viscosities = 10 ** (DECADES[0] + (DECADES[1] - DECADES[0]) * middles)
    return [
        [solved_regime(float(one), float(chi)) for one in viscosities]
        for chi in MOST_FRICTION * middles
    ]


def viscosity_curves(count: int) -> dict[float, list[ViscosityRow]]:
    """Compute thresholds over viscosity for all Poisson ratios of the figure."""
    viscosities = np.logspace(*DECADES, count).tolist()
    return {nu: [viscosity_row(nu, one) for one in viscosities] for nu in POISSON_RATIOS}


@styled
def viscosity_figure(
    regimes: Sequence[Sequence[str]], curves: Mapping[float, Sequence[ViscosityRow]]
) -> Figure:
    """Draw the map with its thresholds, and where the gap closes at several Poisson ratios."""
    figure = describe(new_figure(11, 5.0), FRICTION["preload"])
    left, right = figure.subplots(1, 2)
    names = list(REGIMES)
    borders = np.linspace(0, 1, len(regimes) + 1)
    left.pcolormesh(
        10 ** (DECADES[0] + (DECADES[1] - DECADES[0]) * borders),
        MOST_FRICTION * borders,
        [[names.index(name) for name in row] for row in regimes],
        cmap=ListedColormap([REGIME_COLOURS[name] for name in names]),
        norm=BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names)),
        rasterized=True,
    )
    rows = curves[MAP_POISSON_RATIO]
    for name, line, colour in (("nucleation", "--", PURPLE), ("closing", "-", BLACK)):
        x, y = zip(*((row.viscosity, getattr(row, name)) for row in rows), strict=True)
        left.plot(x, y, line, color=colour, path_effects=outline())
    labels = {
        "slow": REGIMES["slow"],
        "two": REGIMES["two"],
        "one": "one zone across $c_R$",
        "failed": REGIMES["failed"],
    }
    present = {name for row in regimes for name in row}
    patches = [
        Patch(color=REGIME_COLOURS[name], label=labels[name]) for name in labels if name in present
    ]
    left.legend(handles=patches, loc="upper right")
    left.set_title(rf"$\nu = {MAP_POISSON_RATIO:.3g}$")
    for (nu, rows), colour in zip(curves.items(), cycle(), strict=False):
        viscosities, closing = zip(*((row.viscosity, row.closing) for row in rows), strict=True)
        right.plot(viscosities, closing, color=colour, label=rf"$\nu = {nu:.3g}$")
        right.axhline(closing_limit(nu), linestyle=":", color=colour, linewidth=1)
    right.set_title("slip covers $c_R$ below; dotted: $q^*(c)$")
    right.legend()
    for panel in (left, right):
        panel.set(xscale="log", xlim=[10**end for end in DECADES], ylim=(0, MOST_FRICTION))
        panel.set(xlabel=r"viscosity $/\ (\rho c_t / 2)$", ylabel=CHI["preload"])
    return figure


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/regimes")
    folder.mkdir(parents=True, exist_ok=True)
    figure = viscosity_figure(solved_regimes(MAP_SIZE), viscosity_curves(CURVE_SIZE))
    save_figure(figure, folder / "regimes_viscosity.png")
