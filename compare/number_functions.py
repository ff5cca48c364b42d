"""What the numbers of docs/numbers.toml are: public functions, each of one or several of them.

Those that another module has already are named there with their module, one of those imported here.
article_* and published_* give velocities over c_t and slip rates over Q_0/(mu b), one-sided.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from compare.comparison.predictions import contact_nodes
from compare.comparison.report import default_report
from compare.studies import wear
from compare.studies.accuracy import fem as fem_study
from compare.studies.accuracy import spacetime as spacetime_study
from compare.studies.article import cases as article_cases
from compare.studies.article import claims as article_claims
from compare.studies.chart import benchmark as solver_benchmark
from compare.studies.stability import fem as fem_stability
from compare.studies.stability import sweeps as studies
from compare.studies.stability.solver import ESTIMATE_SCENES
from semianalytic import Harmonic, Material, Scene, Solution, march, solve
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import Mode, rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
)
from semianalytic.reference.published import (
    DEFAULT_READING,
    REVERSE_LIMIT,
    examine_all,
    examine_reading,
    readings,
)
from semianalytic.regimes import reverse_slip
from semianalytic.regimes import thresholds as regime_boundaries
from semianalytic.regimes.thresholds import Loading, scene_of
from semianalytic.scene.named import NAMED_SCENES, override_scene
from semianalytic.spacetime.resolution import zone_at_edge

Array = NDArray[np.float64]
Numbers = Sequence[float] | Array

THIRD = 1 / 3


@cache
def _solved(scene: str) -> Solution:
    return solve(NAMED_SCENES[scene].scene, rtol=1e-10)


def _bisected(low: float, high: float, width: float, beyond: Callable[[float], bool]) -> float:
    """Where something starts to be the case between two numbers, from above."""
    while high - low > width:
        middle = (low + high) / 2
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return high


# --- theory: stuck tractions, closed forms --------------------------------------------------------


def stuck_tractions(nu: float, mode: Mode, *slowness: float) -> Array:
    """p* (I) or q* (II) at slownesses [b]."""
    return stuck_traction(nu, mode)(np.array(slowness))


def one_zone_edge(nu: float, chi: float) -> Numbers:
    """Speed of the only zone under a shear step over c_t, and one-sided V(0+) over Q_0/(mu b)."""
    material = Material(1.0, 1.0, nu)
    rate = slip_rate_under_shear_step(material, 1.0, chi, np.array([0.0]))[0] / 2
    return [edge_speed_under_shear_step(material, chi), rate]


def everywhere_share(nu: float, *velocity: float) -> Array:
    """Lambda of a remote load under which all slips, at velocities [c_t]: V less its rest."""
    # with f P_0 = Q_0 = 1 only f P_0 Lambda is left of V
    material = Material(1.0, 1.0, nu)
    return slip_rate_under_remote_shock(material, 1.0, 1.0, 1.0, np.array(velocity)) / 2


def rayleigh_speed(nu: float) -> float:
    """c_R over c_t."""
    return Material(1.0, 1.0, nu).rayleigh_speed


def hidden_root_ratio() -> float:
    """Poisson ratio from which the hidden root of the Rayleigh function is complex."""
    return _bisected(0.2, 0.3, 1e-9, lambda nu: rayleigh_factors(nu).hidden_root.imag != 0)


def pressure_negative_until() -> float:
    """Where p* changes sign between c_t t and the edge, x / (c_t t) at nu = 1/3."""
    pressure = stuck_traction(THIRD, "I")
    return 1 / brentq(lambda u: float(pressure(u)), 1.1, 5.0)


def grid_edge() -> float:
    """Distance from the grid's own edge to the first contact node, over the node distance."""
    return edge_offset_and_factors()[0]


def memory_poles(nu: float, nodes: int, tolerance: float) -> float:
    """Exponentials that carry the memory of a default march."""
    scene = scene_of("preload", nu, 0.3)
    return march(scene, nodes=nodes, every=10**6, tolerance=tolerance).statistics.poles


# --- named scenes ---------------------------------------------------------------------------------


def scene_intensity(scene: str) -> Numbers:
    """K_I and K_II at t = 1."""
    return [float(one) for one in _solved(scene).stress_intensity(1.0)]


def edge_rate(scene: str) -> float:
    """Relative slip rate at the contact edge [length / time]."""
    return _solved(scene).edge_slip_rate


_report = cache(default_report)


@cache
def _rows(scene: str) -> dict[str, dict[str, Any]]:
    return {row.quantity: asdict(row) for row in _report(scene).rows}


def comparison(scene: str, quantity: str, *columns: str) -> Numbers:
    """Columns (prediction, simulation, difference) of one row of the report of a scene."""
    return [_rows(scene)[quantity][column] for column in columns]


def comparison_rows(scene: str, column: str, *quantities: str) -> Numbers:
    """One column of several rows of the report of a scene."""
    return [_rows(scene)[quantity][column] for quantity in quantities]


def simulated_lift(scene: str) -> float:
    """How far the contact has opened at T over c_t T in a default simulation."""
    seen = fem_study.simulated(scene, 100).interface
    return seen.x[seen.pressure[-1] == 0].max()


def largest_rates(scene: str) -> Numbers:
    """Largest forward slip rate, four elements off the edge, predicted and simulated.

    At T where x/t is all that counts, over space and time from 0.2 T on otherwise.
    """
    report = _report(scene)
    predicted, seen = report.prediction.interface, contact_nodes(report.simulation)
    shown = seen.x > 4.5 * report.simulation.element_size
    since = 0.2 if report.prediction.solution is None else 1.0
    later = seen.t >= since * seen.t[-1]
    return [one.slip_rate[np.ix_(later, shown)].max() for one in (predicted, seen)]


# --- regimes --------------------------------------------------------------------------------------


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


def edge_threshold_shift(nu: float) -> float:
    """What slip at the shear front adds to the threshold of the edge."""
    return regime_boundaries.edge_threshold(nu) - regime_boundaries.edge_threshold_alone(nu)


def preload_gap_ratio() -> float:
    """Poisson ratio above which a preloaded gap at c_R gets narrower than 1e-14."""
    threshold = regime_boundaries.gap_threshold
    return _bisected(0.45, 0.49, 1e-6, lambda nu: threshold("preload", nu) is not None)


def reverse_half_width(nu: float) -> float:
    """Half-width over c_R of the strip that reverses without friction."""
    return math.exp(reverse_slip.log_frictionless_half_width(nu))


def narrow_strip_error(nu: float) -> float:
    """Closed form of a narrow reversed strip against the traced threshold."""
    closed_form = math.exp(reverse_slip.log_narrow_reverse_threshold(nu))
    return abs(closed_form / reverse_slip.reverse_threshold(nu) - 1)


def reversal_first_ratio() -> float:
    """Poisson ratio below which slip reverses before a second zone nucleates."""

    def lead(nu: float) -> float:
        return reverse_slip.reverse_threshold(nu) - regime_boundaries.nucleation("preload", nu)

    return brentq(lead, -0.82, -0.72, xtol=1e-6)


def strip_half_width(nu: float, chi: float) -> float:
    """Half-width over c_R of the reversed strip under a preload."""
    solution = solve(scene_of("preload", nu, chi))
    strip = next(zone for zone in solution.zones if zone.sense < 0)
    return (strip.outer - strip.inner) / 2 / solution.scene.material.rayleigh_speed


def strip_seen_at(rtol: float, *nu: float) -> float:
    """Nearest of some shares of the threshold at which a tolerance sees the strip, worst ratio."""
    shares = (0.999, 0.998, 0.995, 0.99, 0.98, 0.95, 0.9, 0.8, 0.7)

    def reverses(nu: float, chi: float, **options: float) -> bool:
        return any(zone.sense < 0 for zone in solve(scene_of("preload", nu, chi), **options).zones)

    def nearest(nu: float) -> float:
        chi = reverse_slip.reverse_threshold(nu)
        seen = (s for s in shares if reverses(nu, s * chi) and reverses(nu, s * chi, rtol=rtol))
        return next(seen, 0.0)

    return min(nearest(one) for one in nu)


# --- the self-similar solver ----------------------------------------------------------------------


def closed_form_error(rtol: float) -> float:
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
    return worst


def slip_rate_errors(scene: str, *rtol: float) -> Numbers:
    """Relative L1 error of the slip rate against rtol = 1e-12."""
    return [solver_benchmark.slip_rate_error(NAMED_SCENES[scene].scene, one) for one in rtol]


@cache
def _timings() -> list[solver_benchmark.Timing]:
    return solver_benchmark.measure(9)


def dense_solves(scene: str, rtol: float) -> Numbers:
    """Time of `solve` over that of a dense 400 x 400 solve."""
    return [row.warm for row in _timings() if row.scene_name == scene and row.rtol == rtol]


@cache
def _swept(scene: str, rtol: float) -> solver_benchmark.SweepTiming:
    return solver_benchmark.measure_sweep(scene, rtol, 1)


def sweep_gain(scene: str, rtol: float) -> Numbers:
    """How many times as fast a sweep is, and solutions from scratch."""
    swept = _swept(scene, rtol)
    return [swept.ratio, swept.scratch]


def sweep_difference(rtol: float) -> Numbers:
    """Largest difference of zone edges between sweep and single solutions, over c_t."""
    return [max(_swept(scene, rtol).difference for scene in solver_benchmark.SWEEPS)]


# --- where the solver fails -----------------------------------------------------------------------

_grid_rows = cache(studies.grid_rows)


def first_stage(loading: Loading, placement: str, way: str, quantity: str, size: int) -> float:
    """A quantity on a grid, by "pivoting" or an "active set": chi_b = 0.2, or remote chi = 1.1."""
    chi, active = {"preload": 0.2, "remote": 1.1}[loading], way == "active set"
    rows = _grid_rows(loading, THIRD, chi, size, placement, active)
    found = {row.quantity: row.value for row in rows if row.method == f"{placement}, {way}"}
    return found[quantity]


def guess_error(count: int) -> float:
    """Median error of the edge unknowns that Newton's method starts from, in random scenes."""
    return float(np.median(studies.guess_errors("preload", count)))


def nodes_for(error: float) -> Numbers:
    """Fewest and most nodes, over four Poisson ratios, at which the rules reach an error."""
    counts = []
    for nu in (-0.99, 0.0, THIRD, 0.499):
        rows = [row for row in studies.rule_rows(nu) if row.quantity == "slip rate error"]
        counts.append(min(row.parameter for row in rows if row.value <= error))
    return [min(counts), max(counts)]


def estimate_shares() -> Numbers:
    """Least and largest true error over its estimate, in the scenes of the study."""
    shares = []
    for scene in ESTIMATE_SCENES:
        rows = studies.estimate_rows(*scene)
        for true, estimate in zip(rows[::2], rows[1::2], strict=True):
            shares.append(true.value / estimate.value)
    return [min(shares), max(shares)]


def impedance_error(distance: float) -> float:
    """Relative error of the impedance computed from the slowness alone, at a distance from c."""
    rows = [row for row in studies.near_rayleigh_rows(THIRD) if row.method == "from v"]
    # rounding is kind at some distances: the worst within half a decade
    return max(row.value for row in rows if abs(math.log10(row.parameter / distance)) < 0.6)


def narrowest_gap() -> Numbers:
    """Narrowest stick gap that was followed, and its error against the closed form."""
    row = min(studies.narrow_gap_rows(THIRD), key=lambda one: one.parameter)
    return [row.parameter, row.value]


@cache
def _near_limit(limit: str) -> list[studies.StudyRow]:
    return [row for exponent in range(2, 10) for row in studies.limit_rows(limit, exponent)]


def limit_error(limit: str, quantity: str) -> float:
    """Largest error of the preloaded zone with chi = 1, from 0.01 to 1e-9 off a limit of nu."""
    return max(row.value for row in _near_limit(limit) if row.quantity == quantity)


# --- the space-time solver ------------------------------------------------------------------------


def march_error(nodes: int, scene: str) -> float:
    """Relative L1 error of the slip rate at T on 0.02 < x/(c_t T) < 1.9."""
    described = NAMED_SCENES[scene].scene
    return spacetime_study.step_error(described, spacetime_study.last_march(described, nodes))


def march_wave_error(steps: float) -> float:
    """Error of frictional work under ten cycles of shear with so many steps a period."""
    scene = replace(NAMED_SCENES["harmonic"].scene, shear_history=Harmonic(10.0))
    return _work_error(scene, round(10 * steps), 4096)


def march_zone_error(nodes: float) -> float:
    """Error of frictional work of a step at high friction with so many nodes in the slip zone."""
    scene = replace(NAMED_SCENES["preloaded"].scene, friction=5.0)
    return _work_error(scene, round(2 * nodes / zone_at_edge(scene, 1.0)), 4096)


def _work_error(scene: Scene, nodes: int, finest: int) -> float:
    return abs(_march_work(scene, nodes) / _march_work(scene, finest) - 1)


@cache
def _march_work(scene: Scene, nodes: int) -> float:
    """Frictional work of a march to T = 1 on a length of 2, per unit thickness."""
    marched = march(scene, 1.0, nodes, length=2.0, every=10**9)
    return float(marched.friction_work.sum() * marched.grid.spacing)


def march_trouble(nu: float, friction: float, step_ratio: float, damping: float) -> float:
    """The same of `preloaded` on 512 nodes with another Poisson ratio, friction and options."""
    preloaded = NAMED_SCENES["preloaded"].scene
    scene = override_scene(preloaded, poisson_ratio=nu, friction=friction)
    marched = spacetime_study.last_march(scene, 512, step_ratio=step_ratio, damping=damping)
    return spacetime_study.step_error(scene, marched)


def grid_edge_percents() -> Numbers:
    """Error of stuck traction over 60 nodes: offset and factors, offset alone, 0.5 [%]."""
    cells = list(spacetime_study.edge().columns[1].cells)
    return [float(str(cell)) for cell in cells[:3]]


def slow_ramp(rise_time: float) -> Numbers:
    """Static zone over c_t T; length and slip off [%]."""
    zone, length, slip = spacetime_study.ramp_errors(rise_time)
    return [zone, 100 * length, 100 * slip]


@cache
def _worn() -> list[wear.WearRow]:
    chis = [0.0, *np.geomspace(0.01, 2.0, 40).tolist()]
    return list(wear.swept_rows(chis, 600))


def most_wear(load: str) -> float:
    """Friction at which frictional work is largest, nu = 1/3."""
    return wear.most_wear(_worn(), load, THIRD)[0]


# --- finite elements ------------------------------------------------------------------------------


class _Run(NamedTuple):
    """What is kept of a simulation."""

    last: Array
    averaged: Array
    unknowns: int
    step: float
    critical: float
    residual: float
    damped: float


@cache
def _simulated(scene: str, resolution: int, element: str, mesh: str, damping: float) -> _Run:
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


def _run(
    scene: str, resolution: int, element: str = "Q1", mesh: str = "squares", damping: float = 0.02
) -> _Run:
    return _simulated(scene, resolution, element, mesh, damping)


def _errors(scene: str, *options: Any) -> fem_study.Errors:
    run = _run(scene, *options)
    return fem_study.profile_errors(_solved(scene), run.last, run.averaged)


def _four(errors: fem_study.Errors) -> Numbers:
    return [errors.last, errors.averaged, errors.second_peak, errors.second_over_largest]


def fem_errors(scene: str, resolution: int) -> Numbers:
    """L1 at T and averaged, second peak, that over the largest slip rate."""
    return _four(_errors(scene, resolution))


def fem_last(resolution: int, mesh: str = "squares") -> float:
    """L1 at T of `preloaded`."""
    return _errors("preloaded", resolution, "Q1", mesh).last


def fem_errors_and_orders(scene: str, resolution: int, coarser: int) -> Numbers:
    """L1 at T, order, L1 averaged, order, second peak, that over the largest slip rate."""
    before, found = _errors(scene, coarser), _errors(scene, resolution)
    last, averaged = (
        fem_study.observed_order(getattr(before, name), getattr(found, name), resolution / coarser)
        for name in ("last", "averaged")
    )
    one, other, *peaks = _four(found)
    return [one, last, other, averaged, *peaks]


def fem_extrapolated(scene: str) -> Numbers:
    """As `fem_errors`, of 2 V(h/2) - V(h) from 1/200 and 1/400."""
    coarse, fine = _run(scene, 200), _run(scene, 400)
    last, averaged = 2 * fine.last - coarse.last, 2 * fine.averaged - coarse.averaged
    return _four(fem_study.profile_errors(_solved(scene), last, averaged))


def fem_setting(resolution: int, element: str, damping: float) -> Numbers:
    """A row of the table of second peaks: both scenes, L1 at T, averaged, second peak."""
    settings = (resolution, element, "squares", damping)
    both = (_four(_errors(scene, *settings)) for scene in ("preloaded", "remote-shock"))
    return [value for one in both for value in one[:3]]


def fem_element(element: str, mesh: str, resolution: int, *earlier: int) -> Numbers:
    """Unknowns, dt c_l/h, L1 at T, and the order since an earlier mesh if one is given."""
    run = _run("preloaded", resolution, element, mesh)
    error = _errors("preloaded", resolution, element, mesh).last
    before = (_errors("preloaded", coarse, element, mesh).last for coarse in earlier)
    return [run.unknowns, run.step, error, *(fem_study.observed_order(b, error) for b in before)]


def fem_damping(damping: float) -> Numbers:
    """A row of the table of damping at 1/200: L1, averaged, second peak, energy, critical step."""
    settings = ("preloaded", 200, "Q1", "squares")
    run, undamped = _run(*settings, damping), _run(*settings, 0.0)
    last, averaged, second, _ = _four(_errors(*settings, damping))
    return [last, averaged, second, run.damped, run.critical / undamped.critical]


def radiated_impedance(element: str) -> float:
    """Least impedance of a pair of inner nodes over rho c_t at the default step."""
    scene = NAMED_SCENES["preloaded"].scene
    faces = fem_study.default_model(scene, 40, element).interface.sliding
    assert faces is not None  # shear slides
    return (faces.step / faces.compliance)[1:].min()


def fem_energy() -> float:
    """Energy balance over the work of the loads, damped or not."""
    return max(_run("preloaded", 50, "Q1", "squares", eta).residual for eta in (0.0, 0.02))


def stuck_history_errors(load: str, resolution: int) -> Numbers:
    """Stuck pressure and shear under a history: L1, and with the offset of the edge."""
    errors = fem_study.stuck_errors(fem_study.LOADS[load], resolution)
    return [*errors["pressure"], *errors["shear"]]


def slip_changes(variant: str, *resolutions: int) -> Numbers:
    """Change of slip at T from mesh to mesh under another load or friction law."""
    scene = replace(NAMED_SCENES["preloaded"].scene, **fem_study.VARIANTS[variant])
    return fem_study.slip_changes(scene, resolutions)


def fem_savings(resolution: int) -> Numbers:
    """Unknowns, and what the window and the trimmed domain save."""
    columns = fem_study.cost_table("preloaded", (resolution,)).columns
    cells = [str(next(iter(column.cells))).replace(",", "") for column in columns]
    return [float(cells[i]) for i in (1, 5, 6)]


def _trials(study: str, element: str) -> list[fem_stability.Trial]:
    every = fem_stability.trials(quick=False)
    return [trial for trial in every if (trial.study, trial.element) == (study, element)]


def unstable_steps(element: str) -> Numbers:
    """Steps after which a run at 1.05 of the critical step is stopped, damping 0 to 0.2, of how
    many the first."""
    chosen = (trial for trial in _trials("step", element) if trial.step_ratio == 1.05)
    first, *others = map(fem_stability.run_trial, sorted(chosen, key=lambda one: one.damping))
    return [first.step, first.steps, *(outcome.step for outcome in others)]


def locking_errors(element: str) -> Numbers:
    """L1 of `preloaded` at h = 1/40 as the Poisson ratio nears 0.5."""
    return [fem_stability.run_trial(trial).error for trial in _trials("locking", element)]


# --- the article ----------------------------------------------------------------------------------


@cache
def _article(chi: float, base: str, nu: float = THIRD) -> Solution:
    return solve(article_cases.article_scene(chi, base, nu))


def article_edge_rate(chi: float, base: str) -> float:
    """V(0+)."""
    return _article(chi, base).edge_slip_rate * chi * 1 / article_cases.SHEAR_SPEED / 2


def article_edges(chi: float, base: str, nu: float, first: int = 0) -> Array:
    """Zone edges from the first of them on, 0 left out."""
    edges = _article(chi, base, nu).edge_speeds.ravel() / article_cases.SHEAR_SPEED
    return edges[edges > 0][first:]


def article_reversed(chi: float, nu: float) -> Numbers:
    """Edges of the reversed zone under a preload."""
    zones = [zone for zone in _article(chi, "preloaded", nu).zones if zone.sense < 0]
    edges = [edge for zone in zones for edge in (zone.inner, zone.outer)]
    return [edge / article_cases.SHEAR_SPEED for edge in edges]


def published_limit() -> float:
    """The article's threshold of reverse slip."""
    return REVERSE_LIMIT


def published_limit_over_threshold(nu: float) -> float:
    """The article's threshold over the right one, in millions."""
    return REVERSE_LIMIT / reverse_slip.reverse_threshold(nu) / 1e6


def published_reading(quantity: str) -> float:
    """Of the default reading: slip_end at chi = 2, or maximum at chi = 0.5."""
    return getattr(examine_reading(DEFAULT_READING), quantity)


def reading_counts() -> Numbers:
    """Readings of the published algorithm: all, singular, settled."""
    found = examine_all()
    singular = [one for one in found if not math.isfinite(one.condition)]
    return [len(list(readings())), len(singular), sum(one.settled for one in found)]


@cache
def _cases(resolution: int) -> article_cases.Cases:
    return article_cases.run_cases(resolution)


def article_disagreement(resolution: int) -> float:
    """Largest mean difference of exact and simulated slip rates."""
    return _cases(resolution).disagreement()


def article_simulated_edge(resolution: int) -> float:
    """Simulated V beside the edge, remote, chi = 1.2."""
    return _cases(resolution).remote[1.2].simulated_mean(0.05, 0.3)


def article_simulated_reversed(resolution: int) -> Numbers:
    """Where the simulation at nu = -1/2 reverses."""
    seen = article_claims.simulated_reversal(_cases(resolution).auxetic)
    return [seen.min(), seen.max()]


def slot_errors(mode: Mode, element_size: float) -> Numbers:
    """Largest difference of the kernels from finite elements: slot free, slot held."""
    check = article_cases.check_slot(mode, element_size)
    return [check.error("free"), check.error("held")]
