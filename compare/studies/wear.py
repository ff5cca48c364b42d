"""A sweep that tests the article's last question: does lower friction increase transient wear?

It computes accumulated |slip| and frictional work along the interface after a step, a ramp and a
pulse of shear under constant pressure, against chi = f P_b / Q_0.  ``slipfront wear`` draws it, and
``python -m compare.studies.wear most --csv docs/data`` writes the frictions of largest wear.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from compare.figures.saving import save_figure
from compare.figures.style import cycle, describe, new_figure, styled
from compare.output.tables import write_rows
from compare.studies.tables import run_studies
from compare.tasks.workers import Progress, counted
from semianalytic import LoadHistory, Material, Pulse, Ramp, Scene, Step, Tractions, solve

LOADS: dict[str, LoadHistory] = {"step": Step(), "ramp": Ramp(0.5), "pulse": Pulse(0.4)}
POISSON_RATIOS = (1 / 3, 0.2)
LENGTH = 2.0
NODES = 600
SUMS = ("accumulated_slip", "frictional_work")


@dataclass(frozen=True)
class WearRow:
    """Wear after one transient, at t = 1 in units of a shear-wave travel time over length 1.

    Attributes
    ----------
    load : str
    poisson_ratio, chi : float
        chi = f P_b / Q_0.
    accumulated_slip : float
        int int |V| dt dx over V_0 c_t T^2, V_0 = 2 Q_0 / (rho c_t).
    frictional_work : float
        int int tau V dt dx over Q_0 V_0 c_t T^2.
    slipped_length : float
        Length of contact that has slipped, over c_t T.
    """

    load: str
    poisson_ratio: float
    chi: float
    accumulated_slip: float
    frictional_work: float
    slipped_length: float


def wear_after(load: str, poisson_ratio: float, chi: float, nodes: int) -> WearRow:
    """March one transient and sum its wear."""
    scene = Scene(
        Material(1.0, 1.0, poisson_ratio),
        chi,
        Tractions(1.0, 0.0),
        Tractions(0.0, 1.0),
        shear_history=LOADS[load],
    )
    marched = solve(
        scene,
        method="space-time",
        end_time=1.0,
        nodes=nodes,
        length=LENGTH,
        every=10**9,
        companion=False,
    )
    spacing, scale = marched.grid.spacing, 2 / scene.material.shear_impedance
    return WearRow(
        load,
        poisson_ratio,
        chi,
        float(marched.final_path.sum() * spacing) / scale,
        float(marched.final_work_density.sum() * spacing) / scale,
        float(np.count_nonzero(marched.final_path > 1e-6 * scale) * spacing),
    )


def swept_rows(chis: Sequence[float], nodes: int) -> Iterator[WearRow]:
    """Yield the wear of all loads and Poisson ratios over friction."""
    for poisson_ratio, load, chi in product(POISSON_RATIOS, LOADS, chis):
        yield wear_after(load, poisson_ratio, float(chi), nodes)


def frictions(count: int) -> list[float]:
    """Return zero friction, and `count` values from 0.01 to 2."""
    return [0.0, *np.geomspace(0.01, 2.0, count).tolist()]


def write_wear(
    output: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
) -> list[WearRow]:
    """Sweep friction, coarsely if `quick`; write wear.csv and wear.png into a folder.

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """
    output.mkdir(parents=True, exist_ok=True)
    chis = frictions(12 if quick else 40)
    count = len(chis) * len(LOADS) * len(POISSON_RATIOS)
    rows = list(counted(swept_rows(chis, 150 if quick else NODES), count, progress))
    write_rows(output / "wear.csv", rows)
    save_figure(sweep_figure(rows), output / f"wear.{form}")
    return rows


def _part(rows: Sequence[WearRow], load: str, poisson_ratio: float) -> list[WearRow]:
    return [row for row in rows if (row.load, row.poisson_ratio) == (load, poisson_ratio)]


def most_wear(rows: Sequence[WearRow], load: str, poisson_ratio: float) -> tuple[float, float]:
    """Return the chi of largest frictional work, and that work, for one load."""
    worst = max(_part(rows, load, poisson_ratio), key=lambda row: row.frictional_work)
    return worst.chi, worst.frictional_work


@styled
def sweep_figure(rows: Sequence[WearRow]) -> Figure:
    """Draw accumulated |slip| above, frictional work below, against chi."""
    figure = new_figure(7, 6.7)
    words = "shear Q₀ under constant pressure $P_b$ until T,  f = χ Q₀/$P_b$,  V₀ = 2 Q₀/ρcₜ"
    describe(figure, words)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for poisson_ratio, style in zip(POISSON_RATIOS, ("-", "--"), strict=True):
        for load, colour in zip(LOADS, cycle(), strict=False):
            part = _part(rows, load, poisson_ratio)
            chi, label = [row.chi for row in part], rf"{load}, $\nu$ = {poisson_ratio:.2g}"
            slip, work = ([getattr(row, name) for row in part] for name in SUMS)
            upper.plot(chi, slip, style, color=colour, label=label)
            lower.plot(chi, work, style, color=colour)
    upper.set_ylabel(r"$\int\!\!\int |V|\,dt\,dx\ /\ V_0 c_t T^2$")
    lower.set_ylabel(r"frictional work $/\ Q_0 V_0 c_t T^2$")
    lower.set(xlabel=r"$\chi = f P_b / Q_0$", xlim=(0, 2))
    upper.legend(ncols=2)
    for panel in (upper, lower):
        panel.set_ylim(bottom=0)
    return figure


@dataclass(frozen=True)
class MostRow:
    """Friction at which a load causes the largest frictional work, and that work."""

    load: str
    poisson_ratio: float
    chi: float
    frictional_work: float


def most_of(rows: Sequence[WearRow]) -> list[MostRow]:
    """Return `most_wear` of all loads and Poisson ratios."""
    return [
        MostRow(load, nu, *most_wear(rows, load, nu)) for nu in POISSON_RATIOS for load in LOADS
    ]


def most_rows() -> list[MostRow]:
    """Sweep all loads and Poisson ratios finely, and return their `most_wear`."""
    return most_of(list(swept_rows(frictions(40), NODES)))


if __name__ == "__main__":
    raise SystemExit(run_studies("compare.studies.wear", "wear", {"most": most_rows}))
