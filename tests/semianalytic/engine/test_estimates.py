"""Estimates of runs hold where two grids share an error: barriers, films, openings, late slip."""

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along

SOLID = sf.Material(1.0, 1.0, 0.3)
NAMES = ("slip", "slip_rate")
TIMES = [0.45, 0.8, 1.2, 1.6]


def off(fields, exact, name):
    """Relative L1 error of a field over frames and nodes; nan is where a front lies on a node."""
    found, right = getattr(fields, name), getattr(exact, name)
    return np.nansum(np.abs(found - right)) / np.nansum(np.abs(right))


@pytest.mark.parametrize("half", [1.6 + 0.125 * part / 6 for part in range(6)])
def test_a_crack_between_barriers_ends_anywhere_in_a_cell(half):
    """Static cracks in a row, in closed form; nodes of 0.125 have half a node wrong at worst."""
    law = sf.Coulomb(lambda x: np.where(np.abs(x) < half, 0.2, 50.0))
    loads = [sf.InterfaceLoad(0.4, history=lambda t: np.sin(np.pi * min(t, 40.0) / 80) ** 2)]
    face = scene_along(SOLID, law, 16.0, shear=0.1, loads=loads, mode="antiplane", even=True)
    done = sf.solve(face, end_time=44.0, nodes=128, times=[44.0])
    x = np.pi * done.interface.x / 16
    ratio = np.cos(x) / np.cos(np.pi * half / 16)
    right = 2 * 0.3 * 16 / np.pi * np.arccosh(np.maximum(ratio, 1.0)) * (x < np.pi * half / 16)
    error = np.abs(done.interface.slip[-1] - right).sum() / right.sum()
    assert error < done.error_estimates["slip"] < 0.3


@pytest.mark.parametrize(
    ("viscosity", "pressure", "shear", "nodes"),
    [
        (30.0, 0.0, 1.0, 256),
        (3000.0, 0.0, 1.0, 256),
        (0.3, -0.04, 1.0, 512),
        (2.0, -0.02, 5.0, 512),
    ],
)
def test_stiff_films_and_openings_below_a_node_count(viscosity, pressure, shear, nodes):
    """Beside an edge at which a film is all but stuck, or opens where no node shows it."""
    law, base = sf.Coulomb(0.3, viscosity=viscosity), sf.Tractions(1.0, 0.0)
    scene = sf.Scene(SOLID, law, base, sf.Tractions(pressure, shear))
    exact, reach = sf.solve(scene), 2.3 * SOLID.longitudinal_speed
    loads = [sf.InterfaceLoad(shear, on="slot"), sf.InterfaceLoad(pressure=pressure, on="slot")]
    contact = sf.Contact([(0.0, reach)])
    face = scene_along(SOLID, law, 2 * reach, loads=loads[: 1 + (pressure != 0)], contact=contact)
    times = np.linspace(0.25, 1.0, 4)
    done = sf.solve(face, end_time=1.0, nodes=nodes, times=list(times))
    near = done.interface.touching & (done.interface.x < reach / 2)
    x = done.interface.x[near]
    march = sf.solve(scene, method="space-time", end_time=1.0, nodes=200)
    for name in NAMES:
        right = getattr(exact, name)(x, times[:, None])
        wrong = np.nansum(np.abs(getattr(done.interface, name)[-4:, near] - right))
        assert wrong < done.error_estimates[name] * np.nansum(np.abs(right)), name
    if pressure:
        assert exact.openings
        assert not done.interface.gap[:, near].any()
        assert done.error_estimates["gap"] == 1.0
    x, t = march.interface.x, march.interface.t[5::10, None]
    right, found = exact.slip_rate(x, t), march.slip_rate(x, t)
    total = np.nansum(np.abs(right))
    assert np.nansum(np.abs(found - right)) < march.error_estimate * total < total / 4
    at, when = np.random.default_rng(1).uniform((0.01, 0.3), (1.8, 1.0), (200, 2)).T
    bars, points = march.reading(at, when), exact.reading(at, when)
    for name in NAMES if pressure else ():
        (first, bar), (other, _) = getattr(bars, name), getattr(points, name)
        assert (np.abs(first - other) <= bar).all(), name


def test_slip_that_begins_in_a_long_step_begins_in_a_short_one():
    """Films permit long steps while nothing slips: slip was off by 1.4 % on any two grids."""
    load = sf.InterfaceLoad(lambda x: 1.2 * np.exp(-np.square(x / 0.6)), sf.Ramp(0.4))
    face = scene_along(SOLID, sf.Coulomb(0.6, viscosity=5.0), 9.0, loads=[load], even=True)
    done, fine = (sf.solve(face, end_time=1.2, nodes=n, times=[0.5, 1.2]) for n in (192, 768))
    error = np.abs(done.interface.slip - fine.interface.slip[:, ::4]).sum()
    error /= np.abs(done.interface.slip).sum()
    assert error < done.error_estimates["slip"] < 5e-3
    assert np.diff(done.totals.t).max() > 3 * np.diff(done.totals.t).min()


def test_each_of_two_slip_zones_has_its_error():
    """A narrow zone beside a wide one: the estimate is that of the worse one."""

    def zones(narrow):
        def push(x):
            return np.exp(-np.square((x + 3) / 1.0)) + narrow * np.exp(-np.square((x - 3) / 0.15))

        load = sf.InterfaceLoad(push, history=sf.Ramp(0.4))
        face = scene_along(SOLID, sf.Coulomb(0.5), 16.0, loads=[load])
        return sf.solve(face, end_time=1.0, nodes=256, times=[0.5, 1.0])

    single, both = zones(0.0), zones(1.6)
    assert both.error_estimates["slip"] > 2 * single.error_estimates["slip"]


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5])
def test_a_film_slips_up_to_anywhere_in_a_cell(part):
    """Strong films slip by their own excess: the node at the end of a zone by its mean, which two
    grids need not show."""
    h, width, f, viscosity = 8 / 128, 0.4, 0.4, 300.0
    end = (5 + part) * h
    load = sf.InterfaceLoad(
        lambda x: f * np.exp((end**2 - np.square(x)) / width**2), sf.Ramp(0.4), "line"
    )
    face = scene_along(SOLID, sf.Coulomb(f, viscosity=viscosity), 8.0, loads=[load])
    done, fine = (sf.solve(face, end_time=1.2, nodes=n, times=[0.5, 1.2]) for n in (128, 1024))
    for name in (*NAMES, "shear_traction"):
        right = getattr(fine.interface, name)[:, ::8]
        error = np.abs(getattr(done.interface, name) - right).sum() / np.abs(right).sum()
        assert error < done.error_estimates[name] < 0.1, name


@pytest.mark.parametrize(
    ("solid", "law", "base", "contact", "shear", "width"),
    [
        (
            sf.Material(1.0, 1.0, 0.2326),
            sf.SlipWeakening(0.4383, 0.3643, 0.5088),
            sf.Tractions(1.0, -0.2048),
            sf.Contact(),
            0.7033,
            0.4746,
        ),
        (
            sf.Material(1.0, 1.0, 0.0559),
            sf.RateAndState(a=0.05, b=0.01014, f0=0.6174, v0=1e-3, distance=0.2),
            sf.Tractions(1.0, 0.6174),
            sf.Contact([(-0.8736, 1.0)]),
            -0.7485,
            0.7893,
        ),
    ],
)
def test_two_grids_that_agree_at_few_times_are_not_believed(
    solid, law, base, contact, shear, width
):
    load = sf.InterfaceLoad(lambda x: shear * np.exp(-np.square(x / width)), sf.Ramp(0.4), "line")
    creep = 1e-3 if isinstance(law, sf.RateAndState) else 0.0
    scene = sf.Scene(solid, law, base, load, contact=contact, rate=creep, period=8.0)
    rough, fine = (sf.solve(scene, end_time=1.6, nodes=n, times=TIMES) for n in (128, 512))
    on = rough.interface.touching
    for name in (*NAMES, "shear_traction"):
        values = getattr(rough.interface, name)[:, on]
        right = fine.at(getattr(fine.interface, name), rough.interface.x[on])
        change = np.abs(right - base.shear * (name == "shear_traction")).sum()
        allowed = rough.error_estimates[name] + fine.error_estimates[name]
        assert np.abs(values - right).sum() < allowed * change
