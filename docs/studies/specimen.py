"""Draw a supershear rupture between two plates of PMMA: field, front speed and strain records.

``python -m docs.studies.specimen docs/figures`` writes specimen.png.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import slipfront as sf
from compare.figures.saving import save_figure
from compare.figures.style import SMALL, cycle, describe, ink, new_figure, shade, styled

Array = NDArray[np.float64]

PLACES, HEIGHT = np.array([0.02, 0.04, 0.06]), 3.5e-3
"""Places of the gauges along the joint, and their height above it [m]."""
MOMENT, END = 36e-6, 120e-6
"""Times of the picture and of the end of the records [s]."""
SHEAR, ONSET = 2.1e6, 1.0
"""Shear that is taken off the slot [Pa], and slip rate at which the tip has come [m/s]."""
REACH, TICKS = 0.08, (0, 20, 40, 60, 80)
"""End of the joint that is shown [m], and ticks, at the gauges as well [mm]."""
WITHIN: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
AROUND = 8
"""Nodes on either side between which a front speed is taken: 4 mm."""


def plates() -> sf.Specimen:
    """Return the specimen of lesson 12."""
    named = sf.find_specimen("pmma-specimen")
    assert named is not None
    return replace(
        named,
        friction=sf.SlipWeakening(static=0.6, dynamic=0.2, distance=5e-6),
        base=sf.Tractions(5e6, SHEAR),
        load=sf.Tractions(0.0, SHEAR),
        gauges=[(x, HEIGHT) for x in PLACES],
    )


@styled
def specimen_figure(specimen: sf.Specimen) -> Figure:
    """Draw the fault-parallel velocity at one time, the front speed and the shear strain."""
    run = specimen.simulated(END, size=0.5e-3, samples=480, damping=0.0)
    figure = new_figure(5.5, 6.4)
    describe(figure, "two plates of PMMA, plane strain, ν = 0.336; f = 0.6 to 0.2 in 5 µm of slip")
    field, speed, strain = figure.subplots(3, 1, height_ratios=(1.15, 1, 1))
    _draw_field(field, specimen)
    _draw_speed(speed, specimen, run)
    _draw_strain(strain, specimen, run)
    return figure


def _draw_field(panel: Axes, specimen: sf.Specimen) -> None:
    x, y = np.meshgrid(np.linspace(0, 0.1, 101), np.linspace(1e-3, 0.04, 40))
    points = list(zip(x.ravel(), y.ravel(), strict=True))
    seen = replace(specimen, gauges=points).simulated(MOMENT, size=1e-3, samples=36).gauges
    assert seen is not None
    values = seen.velocity[-1, :, 0].reshape(x.shape)
    most = float(np.quantile(np.abs(values), 0.995))
    picture = panel.pcolormesh(
        1e3 * x, 1e3 * y, values, vmin=-most, vmax=most, cmap="RdBu_r", shading="gouraud"
    )
    panel.figure.colorbar(picture, ax=panel, label="$v_x$ [m/s]", extend="both", shrink=0.95)
    panel.plot(1e3 * PLACES, np.full(3, 1e3 * HEIGHT), "k+", label="gauges", clip_on=False)
    panel.annotate("Mach front", (40, 23), (44, 31), arrowprops={"arrowstyle": "->"})
    panel.legend(loc="upper right", fontsize=SMALL)
    panel.set(xlabel="x [mm]", ylabel="y [mm]", xticks=TICKS, xlim=(0, 1e3 * REACH))
    panel.set_title(f"velocity along the joint in the upper plate, t = {1e6 * MOMENT:.0f} µs")


def _draw_speed(panel: Axes, specimen: sf.Specimen, run: Any) -> None:
    solid = specimen.upper.material
    joint = np.flatnonzero((run.x > 0) & (run.x < REACH))
    x, begun = run.x[joint], [_onset(run.t, run.slip_rate[:, node]) for node in joint]
    between = (x[2 * AROUND :] - x[: -2 * AROUND]) / np.subtract(
        begun[2 * AROUND :], begun[: -2 * AROUND]
    )
    panel.plot(1e3 * x[AROUND:-AROUND], between / 1e3, color=cycle()[0])
    speeds = {"$c_t$": 1.0, r"$\sqrt{2}\,c_t$": np.sqrt(2), "$c_l$": None}
    for name, ratio in speeds.items():
        speed = solid.longitudinal_speed if ratio is None else ratio * solid.shear_speed
        panel.axhline(speed / 1e3, color=ink(0.65), linestyle="--", linewidth=0.8)
        panel.text(1e3 * REACH, speed / 1e3, f" {name}", va="center")
    panel.set(xlabel="x [mm]", ylabel="front speed [km/s]", xticks=TICKS, xlim=(0, 1e3 * REACH))
    panel.set_ylim(1.0, 1.05e-3 * solid.longitudinal_speed)


def _onset(t: Array, rate: Array) -> float:
    """Return the time at which a slip rate first exceeds that of the tip, between two samples."""
    after = int(np.argmax(rate > ONSET))
    return float(np.interp(ONSET, rate[after - 1 : after + 1], t[after - 1 : after + 1]))


def _draw_strain(panel: Axes, specimen: sf.Specimen, run: Any) -> None:
    felt, t = specimen.felt(PLACES), 1e6 * run.gauges.t
    for place, strain in zip(PLACES, run.gauges.strain[:, :, 2].T, strict=True):
        panel.plot(t, 1e6 * strain, label=f"x = {1e3 * place:.0f} mm", linewidth=1.2)
    panel.axvspan(1e6 * felt.min(), t[-1], color=shade("stick"), linewidth=0, zorder=0)
    panel.annotate("reflections", (1e6 * felt.min(), 0.04), (3, 0), fontsize=SMALL, **WITHIN)
    panel.set_title(f"shear strain $\\varepsilon_{{xy}}$, {1e3 * HEIGHT:g} mm above the joint")
    panel.set(xlabel="t [µs]", ylabel="[µstrain]", xlim=(0, t[-1]))
    panel.set_ylim(top=320)
    panel.legend(loc="upper right", fontsize=SMALL, ncols=3)


def main(folder: Path) -> None:
    """Write the figure."""
    save_figure(specimen_figure(plates()), folder / "specimen.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
