"""Problem sheets as pages: blocks of text, tables and pictures, in Markdown and in HTML."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

from compare.benchmarks.answers import arrival_level, arrival_quantity, written_document
from compare.benchmarks.classes import CLASSES, Tolerance, tolerances
from compare.benchmarks.interfaces.sheets import SI, InterfaceSheet
from compare.benchmarks.sheet import OPENING, SI_SCALES, STATIONS, Sheet
from compare.output.files import filled_template
from compare.output.tables import markdown_table
from semianalytic import (
    IncidentWave,
    Material,
    Pair,
    Patch,
    Pulse,
    Scene,
    ViscousFriction,
    WholeLine,
)
from semianalytic.results.in_words import kind_of_slip
from semianalytic.scene.loading import REMOTE
from semianalytic.scene.units import unit

FIGURE, RECORDS, ANSWERS = "figure.png", "records.csv", "answers.json"
INTERFACE = "interface.toml"
"""Files beside an exported sheet."""

_UNITS = {
    "slip_rate": "length / time",
    "slip": "length",
    "shear_traction": "stress",
    "pressure": "stress",
}


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str


@dataclass(frozen=True)
class Heading:
    """A heading of a level from 1 on."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Code:
    """Lines as they are typed or written."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A table of texts."""

    heading: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Picture:
    """A picture in a file."""

    name: str
    alternative: str


Block = Text | Heading | Code | Table | Picture


def sheet_blocks(sheet: Sheet) -> Iterator[Block]:
    """Yield the blocks of the page of a sheet."""
    yield Heading(f"{sheet.name}: {sheet.title}", 1)
    yield Text(f"It tests {sheet.tests}.")
    yield Heading("Problem")
    if isinstance(sheet, InterfaceSheet):
        yield from _interface(sheet)
    else:
        problem = sheet.problem
        if isinstance(problem, Pair):
            yield Text(_problem(problem.alike, _DIFFERENT))
        else:
            yield Text(_line(problem) if isinstance(problem, WholeLine) else _problem(problem))
        if sheet.note:
            yield Text(sheet.note)
        yield Table(("", "units μ = ρ = c_t = T = 1", "SI"), tuple(_numbers(sheet)))
    yield Picture(FIGURE, f"The answer to {sheet.name}")
    yield Heading("What to report")
    yield from _to_report(sheet)
    yield Heading("The answer")
    yield from _answer(sheet)
    bounds = [one for one in tolerances().values() if one.sheet == sheet.name]
    if bounds:
        yield from _classes(sheet, bounds)
    yield Heading("Scoring")
    if not bounds:
        why = "our own codes do not take this problem" if sheet.is_line else "none are measured"
        yield Text(f"Errors are given without classes: {why}.")
    yield Code(("slipfront benchmark score FILE ...",))


def _interface(sheet: InterfaceSheet) -> Iterator[Block]:
    """Yield the statement of a problem of an interface, with its numbers."""
    yield Text(sheet.statement)
    yield Text(sheet.note)
    yield Table(("", sheet.units), sheet.numbers)


def _cells_over(sheet: Sheet) -> str:
    """Return in words the length over which the cells of a sheet are counted."""
    return sheet.breadth_words if isinstance(sheet, InterfaceSheet) else "c_t T"


def _classes(sheet: Sheet, bounds: Sequence[Tolerance]) -> Iterator[Block]:
    """Yield the table of tolerance classes, and what they are."""
    yield Heading("Tolerance classes")
    yield Text(
        "The largest errors of a first-order scheme (our finite elements) on 200 (A), 100 (B) and "
        f"50 cells (C) over {_cells_over(sheet)}. Of arrivals the root of the mean square error "
        "over T, of all else the relative L1 error over time and all stations."
    )
    yield Table(
        ("", *CLASSES),
        tuple(
            (one.quantity.replace("_", " "), *(f"{getattr(one, name):.2g}" for name in CLASSES))
            for one in bounds
        ),
    )


def _line(line: WholeLine) -> str:
    """The statement of a problem without a slot in words."""
    along = "along z" if line.antiplane else "along x"
    return (
        "Two half-planes of one elastic solid, y > 0 and y < 0, touch along all of y = 0, without "
        "a slot. Coulomb's law holds, strength f p. Everything is at rest under the base tractions "
        "P_b, Q_b; from t = 0 on the interface carries P_0, Q_0 more on a patch |x| < w t where "
        "it sticks: add them to the tractions that an interface without slip would have. Shear and "
        f"slip act {along}. Pressure is positive in compression; slip V and its rate are those of "
        "the upper face less the lower one; tractions are the whole ones."
    )


_SAME = "Two half-planes of one elastic solid, y > 0 and y < 0,"
_DIFFERENT = (
    "Two half-planes of different elastic solids, y > 0 (μ, ρ, ν) and y < 0 (μ_2, ρ_2, ν_2),"
)


def _problem(scene: Scene, bodies: str = _SAME) -> str:
    """The statement in words."""
    along = "along z, the edge" if scene.antiplane else "along x"
    load, start = scene.load, _slot_load(scene)
    if isinstance(load, IncidentWave):
        side, body = ("+x", "-x")[load.angle < 0], load.from_
        start = (
            f"A plane {load.kind} step wave arrives from {body}, towards {side}, at the angle "
            "theta to the normal of y = 0; its front reaches the tip of the slot, x = 0, at t = 0. "
            "Behind the front, from t = p x on with p = sin(theta)/c of its speed c, an uncut line "
            "y = 0 would carry P_0, Q_0 more than the base tractions P_b, Q_b; the faces of the "
            "slot stay free of them"
        )
    history = scene.shear_history
    until = f", until {history.duration:g} T" if isinstance(history, Pulse) else ""
    film = " + viscosity |V|" if isinstance(scene.friction_law, ViscousFriction) else ""
    return (
        f"{bodies} touch on x > 0; x < 0 is an open slot. On the contact Coulomb's law holds, "
        f"strength f p{film}; it carries no tension. {start}{until}. Shear and slip act {along}. "
        "Pressure is positive in compression; slip V and its rate are those of the upper face less "
        "the lower one; tractions are the whole ones."
    )


def _slot_load(scene: Scene) -> str:
    """Return in words how tractions act as a load."""
    if scene.load_on == REMOTE:
        return (
            "At t = 0 a uniform pressure P_0 and shear Q_0 come from afar, everywhere on y = 0 at "
            "once; the faces of the slot stay free"
        )
    return (
        "Everything is at rest under the base tractions P_b, Q_b; from t = 0 on the faces of the "
        "slot, x < 0, receive the change of tractions (-P_0, -Q_0)"
    )


def _numbers(sheet: Sheet) -> Iterator[tuple[str, str, str]]:
    """Rows of all numbers in both systems of units."""
    plain, si = sheet.problem, sheet.si_problem
    if isinstance(plain, Pair) and isinstance(si, Pair):
        below = plain.lower, si.lower
        plain, si = plain.alike, si.alike
    else:
        below = None
    assert not isinstance(plain, Pair)
    assert not isinstance(si, Pair)
    rows: list[tuple[str, float, float, str]] = [
        ("shear modulus μ", plain.material.shear_modulus, si.material.shear_modulus, "stress"),
        ("density ρ", plain.material.density, si.material.density, "mass / length^3"),
    ]
    for name, symbols in (("base", "P_b Q_b"), ("load", "P_0 Q_0")):
        for part, symbol in zip(("pressure", "shear"), symbols.split(), strict=True):
            ours, theirs = (
                getattr(getattr(one, name).tractions(one.material), part)
                if name == "load" and isinstance(one, Scene)
                else getattr(getattr(one, name), part)
                for one in (plain, si)
            )
            rows.append((f"{part} of the {name} {symbol}", ours, theirs, "stress"))
    speeds = [one.load.speed for one in (plain, si) if isinstance(one.load, Patch)]
    if speeds:
        rows.append(("speed w of either end of the patch", speeds[0], speeds[1], "length / time"))
    laws = [scene.friction_law for scene in (plain, si) if isinstance(scene, Scene)]
    films = [law.viscosity for law in laws if isinstance(law, ViscousFriction)]
    if films:
        rows.append(("viscosity", films[0], films[1], "stress time / length"))
    rows.append(("end T", 1.0, SI_SCALES["t"], "time"))
    rows.append(("c_t T", 1.0, SI_SCALES["x"], "length"))
    for label, value, in_si, dimension in rows:
        named = "Pa s/m" if dimension == "stress time / length" else unit(dimension, "SI")
        yield label, f"{value:g}", f"{in_si:g} {named}"
    nu = plain.material.poisson_ratio
    yield "Poisson ratio ν", "1/3" if abs(3 * nu - 1) < 1e-12 else f"{nu:g}", "the same"
    if below is not None:
        yield from _numbers_below(*below)
    yield "friction f", f"{plain.friction:g}", "the same"
    if isinstance(plain.load, IncidentWave):
        yield "angle theta", f"{plain.load.angle:g} degrees", "the same"


def _numbers_below(plain: Material, si: Material) -> Iterator[tuple[str, str, str]]:
    """Rows of the lower body, in both systems of units."""
    yield (
        "shear modulus μ_2 of the lower body",
        f"{plain.shear_modulus:g}",
        f"{si.shear_modulus:g} Pa",
    )
    yield "density ρ_2 of the lower body", f"{plain.density:g}", f"{si.density:g} kg/m^3"
    yield "Poisson ratio ν_2 of the lower body", f"{plain.poisson_ratio:g}", "the same"


def _to_report(sheet: Sheet) -> Iterator[Block]:
    names = ", ".join(name.replace("_", " ") for name in sheet.report)
    yield Text(
        f"{names[0].upper()}{names[1:]} over 0 < t <= T at {_places(sheet)}, at your own time "
        f"steps, as CSV in units {_system(sheet)}. Columns that you do not have may be missing; "
        "where slip rate is a mean over a step, a comment line says so."
    )
    yield Code(
        (
            f"# benchmark: {sheet.name}",
            "# code: NAME",
            "# version: NUMBER",
            "# cells: 100",
            "# seconds: 12.3",
            "# slip_rate: mean over the step from t to t + 0.005",
            "t,x,slip_rate,slip,shear_traction" + ("" if sheet.is_interface else ",pressure"),
        )
    )
    if sheet.is_interface:
        yield Text(f"Cells are counted over {_cells_over(sheet)}.")
    if sheet.arrival:
        name, side = arrival_quantity(sheet), "below" if sheet.arrival == OPENING else "above"
        yield Text(
            f"Arrivals are read off these records: the first time that {name.replace('_', ' ')} is "
            f"{side} {arrival_level(sheet):g}, between samples by linear interpolation."
        )


def _places(sheet: Sheet) -> str:
    """Return in words where the stations of a sheet are."""
    places = ", ".join(f"{x:g}" for x in sheet.stations)
    if isinstance(sheet, InterfaceSheet):
        return f"x = {places}{' m' if sheet.units == SI else ''}"
    metres = ", ".join(f"{x * SI_SCALES['x']:g}" for x in sheet.stations)
    return f"x/(c_t T) = {places} ({metres} m)"


def _system(sheet: Sheet) -> str:
    """Return in words the system of units in which records are handed in."""
    if isinstance(sheet, InterfaceSheet):
        return "of the SI" if sheet.units == SI else sheet.units
    return "μ = ρ = c_t = T = 1"


def _reference(sheet: InterfaceSheet) -> Iterator[Block]:
    """Yield what is known of the answer to a problem of an interface, and how well."""
    document = written_document(sheet)
    answers, errors = document["answers"], document["errors"]
    yield Text(
        f"{RECORDS} holds the records at the stations, {ANSWERS} the same and the arrivals; "
        f"{INTERFACE} is the problem as `slipfront run` reads it. It is the limit of two grids, of "
        f"{sheet.nodes // 2} and {sheet.nodes} nodes, by an order of {sheet.order}. The stated "
        f"error is its difference from the limit of {sheet.nodes // 4} and {sheet.nodes // 2} "
        "nodes: relative L1 over all times and stations; of arrivals the largest, in units of "
        "time. An error of a code below it says nothing about the code."
    )
    yield Table(
        ("", "stated error"),
        tuple((name.replace("_", " "), f"{error:.2g}") for name, error in errors.items()),
    )
    rows = zip(sheet.stations, answers["arrivals"], answers["slip"][-1], strict=True)
    yield Table(
        ("x", "arrival", "slip at t = T"),
        tuple(
            (f"{x:g}", "never" if time is None else f"{time:.6g}", f"{slip:.7g}")
            for x, time, slip in rows
        ),
    )


def _answer(sheet: Sheet) -> Iterator[Block]:
    if isinstance(sheet, InterfaceSheet):
        yield from _reference(sheet)
        return
    document = written_document(sheet)
    answers, sure = document["answers"], document["sure"]
    yield Text(
        f"{RECORDS} holds the records at the stations, {ANSWERS} all numbers ({sure}); SHA256SUMS, "
        "one folder up, their checksums. To SI: " + _scales_words() + "."
    )
    rows = [
        (f"zone {at}, {kind_of_slip(sense)}, x/(c_t t)", _range(inner, outer))
        for at, (inner, outer, sense) in enumerate(answers.get("zones", ()), start=1)
    ]
    rows += [("open, x/(c_t t)", _range(*ends)) for ends in answers.get("openings", ())]
    rows += [
        (name.replace("_", " "), f"{answers[name]:.10g}")
        for name in answers
        if isinstance(answers[name], float)
    ]
    rows += [
        (f"arrival at x = {x:g}", "never" if time is None else f"{time:.10g}")
        for x, time in zip(STATIONS, answers.get("arrivals", ()), strict=False)
    ]
    yield Table(("at t = T", ""), tuple(rows))


def _range(inner: float, outer: float) -> str:
    return f"{inner:.10g} to {outer:.10g}"


def _scales_words() -> str:
    """Return in words the factors that convert dimensionless numbers to SI units."""
    return ", ".join(
        f"{name.replace('_', ' ')} times {SI_SCALES[name]:g} {unit(dimension, 'SI')}"
        for name, dimension in _UNITS.items()
    )


def as_markdown(blocks: Sequence[Block]) -> str:
    """Blocks in Markdown."""
    parts = []
    for block in blocks:
        match block:
            case Heading(text, level):
                parts.append(f"{'#' * level} {text}\n")
            case Text(text):
                parts.append(f"{text}\n")
            case Code(lines):
                parts.append("\n".join(("```", *lines, "```")) + "\n")
            case Table(heading, rows):
                parts.append(markdown_table(heading, rows))
            case Picture(name, alternative):
                parts.append(f"![{alternative}]({name})\n")
    return "\n".join(parts)


def as_html(blocks: Sequence[Block], pictures: Mapping[str, bytes]) -> str:
    """Blocks as one HTML page that holds its pictures, PNG by name."""
    title = next(block.text for block in blocks if isinstance(block, Heading))
    body = "".join(_html(block, pictures) for block in blocks)
    return filled_template("compare.benchmarks", "sheet.html", title=escape(title), body=body)


def _html(block: Block, pictures: Mapping[str, bytes]) -> str:
    match block:
        case Heading(text, level):
            return f"<h{level}>{escape(text)}</h{level}>\n"
        case Text(text):
            return f"<p>{escape(text)}</p>\n"
        case Code(lines):
            return f"<pre>{escape(chr(10).join(lines))}</pre>\n"
        case Table(heading, rows):
            return f"<div><table>{_cells('th', heading)}{_rows(rows)}</table></div>\n"
        case Picture(name, alternative):
            source = f"data:image/png;base64,{b64encode(pictures[name]).decode()}"
            return f'<p><img src="{source}" alt="{escape(alternative)}"></p>\n'


def _rows(rows: Sequence[Sequence[str]]) -> str:
    return "".join(_cells("td", row) for row in rows)


def _cells(tag: str, cells: Sequence[str]) -> str:
    inner = "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
    return f"<tr>{inner}</tr>\n"
