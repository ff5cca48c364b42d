"""Draw where the error of a march sits: docs/figures/march-sites.png.

``python -m docs.studies.accuracy.march_sites`` compares marches of 512 nodes under loads that jump
or turn with marches of 2,048.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.figures.saving import figure_png
from compare.figures.style import look
from semianalytic import Scene, SlipWeakening, march
from semianalytic.results.files import write_bytes
from semianalytic.scene.named import NAMED_SCENES

Array = NDArray[np.float64]

PICTURE = Path(__file__).resolve().parents[2] / "figures" / "march-sites.png"
NODES, FINER = 512, 4
_PRELOADED = NAMED_SCENES["preloaded"].scene
SCENES: dict[str, Scene] = {
    "pulse": NAMED_SCENES["pulse"].scene,
    "harmonic": NAMED_SCENES["harmonic"].scene,
    "slip weakening": replace(_PRELOADED, friction_law=SlipWeakening(0.5, 0.2)),
}


def errors(scene: Scene, nodes: int = NODES) -> tuple[Array, Array, Array]:
    """Return positions (n,), times (m,) and |error| of the slip rate over its mean (m, n)."""
    coarse = march(scene, nodes=nodes, companion=False)
    fine = march(scene, nodes=FINER * nodes, every=FINER, companion=False)
    x, t = coarse.interface.x, coarse.interface.t
    exact = fine.slip_rate(x, t[:, None])
    off = np.abs(coarse.interface.slip_rate - exact)
    return x, t, off / np.abs(exact).mean()


@look()
def sites_figure() -> Figure:
    """Draw the errors over place and time."""
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    for axes, (name, scene) in zip(figure.subplots(1, len(SCENES)), SCENES.items(), strict=True):
        x, t, off = errors(scene)
        shown = axes.pcolormesh(
            x, t, np.maximum(off, 1e-5), norm=LogNorm(1e-4, 1.0), rasterized=True
        )
        for speed in (scene.material.rayleigh_speed, 1.0, scene.material.longitudinal_speed):
            axes.plot(speed * t, t, color="white", linewidth=0.4, linestyle="--")
        axes.set(xlim=(0, x[-1]), title=name, xlabel="x / (c_t T)")
    figure.axes[0].set_ylabel("t / T")
    figure.colorbar(shown, ax=figure.axes, label="|error| / mean slip rate")
    return figure


if __name__ == "__main__":
    write_bytes(PICTURE, figure_png(sites_figure()))
