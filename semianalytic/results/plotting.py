"""An answer as a picture: slip rate and tractions over x at one time, or over x and t."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import product
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.files import new_file
from semianalytic.results.in_words import kind_of_slip
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import needing
from semianalytic.scene.laws.kinds import law_table
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.units import SI

_POINTS = 800
_TALLEST = 4.0
"""Largest slip rate drawn, over the one that a hundredth of the points exceed."""
SHOWN = {
    "length": ((1e-3, "km"), (1.0, "m"), (1e3, "mm"), (1e6, "µm")),
    "time": ((1.0, "s"), (1e3, "ms"), (1e6, "µs")),
    "stress": ((1e-6, "MPa"), (1e-3, "kPa"), (1.0, "Pa")),
}
"""Units of figures of SI scenes: the largest of which there are two or more is drawn."""
_TRACTIONS = ("pressure", "shear")
SHADES = {"slip": ("#56B4E9", 0.3), "reverse slip": ("#D55E00", 0.18), "open": ("#F0E442", 0.45)}
"""Colours behind curves by what the contact does, and their shares in the mixture."""
_LARGE = 10.0
"""Ratio of pressure to shear traction above which the pressure is not drawn with it."""
_LEGEND: Any = {"loc": "lower right", "bbox_to_anchor": (1, 1), "ncols": 3, "frameon": False}
_APART = 0.06
"""Distance over the width of a figure below which waves share one label."""


def drawn(answer: Any, ax: Any, t: float | None) -> Any:
    """Draw an answer; `Gridded.plot` describes it."""
    with needing("plot"):
        from matplotlib import pyplot
    history = getattr(answer, "interface", None)
    mapped = t is None and history is not None
    axes = ax
    if ax is None:
        figure, axes = pyplot.subplots(1 if mapped else 2, sharex=True, layout="constrained")
        figure.suptitle(scene_title(answer.scene), fontsize="small")
    if mapped:
        return draw_map(answer, history, axes)
    draw_profile(answer, axes, _end(answer) if t is None else t)
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
    if shown.ndim > 1 or not shown.size:
        raise SceneError(f"animate: t must be one or more times, got an array {shown.shape}.")
    figure, axes = pyplot.subplots(2, sharex=True, layout="constrained")
    figure.suptitle(scene_title(answer.scene), fontsize="small")
    limits = draw_profile(answer, axes, float(np.max(shown)))

    def show(t: float) -> None:
        for axis in axes:
            axis.clear()
        draw_profile(answer, axes, t, limits)

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


def shown_units(scene: Any, reach: float, end: float) -> list[tuple[float, str]]:
    """Return factors and names of the units of length, time and stress for sizes of x, t and the
    largest traction that a scene states as a number."""
    if scene.units != SI:
        return [(1.0, unit) for unit in SHOWN]
    stated = (getattr(of, what, 0.0) for of in (scene.base, scene.load) for what in _TRACTIONS)
    most = max(abs(value) if isinstance(value, float | int) else 0.0 for value in stated)
    units = zip(SHOWN.values(), (reach, end, most), strict=True)
    return [next((unit for unit in of if unit[0] * size >= 2), of[-1]) for of, size in units]


def _labelled(what: str, unit: str) -> str:
    """Return the label of an axis; dimensions stand for units that have no name."""
    return what if unit in SHOWN else f"{what} [{unit}]"


def scene_title(scene: Any) -> str:
    """Return what a figure says of its scene."""
    metre, _, pascal = shown_units(scene, scene.period, 0.0)
    bodies = [body for body in (scene.material, scene.lower_material) if body is not None]
    words = ["ν = " + " on ".join(f"{body.poisson_ratio:.3g}" for body in bodies)]
    if len(bodies) > 1:
        upper, lower = bodies
        moduli = lower.shear_modulus / upper.shear_modulus, lower.density / upper.density
        words.append("lower body {:.3g} μ, {:.3g} ρ".format(*moduli))
    words += [scene.mode] * (scene.mode == "antiplane")
    words += ["remote load"] * (scene.load_on == REMOTE)
    law, load = scene.friction, scene.load
    coefficient = law if isinstance(law, float) else getattr(law, "friction", None)
    if isinstance(coefficient, float):
        words.append(f"f = {coefficient:.3g}")
    if not isinstance(law, float):
        table = law_table(law)
        numbers = [f"{name} {n:.3g}" for name, n in table.items() if isinstance(n, float)]
        words.append(f"{table['kind']} ({', '.join(numbers)})" if numbers else table["kind"])
    # what has a speed or grows says its kind; its numbers are no tractions, or not these alone
    plain = isinstance(load, type(scene.base))
    for of, what in product(("base", "load") if plain else ("base",), _TRACTIONS):
        value = getattr(getattr(scene, of), what)
        number = isinstance(value, float | int)
        if not number or value:
            words.append(f"{of} {what} {shown_number(value, pascal) if number else 'varies'}")
    words += [] if plain else [_kind_of(load)]
    acting = scene.acting_histories.values() if plain else ()
    histories = {type(history).__name__ for history in acting}
    words += sorted(histories - {"Step"})
    if scene.on_line and np.isfinite(scene.period):
        words.append(f"period {shown_number(scene.period, metre)}")
    words += ["in units of the scene"] * (scene.units != SI)
    return ", ".join(words)


def _kind_of(load: Any) -> str:
    """Return the kind of a load, with the angle of a wave or the speed of a patch."""
    if isinstance(load, tuple):
        return f"{len(load)} loads"
    if hasattr(load, "angle"):
        return f"{load.kind} wave at {load.angle:.3g}°"
    speed = f" at speed {load.speed:.4g}" if hasattr(load, "speed") else ""
    return re.sub(r"\B(?=[A-Z])", " ", type(load).__name__).lower() + speed  # "moving load"


def shown_number(value: float, unit: tuple[float, str]) -> str:
    """Return a number with its unit, if that has a name."""
    return f"{value * unit[0]:.4g}" + (f" {unit[1]}" if unit[1] not in SHOWN else "")


def draw_map(answer: Any, history: Any, ax: Any) -> Any:
    """Draw the slip rate over x and t, and wave fronts from the edge or from where slip begins."""
    x, t, rate = history.x, history.t, history.slip_rate
    origins, begin = [(0.0, 1)], 0.0
    if answer.scene.on_line:
        touching = history.touching
        x, rate, onset = x[touching], rate[:, touching], answer.seen.onset[touching]
        begin = float(onset.min(initial=np.inf))
        first = x[onset <= begin * (1 + 1e-9)]
        # waves run from either end of what slips first to its own side, else to the other
        ends = [(first.min(), -1), (first.max(), 1)] if np.isfinite(begin) else []
        rooms = [(x[-1] - at if sign > 0 else at - x[0]) for at, sign in ends]
        least = 0.02 * np.ptp(x)
        origins = [
            (at, s if room > least else -s) for (at, s), room in zip(ends, rooms, strict=True)
        ]
    length, time, _ = shown_units(answer.scene, np.ptp(x), t[-1])
    slips = np.abs(rate[np.isfinite(rate)])
    # a line that hardly slips, or rests, does not count
    slips = slips[slips > 0.01 * slips.max(initial=0.0)]
    most = float(np.quantile(slips, 0.99)) if slips.size else 1.0  # higher at the edge
    # as many cells as a picture has pixels: levels and nodes may be tens of thousands
    rows, columns = (slice(None, None, -(-len(axis) // _POINTS)) for axis in (t, x))
    cells = x[columns] * length[0], t[rows] * time[0], rate[rows, columns]
    colours = {"cmap": "RdBu_r", "vmin": -most, "vmax": most}
    mesh = ax.pcolormesh(*cells, **colours, shading="nearest", rasterized=True)
    label = "slip rate" + " [m/s]" * (answer.scene.units == SI)
    beyond = "both" if slips.max(initial=0.0) > most else "neither"
    ax.figure.colorbar(mesh, ax=ax, label=label, extend=beyond)
    labels: list[tuple[float, float, str]] = []
    for name, speed in _waves(answer).items():
        # where waves cross the line many times they are no lines of a picture
        for origin, sign in origins if speed * t[-1] < 20 * np.ptp(x) else ():
            run = min(t[-1] - begin, abs(x[-1 if sign > 0 else 0] - origin) / speed)
            at = (origin + sign * speed * run) * length[0], (begin + run) * time[0]
            ax.plot([origin * length[0], at[0]], [begin * time[0], at[1]], color="0.4", lw=0.8)
            if run > 0:
                labels.append((*at, name))
    _name(ax, labels, (np.ptp(x) * length[0], t[-1] * time[0]), "data")
    limits = [limit * length[0] for limit in (min(x[0], 0.0), x[-1])]
    ax.set(xlabel=_labelled("x", length[1]), ylabel=_labelled("t", time[1]), xlim=limits)
    return ax


def _name(ax: Any, labels: Any, sizes: tuple[float, float], rise: str) -> None:
    """Write the names of waves at places (x, y, name); those close to each other share one."""
    groups: list[list[tuple[float, float, str]]] = []
    for label in sorted(labels):
        near = [
            group
            for group in groups
            if all(abs(group[-1][k] - label[k]) < _APART * sizes[k] for k in (0, 1))
        ]
        if near:
            near[0].append(label)
        else:
            groups.append([label])
    for group in groups:
        x, y, _ = group[-1]
        names = ", ".join(dict.fromkeys(name for *_, name in group))
        # the time of a profile stands above it, so names are right of the lines they would cross
        shift, align = ((0, 3), "center") if rise == "data" else ((2, -12), "left")
        where = {"textcoords": "offset points", "xycoords": ("data", rise), "ha": align}
        ax.annotate(names, (x, y), xytext=shift, fontsize="small", **where)


def draw_profile(answer: Any, axes: Any, end: float, limits: Any = None) -> Any:
    """Draw slip rate, and tractions on a second axis, over x at a time; return limits for later.

    Further axes have the shades and waves alone.
    """
    scene: Any = answer.scene
    known: Any = getattr(answer, "interface", None)
    nodes = getattr(known, "x", None)
    waves = _waves(answer)
    reach = 1.05 * max(waves.values()) * end if nodes is None else nodes[-1]
    if nodes is None and scene.front_slowness > 0:  # a load whose front runs over the contact
        reach = max(reach, 1.2 * end / max(scene.front_slowness, 0.2 / max(waves.values())))
    length, time, stress = shown_units(scene, reach, end)
    opened = answer.openings_at(end)
    # on a whole line slip spreads to both sides
    spreads = any(part.start < 0 for part in (*answer.zones_at(end), *opened))
    start = -reach if spreads else 0.0
    if limits is not None:
        start, reach = limits[0]
    x = known.x[known.touching] if scene.on_line else np.linspace(start, reach, _POINTS + 1)[1:]
    panels = np.atleast_1d(axes)
    upper = panels[0]
    rate = answer.slip_rate(x, end)
    finite = np.abs(rate[np.isfinite(rate)])
    upper.plot(x * length[0], np.where(np.isfinite(rate), rate, np.nan), label="slip rate")
    # next to points where it is infinite the curve leaves the figure
    tallest = max(_TALLEST * np.quantile(finite, 0.99), finite.min())
    low, high = (
        float(np.clip(value, -tallest, tallest)) for value in (np.nanmin(rate), np.nanmax(rate))
    )
    if high > low:
        margin = 0.05 * (max(high, 0.0) - min(low, 0.0))
        upper.set_ylim(min(low, 0.0) - margin, max(high, 0.0) + margin)
    upper.set_ylabel("slip rate" + " [m/s]" * (scene.units == SI))
    upper.set_title(f"t = {end * time[0]:.4g} {time[1]}".removesuffix(" time"), loc="left")
    kinds = [(kind_of_slip(part.sense), part) for part in answer.zones_at(end)]
    moving = [*kinds, *(("open", part) for part in opened)]
    for number, (kind, part) in enumerate(moving):
        span = (part.start * length[0], min(part.end, reach) * length[0])
        label = None if kind in (before for before, _ in moving[:number]) else kind
        colour, share = SHADES[kind]
        for panel in panels:
            said = label if panel is upper else None
            panel.axvspan(*span, color=colour, alpha=share, linewidth=0, zorder=0, label=said)
    if moving:
        handles = upper.get_legend_handles_labels()[0][1:]  # the curve has its axis
        upper.legend(handles=handles, **_LEGEND)
    if len(panels) > 1:
        of = answer.shear_traction, answer.pressure
        shear, pressure = (stress[0] * field(x, end) for field in of)
        panels[1].plot(x * length[0], shear, label="shear traction")
        largest = np.nanmax(np.abs(shear), initial=0.0)
        if largest == 0 or np.nanmax(pressure) < _LARGE * largest:
            panels[1].plot(x * length[0], pressure, "--", color="0.3", label="pressure")
        if isinstance(getattr(scene, "friction", None), float):
            signs = {float(np.sign(value)) for value in (shear.min(), shear.max()) if value}
            for sign in signs:  # friction bounds the shear traction on the sides that it is on
                bound = sign * scene.friction * pressure
                label = "strength f p" if sign == max(signs) else None
                panels[1].plot(x * length[0], bound, ":", color="0.3", label=label)
        panels[1].set_ylabel(_labelled("traction", stress[1]))
        panels[1].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, frameon=False)
    labels = []
    for name, speed in waves.items():
        for place in (speed * end, -speed * end):
            if start <= place < reach and not scene.on_line:
                labels.append((place * length[0], 1.0, name))
                for panel in panels:
                    panel.axvline(place * length[0], color="0.35", lw=0.8)
    _name(upper, labels, ((reach - start) * length[0], 1.0), "axes fraction")
    panels[-1].set_xlabel(_labelled("x", length[1]))
    for panel, set_before in zip(panels, limits[1] if limits else (), strict=False):
        panel.set_ylim(set_before)
    return (start, reach), [panel.get_ylim() for panel in panels]


def _waves(answer: Any) -> dict[str, float]:
    """Return the speeds of waves by symbol, with a prime those of a lower body of another kind."""
    lower = getattr(answer.scene, "lower_material", None)  # whole lines have equal bodies
    bodies = {"": answer.scene.material} | ({"'": lower} if lower else {})
    return {
        f"$c_{name}{of}$": getattr(body, f"{wave}_speed")
        for of, body in bodies.items()
        for name, wave in (("R", "rayleigh"), ("t", "shear"), ("l", "longitudinal"))
        if name == "t" or answer.scene.mode != "antiplane"
    }
