"""Friction with a direct effect of slip rate beside a slot: steps as long as without one."""

import re
from pathlib import Path

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.engine.balance import freed_rate
from semianalytic.engine.line import Grid

ROCK = sf.Material(30e9, 2700.0, 0.25)
LAW = sf.RateAndState(a=0.01, b=0.014, f0=0.6, v0=1e-6, distance=1e-4)
PAGE = Path(__file__).parents[3] / "docs" / "engine.md"


@pytest.mark.parametrize("even", [False, True])
def test_slots_carry_nothing_whatever_the_contact_does(even):
    """V + h * V = load on slots, by the whole matrix of the line."""
    rng = np.random.default_rng(1)
    grid = Grid(16.0, 64, True, even)
    touching = (np.abs(grid.x) > 1) & (np.abs(grid.x) < 6)
    count, waves = len(grid.x), len(grid.wavenumbers)
    rate, load = rng.normal(size=count), rng.normal(size=count)
    past = grid.amplitudes(rng.normal(size=count))
    feedback = 3.0 * np.arange(waves)
    found = freed_rate(grid, touching, rate, load, past, feedback)
    assert np.array_equal(found[touching], rate[touching])
    held = grid.values(past + feedback * grid.amplitudes(found))
    assert (found + held)[~touching] == pytest.approx(load[~touching], abs=1e-7)
    assert np.abs((found + held - load)[touching]).max() > 0.1


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("contact", "plate"),
    [([(-6.0, -1.0), (1.0, 6.0)], 0.0), ([(-3.0, 7.0)], 1e-6)],
)
def test_long_steps_beside_slots_give_the_answer_of_short_ones(contact, plate):
    push = sf.InterfaceLoad(lambda x: 3e5 * (abs(x) < 3), history=lambda t: min(t / 0.1, 1.0))
    face = sf.Interface(
        *(ROCK, LAW, 16.0),
        **{"pressure": 5e6, "shear": 3e6, "rate": 1e-6, "plate_rate": plate, "loads": [push]},
        contact=sf.Contact(contact),
    )
    times = [0.02, 0.05]
    found = sf.run(face, 0.05, 32, estimate=False, times=times)
    fine = sf.run(face, 0.05, 32, estimate=False, times=times, longest=6e-5)
    assert np.diff(fine.step_times).max() < 6.1e-5  # the shortest steps, which need no solution
    assert found.steps < fine.steps / 5
    on = found.touching
    for name, limit in (("slip", 2e-3), ("shear_traction", 2e-3), ("slip_rate", 5e-3)):
        one, other = getattr(found, name), getattr(fine, name)
        change = other - (3e6 if name == "shear_traction" else 0)
        assert np.abs(one - other)[:, on].sum() < limit * np.abs(change)[:, on].sum()
    slots = np.abs(found.slip - fine.slip)[:, ~on].sum() / np.abs(fine.slip)[:, ~on].sum()
    assert slots < 1e-3


def test_the_file_of_the_page_runs(tmp_path, monkeypatch):
    """docs/engine.md, "Files": contacts, a table, an expression and a history."""
    block = re.search(r"## Files\n\n((?:    .*\n)+)", PAGE.read_text(encoding="utf-8")).group(1)
    text = re.sub("nodes = 512", "nodes = 64", re.sub("^    ", "", block, flags=re.MULTILINE))
    (tmp_path / "fault.toml").write_text(text, encoding="utf-8")
    table = "x [m],pressure [MPa]\n-8,4.8\n0,5\n8,4.8\n"
    (tmp_path / "pressure.csv").write_text(table, encoding="utf-8")
    found = sf.find_interface(tmp_path / "fault.toml")
    done = sf.run(found.interface, found.end_time, **found.options)
    assert done.status == "done"
    assert done.steps < 2000
