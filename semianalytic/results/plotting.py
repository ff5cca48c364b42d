"""An answer as a picture: slip rate and tractions over x at one time, or over x and t."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.files import new_file
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import needing
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
    history = getattr(answer, "interface", None)
    if t is None and history is not None:
        return _map(answer, history, ax or pyplot.subplots(layout="constrained")[1])
    axes = ax if ax is not None else pyplot.subplots(2, sharex=True, layout="constrained")[1]
    _profile(answer, axes, _end(answer) if t is None else t)
    return axes


def animated(answer: Any, path: str | PathLike[str], times: ArrayLike | None) -> None:
    """Write the profiles of an answer at several times; `Gridded.animate` describes it."""
    with needing("plot"):
        from matplotlib import pyplot
        from matplotlib.animation import PillowWriter
    path, end = Path(path), _end(answer)
    if path.suffix != ".gif":
        raise SceneError(f"animate: path must end with .gif, got {path.name}.")
    shown = np.linspace(end / 40, end, 40) if times is None else np.atleast_1d(times)
    figure, axes = pyplot.subplots(2, sharex=True, layout="constrained")
    limits = _profile(answer, axes, float(np.max(shown)))

    def show(t: float) -> None:
        for one in axes:
            one.clear()
        _profile(answer, axes, t, limits)

    try:
        with new_file(path, suffix=path.suffix) as part:
            write_frames(part, figure, show, shown.tolist(), PillowWriter(fps=10))
    finally:
        pyplot.close(figure)


def write_frames(
    path: Path,
    figure: Any,
    show: Callable[[float], object],
    times: Sequence[float],
    writer: Any,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Write a figure at several times as an animation.

    `show` draws a time, `writer` is one of matplotlib, and `progress` is called with (frame,
    frames) after each.
    """
    writer.setup(figure, path, dpi=100)
    for number, time in enumerate(times, start=1):
        show(time)
        writer.grab_frame()
        if progress is not None:
            progress(number, len(times))
    writer.finish()


def _end(answer: Any) -> float:
    """Return the last time of an answer, of an exact one that at which c_t t is 1."""
    return float(getattr(answer, "end_time", 1 / answer.scene.material.shear_speed))


def _units(answer: Any) -> list[tuple[float, str]]:
    """Return factors and names of the units of length, time and stress that are drawn."""
    return [_SHOWN[one] if answer.scene.units == SI else (1.0, one) for one in _SHOWN]


def _labelled(what: str, unit: str) -> str:
    """Return the label of an axis; dimensions stand for units that have no name."""
    return what if unit in _SHOWN else f"{what} [{unit}]"


def _map(answer: Any, history: Any, ax: Any) -> Any:
    """Draw the slip rate over x and t, and wave fronts from the edge or from where slip begins."""
    length, time, _ = _units(answer)
    x, t, rate = history.x, history.t, history.slip_rate
    origin, begin, sign = 0.0, 0.0, 1
    if (touching := getattr(history, "touching", None)) is not None:
        x, rate = x[touching], rate[:, touching]
        onset = np.where(np.isfinite(answer.onset[touching]), answer.onset[touching], np.inf)
        first = int(onset.argmin())
        if np.isfinite(onset[first]):
            origin, begin = x[first], onset[first]
            sign = 1 if x[-1] - origin >= origin - x[0] else -1
    slips = np.abs(rate[rate != 0])
    most = np.quantile(slips, 0.99) if slips.size else 1.0  # it may be infinite at the edge
    # as many cells as a picture has pixels: levels and nodes may be tens of thousands
    rows, columns = (slice(None, None, -(-len(one) // _POINTS)) for one in (t, x))
    cells = x[columns] * length[0], t[rows] * time[0], rate[rows, columns]
    colours = {"cmap": "RdBu_r", "vmin": -most, "vmax": most}
    mesh = ax.pcolormesh(*cells, **colours, shading="nearest", rasterized=True)
    ax.figure.colorbar(mesh, ax=ax, label="slip rate" + " [m/s]" * (answer.scene.units == SI))
    for name, speed in _waves(answer).items():
        run = min(t[-1] - begin, abs(x[-1 if sign > 0 else 0] - origin) / speed)
        at = (origin + sign * speed * run) * length[0], (begin + run) * time[0]
        ax.plot([origin * length[0], at[0]], [begin * time[0], at[1]], color="0.4", lw=0.8)
        side = "right" if "R" in name else "left"  # c_R is close to c_t
        ax.annotate(name, at, xytext=(0, 3), textcoords="offset points", ha=side)
    ax.set(xlabel=_labelled("x", length[1]), ylabel=_labelled("t", time[1]))
    return ax


def _profile(answer: Any, axes: Any, end: float, limits: Any = None) -> Any:
    """Draw slip rate, and tractions on a second axis, over x at a time; return limits for later."""
    length, time, stress = _units(answer)
    known: Any = getattr(answer, "interface", None)
    nodes, touching = getattr(known, "x", None), getattr(known, "touching", None)
    waves = _waves(answer)
    reach = 1.05 * max(waves.values()) * end if nodes is None else nodes[-1]
    moving = (*answer.zones_at(end), *answer.openings_at(end))
    # on a whole line slip spreads to both sides
    start = -reach if any(part.start < 0 for part in moving) else 0.0
    if limits is not None:
        start, reach = limits[0]
    x = np.linspace(start, reach, _POINTS + 1)[1:] if touching is None else known.x[touching]
    panels = np.atleast_1d(axes)
    upper = panels[0]
    rate = answer.slip_rate(x, end)
    finite = np.abs(rate[np.isfinite(rate)])
    # it may be infinite at points
    tallest = max(_TALLEST * np.quantile(finite, 0.99), finite.min())
    upper.plot(x * length[0], np.where(np.abs(rate) <= tallest, rate, np.nan))
    upper.set_ylabel("slip rate" + " [m/s]" * (answer.scene.units == SI))
    upper.set_title(f"t = {end * time[0]:.4g} {time[1]}".removesuffix(" time"), loc="left")
    if len(panels) == 2:
        for name in ("shear_traction", "pressure"):
            values = stress[0] * getattr(answer, name)(x, end)
            panels[1].plot(x * length[0], values, label=name.replace("_", " "))
        if isinstance(getattr(answer.scene, "friction", None), float):
            strength = answer.scene.friction * values
            panels[1].plot(x * length[0], strength, ":", color="0.3", label="strength f p")
        panels[1].set_ylabel(_labelled("traction", stress[1]))
        panels[1].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
    for name, speed in waves.items():
        place = speed * end * length[0]
        for at in (place, -place) if speed * end < reach else ():
            if at < start * length[0]:
                continue
            for one in panels:
                one.axvline(at, color="0.7", lw=0.8)
        if speed * end < reach:
            above = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
            side = "right" if "R" in name else "left"  # c_R is close to c_t
            upper.annotate(name, (place, 1), xytext=(0, 3), ha=side, **above)
    panels[-1].set_xlabel(_labelled("x", length[1]))
    for one, known in zip(panels, limits[1] if limits else (), strict=False):
        one.set_ylim(known)
    return (start, reach), [one.get_ylim() for one in panels]


def _waves(answer: Any) -> dict[str, float]:
    """Return the speeds of waves by symbol, with a prime those of a lower body of another kind."""
    lower = getattr(answer.scene, "lower_material", None)  # whole lines have equal bodies
    bodies = {"": answer.scene.material} | ({"'": lower} if lower else {})
    return {
        f"$c_{name}{of}$": getattr(body, f"{wave}_speed")
        for of, body in bodies.items()
        for name, wave in (("R", "rayleigh"), ("t", "shear"), ("l", "longitudinal"))
    }
