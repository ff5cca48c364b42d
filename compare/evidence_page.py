"""The evidence as one HTML page that needs nothing else: tables, figures, profiles over time."""

from __future__ import annotations

import json
import math
import shlex
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.article_claims import FAILS, HOLDS, METHODS, PARTLY
from compare.article_figures import figure_2, figure_5, figure_6
from compare.evidence import (
    FEM,
    OPEN,
    PUBLISHED,
    Evidence,
    SceneEvidence,
    differences,
    excess,
    worst_row,
)
from compare.evidence_figures import (
    FRAMES,
    energy_figure,
    energy_unit,
    figure_png,
    opening_figure,
    profiles,
    rates_figure,
    tractions_figure,
)
from compare.figures import fronts_figure
from compare.history_figures import history_figure, sense_figure, wear_figure
from compare.measures import slip_zones
from compare.predictions import FINER
from compare.report import edge_state
from compare.rows import Row
from compare.scales import front_speeds, slip_rate_scale, speed_regime, stress_scale
from semianalytic import SlipZone
from semianalytic.scene import scene_document

Array = NDArray[np.float64]

PASS, FAIL = "within", "OUTSIDE"
READ_FROM = 0.01
"""Slip counts from this share of the largest slip rate on, where zones are read off a profile."""
CHECKOUT = Path(__file__).parents[1]
DASH = "–"


@dataclass(frozen=True)
class Cell:
    """Text of a table cell and what it looks like: number, long, good, bad or plain."""

    text: str
    look: str = ""
    link: str = ""


@dataclass(frozen=True)
class Earlier:
    """Figures of a longer study, taken from files if there are any.

    Attributes
    ----------
    title, command, about : str
        Heading, the command that draws the figures, and what they show.
    patterns : tuple of str
        Names of the files, below the folders `results/` and `docs/figures/`.
    """

    title: str
    command: str
    about: str
    patterns: tuple[str, ...]


STUDIES = {
    "chart": Earlier(
        "Error against time",
        "slipfront chart",
        "Every method on one machine: relative error of the slip rate against wall time.",
        ("chart/figures/chart_*.png", "chart_*.png"),
    ),
    "stability": Earlier(
        "Where methods fail",
        "slipfront stability --solver --fem --space-time",
        "Thresholds, limits of the Poisson ratio, grids, rules, step sizes and damping.",
        ("stability/*stability*.png", "*stability*.png"),
    ),
    "regimes": Earlier(
        "Regimes over Poisson ratio and friction",
        "slipfront regimes",
        "How the interface slips, with traced boundaries, and speeds of all zone edges.",
        ("regimes/*.png", "regimes*.png", "front_speeds.png"),
    ),
    "wear": Earlier(
        "Wear against friction",
        "slipfront wear",
        "Accumulated slip and frictional work for a step, a ramp and a pulse.",
        ("wear/*.png", "wear*.png"),
    ),
}


def page(found: Evidence) -> str:
    """The whole page."""
    sections = {"summary": "Summary", "reading": "How to read this page"}
    sections |= {_anchor(i): f"Scene: {scene.label}" for i, scene in enumerate(found.scenes)}
    sections |= {"closed": "Closed forms"}
    sections |= {"article": "Claims of the article"}
    sections |= {key: study.title for key, study in STUDIES.items()}
    sections |= {"versions": "Versions, machine and commands"}
    bodies = [
        _summary(found),
        _reading(),
        *(_scene(i, scene, found.quick) for i, scene in enumerate(found.scenes)),
        _closed_forms(found),
        _article(found),
        *(_earlier(study) for study in STUDIES.values()),
        _versions(found),
    ]
    contents = "".join(
        f'<li><a href="#{anchor}">{escape(title)}</a></li>' for anchor, title in sections.items()
    )
    main = "\n".join(
        f'<section id="{anchor}" aria-labelledby="{anchor}-title">\n'
        f'<h2 id="{anchor}-title">{escape(title)}</h2>\n{body}\n</section>'
        for (anchor, title), body in zip(sections.items(), bodies, strict=True)
    )
    body = (
        "<header><h1>slipfront: evidence</h1>\n"
        + _paragraph(
            "Two identical elastic half-planes touch along x > 0; x < 0 is an open slot. Where, "
            "when, how fast and which way the interface slips is answered here by two "
            "semi-analytic methods and by finite elements, which share with them the description "
            "of a scene and nothing else."
        )
        + _paragraph(f"Made on {found.stamp['date']} by slipfront {found.stamp['slipfront']}.")
        + f'</header>\n<nav aria-label="Contents"><h2>Contents</h2><ol>{contents}</ol></nav>\n'
        + f"<main>\n{main}\n</main>"
    )
    template = files("compare").joinpath("evidence.html").read_text(encoding="utf-8")
    return Template(template).substitute(body=body)


def _anchor(number: int) -> str:
    return f"scene-{number + 1}"


def _summary(found: Evidence) -> str:
    rows = []
    for number, scene in enumerate(found.scenes):
        worst = worst_row(scene)
        passed = sum(row.passed for _, row in scene.rows)
        rows.append(
            (
                Cell(scene.label, link=f"#{_anchor(number)}"),
                _scene_verdict(scene),
                Cell(f"{passed} of {len(scene.rows)}" if scene.rows else DASH, "number"),
                Cell(DASH if worst is None else _closeness(*worst), "long"),
                Cell(", ".join(scene.methods), "long"),
                Cell(scene.summary, "long"),
            )
        )
    head = ("scene", "verdict", "rows within", "closest to its tolerance", "methods", "shows")
    claims = [claim.verdicts["exact"].verdict for claim in found.claims]
    return _table(
        head, rows, "Every scene, and the row that comes closest to failing"
    ) + _paragraph(
        f"By the exact solution, {claims.count(HOLDS)} of the {len(claims)} claims of the article "
        f"hold, {claims.count(PARTLY)} hold in part and {claims.count(FAILS)} fail."
    )


def _scene_verdict(scene: SceneEvidence) -> Cell:
    if not scene.rows:
        return Cell("not judged")
    return Cell(PASS, "good") if scene.passed else Cell(FAIL, "bad")


def _closeness(method: str, row: Row) -> str:
    ratio = excess(row)
    share = "in one answer only" if math.isinf(ratio) else f"{100 * ratio:.0f} % of its tolerance"
    return f"{row.quantity}: {share} ({method} against {FEM})"


def _reading() -> str:
    return "".join(
        _paragraph(text)
        for text in (
            "Lengths are over c_t T and times over T, the end of the simulation; stresses are over "
            "τ₀, the larger load step, and slip rates over V₀ = 2 τ₀ / (ρ c_t). Slip and slip rate "
            "are relative, upper side less lower side. Numbers hold at the contact nodes of the "
            "finite-element mesh.",
            "Self-similar: closed forms up to quadrature, the zone edges being the only unknowns; "
            "for step loads. Space-time: the interface alone, marched in time on a spectral grid; "
            "for any load history. Both rest on the theory of two half-planes. Finite elements: "
            "the blocks themselves, explicit steps, Coulomb's law node by node; they know nothing "
            "of that theory. Published algorithm: the article's own, for its only load, a sudden "
            "remote one; drawn, but not judged row by row.",
            "A row is one quantity by a semi-analytic method and by finite elements. Its tolerance "
            "is stated with a reason, which is nearly always the mesh: halve h and it shrinks. The "
            f"verdict says whether the difference is {PASS} or {FAIL} the tolerance; a quantity "
            f"that is in one answer only is {FAIL}.",
        )
    )


def _scene(number: int, scene: SceneEvidence, quick: bool) -> str:
    parts = [_paragraph(scene.summary[0].upper() + scene.summary[1:] + ".")]
    if scene.obstacle:
        parts.append(
            _paragraph(
                "Finite elements only. The semi-analytic methods hold while the contact is closed, "
                f"and refuse this scene: “{scene.obstacle}” {_opening(scene)}"
            )
        )
    parts += [
        _parameters(scene),
        "<h3>Methods</h3>",
        _methods(scene),
        "<h3>Profiles through time</h3>",
        _player(number, scene),
        "<h3>Figures</h3>",
        _figures(scene, quick),
        "<h3>Fronts and slip zones</h3>",
        _zones(scene),
        "<h3>Energy</h3>",
        _energy(scene),
    ]
    if scene.rows:
        parts += ["<h3>Row by row</h3>", *(_rows(scene, method) for method in _judged(scene))]
    parts += ["<h3>Do it again</h3>", _commands(scene)]
    return "\n".join(parts)


def _judged(scene: SceneEvidence) -> list[str]:
    return list(dict.fromkeys(method for method, _ in scene.rows))


def _opening(scene: SceneEvidence) -> str:
    """How far the contact has opened at the end, in a sentence."""
    simulation = scene.simulation
    opened = simulation.interface.x[simulation.state[-1] == OPEN]
    length = scene.scene.material.shear_speed * simulation.end_time
    if not len(opened):
        return "At T the contact is closed everywhere."
    return f"At T the contact is open up to x = {opened.max() / length:.3f} c_t T."


def _parameters(scene: SceneEvidence) -> str:
    document = scene_document(scene.scene)
    items = [("friction", document.pop("friction"))]
    for group, values in document.items():
        items += [(f"{group}.{name}", value) for name, value in values.items()]
    return (
        f"<pre>{escape(chr(10).join(f'{name} = {_plain(value)}' for name, value in items))}</pre>"
    )


def _methods(scene: SceneEvidence) -> str:
    gaps = differences(scene)
    rows: list[tuple[str | Cell, ...]] = []
    settings = {FEM: _mesh_words(scene), PUBLISHED: "default reading, 200 unknowns"}
    seconds = {FEM: sum(scene.simulation.seconds.values())}
    for report in scene.reports:
        prediction = report.prediction
        seconds[prediction.method] = prediction.seconds
        settings[prediction.method] = (
            f"{prediction.solution.status}, error estimate {prediction.solution.error_estimate:.0e}"
            if prediction.solution is not None
            else f"{FINER} nodes per element of the mesh"
        )
    for method in scene.methods:
        took = f"{seconds[method]:.2g}" if method in seconds else DASH
        gap = [f"{value:.2e}" for value in gaps[method]] if method in gaps else [DASH, DASH]
        rows.append(
            (method, Cell(settings[method], "long"), *(Cell(t, "number") for t in (took, *gap)))
        )
    return _table(
        ("method", "settings", "time [s]", "mean difference / V₀", "largest difference / V₀"),
        rows,
        f"Slip rate at T on 0.02 < x/(c_t T) < 1.9: differences from {scene.methods[0]}"
        if gaps
        else "The one method that applies",
    )


def _mesh_words(scene: SceneEvidence) -> str:
    run = scene.simulation
    return (
        f"h = c_t T / {run.resolution}, {run.element} on {run.mesh}, {run.model}, damping "
        f"{run.damping:g} h/c_t, {run.unknowns:,} unknowns, {run.steps} steps"
    )


def _zones(scene: SceneEvidence) -> str:
    material, simulation = scene.scene.material, scene.simulation
    speeds = [
        (f"{name} wave", Cell(f"{speed / material.shear_speed:.6f}", "number"))
        for name, speed in front_speeds(material).items()
    ]
    parts = [_table(("front", "speed / c_t"), speeds, "Wave speeds")]
    rows = []
    for report in scene.reports:
        solution = report.prediction.solution
        if solution is None:
            continue
        for zone in solution.zones:
            edges = [
                text
                for edge in (zone.inner, zone.outer)
                for text in (
                    Cell(
                        "∞" if math.isinf(edge) else f"{edge / material.shear_speed:.9f}", "number"
                    ),
                    speed_regime(edge, material),
                )
            ]
            rows.append((_sense(zone.sense), *edges))
        mode_one, mode_two = solution.stress_intensity(simulation.end_time)
        unit = stress_scale(scene.scene) * math.sqrt(material.shear_speed * simulation.end_time)
        if rows:
            head = ("sense", "inner edge / c_t", "which is", "outer edge / c_t", "which is")
            parts.append(_table(head, rows, "Slip zones solved for by the self-similar method"))
        parts.append(
            _paragraph(
                f"The contact edge is {edge_state(solution)}; slip rate there "
                f"{solution.edge_slip_rate / slip_rate_scale(scene.scene):.6f} V₀. At T its stress "
                f"intensities are K_I = {float(mode_one) / unit:.6f} and K_II = "
                f"{float(mode_two) / unit:.6f} in units of τ₀ √(c_t T)."
            )
        )
    read = [(name, Cell(_read_zones(scene, name), "long")) for name in scene.histories]
    parts.append(
        _table(
            ("method", "zones, x / (c_t T)"),
            read,
            "Slip zones at T as read off the slip rate at the nodes, from 1 % of the largest on",
        )
    )
    return "".join(parts)


def _read_zones(scene: SceneEvidence, method: str) -> str:
    history = scene.histories[method]
    rate, time = history.slip_rate[-1], history.t[-1]
    largest = float(np.abs(rate).max())
    if largest < 1e-6 * slip_rate_scale(scene.scene):
        return "none"
    shown: Sequence[SlipZone] = slip_zones(history.x / time, rate, READ_FROM * largest)
    unit = scene.scene.material.shear_speed
    return "; ".join(
        f"{zone.inner / unit:.4f} to "
        + ("the end " if math.isinf(zone.outer) else f"{zone.outer / unit:.4f} ")
        + _sense(zone.sense)
        for zone in shown
    )


def _energy(scene: SceneEvidence) -> str:
    unit, energy = energy_unit(scene), scene.simulation.energy
    parts = [
        (name, Cell(f"{round(float(values[-1]) / unit, 6) + 0.0:.6f}", "number"))
        for name, values in (
            ("work of the loads", energy.external),
            ("kinetic energy", energy.kinetic),
            ("strain energy", energy.strain),
            ("taken by friction", energy.friction),
            ("taken by damping", energy.damping),
            ("taken where gaps close", energy.impact),
        )
    ]
    parts.append(("largest imbalance over the work", Cell(f"{energy.residual:.1e}", "number")))
    work = []
    for report in scene.reports:
        prediction = report.prediction
        x, taken = prediction.interface.x, prediction.friction_work
        sampled = float(np.trapezoid(taken, x)) / unit
        exact = DASH
        if prediction.solution is not None:
            end = scene.simulation.end_time
            power = float(prediction.solution.frictional_power(end))
            exact = "∞" if math.isinf(power) else f"{power * end / 2 / unit:.6f}"
        work.append((prediction.method, Cell(f"{sampled:.6f}", "number"), Cell(exact, "number")))
    inside = scene.simulation.interface.x > 0
    nodes = scene.simulation.interface.x[inside]
    seen = float(np.trapezoid(scene.simulation.friction_work[inside], nodes)) / unit
    work.append((FEM, Cell(f"{seen:.6f}", "number"), parts[3][1]))
    return _table(
        ("finite elements at T", "over τ₀ V₀ c_t T²"),
        parts,
        "Energy balance of the scheme, per unit thickness, both blocks",
    ) + _table(
        ("method", "nodes from x = h on", "all of x > 0, by the method itself"),
        work,
        "Frictional work until T, over τ₀ V₀ c_t T²",
    )


def _rows(scene: SceneEvidence, method: str) -> str:
    rows = [row for name, row in scene.rows if name == method]
    passed = sum(row.passed for row in rows)
    cells = [
        (
            Cell(row.quantity, "long"),
            *(
                Cell(_number(value), "number")
                for value in (row.prediction, row.simulation, row.difference, row.tolerance)
            ),
            Cell(PASS, "good") if row.passed else Cell(FAIL, "bad"),
        )
        for row in rows
    ]
    title = f"{method} against {FEM}: {passed} of {len(rows)} rows {PASS} their tolerance"
    head = ("quantity", method, FEM, "difference", "tolerance", "verdict")
    reasons = "".join(f"<li>{escape(row)}</li>" for row in dict.fromkeys(r.reason for r in rows))
    return (
        f"<details{'' if passed == len(rows) else ' open'}><summary>{escape(title)}</summary>"
        + _table(head, cells, "Differences of fields are relative; all others absolute")
        + f"<p>Where the tolerances come from:</p><ul>{reasons}</ul></details>"
    )


def _commands(scene: SceneEvidence) -> str:
    name, run = shlex.quote(scene.source), scene.simulation
    mesh = f"--resolution {run.resolution}"
    if not scene.reports:
        return _code([f"slipfront simulate {name} {mesh}"])
    lines = [f"slipfront compare {name} {mesh} --no-snapshots"]
    if len(scene.reports) > 1:
        lines.append(f"slipfront compare {name} {mesh} --no-snapshots --method space-time")
    lines.append(f"slipfront solve {name}")
    return _code(lines)


def _figures(scene: SceneEvidence, quick: bool) -> str:
    label, methods = scene.label, ", ".join(scene.histories)
    if not scene.reports:
        drawn = [_figure(opening_figure(scene), f"Where the contact of {label} is open")]
    else:
        every = ", ".join(scene.methods)
        drawn = [
            _figure(rates_figure(scene), f"Slip rate at T of {label} by {every}"),
            _figure(
                tractions_figure(scene),
                f"Shear traction and friction bound at T of {label} by {methods}",
            ),
        ]
    for report in scene.reports:
        if not report.prediction.interface.slip_rate.any():
            continue
        method = report.prediction.method
        drawn.append(
            _figure(
                sense_figure(report),
                f"Sense of slip of {label} over space and time: {method}, {FEM}, and where the two "
                "differ",
                wide=True,
            )
        )
        if quick or report is not scene.reports[0]:
            continue
        drawn += [
            _figure(
                history_figure(report), f"Slip rate of {label} at four moments, {method} and {FEM}"
            ),
            _figure(
                wear_figure(report),
                f"Accumulated slip and frictional work of {label} at T, {method} and {FEM}",
            ),
        ]
    if not quick:
        for report in scene.reports:
            if report.prediction.solution is not None:
                drawn.append(
                    _figure(
                        fronts_figure(report.prediction.solution, scene.simulation.interface),
                        f"Simulated slip rate of {label} under predicted fronts and zone edges",
                    )
                )
        drawn.append(_figure(energy_figure(scene), f"Energies of {label} in the {FEM} over time"))
    return f'<div class="figures">{"".join(drawn)}</div>'


def _player(number: int, scene: SceneEvidence) -> str:
    """A slider through time with two panels, drawn by the script of the page."""
    anchor, methods = f"{_anchor(number)}-time", scene.methods
    data = json.dumps(profiles(_anchor(number), scene), separators=(",", ":"))
    panels = "".join(
        f'<svg role="img" aria-label="{escape(text)} of {escape(scene.label)} along the interface '
        'at the time of the slider"></svg>'
        for text in ("Slip rate", "Shear traction and friction bound")
    )
    boxes = "".join(
        f'<label><input type="checkbox" value="{method}" checked>'
        f'<span class="swatch" style="background:var(--{method.replace(" ", "-")})"></span>'
        f"{method}</label>"
        for method in methods
    )
    return (
        f'<div class="player">{panels}<div class="time"><label for="{anchor}">time</label>'
        f'<input type="range" id="{anchor}" min="0" max="{FRAMES - 1}" value="{FRAMES - 1}">'
        f'<output for="{anchor}"></output></div>'
        f'<fieldset class="choices"><legend>methods</legend>{boxes}</fieldset>'
        f'<script type="application/json">{data.replace("</", chr(92).join("</"))}</script>'
        "<noscript><p>The slider needs JavaScript; the figures below do not.</p></noscript></div>"
    )


def _closed_forms(found: Evidence) -> str:
    forms = found.closed_forms
    methods = tuple(forms[0].errors)
    rows: list[tuple[str | Cell, ...]] = []
    for form in forms:
        edges = (DASH if edge is None else f"{edge:.12f}" for edge in (form.edge, form.found))
        errors = (f"{form.errors[method]:.1e}" for method in methods)
        cells = [Cell(text, "number") for text in (*errors, *edges)]
        rows.append((Cell(form.words, "long"), *cells))
    head = ("scene", *methods, "edge / c_t, closed form", "edge / c_t, self-similar")
    return (
        _paragraph(
            "Some scenes have slip rates in closed form, as plain quadratures in "
            "semianalytic/reference.py. Neither solver nor finite elements use them."
        )
        + _table(head, rows, "Relative L1 error of slip rate at T on 0.02 < x/(c_t T) < 1.9")
        + _code(["pytest tests/test_solver.py"])
    )


def _article(found: Evidence) -> str:
    rows: list[tuple[str | Cell, ...]] = [
        (
            claim.section,
            Cell(claim.text, "long"),
            claim.base,
            *(
                Cell(f"{v.verdict}: {v.evidence}", "long")
                for v in (claim.verdicts[m] for m in METHODS)
            ),
        )
        for claim in found.claims
    ]
    cases = found.cases.everyone()
    disagreement = max(case.disagreement() for case in cases)
    text = _paragraph(
        f"Every verdict is computed from {len(cases)} scenes, solved and simulated with h = "
        f"c_t T / {cases[0].resolution}. Exact and simulated slip rates differ by at most "
        f"{disagreement:.2g} Q_0/(μb) in the mean."
    )
    table = _table(("section", "claim", "load base", *METHODS), rows, "Claims and verdicts")
    if found.quick:
        return text + table + _code(["slipfront article --quick", "slipfront article"])
    drawn = "".join(
        _figure(draw(found.cases), f"Figure {name} of the article, redrawn", wide=True)
        for name, draw in (("2", figure_2), ("5", figure_5), ("6", figure_6))
    )
    commands = _code(["slipfront article --quick", "slipfront article"])
    return f'{text}{table}<div class="figures">{drawn}</div>{commands}'


def _earlier(study: Earlier) -> str:
    """Figures of a longer study from files, with their dates, or how to make them."""
    found = list(_earlier_files(study.patterns))
    if not found:
        return _paragraph(f"{study.about} Not drawn on this machine yet:") + _code([study.command])
    drawn = "".join(
        _image(
            path.read_bytes(),
            f"{study.title}: {path.stem.replace('_', ' ')}",
            f"{path.name}, a file of {datetime.fromtimestamp(path.stat().st_mtime, UTC):%Y-%m-%d}",
            wide=True,
        )
        for path in found
    )
    return (
        _paragraph(f"{study.about} Drawn earlier, not together with this page, by")
        + _code([study.command])
        + f'<div class="figures">{drawn}</div>'
    )


def _earlier_files(patterns: Iterable[str]) -> Iterator[Path]:
    """Files by name; where two folders hold the same figure, that of this machine's results."""
    found: dict[str, Path] = {}
    for folder in (Path("results"), Path("docs", "figures"), CHECKOUT / "docs" / "figures"):
        for path in sorted({path for pattern in patterns for path in folder.glob(pattern)}):
            found.setdefault(path.name.replace("_", "-"), path)
    yield from found.values()


def _versions(found: Evidence) -> str:
    names = " ".join(shlex.quote(scene.source) for scene in found.scenes)
    command = f"slipfront evidence {names}" + (" --quick" if found.quick else "")
    rows = [*found.stamp.items(), ("time to compute", f"{found.seconds:.1f} s, without figures")]
    return (
        _table(("what", "value"), rows, "What made this page")
        + _paragraph("This page, the tests behind it, and the parts that take longer:")
        + _code([command, "pytest", *(study.command for study in STUDIES.values())])
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[str | Cell]], title: str) -> str:
    """A table that scrolls in its own box, under its title."""
    heads = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
    lines = "".join(
        "<tr>"
        + "".join(_cell(cell, first=index == 0) for index, cell in enumerate(row))
        + "</tr>\n"
        for row in rows
    )
    return (
        f'<p class="title">{escape(title)}</p><div class="scroll" role="region" tabindex="0" '
        f'aria-label="{escape(title)}"><table><thead><tr>{heads}</tr></thead>\n'
        f"<tbody>{lines}</tbody></table></div>\n"
    )


def _cell(cell: str | Cell, *, first: bool) -> str:
    cell = cell if isinstance(cell, Cell) else Cell(cell)
    text = escape(cell.text)
    if cell.link:
        text = f'<a href="{escape(cell.link)}">{text}</a>'
    look = f' class="{cell.look}"' if cell.look else ""
    return f'<th scope="row"{look}>{text}</th>' if first else f"<td{look}>{text}</td>"


def _figure(figure: Figure, caption: str, *, wide: bool = False) -> str:
    return _image(figure_png(figure), caption, caption + ".", wide=wide)


def _image(data: bytes, alternative: str, caption: str, *, wide: bool = False) -> str:
    return (
        f"<figure{' class=' + chr(34) + 'wide' + chr(34) if wide else ''}>"
        f'<img src="data:image/png;base64,{b64encode(data).decode()}" alt="{escape(alternative)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>\n"


def _code(lines: Sequence[str]) -> str:
    return f"<pre>{escape(chr(10).join(lines))}</pre>\n"


def _sense(sense: int) -> str:
    return "forward" if sense > 0 else "reverse"


def _number(value: float | None) -> str:
    return DASH if value is None else f"{value:.4f}"


def _plain(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
