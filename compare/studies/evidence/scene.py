"""Section of one scene on the evidence page: methods, figures, zones, energy, every row."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from html import escape

import numpy as np

from compare.comparison.documents import edge_state
from compare.comparison.judgement import Judgement
from compare.comparison.measures import sampled_zones
from compare.comparison.prediction import FINER, method_of, seconds_of
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, shown_number
from compare.comparison.scales import scene_fronts, slip_rate_scale, speed_regime, stress_scale
from compare.figures.histories import history_figure, sense_figure, wear_figure
from compare.figures.interface import fronts_figure
from compare.studies.evidence.figures import (
    FRAMES,
    energy_figure,
    energy_unit,
    opening_figure,
    profiles,
    rates_figure,
    tractions_figure,
)
from compare.studies.evidence.html import (
    Cell,
    code,
    data_block,
    drawn_figure,
    figures,
    number,
    paragraph,
    table,
    words,
)
from compare.studies.evidence.study import FEM, PUBLISHED, SceneEvidence, differences
from semianalytic import Marched, Solution
from semianalytic.results.answer import Answer
from semianalytic.results.in_words import digits_apart, number_or_infinity
from semianalytic.scene.given.documents import scene_document

LOOKS = {AGREES: "good", DIFFERS: "bad", UNRESOLVED: "open"}
READ_FROM = 0.01
"""Slip rate, relative to the largest, above which a profile counts as slipping."""
DASH = "–"


def verdict_cell(verdict: str) -> Cell:
    """Return the cell of a verdict in its colour; a difference is also written in capitals."""
    return Cell(verdict.upper() if verdict == DIFFERS else verdict, LOOKS[verdict])


def counts_text(counts: Mapping[str, int]) -> str:
    """Say how many rows have each verdict."""
    return (
        f"{counts[AGREES]} of {sum(counts.values())} rows agree, {counts[UNRESOLVED]} unresolved, "
        f"{counts[DIFFERS]} differ"
    )


def scene_section(anchor: str, evidence: SceneEvidence, quick: bool) -> str:
    """Return the section of a scene; identifiers in it begin with `anchor`."""
    parts = [paragraph(evidence.summary[0].upper() + evidence.summary[1:] + ".")]
    if evidence.obstacle:
        parts.append(
            paragraph(
                "Finite elements only. The semi-analytic methods hold while the contact is closed, "
                f"and refuse this scene: “{evidence.obstacle}” {_opening(evidence)}"
            )
        )
    parts += [
        _parameters(evidence),
        "<h3>Methods</h3>",
        _methods(evidence),
        "<h3>Profiles through time</h3>",
        _player(anchor, evidence),
        "<h3>Figures</h3>",
        _figures(evidence, quick),
        "<h3>Fronts and slip zones</h3>",
        _zones(evidence),
        "<h3>Energy</h3>",
        energy_tables(evidence),
    ]
    if evidence.judgements:
        parts += ["<h3>Row by row</h3>", *map(_rows, evidence.judgements)]
    parts += ["<h3>Do it again</h3>", _commands(evidence)]
    return "\n".join(parts)


def _opening(evidence: SceneEvidence) -> str:
    """Say how far the contact has opened at the end."""
    simulation = evidence.simulation
    opened = simulation.interface.x[simulation.is_open[-1]]
    length = evidence.scene.material.shear_speed * simulation.end_time
    if not len(opened):
        return "At T the contact is closed everywhere."
    return f"At T the contact is open up to x = {opened.max() / length:.3f} c_t T."


def _parameters(evidence: SceneEvidence) -> str:
    document = scene_document(evidence.scene)
    items = [("friction", document.pop("friction"))]
    for group, values in document.items():
        named = values if isinstance(values, dict) else {"": values}
        items += [(f"{group}.{name}".rstrip("."), value) for name, value in named.items()]
    return code(
        f"{name} = {f'{value:.6g}' if isinstance(value, float) else value}" for name, value in items
    ).rstrip()


def _methods(evidence: SceneEvidence) -> str:
    gaps = differences(evidence)
    rows: list[tuple[str | Cell, ...]] = []
    settings = {FEM: _mesh_words(evidence), PUBLISHED: "default reading, 200 unknowns"}
    seconds = {FEM: sum(evidence.simulation.seconds.values())}
    for judgement in evidence.judgements:
        prediction = judgement.prediction
        seconds[method_of(prediction)] = seconds_of(prediction)
        settings[method_of(prediction)] = _settings(prediction)
    for method in evidence.methods:
        took = f"{seconds[method]:.2g}" if method in seconds else DASH
        gap = [f"{value:.2e}" for value in gaps[method]] if method in gaps else [DASH, DASH]
        rows.append((method, words(settings[method]), *map(number, (took, *gap))))
    return table(
        ("method", "settings", "time [s]", "mean difference / V₀", "largest difference / V₀"),
        rows,
        f"Slip rate at T on 0.02 < x/(c_t T) < 1.9: differences from {evidence.methods[0]}"
        if gaps
        else "The one method that applies",
    )


def _settings(prediction: Answer) -> str:
    """Describe how a prediction was made, and its error estimate."""
    assert isinstance(prediction, Solution | Marched)  # `predict_like` makes only these two
    nodes = f"{FINER} nodes per element of the mesh, " if isinstance(prediction, Marched) else ""
    return f"{nodes}{prediction.status}, error estimate {prediction.error_estimate:.0e}"


def _mesh_words(evidence: SceneEvidence) -> str:
    run = evidence.simulation
    coarser = " and ".join(str(one.resolution) for one in evidence.coarser)
    return (
        f"h = c_t T / {run.resolution}, {run.element} on {run.mesh}, {run.model}, damping "
        f"{run.damping:g} h/c_t, {run.unknowns:,} unknowns, {run.steps} steps"
    ) + (f"; error bars from runs at c_t T / {coarser}" if coarser else "")


def _zones(evidence: SceneEvidence) -> str:
    material, simulation = evidence.scene.material, evidence.simulation
    speeds = [
        (f"{name} wave", number(f"{speed / material.shear_speed:.6f}"))
        for name, speed in scene_fronts(evidence.scene).items()
    ]
    parts = [table(("front", "speed / c_t"), speeds, "Wave speeds")]
    rows = []
    for solution in _solutions(evidence):
        ends = [
            end / material.shear_speed
            for zone in solution.zones
            for end in (zone.inner, zone.outer)
        ]
        places = digits_apart(ends, 9, "f")
        for zone in solution.zones:
            edges = [
                text
                for edge in (zone.inner, zone.outer)
                for text in (
                    number(number_or_infinity(edge / material.shear_speed, places, "f")),
                    speed_regime(edge, evidence.scene),
                )
            ]
            rows.append((_sense(zone.sense), *edges))
        edge_rate = solution.edge_slip_rate / slip_rate_scale(evidence.scene)
        mode_one, sheared = solution.stress_intensity(simulation.end_time)
        unit = stress_scale(evidence.scene) * math.sqrt(material.shear_speed * simulation.end_time)
        if rows:
            head = ("sense", "inner edge / c_t", "which is", "outer edge / c_t", "which is")
            parts.append(table(head, rows, "Slip zones solved for by the self-similar method"))
        parts.append(
            paragraph(
                f"The contact edge is {edge_state(solution)}; slip rate there {edge_rate:.6f} "
                f"V₀. At T its stress intensities are K_I = {float(mode_one) / unit:.6f} and "
                f"K_{evidence.scene.shear_mode} = {float(sheared) / unit:.6f} in units of "
                f"τ₀ √(c_t T)."
            )
        )
    read = [(name, words(_read_zones(evidence, name))) for name in evidence.histories]
    parts.append(
        table(
            ("method", "zones, x / (c_t T)"),
            read,
            "Slip zones at T as read off the slip rate at the nodes, from 1 % of the largest on",
        )
    )
    return "".join(parts)


def _read_zones(evidence: SceneEvidence, method: str) -> str:
    history = evidence.histories[method]
    rate, time = history.slip_rate[-1], history.t[-1]
    largest = float(np.abs(rate).max())
    if largest < 1e-6 * slip_rate_scale(evidence.scene):
        return "none"
    shown = sampled_zones(history.x / time, rate, READ_FROM * largest)
    unit = evidence.scene.material.shear_speed
    return "; ".join(
        f"{zone.inner / unit:.4f} to "
        + ("the end " if math.isinf(zone.outer) else f"{zone.outer / unit:.4f} ")
        + _sense(zone.sense)
        for zone in shown
    )


def energy_tables(evidence: SceneEvidence) -> str:
    """Return tables of the simulation's energy balance, and of frictional work by all methods."""
    unit, energy = energy_unit(evidence), evidence.simulation.energy
    parts = [
        (name, number(f"{round(float(values[-1]) / unit, 6) + 0.0:.6f}"))
        for name, values in (
            ("work of the loads", energy.external),
            ("kinetic energy", energy.kinetic),
            ("strain energy", energy.strain),
            ("taken by friction", energy.friction),
            ("taken by damping", energy.damping),
            ("taken where gaps close", energy.impact),
        )
    ]
    parts.append(("largest imbalance over the work", number(f"{energy.residual:.1e}")))
    simulation = evidence.simulation
    nodes, end = simulation.interface.x, simulation.end_time
    work = []
    for judgement in evidence.judgements:
        prediction = judgement.prediction
        if isinstance(prediction, Solution):
            heat = prediction.frictional_work
            part, whole = float(heat(end, nodes[0], nodes[-1])), float(heat(end))
        else:
            _, taken = judgement.case.worn_at_nodes
            part, whole = float(np.trapezoid(taken, nodes)), math.nan
        shown = number(_work(part / unit)), number(_work(whole / unit))
        work.append((method_of(prediction), *shown))
    seen = float(np.trapezoid(simulation.final_work_density, nodes))
    work.append((FEM, number(_work(seen / unit)), parts[3][1]))
    return table(
        ("finite elements at T", "over τ₀ V₀ c_t T²"),
        parts,
        "Energy balance of the scheme, per unit thickness, both blocks",
    ) + table(
        ("method", "from the first node on", "all of x > 0, by the method itself"),
        work,
        "Frictional work until T, over τ₀ V₀ c_t T²",
    )


def _work(value: float) -> str:
    """Write frictional work to six places; infinite for slip ahead of all waves, nan if unknown."""
    if math.isnan(value):
        return DASH
    return number_or_infinity(value, 6, "f")


def _rows(judgement: Judgement) -> str:
    """Return the rows of one judgement as a table, unfolded if some rows differ."""
    cells = [
        (
            words(row.label),
            *(number(shown_number(value)) for value in (row.exact, row.at_nodes, row.simulated)),
            *(number(row.shown_share(value)) for value in (row.difference, row.bar)),
            verdict_cell(row.verdict),
            words("; ".join(filter(None, (row.obstacle, judgement.remedy(row))))),
        )
        for row in judgement.rows
    ]
    counts = judgement.counts
    title = f"{method_of(judgement.prediction)} against {FEM}: {counts_text(counts)}"
    head = (
        "quantity",
        "exact",
        "at nodes",
        FEM,
        "difference",
        "bar ±",
        "verdict",
        "why unresolved",
    )
    return (
        f"<details{' open' if counts[DIFFERS] else ''}><summary>{escape(title)}</summary>"
        + table(
            head, cells, "Differences are between the last two values; of fields, their norm in %"
        )
        + "</details>"
    )


def _commands(evidence: SceneEvidence) -> str:
    name, run = shlex.quote(evidence.source), evidence.simulation
    mesh = f"--resolution {run.resolution}"
    if not evidence.judgements:
        return code([f"slipfront simulate {name} {mesh}"])
    lines = [f"slipfront compare {name} {mesh} --no-snapshots"]
    if len(evidence.judgements) > 1:
        lines.append(f"slipfront compare {name} {mesh} --no-snapshots --method space-time")
    lines.append(f"slipfront solve {name}")
    return code(lines)


def _figures(evidence: SceneEvidence, quick: bool) -> str:
    label, methods = evidence.label, ", ".join(evidence.histories)
    every = ", ".join(evidence.methods)
    drawn = []
    if evidence.judgements:
        caption = f"Slip rate at T of {label} by {every}"
        drawn.append(drawn_figure(rates_figure(evidence), caption))
        caption = f"Shear traction and friction bound at T of {label} by {methods}"
        drawn.append(drawn_figure(tractions_figure(evidence), caption))
    else:
        caption = f"Where the contact of {label} is open"
        drawn.append(drawn_figure(opening_figure(evidence), caption))
    for judgement in evidence.judgements:
        case, method = judgement.case, method_of(judgement.prediction)
        if not case.slips:
            continue
        caption = (
            f"Sense of slip of {label} over space and time: {method}, {FEM}, and where the two"
        )
        drawn.append(drawn_figure(sense_figure(case), f"{caption} differ", wide=True))
        if quick or judgement is not evidence.judgements[0]:
            continue
        caption = f"Slip rate of {label} at four moments, {method} and {FEM}"
        drawn.append(drawn_figure(history_figure(case), caption))
        caption = f"Accumulated slip and frictional work of {label} at T, {method} and {FEM}"
        drawn.append(drawn_figure(wear_figure(case), caption))
    if not quick:
        caption = f"Simulated slip rate of {label} under predicted fronts and zone edges"
        drawn += [
            drawn_figure(fronts_figure(solution, evidence.simulation.interface), caption)
            for solution in _solutions(evidence)
        ]
        caption = f"Energies of {label} in the {FEM} over time"
        drawn.append(drawn_figure(energy_figure(evidence), caption))
    return figures(drawn)


def _player(anchor: str, evidence: SceneEvidence) -> str:
    """Return a time slider with two panels, which the script of the page draws."""
    slider = f"{anchor}-time"
    panels = "".join(
        f'<svg role="img" aria-label="{escape(text)} of {escape(evidence.label)} along the '
        'interface at the time of the slider"></svg>'
        for text in ("Slip rate", "Shear traction and friction bound")
    )
    boxes = "".join(
        f'<label><input type="checkbox" value="{method}" checked>'
        f'<span class="swatch" style="background:var(--{method.replace(" ", "-")})"></span>'
        f"{method}</label>"
        for method in evidence.methods
    )
    return (
        f'<div class="player">{panels}<div class="time"><label for="{slider}">time</label>'
        f'<input type="range" id="{slider}" min="0" max="{FRAMES - 1}" value="{FRAMES - 1}">'
        f'<output for="{slider}"></output></div>'
        f'<fieldset class="choices"><legend>methods</legend>{boxes}</fieldset>'
        + data_block(profiles(anchor, evidence))
        + "<noscript><p>The slider needs JavaScript; the figures below do not.</p></noscript></div>"
    )


def _solutions(evidence: SceneEvidence) -> list[Solution]:
    """Return the predictions by the self-similar method: one solution, or none."""
    predictions = (judgement.prediction for judgement in evidence.judgements)
    return [prediction for prediction in predictions if isinstance(prediction, Solution)]


def _sense(sense: int) -> str:
    return "forward" if sense > 0 else "reverse"
