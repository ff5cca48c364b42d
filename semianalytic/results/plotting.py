"""An answer as a picture: slip rate and tractions over x at one time."""

from __future__ import annotations

from typing import Any

import numpy as np

from semianalytic.scene.extras import needing
from semianalytic.scene.friction import CoulombFriction
from semianalytic.scene.units import SI

_POINTS = 800
_TALLEST = 2.0
"""Largest slip rate drawn, over the one that a hundredth of the points exceed."""
_SHOWN = {"length": (1e3, "mm"), "time": (1e6, "µs"), "stress": (1e-6, "MPa")}
"""Sizes and names of the units in which scenes in those of the SI are drawn."""


def drawn(answer: Any, ax: Any, t: float | None) -> Any:
    """Draw an answer; `Gridded.plot` describes it."""
    with needing("plot"):
        from matplotlib import pyplot
    end = getattr(answer, "end_time", 1 / answer.scene.material.shear_speed) if t is None else t
    nodes = getattr(getattr(answer, "interface", None), "x", None)
    waves = _waves(answer)
    reach = 1.05 * max(waves.values()) * end if nodes is None else nodes[-1]
    moving = (*answer.zones_at(end), *answer.openings_at(end))
    # on a whole line slip spreads to both sides
    start = -reach if any(part.start < 0 for part in moving) else 0.0
    x = np.linspace(start, reach, _POINTS + 1)[1:]
    axes = ax if ax is not None else pyplot.subplots(2, sharex=True, layout="constrained")[1]
    si = answer.scene.units == SI
    length, time, stress = (_SHOWN[one] if si else (1.0, one) for one in _SHOWN)
    upper = axes if ax is not None else axes[0]
    rate = answer.slip_rate(x, end)
    finite = np.abs(rate[np.isfinite(rate)])
    tallest = max(
        _TALLEST * np.quantile(finite, 0.99), finite.min()
    )  # it may be infinite at points
    upper.plot(x * length[0], np.where(np.abs(rate) <= tallest, rate, np.nan))
    upper.set_ylabel("slip rate" + (" [m/s]" if si else ""))
    upper.set_title(f"t = {end * time[0]:.4g}" + (f" {time[1]}" if si else ""), loc="left")
    if ax is None:
        for name in ("shear_traction", "pressure"):
            values = stress[0] * getattr(answer, name)(x, end)
            axes[1].plot(x * length[0], values, label=name.replace("_", " "))
        if type(getattr(answer.scene, "friction_law", CoulombFriction())) is CoulombFriction:
            strength = answer.scene.friction * values
            axes[1].plot(x * length[0], strength, ":", color="0.3", label="strength f p")
        axes[1].set_ylabel("traction" + (f" [{stress[1]}]" if si else ""))
        axes[1].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
    for name, speed in waves.items():
        place = speed * end * length[0]
        for at in (place, -place) if speed * end < reach else ():
            if at < start:
                continue
            for one in np.atleast_1d(axes):
                one.axvline(at, color="0.7", lw=0.8)
        if speed * end < reach:
            above = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
            side = "right" if "R" in name else "left"  # c_R is close to c_t
            upper.annotate(name, (place, 1), xytext=(0, 3), ha=side, **above)
    np.atleast_1d(axes)[-1].set_xlabel("x" + (f" [{length[1]}]" if si else ""))
    return axes


def _waves(answer: Any) -> dict[str, float]:
    """Return the speeds of waves by symbol, with a prime those of a lower body of another kind."""
    lower = getattr(answer.scene, "lower_material", None)  # whole lines have equal bodies
    bodies = {"": answer.scene.material} | ({"'": lower} if lower else {})
    return {
        f"$c_{name}{of}$": getattr(body, f"{wave}_speed")
        for of, body in bodies.items()
        for name, wave in (("R", "rayleigh"), ("t", "shear"), ("l", "longitudinal"))
    }
