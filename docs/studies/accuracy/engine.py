"""The engine against exact numbers, statics, dispersion relations, and finer grids of its own.

``python -m docs.studies.accuracy.engine --output docs`` makes the tables of how_we_know.md in
some minutes; growth rates come from the dispersion relation by Newton's method, marches from `run`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.integrate import cumulative_trapezoid, quad

import semianalytic as sf
from docs.studies.lines import scene_along
from docs.studies.runner import Row, Study, main
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.halfplane.rayleigh import Mode, RayleighFactors, rayleigh_factors
from semianalytic.memory.impedance import Antiplane, Impedance, InPlane
from semianalytic.reference.ruptures import critical_wavenumber, growth, supershear_strength
from semianalytic.scene.arrays import Array

MODES: dict[str, Impedance] = {"II": InPlane(1 / math.sqrt(3)), "III": Antiplane()}
UNIT, SOLID = sf.Material(1.0, 1.0, 0.25), sf.Material(1.0, 1.0, 1 / 3)
SIDES: tuple[tuple[str, Mode, Impedance], ...] = (
    ("in-plane", "II", InPlane(SOLID.shear_speed / SOLID.longitudinal_speed)),
    ("antiplane", "III", Antiplane()),
)
"""Both modes, and their impedances in the solid of the cracks and patches."""
RATIOS, INERTIAS = (1.1, 1.4, 2.0), (0.01, 0.1, 0.3, 1.0, 3.0)
SHARES = (0.3, 0.5, 0.7, 0.9)
"""Wavenumbers over the critical one: the growing waves of the notes."""
WEAKEST = 0.004
"""Slowest growth that is marched [V / L]; half of it would need marches of 1,250 L / V."""


def line(case: str, quantity: str, reference: str, here: str, difference: str) -> Row:
    """Return a row of the table."""
    row: Row = {"case": case, "quantity": quantity, "reference": reference}
    return row | {"here": here, "difference": difference}


def compared(case: str, quantity: str, reference: float, here: float, digits: int = 8) -> Row:
    """Return a row of two numbers and their relative difference."""
    off = f"{abs(here / reference - 1):.1e}"
    return line(case, quantity, f"{reference:.{digits}g}", f"{here:.{digits}g}", off)


def profile(case: str, quantity: str, known: Array, found: Array) -> Row:
    """Return a row of the relative L1 difference of two profiles."""
    off = float(np.abs(found - known).sum() / np.abs(known).sum())
    return line(case, quantity, "exact profile", "L1", f"{off:.1e}")


def profiles(
    case: str, answer: sf.Solution, done: sf.Marched, *fields: str, least: float, most: float
) -> Iterator[Row]:
    """Yield rows of fields of a run at its end, against a solution at unit time between places."""
    near = (done.interface.x > least) & (done.interface.x < most)
    for field in fields:
        known = getattr(answer, field)(done.interface.x[near], 1.0)
        yield profile(case, field.replace("_", " "), known, getattr(done.interface, field)[0][near])


def ended(fault: sf.Scene, nodes: int, end: float = 1.0) -> sf.Marched:
    """Run an interface and keep its end alone."""
    return sf.solve(fault, end_time=end, nodes=nodes, times=[end], estimate=False)


def exact() -> Iterator[Row]:
    """Yield numbers that need no march, against digits computed by others of this project."""
    for mode, ratio, inertia, known in (
        ("III", 1.4, 1.0, 0.7483314774),
        ("II", 1.4, 1.0, 0.7443485228),
        ("II", 2.0, 10.0, 10.9682149592),
    ):
        found = critical_wavenumber(ratio, inertia, MODES[mode])
        case = f"steady sliding, mode {mode}, b/a {ratio:g}, inertia {inertia:g}"
        yield compared(case, "critical wavenumber", known, found, 12)
    for nu, known in ((0.1, 1.2791911), (0.25, 1.7746479), (0.4, 2.4408742)):
        case = f"crack at the Rayleigh speed, Poisson ratio {nu:g}"
        yield compared(case, "critical strength S", known, supershear_strength(nu))


def marched_growth(mode: str, ratio: float, inertia: float, kappa: float, step: float) -> complex:
    """Return lambda L / V0 of a marched wave, by linear prediction of its amplitude.

    The wave grows at least tenfold and at most e^9-fold: a march of 60 L / V0 whatever the growth
    rate took the fastest waves beyond the linear range, and their rates were off by .02 to .9.  The
    mean slip is held.
    """
    found = growth(ratio, inertia, kappa, MODES[mode])
    a = 0.01
    rate, q = inertia * 2 * a, kappa * 2 * a
    law = sf.RateAndState(a, ratio * a, 0.6, rate, 1.0)
    kick = sf.InterfaceLoad(lambda x: 1e-8 * np.cos(q * x), history=lambda t: math.exp(-rate * t))
    fault = scene_along(
        UNIT,
        law,
        2 * math.pi / q,
        shear=0.6,
        rate=rate,
        plate_rate=rate,
        held=2 * math.pi / q / 3,
        mode="in-plane" if mode == "II" else "antiplane",
        loads=[kick],
        even=True,
    )
    # waves that die away fall like t^-3/2, and weak growth needs its time; slip rates of the wave
    # stay below 1e-4 of V0, where friction is linear
    until = min(max(60.0, 2.5 / found.real), 9.0 / found.real)
    stepper = Stepper(fault, 8, 0.4, end_time=until / rate)
    now, amplitudes = stepper.begin(), []
    for _ in range(int(until / step)):
        now = stepper.step(now, step / rate, 0)
        amplitudes.append(float(stepper.grid.amplitudes(now.rate - rate)[0, 1]))
    every = max(1, int(0.4 / step))
    history = np.array(amplitudes)[len(amplitudes) // 3 :: every]
    columns = np.array([history[i : i + 4] for i in range(len(history) - 4)])
    predicted = np.linalg.lstsq(columns, history[4:], rcond=None)[0]
    roots = np.log(np.roots([1.0, *-predicted[::-1]])) / (step * every)
    return complex(roots[np.argmin(np.abs(roots - found))])


def dispersion() -> Iterator[Row]:
    """Yield growing waves of rate-and-state friction, marched, against the dispersion relation.

    The grid is that of the 210 digits of the notes (two modes, three b/a, five inertias, seven
    wavelengths), without the waves that decay, whose rates cannot be told from a march.
    """
    errors, weak = [], 0
    for mode, ratio, inertia, share in product(MODES, RATIOS, INERTIAS, SHARES):
        kappa = share * critical_wavenumber(ratio, inertia, MODES[mode])
        known = growth(ratio, inertia, kappa, MODES[mode])
        if known.real < WEAKEST:
            weak += 1
            continue
        # the march is of second order in |Lambda| times the step: 1e-3 at .05 L / V0 and |Lambda| 1
        found = marched_growth(mode, ratio, inertia, kappa, 0.05)
        errors.append(abs(found - known) / abs(known))
    yield line(
        f"{len(errors)} growing waves, steps of 0.05 L/V ({weak} grow slower than {WEAKEST:g} V/L)",
        "complex growth rate",
        "dispersion relation",
        f"median off by {np.median(errors):.1e}",
        f"{max(errors):.1e} at most",
    )


def patches() -> Iterator[Row]:
    """Yield slip around an over-stressed patch |x| < 0.3 c_t t, whose edges and rate are known.

    The slip rate is C / (pi p sqrt(p^2 - s^2)) artanh or arcoth of v sqrt(p^2 - s^2) / (p sqrt(v^2
    - s^2)) at slowness v = t/x, with p, s the slownesses of patch and edge and C = 2 p sqrt(p^2 -
    s^2) / |Im G(-i/p)|.  The load rises over 8 nodes, without which its steps send noise.
    """
    for (mode, _, impedance), edge in zip(SIDES, (0.395154, 0.384265), strict=True):
        p, s = 1 / 0.3, 1 / edge
        root = math.sqrt(p * p - s * s)
        strength = 2 * p * root / abs(impedance(np.array([1e-300 - 1j / p]))[0].imag)
        for nodes in (1024, 4096):

            def shear(x: Array, t: float, n: int = nodes) -> Array:
                rise = np.clip((0.3 * t - np.abs(x)) * n / 20 + 0.5, 0, 1)
                return np.asarray(rise * rise * (3 - 2 * rise))

            load = sf.InterfaceLoad(shear, history=None)
            fault = scene_along(SOLID, sf.Coulomb(0.5), 2.5, loads=[load], mode=mode, even=True)
            done = ended(fault, nodes)
            v = 1 / done.interface.x[1:]
            y = v * root / (p * np.sqrt(np.maximum(v * v - s * s, 1e-12)))
            inner = np.arctanh(np.minimum(np.minimum(y, 1 / y), 1 - 1e-15))
            known = np.where(v > s, 2 * strength / (math.pi * p * root) * inner, 0.0)
            case = f"over-stressed patch, {mode}, {nodes} nodes"
            yield profile(case, "slip rate", known, done.interface.slip_rate[0][1:])
            if nodes == 4096:
                found = float(done.interface.x[done.interface.slip_rate[0] > 1e-9].max())
                yield compared(case, "edge", edge, found, 6)


def fronts() -> Iterator[Row]:
    """Yield slip rate and traction under waves at an angle and moving loads next to a slot."""
    for name, front, mode, at, length in (
        ("SV wave, -20 degrees", sf.IncidentWave("SV", -20.0, stress=0.3), "in-plane", 0.0, 12.0),
        ("SH wave, -40 degrees", sf.IncidentWave("SH", -40.0, stress=0.3), "antiplane", 0.0, 12.0),
        ("load that leaves at 4 c_t", sf.MovingLoad(4.0, 0.0, 1.0), "in-plane", 0.0, 12.0),
        # it enters the slot 10 before the tip, from where waves arrive too late
        ("load that comes at 4 c_t", sf.MovingLoad(-4.0, 0.0, 1.0), "in-plane", -10.0, 20.0),
    ):
        scene = sf.Scene(SOLID, friction=0.3, base=sf.Tractions(1.0, 0.0), load=front, mode=mode)
        answer, end = sf.solve(scene), 1.0 - front.slowness(SOLID) * at
        loads, half = [sf.FrontLoad(front, at=at)], sf.Contact.half_line()
        face = scene_along(SOLID, sf.Coulomb(0.3), length, 1.0, 0.0, loads, half, mode)
        for nodes in (512, 1024, 2048):
            done, case = ended(face, nodes, end), f"{name}, {nodes} nodes"
            fields = ("slip_rate", "shear_traction")
            yield from profiles(case, answer, done, *fields, least=0.02, most=1.9)


def kostrov_slip(x: Array, speed: float, impedance: Impedance) -> Array:
    """Return the slip (n,) of a crack |x| < v t at unit time, with unit modulus, c_t and drop.

    It is 2 A sqrt(v^2 - x^2), with the stress drop (A / v) int_0^inf G(1/y) / (1/v^2 + y^2)^(3/2)
    dy of the impedance G.
    """
    drop = quad(
        lambda y: float(impedance(np.array([1 / y + 0j]))[0].real) / (speed**-2 + y * y) ** 1.5,
        0.0,
        np.inf,
        epsabs=1e-13,
        epsrel=1e-10,
    )[0]
    return 2 * speed / drop * np.sqrt(np.maximum(speed**2 - x * x, 0.0))


def freund_slip(x: Array, speed: float, factors: RayleighFactors, mode: Mode) -> Array:
    """Return the slip (n,) at 0 < x < v of a half-plane crack that runs since t = 0, at unit time.

    Slot x < 0 and crack 0 < x < v t lose the shear 1 that all of the line carries before.  With the
    slowness u = 1/v of the tip the traction is M_+(k)/M_+(0) (1 + k/u)^(-3/2), so that the slip
    rate falls behind the tip by g(s) (s/u - 1)^(-3/2) per slowness s = t/x,
    g = 1 / (pi s kappa M_+(0) M_+(s)); the tip's singularity is Freund's K(v) = k(v) K(0).
    """
    u = 1 / speed
    w = np.linspace(0.0, math.sqrt(max(1 / x.min() / u - 1, 0.0)), 40001)
    s = u * (1 + w * w)
    start = factors.m_plus_at_zero[mode]
    g = 1 / (math.pi * s * factors.kappa * start * factors.m_plus(s, mode))
    steep = np.empty_like(w)
    steep[1:] = (g[1:] - g[0]) / w[1:] ** 2
    steep[0] = steep[1]
    # the finite part of the integral, and slip over x: both with w as the variable
    rate = 2 * u * (g[0] - w * cumulative_trapezoid(steep, w, initial=0))
    slip = cumulative_trapezoid(2 * u * rate, w, initial=0)
    behind = np.sqrt(np.maximum(1 / x / u - 1, 0.0))
    return np.asarray(2 * x * np.interp(behind, w, slip))


def cracks() -> Iterator[Row]:
    """Yield slip of cracks of prescribed speed c_t / 2, on a whole line and next to a slot.

    Kostrov's crack grows from a point, Freund's from the edge of a slot that is freed at t = 0.
    """
    speed = 0.5
    law = sf.ForcedFront(static=100.0, dynamic=0.0, arrival=lambda x: np.abs(x) / speed)
    off, beside = sf.InterfaceLoad(1.0, on="slot"), sf.Contact.half_line()
    for side, mode, impedance in SIDES:
        for nodes in (512, 1024, 2048, 4096):
            whole = scene_along(SOLID, law, 5.0, shear=1.0, mode=side, even=True)
            half = scene_along(SOLID, law, 10.0, shear=1.0, loads=[off], contact=beside, mode=side)
            for name, fault in (("Kostrov", whole), ("Freund", half)):
                done = ended(fault, nodes)
                near = (done.interface.x > 0) & (done.interface.x < speed)
                x = done.interface.x[near]
                if name == "Kostrov":
                    known = kostrov_slip(x, speed, impedance)
                else:
                    known = freund_slip(x, speed, rayleigh_factors(SOLID.poisson_ratio, mode), mode)
                case = f"{name}'s crack, {side}, {nodes} nodes"
                yield profile(case, "slip", known, done.interface.slip[0][near])


def statics() -> Iterator[Row]:
    """Yield partial slip of a contact under uniform pressure, in the slow limit."""
    named = sf.find("cattaneo")
    edge = 8 / math.pi * math.acos(math.cos(math.pi / 8) / math.cos(math.pi * 0.15 / 2))
    for nodes in (256, 512, 1024):
        options: Row = {"step_ratio": 0.5, "times": [62.0], "estimate": False}
        done = sf.solve(named, nodes=nodes, **options)
        x = done.interface.x[done.interface.x < edge]
        square = np.tan(math.pi * edge / 8) ** 2 - np.tan(math.pi * x / 8) ** 2
        top = math.tan(math.pi / 8) ** 2 - math.tan(math.pi * edge / 8) ** 2
        known = 2 / math.pi * np.arctan(np.sqrt(top / square))
        found = done.interface.shear_traction[0][: len(x)]
        yield profile(f"cattaneo, {nodes} nodes", "traction where it sticks", known, found)


def edges() -> Iterator[Row]:
    """Yield the slip rate next to two edges until the wave of the other one arrives."""
    scene = sf.find("preloaded")
    answer = sf.solve(scene)
    fault = scene_along(
        scene.material,
        sf.Coulomb(scene.coefficient),
        16.0,
        loads=[sf.InterfaceLoad(1.0, on="slot")],
        contact=sf.Contact([(-math.inf, -2.0), (0.0, math.inf)]),
    )
    for nodes in (1024, 2048, 4096):
        case = f"two edges, {nodes} nodes"
        yield from profiles(case, answer, ended(fault, nodes), "slip_rate", least=0, most=3)


def beside_slot(name: str) -> tuple[sf.Scene, sf.Scene]:
    """Return a named scene, and the same on a periodic line: a gap of c_l T on either side."""
    scene = sf.find(name)
    put = scene.superposition.taken_off
    face = scene_along(
        scene.material,
        sf.Coulomb(scene.coefficient),
        10.0,
        scene.base.pressure,
        scene.base.shear,
        [sf.InterfaceLoad(put.shear, pressure=put.pressure, on="slot")],
        sf.Contact.half_line(),
    )
    return scene, face


def openings() -> Iterator[Row]:
    """Yield gap, pressure and slip rate of contacts that open next to a slot, against `solve`."""
    for name in ("tap", "lift-off-shear"):
        scene, face = beside_slot(name)
        answer, sheared = sf.solve(scene), scene.superposition.taken_off.shear != 0
        for nodes in (1024, 2048, 4096):
            done, case = ended(face, nodes), f"{name}, {nodes} nodes"
            for field in ("gap", "pressure", *(["slip_rate"] if sheared else [])):
                # the pressure is singular at the edge, where the grid is of order one half
                least = 0.2 if field == "pressure" else 0
                yield from profiles(case, answer, done, field, least=least, most=2.2)
        closing = f"{done.work['closing']:.1e}"
        yield line(case, "work lost in closing", "0 or more", closing, "")


_PARTS = (exact, patches, fronts, cracks, statics, edges, openings, dispersion)
PARTS = {part.__name__: part for part in _PARTS}
"""Parts of the table."""


def rows_of(part: str) -> list[Row]:
    """Return the rows of a part."""
    return list(PARTS[part]())


def points(quick: bool) -> list[tuple[str]]:
    """Return all parts; those that take some seconds for a quick look."""
    return [(part,) for part in (("exact", "statics", "edges") if quick else PARTS)]


STUDIES = [Study("engine-checks", points, rows_of)]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.accuracy.engine", STUDIES))
