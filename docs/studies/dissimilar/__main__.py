"""Different bodies in numbers: the figure and the tables of dissimilar.md.

``python -m docs.studies.dissimilar --output docs --workers 2``
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from compare.figures.style import BLACK, SMALL, STICK_SHADE, outline
from docs.studies.dissimilar import pairs
from docs.studies.dissimilar.half_line import half_line_exponent, half_line_speed
from docs.studies.runner import Point, Row, Study, drawn, main
from semianalytic import SceneError, sliding_stability, solve
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.growth import growing_waves
from semianalytic.dissimilar.thresholds import generalised_rayleigh_speed, growth_threshold
from semianalytic.dissimilar_slot.solution import PairSolution

MAPPED, FRICTIONS = (1.02, 4.0), (0.01, 1.25)
"""Contrasts of the map, speeds of the lower over the upper body of the same density and Poisson
ratio: beyond 4 it is that of a rigid body but for the growth against the slower one, of which 4 has
all; and its frictions."""
TABLED = (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.2, 2.5, 3.0, 5.0, 10.0)
SLID = (0.2, 0.5, 1.0)
HALF_LINES = ((1.4, 0.2), (1.5, 0.2), (1.5, 0.4), (1.8, 0.4), (1.2, 0.2))
FIELDS = ("two zones", "slip and opening", "film")
_LEAST, _MOST = 0.01, 100.0
"""Growth per wavelength [%] that colours and lines show."""


def map_points(quick: bool) -> list[Point]:
    """Return columns of the map of growth, thresholds on it, and named pairs over friction."""
    size = 12 if quick else 40
    columns = [("map", ratio, size) for ratio in np.geomspace(*MAPPED, size).tolist()]
    curves = [("curves", ratio, 0) for ratio in np.geomspace(*MAPPED, 4 * size).tolist()]
    return [*columns, *curves, *(("named", name, 24) for name in pairs.NAMED)]


def map_rows(part: str, of: Any, size: int) -> list[Row]:
    """Return growth per wavelength [%] of the fastest wave over friction; 0 or nan if none grows.

    That of a contrast is with and against the slower body; of named pairs with the velocity.
    """
    if part == "curves":
        return [{"part": part} | threshold_row(of)]
    compliance = compliance_of(*(pairs.NAMED[of] if part == "named" else pairs.of_contrast(of)))
    rows: list[Row] = []
    for friction in np.geomspace(*FRICTIONS, size).tolist():
        grown = {
            wave.velocity: 100 * float(np.expm1(wave.per_wavelength))
            for wave in growing_waves(compliance, friction)
        }
        row: Row = {"part": part, "of": of, "friction": friction}
        if part == "map":
            row["with"] = max((grown[wave] for wave in grown if wave > 0), default=0.0)
            row["against"] = max((grown[wave] for wave in grown if wave < 0), default=0.0)
        else:
            row["velocity"], row["growth"] = next(iter(grown.items()), (np.nan, np.nan))
        rows.append(row)
    return rows


def threshold_row(contrast: float) -> Row:
    """Return frictions above which waves grow with and against the slower body.

    The speed of the generalised Rayleigh wave is over c_t of the slower body, nan if there is none.
    """
    compliance = compliance_of(*pairs.of_contrast(contrast))
    return {
        "contrast": contrast,
        "threshold_with": float(growth_threshold(compliance, 1)),
        "threshold_against": float(growth_threshold(compliance, -1)),
        "rayleigh_speed": generalised_rayleigh_speed(compliance) or np.nan,
    }


def growth_figure(rows: list[Row]) -> Figure:
    """Draw growth per wavelength over contrast and friction, and over friction for named pairs."""
    grown = [max(row.get("with", 0), row.get("against", 0)) or np.nan for row in rows]
    shown = [row | {"largest": wave} for row, wave in zip(rows, grown, strict=True)]
    named = [row for row in shown if row["part"] == "named" and row["growth"] == row["growth"]]
    growth = {"xscale": "log", "yscale": "log"}
    panels: list[dict[str, Any]] = [
        growth
        | {"x": "of", "y": "friction", "value": "largest", "where": {"part": "map"}}
        | {"style": {"norm": LogNorm(_LEAST, _MOST), "cmap": "YlOrRd"}, "ylabel": "friction $f$"}
        | {"xlabel": "$c_t$ of the faster body over the slower"}
        | {"label": "growth per wavelength [%]"},
        growth
        | {"x": "friction", "y": "growth", "by": ("of",), "where": {"part": "named"}}
        | {"failed": lambda row: row["velocity"] < 0, "title": "crosses: against the slower body"}
        | {"marker": "-", "xlabel": "friction $f$", "ylabel": "growth per wavelength [%]"}
        | {"xlim": FRICTIONS, "ylim": (_LEAST, _MOST)},
    ]
    others = [row for row in shown if row["part"] != "named"]
    words = "waves that grow while bodies slide (left: equal densities, ν = 1/4)"
    figure = drawn([*others, *named], panels, words)
    panel = figure.axes[0]
    panel.set_facecolor(STICK_SHADE)
    curves = [row for row in rows if row["part"] == "curves"]
    names = {
        "threshold_with": ("-", "$f_+$: waves with the slower body grow above"),
        "threshold_against": ("--", "$f_-$: waves against it grow above"),
    }
    for name, (line, label) in names.items():
        values = [row[name] or np.nan for row in curves]
        style: dict[str, Any] = {"color": BLACK, "path_effects": outline()}
        panel.plot([row["contrast"] for row in curves], values, line, label=label, **style)
    panel.set_xticks((1, 1.2, 1.5, 2, 2.5, 3, 4), ("1", "1.2", "1.5", "2", "2.5", "3", "4"))
    panel.set_xticks([], minor=True)
    panel.set(xlim=MAPPED, ylim=FRICTIONS)
    panel.text(0.42, 0.3, "no wave\ngrows", transform=panel.transAxes, ha="center", fontsize=SMALL)
    panel.legend(loc="lower left", fontsize=SMALL)
    return figure


def named_row(pair: str, friction: float) -> Row:
    """Return thresholds of a named pair, growth per wavelength [%], velocity, and G of a delay."""
    known = sliding_stability(*pairs.NAMED[pair], friction)
    fastest = known.waves[0] if known.waves else None
    return {
        "pair": pair,
        "friction": friction,
        "threshold_with": known.threshold_with,
        "threshold_against": known.threshold_against,
        "growth": 100 * (fastest.per_wavelength - 1) if fastest else np.nan,
        "velocity": fastest.velocity / pairs.NAMED[pair][0].shear_speed if fastest else np.nan,
        "delayed": known.delayed_growth or np.nan,
    }


def half_line_row(contrast: float, friction: float, chi: float) -> Row:
    """Return speeds of the edge of slip ahead of an over-stressed half-line, and exponents there.

    Speeds are over c_t of the slower body, with it and against it; nan where there is no answer.
    """
    compliance = compliance_of(*pairs.of_contrast(contrast))
    row: Row = {"contrast": contrast, "friction": friction, "chi": chi}
    exponents: Row = {}
    for name, sense in (("with", 1), ("against", -1)):
        row[f"speed_{name}"] = exponents[f"exponent_{name}"] = np.nan
        with suppress(SceneError):
            speed = half_line_speed(compliance, sense * friction, chi)
            exponents[f"exponent_{name}"] = half_line_exponent(compliance, sense * friction, speed)
            row[f"speed_{name}"] = speed
    return row | exponents


def slot_row(scene: str) -> Row:
    """Return the zones of a scene, in x/t over c_t of the upper body, and how sure they are."""
    answer: PairSolution = solve(pairs.SCENES[scene], rtol=1e-9)
    # from the slot outward, as "open 0 to 0.1, slip + 0.1 to 0.5"
    parts = [(part.inner, part.outer, "open") for part in answer.openings]
    signs = {1: "slip +", -1: "slip −"}
    parts += [(zone.inner, zone.outer, signs[zone.sense]) for zone in answer.zones]
    zones = [f"{what} {inner:.8g} to {outer:.8g}" for inner, outer, what in sorted(parts)]
    return {"scene": scene, "zones": ", ".join(zones), "error_estimate": answer.error_estimate}


STUDIES = [
    Study("dissimilar-map", map_points, map_rows, lambda rows: [], {"dissimilar": growth_figure}),
    Study("dissimilar-thresholds", lambda quick: [(entry,) for entry in TABLED], threshold_row),
    Study("dissimilar-named", lambda quick: [(n, f) for n in pairs.NAMED for f in SLID], named_row),
    Study(
        "dissimilar-halflines",
        lambda quick: [(*line, chi) for line in HALF_LINES for chi in (1.0, 2.0)],
        half_line_row,
    ),
    Study("dissimilar-slots", lambda quick: [(name,) for name in pairs.SCENES], slot_row),
    Study(
        "dissimilar-honesty",
        lambda quick: [(number,) for number in range(5 if quick else pairs.STATED)],
        pairs.stated_rows,
        pairs.honesty,
    ),
    Study(
        "dissimilar-fields",
        lambda quick: [(name, 24 if quick else pairs.FIELDS_RESOLUTION) for name in FIELDS],
        pairs.fields_rows,
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.dissimilar", STUDIES))
