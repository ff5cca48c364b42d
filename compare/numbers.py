"""Every number that README and docs quote, computed again and compared with the text.

``python -m compare.numbers`` reads docs/numbers.toml, where each entry names the pages, the text as
it stands there with its numbers in «guillemets», the function of this module that computes them,
and how closely they have to agree.  It fails if a text is not in its page or a number is off.
"""

from __future__ import annotations

import argparse
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from compare import (
    article_cases,
    fem_stability,
    fem_study,
    regime_boundaries,
    solver_benchmark,
    spacetime_study,
    wear,
)
from compare import reverse_slip as reversal
from compare import stability_studies as studies
from compare.history_figures import comparison_figures
from compare.regime_boundaries import scene_of
from compare.report import Report, build_report
from compare.scenes import NAMED_SCENES, override_scene
from compare.solver_stability import ESTIMATE_SCENES
from semianalytic import Material, Solution, march, solve
from semianalytic.edge_factors import edge_offset_and_factors
from semianalytic.errors import SlipfrontError
from semianalytic.published import (
    DEFAULT_READING,
    REVERSE_LIMIT,
    examine_all,
    examine_reading,
    published_slip,
    readings,
)
from semianalytic.rayleigh import rayleigh_factors
from semianalytic.reference import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
)
from semianalytic.stuck import stuck_traction

Array = NDArray[np.float64]
Numbers = Sequence[float]

ROOT = Path(__file__).resolve().parents[1]
LIST = ROOT / "docs" / "numbers.toml"
THIRD = 1 / 3

# --- the list ---------------------------------------------------------------------------------

_SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"
_DIGITS = str.maketrans(_SUPERSCRIPT + "−", "0123456789--")
_QUOTED = re.compile("«([^»]*)»")
_NUMBER = re.compile(
    rf"(?P<sign>[+−-]?)(?P<mantissa>\d[\d,]*(?:\.\d+)?)?(?P<power>·?10[{_SUPERSCRIPT}]+)?"
    r"(?:e(?P<exponent>[-+]?\d+))?(?P<percent> ?%)?"
)
AGREEMENTS = ("relative", "absolute", "units", "factor", "at_most", "at_least")


@dataclass(frozen=True)
class Quoted:
    """A number as it is written: its value, and one unit of its last digit."""

    written: str

    def _parts(self) -> re.Match[str]:
        match = _NUMBER.fullmatch(self.written)
        if match is None or not (match["mantissa"] or match["power"]):
            raise ValueError(f"«{self.written}» is not a number this script can read.")
        return match

    @property
    def value(self) -> float:
        """The number; percents as fractions."""
        match = self._parts()
        mantissa = float((match["mantissa"] or "1").replace(",", ""))
        return (-1 if match["sign"] in ("−", "-") else 1) * mantissa * self._scale

    @property
    def unit(self) -> float:
        """One unit of the last digit."""
        return 10.0**-self._decimals * self._scale

    @property
    def _decimals(self) -> int:
        _, _, fraction = (self._parts()["mantissa"] or "1").partition(".")
        return len(fraction)

    @property
    def _scale(self) -> float:
        match = self._parts()
        exponent = int(match["exponent"] or 0)
        if match["power"]:
            exponent += int(match["power"].split("10", 1)[1].translate(_DIGITS))
        return float(f"1e{exponent - (2 if match['percent'] else 0)}")

    def rewritten(self, value: float) -> str:
        """Another value in the same style."""
        if not math.isfinite(value):
            return str(value)
        match, decimals = self._parts(), self._decimals
        percent = match["percent"] or ""
        sign = ("−" if match["sign"] != "-" else "-") if value < 0 else match["sign"]
        sign = "+" if sign == "+" and value >= 0 else sign if value < 0 else ""
        size = abs(value) * (100 if percent else 1)
        if not (match["power"] or match["exponent"]):
            thousands = "," if "," in match["mantissa"] else ""
            return f"{sign}{size:{thousands}.{decimals}f}{percent}"
        mantissa, _, exponent = f"{size:.{decimals}e}".partition("e")
        if match["exponent"]:
            return f"{sign}{mantissa}e{int(exponent)}{percent}"
        raised = "".join(_SUPERSCRIPT["0123456789-".index(one)] for one in str(int(exponent)))
        lead = f"{mantissa}·" if match["mantissa"] else ""
        return f"{sign}{lead}10{raised}{percent}"


@dataclass(frozen=True)
class Entry:
    """One text of one or more pages, and how its numbers are computed.

    Attributes
    ----------
    id : str
    pages : tuple of str
        Paths from the root of the repository.
    text : str
        As in the page, numbers in guillemets; white space does not count.
    function : str
        Key of `FUNCTIONS`.
    arguments : tuple
    agreement, tolerance : str, float
        "relative", "absolute", "units" of the last digit, "factor" (to either side), or "at_most"
        and "at_least" (bounds: tolerance is a factor of slack, 1 for none).
    slow : bool
        Takes more than seconds.
    """

    id: str
    pages: tuple[str, ...]
    text: str
    function: str
    arguments: tuple[Any, ...]
    agreement: str
    tolerance: float
    slow: bool

    @property
    def quoted(self) -> tuple[Quoted, ...]:
        """The numbers, in order."""
        return tuple(Quoted(written) for written in _QUOTED.findall(self.text))

    @property
    def plain(self) -> str:
        """The text as it should stand in the page."""
        return _QUOTED.sub(r"\1", self.text)

    def missing_pages(self) -> list[str]:
        """Pages that do not hold the text."""
        wanted = _squeezed(self.plain)
        return [page for page in self.pages if wanted not in _page(page)]

    def computed(self) -> list[float]:
        """What the function says now, one value per quoted number.

        Raises
        ------
        ValueError
            If there are not as many.
        """
        values = [float(value) for value in FUNCTIONS[self.function](*self.arguments)]
        if len(values) != len(self.quoted):
            raise ValueError(f"{self.id}: {len(self.quoted)} numbers quoted, {len(values)} found.")
        return values

    def agrees(self, quoted: Quoted, value: float) -> bool:
        """Whether a computed value is near enough to the quoted one."""
        wanted, tolerance = quoted.value, self.tolerance
        if not math.isfinite(value):
            return False
        if self.agreement == "at_most":
            return value <= wanted * tolerance
        if self.agreement == "at_least":
            return value >= wanted / tolerance
        if self.agreement == "factor":
            return bool(value * wanted > 0 and max(value / wanted, wanted / value) <= tolerance)
        scale = {"relative": abs(wanted), "absolute": 1.0, "units": quoted.unit}[self.agreement]
        return bool(abs(value - wanted) <= tolerance * scale * (1 + 1e-9))

    def rewritten(self, values: Iterable[float]) -> str:
        """The text with other numbers, in the same style."""
        old = iter(zip(self.quoted, values, strict=True))

        def new(_: re.Match[str]) -> str:
            quoted, value = next(old)
            return quoted.written if self.agrees(quoted, value) else quoted.rewritten(value)

        return _QUOTED.sub(new, self.text)


def read_list(path: Path = LIST) -> list[Entry]:
    """All entries of docs/numbers.toml.

    Raises
    ------
    ValueError
        If one is not complete, or its function does not exist.
    """
    entries = []
    for raw in tomllib.loads(path.read_text(encoding="utf-8"))["number"]:
        given = dict(raw)
        kinds = [kind for kind in AGREEMENTS if kind in given]
        if len(kinds) != 1:
            raise ValueError(f"{given.get('id')}: give one of {', '.join(AGREEMENTS)}.")
        entry = Entry(
            id=given.pop("id"),
            pages=tuple(given.pop("pages")),
            text=given.pop("text"),
            function=given.pop("function"),
            arguments=tuple(given.pop("arguments", ())),
            agreement=kinds[0],
            tolerance=float(given.pop(kinds[0])),
            slow=given.pop("slow", False),
        )
        if given or entry.function not in FUNCTIONS or not entry.quoted:
            raise ValueError(f"{entry.id}: unknown {', '.join(given) or entry.function}.")
        entries.append(entry)
    return entries


def _squeezed(text: str) -> str:
    return " ".join(text.split())


@cache
def _page(name: str) -> str:
    path = ROOT / name
    return _squeezed(path.read_text(encoding="utf-8")) if path.is_file() else ""


# --- functions: what the numbers are -----------------------------------------------------------

FUNCTIONS: dict[str, Callable[..., Numbers]] = {}


def computes(function: Callable[..., Numbers]) -> Callable[..., Numbers]:
    """Make a function known to docs/numbers.toml under its name."""
    FUNCTIONS[function.__name__] = function
    return function


@cache
def _solved(scene: str, rtol: float = 1e-10) -> Solution:
    return solve(NAMED_SCENES[scene].scene, rtol=rtol)


# theory: stuck tractions, closed forms


@computes
def stuck_tractions(nu: float, mode: str, *slowness: float) -> Numbers:
    """p* (I) or q* (II) at slownesses [b]."""
    return stuck_traction(nu, "I" if mode == "I" else "II")(np.array(slowness)).tolist()


@computes
def one_zone_edge(nu: float, chi: float) -> Numbers:
    """Speed of the only zone under a shear step over c_t, and one-sided V(0+) over Q_0/(mu b)."""
    material = Material(1.0, 1.0, nu)
    rate = slip_rate_under_shear_step(material, 1.0, chi, np.array([0.0]))[0] / 2
    return [edge_speed_under_shear_step(material, chi), float(rate)]


@computes
def everywhere_share(nu: float, *velocity: float) -> Numbers:
    """Lambda of a remote load under which all slips, at velocities [c_t]: V less its rest."""
    # with f P_0 = Q_0 = 1 only f P_0 Lambda is left of V
    rate = slip_rate_under_remote_shock(Material(1.0, 1.0, nu), 1.0, 1.0, 1.0, np.array(velocity))
    return (rate / 2).tolist()


@computes
def rayleigh_speed(nu: float) -> Numbers:
    """c_R over c_t."""
    return [Material(1.0, 1.0, nu).rayleigh_speed]


@computes
def hidden_root_ratio() -> Numbers:
    """Poisson ratio from which the hidden root of the Rayleigh function is complex."""
    low, high = 0.2, 0.3
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (low, middle) if rayleigh_factors(middle).hidden_root.imag else (middle, high)
    return [high]


@computes
def pressure_negative_until() -> Numbers:
    """Where p* changes sign between c_t t and the edge, x / (c_t t) at nu = 1/3."""
    pressure = stuck_traction(THIRD, "I")
    return [1 / brentq(lambda u: float(pressure(u)), 1.1, 5.0)]


@computes
def grid_edge() -> Numbers:
    """Distance from the grid's own edge to the first contact node, over the node distance."""
    return [edge_offset_and_factors()[0]]


@computes
def memory_poles(nu: float, nodes: int, *tolerances: float) -> Numbers:
    """Exponentials that carry the memory of a default march."""
    scene = scene_of("preload", nu, 0.3)
    marches = (march(scene, nodes=nodes, every=10**6, tolerance=one) for one in tolerances)
    return [marched.statistics.poles for marched in marches]


@computes
def edge_threshold_at(nu: float) -> Numbers:
    """Friction below which the edge slips under a remote load."""
    return [regime_boundaries.edge_threshold(nu)]


@computes
def preload_nucleation(nu: float) -> Numbers:
    """Friction below which a second zone nucleates under a preload."""
    return [regime_boundaries.nucleation("preload", nu)]


# named scenes


@computes
def scene_intensity(scene: str) -> Numbers:
    """K_I and K_II at t = 1."""
    return [float(one) for one in _solved(scene).stress_intensity(1.0)]


@computes
def edge_rate(scene: str) -> Numbers:
    """Relative slip rate at the contact edge [length / time]."""
    return [float(_solved(scene).edge_slip_rate)]


@cache
def _report(scene: str) -> Report:
    """What `slipfront compare SCENE` finds with default options."""
    from compare.predictions import predict
    from fem import simulate

    simulation = simulate(NAMED_SCENES[scene].scene)
    return build_report(scene, predict(simulation), simulation)


@cache
def _compared(scene: str) -> dict[str, dict[str, Any]]:
    return {row.quantity: asdict(row) for row in _report(scene).rows}


@computes
def comparison(scene: str, quantity: str, *columns: str) -> Numbers:
    """Columns (prediction, simulation, difference) of one row of the report of a scene."""
    return [_compared(scene)[quantity][column] for column in columns]


@computes
def comparison_rows(scene: str, column: str, *quantities: str) -> Numbers:
    """One column of several rows of the report of a scene."""
    return [_compared(scene)[quantity][column] for quantity in quantities]


@computes
def comparison_percents(scene: str, column: str, *quantities: str) -> Numbers:
    """As `comparison_rows` [%]."""
    return [100 * value for value in comparison_rows(scene, column, *quantities)]


@computes
def comparison_percents_both(scene: str, quantity: str) -> Numbers:
    """Prediction and simulation of one row [%]."""
    return [100 * value for value in comparison(scene, quantity, "prediction", "simulation")]


@computes
def simulated_lift(scene: str) -> Numbers:
    """How far the contact has opened at T over c_t T in a default simulation."""
    seen = fem_study.simulated(scene, 100).interface
    return [float(seen.x[seen.pressure[-1] == 0].max())]


@computes
def largest_rates(scene: str) -> Numbers:
    """Largest forward slip rate, four elements off the edge, predicted and simulated.

    At T where x/t is all that counts, over space and time from 0.2 T on otherwise.
    """
    from compare.predictions import contact_nodes

    report = _report(scene)
    predicted, seen = report.prediction.interface, contact_nodes(report.simulation)
    shown = seen.x > 4.5 * report.simulation.element_size
    since = 0.2 if report.prediction.solution is None else 1.0
    later = seen.t >= since * seen.t[-1]
    return [float(one.slip_rate[np.ix_(later, shown)].max()) for one in (predicted, seen)]


# regimes


@computes
def regime_thresholds(nu: float) -> Numbers:
    """The row of one Poisson ratio in the table of docs/regimes.md."""
    gap = regime_boundaries.gap_threshold("remote", nu)
    return [
        regime_boundaries.nucleation("preload", nu),
        regime_boundaries.edge_threshold_alone(nu),
        regime_boundaries.front_threshold_stuck(nu),
        regime_boundaries.nucleation("remote", nu),
        math.nan if gap is None else gap,
    ]


@computes
def crossing_ratio() -> Numbers:
    """Poisson ratio below which the shear front breaks before the contact edge."""
    return [regime_boundaries.crossing_poisson_ratio()]


@computes
def edge_threshold_shift(nu: float) -> Numbers:
    """What slip at the shear front adds to the threshold of the edge."""
    return [regime_boundaries.edge_threshold(nu) - regime_boundaries.edge_threshold_alone(nu)]


@computes
def preload_gap_ratio() -> Numbers:
    """Poisson ratio above which a preloaded gap at c_R gets narrower than 1e-14."""
    low, high = 0.45, 0.49
    while high - low > 1e-6:
        middle = (low + high) / 2
        closes = regime_boundaries.gap_threshold("preload", middle) is not None
        low, high = (low, middle) if closes else (middle, high)
    return [high]


@computes
def reverse_thresholds(*nu: float) -> Numbers:
    """Friction below which slip reverses under a preload."""
    return [reversal.reverse_threshold(one) for one in nu]


@computes
def reverse_half_widths(*nu: float) -> Numbers:
    """Half-width over c_R of the strip that reverses without friction."""
    return [math.exp(reversal.log_frictionless_half_width(one)) for one in nu]


@computes
def published_limit() -> Numbers:
    """The article's threshold of reverse slip."""
    return [REVERSE_LIMIT]


@computes
def published_limit_over_threshold(nu: float) -> Numbers:
    """The article's threshold over the right one, in millions."""
    return [REVERSE_LIMIT / reversal.reverse_threshold(nu) / 1e6]


@computes
def narrow_strip_error(*nu: float) -> Numbers:
    """Closed form of a narrow reversed strip against the traced threshold."""
    return [
        abs(
            math.exp(reversal.log_narrow_reverse_threshold(one)) / reversal.reverse_threshold(one)
            - 1
        )
        for one in nu
    ]


@computes
def reversal_first_ratio() -> Numbers:
    """Poisson ratio below which slip reverses before a second zone nucleates."""

    def lead(nu: float) -> float:
        return reversal.reverse_threshold(nu) - regime_boundaries.nucleation("preload", nu)

    return [float(brentq(lead, -0.82, -0.72, xtol=1e-6))]


@computes
def strip_half_width(nu: float, chi: float) -> Numbers:
    """Half-width over c_R of the reversed strip under a preload."""
    solution = solve(scene_of("preload", nu, chi))
    strip = next(zone for zone in solution.zones if zone.sense < 0)
    return [(strip.outer - strip.inner) / 2 / solution.scene.material.rayleigh_speed]


@computes
def strip_seen_at(rtol: float, *nu: float) -> Numbers:
    """Nearest of some shares of the threshold at which a tolerance sees the strip, worst ratio."""
    shares = (0.999, 0.998, 0.995, 0.99, 0.98, 0.95, 0.9, 0.8, 0.7)
    worst = 1.0
    for one in nu:
        threshold = reversal.reverse_threshold(one)
        seen = (
            share
            for share in shares
            if any(z.sense < 0 for z in solve(scene_of("preload", one, share * threshold)).zones)
            and any(
                z.sense < 0
                for z in solve(scene_of("preload", one, share * threshold), rtol=rtol).zones
            )
        )
        worst = min(worst, next(seen, 0.0))
    return [worst]


# the self-similar solver


@computes
def closed_form_error(rtol: float) -> Numbers:
    """Largest error of edges and slip rate against the closed forms, nu from -0.9 to 0.499."""
    worst = 0.0
    for nu in (-0.9, -0.5, 0.0, 0.25, THIRD, 0.45, 0.499):
        material = Material(1.0, 1.0, nu)
        speed = edge_speed_under_shear_step(material, 1.0)
        solution = solve(scene_of("preload", nu, 1.0), rtol=rtol)
        worst = max(worst, abs(solution.zones[0].outer - speed))
        xi = speed * np.array([0.0, 0.1, 0.5, 0.9])
        exact = slip_rate_under_shear_step(material, 1.0, 1.0, xi)
        found = np.append(solution.edge_slip_rate, solution.slip_rate(xi[1:], 1.0))
        worst = max(worst, float(np.abs(found - exact).max() / exact.max()))
    return [worst]


@computes
def slip_rate_errors(scene: str, *rtol: float) -> Numbers:
    """Relative L1 error of the slip rate against rtol = 1e-12."""
    return [solver_benchmark.slip_rate_error(NAMED_SCENES[scene].scene, one) for one in rtol]


@cache
def _timings() -> list[solver_benchmark.Timing]:
    return solver_benchmark.measure(9)


@computes
def dense_solves(scene: str, rtol: float) -> Numbers:
    """Time of `solve` over that of a dense 400 x 400 solve."""
    return [row.warm for row in _timings() if row.scene == scene and row.rtol == rtol]


@cache
def _swept(scene: str, rtol: float) -> solver_benchmark.SweepTiming:
    return solver_benchmark.measure_sweep(scene, rtol, 1)


@computes
def sweep_gain(scene: str, rtol: float) -> Numbers:
    """How many times as fast a sweep is, and solutions from scratch."""
    swept = _swept(scene, rtol)
    return [swept.ratio, swept.scratch]


@computes
def sweep_difference(rtol: float) -> Numbers:
    """Largest difference of zone edges between sweep and single solutions, over c_t."""
    return [max(_swept(scene, rtol).difference for scene in solver_benchmark.SWEEPS)]


# where methods fail: the solver


@cache
def _grid(
    loading: regime_boundaries.Loading,
    nu: float,
    chi: float,
    size: int,
    placement: str,
    active: bool,
) -> dict[tuple[str, str], float]:
    rows = studies.grid_rows(loading, nu, chi, size, placement, active)
    return {(row.method.rpartition(", ")[2], row.quantity): row.value for row in rows}


@computes
def least_eigenvalues(*sizes: int) -> Numbers:
    """Of the symmetric part of the Galerkin matrix, nu = 1/3, chi_b = 0.2."""
    return [
        _grid("preload", THIRD, 0.2, size, "galerkin", False)["pivoting", "least eigenvalue"]
        for size in sizes
    ]


@computes
def pivots(*sizes: int) -> Numbers:
    """Of complementary pivoting on Galerkin grids, nu = 1/3, chi_b = 0.2."""
    return [
        _grid("preload", THIRD, 0.2, size, "galerkin", False)["pivoting", "rounds"]
        for size in sizes
    ]


@computes
def odd_even_modes(placement: str, *sizes: int) -> Numbers:
    """Under a remote load, chi = 1.1, nu = 1/3."""
    return [
        _grid("remote", THIRD, 1.1, size, placement, False)["pivoting", "odd-even mode"]
        for size in sizes
    ]


@computes
def grid_error(size: int) -> Numbers:
    """Mean error of V on a Galerkin grid, nu = 1/3, chi_b = 0.2."""
    return [_grid("preload", THIRD, 0.2, size, "galerkin", False)["pivoting", "slip rate error"]]


@computes
def active_set_rounds(size: int) -> Numbers:
    """Rounds of the active set on a Galerkin grid, nu = 1/3, chi_b = 0.2."""
    return [_grid("preload", THIRD, 0.2, size, "galerkin", True)["active set", "rounds"]]


@computes
def nodes_for(error: float) -> Numbers:
    """Fewest and most nodes, over four Poisson ratios, at which the rules reach an error."""
    counts = []
    for nu in (-0.99, 0.0, THIRD, 0.499):
        rows = [row for row in studies.rule_rows(nu) if row.quantity == "slip rate error"]
        counts.append(min(row.parameter for row in rows if row.value <= error))
    return [min(counts), max(counts)]


@computes
def estimate_shares() -> Numbers:
    """Least and largest true error over its estimate [%], in the scenes of the study."""
    shares = []
    for loading, nu, chi in ESTIMATE_SCENES:
        rows = studies.estimate_rows("preload" if loading == "preload" else "remote", nu, chi)
        for true, estimate in zip(rows[::2], rows[1::2], strict=True):
            shares.append(true.value / estimate.value)
    return [100 * min(shares), 100 * max(shares)]


@computes
def impedance_errors(*distances: float) -> Numbers:
    """Relative error of the impedance computed from the slowness alone, at distances from c."""
    rows = [row for row in studies.near_rayleigh_rows(THIRD) if row.method == "from v"]
    # rounding is kind at some distances: the worst within half a decade
    return [
        max(r.value for r in rows if abs(math.log10(r.parameter / distance)) < 0.6)
        for distance in distances
    ]


@computes
def narrowest_gap() -> Numbers:
    """Narrowest stick gap that was followed, and its error against the closed form."""
    rows = studies.narrow_gap_rows(THIRD)
    row = min(rows, key=lambda one: one.parameter)
    return [row.parameter, row.value]


@cache
def _near_limit(limit: str) -> list[studies.StudyRow]:
    return [row for exponent in range(2, 10) for row in studies.limit_rows(limit, exponent)]


@computes
def limit_errors(limit: str, quantity: str) -> Numbers:
    """Largest error of the preloaded zone with chi = 1, from 0.01 to 1e-9 off a limit of nu."""
    return [max(row.value for row in _near_limit(limit) if row.quantity == quantity)]


# the space-time solver


@cache
def _march_error(
    scene: str, nodes: int, step_ratio: float = 0.5, damping: float = 0.7, **changes: float
) -> float:
    """L1 error of the slip rate of a scene, with another Poisson ratio or friction if given."""
    wanted = override_scene(NAMED_SCENES[scene].scene, **changes)
    marched = march(
        wanted,
        nodes=nodes,
        length=spacetime_study.LENGTH,
        step_ratio=step_ratio,
        damping=damping,
        every=10**9,
    )
    return spacetime_study.step_error(wanted, marched)


@computes
def march_errors(nodes: int, *scenes: str) -> Numbers:
    """Relative L1 error of the slip rate at T on 0.02 < x/(c_t T) < 1.9."""
    return [_march_error(scene, nodes) for scene in scenes]


@computes
def march_percents(nodes: int, *scenes: str) -> Numbers:
    """As `march_errors` [%]."""
    return [100 * _march_error(scene, nodes) for scene in scenes]


@computes
def march_percents_of(scene: str, *nodes: int) -> Numbers:
    """As `march_percents`, one scene on several grids."""
    return [100 * _march_error(scene, count) for count in nodes]


@computes
def march_trouble(nu: float, friction: float, step_ratio: float, damping: float) -> Numbers:
    """Error [%] of `preloaded` on 512 nodes with another Poisson ratio, friction and options."""
    return [
        100
        * _march_error("preloaded", 512, step_ratio, damping, poisson_ratio=nu, friction=friction)
    ]


@computes
def grid_edge_percents() -> Numbers:
    """Error of stuck traction over 60 nodes: offset and factors, offset alone, 0.5 [%]."""
    cells = list(spacetime_study.edge().columns[1].cells)
    return [float(str(cell)) for cell in cells[:3]]


@computes
def slow_ramp(rise_time: float) -> Numbers:
    """Static zone over c_t T; length and slip off [%]."""
    zone, length, slip = spacetime_study.ramp_errors(rise_time)
    return [zone, 100 * length, 100 * slip]


@cache
def _worn() -> list[wear.WearRow]:
    chis = [0.0, *np.geomspace(0.01, 2.0, 40).tolist()]
    return list(wear.wear_rows(chis, 600))


@computes
def most_wear(load: str) -> Numbers:
    """Friction at which frictional work is largest, nu = 1/3."""
    return [wear.most_wear(_worn(), load, THIRD)[0]]


# finite elements


@dataclass(frozen=True)
class _Run:
    """What is kept of a simulation."""

    last: Array
    averaged: Array
    unknowns: int
    step: float
    critical: float
    residual: float
    damped: float


@cache
def _run(
    scene: str, resolution: int, element: str = "Q1", mesh: str = "squares", damping: float = 0.02
) -> _Run:
    run = fem_study.simulated(scene, resolution, element=element, mesh=mesh, damping=damping)
    return _Run(
        fem_study.last_profile(run),
        fem_study.averaged_profile(run),
        run.unknowns,
        run.critical_step / run.element_size * run.scene.material.longitudinal_speed,
        run.critical_step,
        run.energy.residual,
        float(run.energy.damping[-1] / run.energy.external[-1]),
    )


@cache
def _errors(scene: str, resolution: int, *options: Any) -> fem_study.Errors:
    run = _run(scene, resolution, *options)
    return fem_study.profile_errors(_solved(scene), run.last, run.averaged)


def _order(coarse: float, fine: float, ratio: float = 2.0) -> float:
    return math.log(coarse / fine) / math.log(ratio)


@computes
def fem_errors(scene: str, resolution: int) -> Numbers:
    """L1 at T and averaged, second peak, that over the largest slip rate."""
    found = _errors(scene, resolution)
    return [found.last, found.averaged, found.second_peak, found.second_over_largest]


@computes
def fem_last(resolution: int) -> Numbers:
    """L1 at T of `preloaded`."""
    return [_errors("preloaded", resolution).last]


@computes
def fem_errors_and_orders(scene: str, resolution: int, coarser: int) -> Numbers:
    """L1 at T, order, L1 averaged, order, second peak, that over the largest slip rate."""
    before, found = _errors(scene, coarser), _errors(scene, resolution)
    ratio = resolution / coarser
    return [
        found.last,
        _order(before.last, found.last, ratio),
        found.averaged,
        _order(before.averaged, found.averaged, ratio),
        found.second_peak,
        found.second_over_largest,
    ]


@computes
def fem_extrapolated(scene: str) -> Numbers:
    """As `fem_errors`, of 2 V(h/2) - V(h) from 1/200 and 1/400."""
    coarse, fine = _run(scene, 200), _run(scene, 400)
    found = fem_study.profile_errors(
        _solved(scene), 2 * fine.last - coarse.last, 2 * fine.averaged - coarse.averaged
    )
    return [found.last, found.averaged, found.second_peak, found.second_over_largest]


@computes
def fem_setting(resolution: int, element: str, damping: float) -> Numbers:
    """A row of the table of second peaks: both scenes, L1 at T, averaged, second peak."""
    both = (
        _errors(scene, resolution, element, "squares", damping)
        for scene in ("preloaded", "remote-shock")
    )
    return [value for one in both for value in (one.last, one.averaged, one.second_peak)]


@computes
def fem_element(element: str, mesh: str, resolution: int, *earlier: int) -> Numbers:
    """Unknowns, dt c_l/h, L1 at T, and the order since an earlier mesh if one is given."""
    run = _run("preloaded", resolution, element, mesh)
    error = _errors("preloaded", resolution, element, mesh).last
    row = [float(run.unknowns), run.step, error]
    for coarse in earlier:
        row.append(_order(_errors("preloaded", coarse, element, mesh).last, error))
    return row


@computes
def fem_damping(damping: float) -> Numbers:
    """A row of the table of damping at 1/200: L1, averaged, second peak, energy, critical step."""
    run = _run("preloaded", 200, "Q1", "squares", damping)
    undamped = _run("preloaded", 200, "Q1", "squares", 0.0)
    found = _errors("preloaded", 200, "Q1", "squares", damping)
    ratio = run.critical / undamped.critical
    return [found.last, found.averaged, found.second_peak, run.damped, ratio]


@computes
def radiated_impedances() -> Numbers:
    """Least impedance of a pair of inner nodes over rho c_t at the default step: Q1, Q2, P1."""
    from fem.assembly import find_family, make_space
    from fem.model import build_model, choose_model
    from meshes import cached_mesh, causal_blocks

    scene, size, found = NAMED_SCENES["preloaded"].scene, 1 / 40, []
    for element in ("Q1", "Q2", "P1"):
        family = find_family(element, "squares")
        blocks = causal_blocks(scene.material, 1.0, size * family.spacing)
        model = build_model(
            scene,
            make_space(cached_mesh(blocks), family),
            name=choose_model(scene, "auto"),
            size=size,
            end_time=1.0,
            damping_time=0.02 * size,
            step_ratio=0.95,
        )
        faces = model.interface.sliding
        assert faces is not None  # shear slides
        found.append(float((faces.step / faces.compliance)[1:].min()))
    return found


@computes
def fem_energy() -> Numbers:
    """Energy balance over the work of the loads, damped or not."""
    return [max(_run("preloaded", 50, "Q1", "squares", eta).residual for eta in (0.0, 0.02))]


@computes
def stuck_history_errors(load: str, resolution: int) -> Numbers:
    """Stuck pressure and shear under a history: L1, and with the offset of the edge."""
    errors = fem_study.stuck_errors(fem_study.LOADS[load], resolution)
    return [*errors["pressure"], *errors["shear"]]


@computes
def slip_changes(variant: str, *resolutions: int) -> Numbers:
    """Change of slip at T from mesh to mesh under another load or friction law."""
    scene = replace(NAMED_SCENES["preloaded"].scene, **fem_study.VARIANTS[variant])
    return fem_study.slip_changes(scene, resolutions)


@computes
def fem_savings(resolution: int) -> Numbers:
    """Unknowns, and what the window and the trimmed domain save."""
    cells = [
        next(iter(column.cells))
        for column in fem_study.cost_table("preloaded", (resolution,)).columns
    ]
    return [float(str(cells[i]).replace(",", "")) for i in (1, 5, 6)]


@computes
def unstable_steps(element: str) -> Numbers:
    """Steps after which a run at 1.05 of the critical step is stopped, damping 0 to 0.2, of how
    many the first."""
    chosen = [
        trial
        for trial in fem_stability.trials(False)
        if trial.study == "step" and trial.element == element and trial.step_ratio == 1.05
    ]
    outcomes = [fem_stability.run_trial(trial) for trial in chosen]
    by_damping = sorted(outcomes, key=lambda outcome: outcome.damping)
    return [by_damping[0].step, by_damping[0].steps, *(one.step for one in by_damping[1:])]


@computes
def graded_errors(*resolutions: int) -> Numbers:
    """L1 of `preloaded` on graded meshes, then on squares."""
    return [
        _errors("preloaded", resolution, "Q1", mesh).last
        for mesh in ("graded", "squares")
        for resolution in resolutions
    ]


@computes
def locking_errors(element: str) -> Numbers:
    """L1 [%] of `preloaded` at h = 1/40 as the Poisson ratio nears 0.5."""
    chosen = (
        trial
        for trial in fem_stability.trials(False)
        if trial.study == "locking" and trial.element == element
    )
    return [100 * fem_stability.run_trial(trial).error for trial in chosen]


# the article


@cache
def _article(chi: float, base: str, nu: float = THIRD) -> Solution:
    return solve(article_cases.article_scene(chi, base, nu))


@computes
def article_edge_rate(chi: float, base: str) -> Numbers:
    """V(0+) over Q_0/(mu b), both one-sided."""
    return [_article(chi, base).edge_slip_rate * chi * 1 / article_cases.SHEAR_SPEED / 2]


@computes
def article_edges(chi: float, base: str, nu: float) -> Numbers:
    """Zone edges over c_t, 0 left out."""
    edges = _article(chi, base, nu).front_speeds.ravel() / article_cases.SHEAR_SPEED
    return edges[edges > 0].tolist()


@computes
def article_reversed(chi: float, nu: float) -> Numbers:
    """Edges of the reversed zone under a preload over c_t."""
    zones = _article(chi, "preloaded", nu).zones
    return [
        edge / article_cases.SHEAR_SPEED
        for zone in zones
        if zone.sense < 0
        for edge in (zone.inner, zone.outer)
    ]


@computes
def article_last_edge(chi: float, base: str, nu: float) -> Numbers:
    """Edge furthest out over c_t."""
    return article_edges(chi, base, nu)[-1:]


@computes
def published_slip_end() -> Numbers:
    """Where the slip wave of the default reading ends at chi = 2, x/(c_t t)."""
    return [examine_reading(DEFAULT_READING).slip_end]


@computes
def published_maximum() -> Numbers:
    """Where slip is fastest by the default reading at chi = 0.5, x/(c_t t)."""
    return [examine_reading(DEFAULT_READING).maximum]


@computes
def published_reversal() -> Numbers:
    """Mean reversed slip rate on 0.63 to 0.95 c_t t over Q_0/(mu b), at chi = 0.5 and 0.01."""
    sample = np.linspace(1.05, 1.6, 100)
    return [-chi * float(published_slip(chi).at(sample).mean()) for chi in (0.5, 0.01)]


@computes
def published_sense_change() -> Numbers:
    """Where the published algorithm changes the sense of slip at chi = 0.01, x/(c_t t)."""
    slip = published_slip(article_cases.LOW_FRICTION)
    behind = slip.u > 1.02
    change = np.flatnonzero(np.diff(np.sign(slip.slip_rate[behind])))[0]
    return [float(1 / slip.u[behind][change])]


@computes
def reading_counts() -> Numbers:
    """Readings of the published algorithm: all, singular, settled."""
    found = examine_all()
    singular = [one for one in found if not math.isfinite(one.condition)]
    return [len(list(readings())), len(singular), sum(one.settled for one in found)]


@cache
def _cases(resolution: int) -> article_cases.Cases:
    return article_cases.run_cases(resolution)


@computes
def article_disagreement(resolution: int) -> Numbers:
    """Largest mean difference of exact and simulated slip rates over Q_0/(mu b)."""
    return [max(case.disagreement() for case in _cases(resolution).everyone())]


@computes
def article_simulated_edge(resolution: int) -> Numbers:
    """Simulated V beside the edge over Q_0/(mu b), remote, chi = 1.2."""
    return [_cases(resolution).remote[1.2].simulated_mean(0.05, 0.3)]


@computes
def article_simulated_reversed(resolution: int) -> Numbers:
    """Where the simulation at nu = -1/2 reverses, x/(c_t t)."""
    velocity, rate = _cases(resolution).auxetic.simulated()
    seen = velocity[rate < -0.01 * np.abs(rate).max()]
    return [float(seen.min()), float(seen.max())]


@computes
def slot_errors(mode: str, element_size: float) -> Numbers:
    """Largest difference of the kernels from finite elements: slot free, slot held."""
    check = article_cases.check_slot("I" if mode == "I" else "II", element_size)
    return [check.error("free"), check.error("held")]


# --- comparing ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Finding:
    """What became of an entry: what is wrong, and what to change; both empty if nothing."""

    entry: Entry
    problem: str = ""
    change: str = ""
    seconds: float = 0.0


def check(entry: Entry, texts_only: bool = False) -> Finding:
    """Compare one entry with its pages and with what is computed now."""
    started = perf_counter()
    missing = entry.missing_pages()
    problem = f"{', '.join(missing)} does not say «{entry.plain}»" if missing else ""
    change = ""
    if not texts_only:
        try:
            values = entry.computed()
        except (SlipfrontError, ValueError, KeyError, StopIteration) as error:
            return Finding(entry, f"cannot be computed: {error}", "", perf_counter() - started)
        off = [
            f"{quoted.written} is {value:.6g}"
            for quoted, value in zip(entry.quoted, values, strict=True)
            if not entry.agrees(quoted, value)
        ]
        if off:
            problem = "; ".join(filter(None, [problem, ", ".join(off)]))
            change = entry.rewritten(values)
    return Finding(entry, problem, change, perf_counter() - started)


def check_all(entries: Iterable[Entry]) -> Iterator[Finding]:
    """Findings of all entries, in order."""
    yield from (check(entry) for entry in entries)


FIGURES = {
    "remote-shock": "slip_rate.png",
    "stuck": "tractions.png",
    "auxetic": "sense.png",
    "ramp": "sense.png",
    "unload": "sense.png",
    "pulse": "sense.png",
    "harmonic": "sense.png",
    "pressure-drop": "sense.png",
}
"""Which figure of `slipfront compare SCENE` docs/scenes.md shows."""


def write_figures(folder: Path = ROOT / "docs" / "figures") -> None:
    """Write the figures of docs/scenes.md as scene_NAME.png, in few colours to keep them small."""
    from PIL import Image

    for scene, name in FIGURES.items():
        path = folder / f"scene_{scene}.png"
        report = _report(scene)
        comparison_figures(report)[name](report).savefig(path, dpi=100)
        with Image.open(path) as image:
            small = image.convert("RGB").quantize(64, dither=Image.Dither.NONE)
        small.save(path, optimize=True)
        print(f"{path} {path.stat().st_size / 1000:.0f} kB")


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the numbers of README and docs with the code; 1 if one is off or not there."""
    parser = argparse.ArgumentParser(prog="python -m compare.numbers", description=__doc__)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="compare (the default)")
    what.add_argument("--write", action="store_true", help="compare, and print what to change")
    what.add_argument("--figures", action="store_true", help="draw those of docs/scenes.md again")
    parser.add_argument("--cheap", action="store_true", help="leave out what takes long")
    parser.add_argument("--verbose", action="store_true", help="print every entry and its time")
    parser.add_argument("ids", nargs="*", help="entries whose id begins so; all unless given")
    options = parser.parse_args(arguments)
    if options.figures:
        write_figures()
        return 0
    entries = [
        entry
        for entry in read_list()
        if (not options.ids or entry.id.startswith(tuple(options.ids)))
        and not (options.cheap and entry.slow)
    ]
    wrong = 0
    for finding in check_all(entries):
        entry = finding.entry
        if finding.problem:
            wrong += 1
            print(f"{entry.id}: {finding.problem}", flush=True)
            if options.write and finding.change:
                print(f"  {', '.join(entry.pages)}: write\n  {finding.change}", flush=True)
        elif options.verbose:
            print(f"{entry.id}: fine, {finding.seconds:.1f} s", flush=True)
    count = sum(len(entry.quoted) for entry in entries)
    print(f"{count} numbers in {len(entries)} texts, {wrong} texts to correct.")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
