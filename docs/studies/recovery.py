"""Fits of two ruptures to strain in both bodies that was made with known values, and noise.

``python -m docs.studies.recovery`` fits each five times, to other noise, and writes the fifty
values with their standard errors to docs/data/fits-recovered.csv.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import slipfront as sf

CSV = Path(__file__).resolve().parents[2] / "docs" / "data" / "fits-recovered.csv"
NOISE = 0.05
"""Deviation of samples over the largest value of a record."""
LATE = 0.1
"""Time of the records at which the load acts, over their duration."""
SPREAD = 0.3
"""Uniform priors reach so far to either side, over the true value."""
LOAD = """
contact = "whole line"
[[load]]
shear = "kick * (abs(x - centre) < radius)"
history = {kind = "ramp", rise_time = %g}
[numbers]
kick = %g
centre = %g
radius = %g
"""
WEAKENING = """
period = 16.0
base = {pressure = 1.0, shear = 0.42}
material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}
friction_law = {kind = "slip-weakening", static = 0.6, dynamic = 0.3, distance = 0.15}
"""
RATE_AND_STATE = """
units = "SI"
period = 24.0
rate = 1e-9
base = {pressure = 50e6, shear = 31.5e6}
material = {shear_modulus = 30e9, density = 2700.0, poisson_ratio = 0.25}
friction_law = {kind = "rate-and-state", a = 0.008, b = 0.016, f0 = 0.6, v0 = 1e-6, distance = 2e-5}
"""
Rupture = tuple[str, float, tuple[tuple[str, float, float], ...], Mapping[str, float]]
RUPTURES: Mapping[str, Rupture] = {
    "slip-weakening": (
        WEAKENING + LOAD % (0.2, 0.3, 0.2, 0.6),
        3.0,
        (("exx", 1.5, 0.25), ("exy", 1.9, -0.25), ("exy", 2.3, 0.25), ("eyy", -1.2, 0.25)),
        {
            "base_shear": 0.42,
            "friction_law_dynamic": 0.3,
            "friction_law_distance": 0.15,
            "centre": 0.2,
        },
    ),
    "rate-and-state": (
        RATE_AND_STATE + LOAD % (2e-4, 7e6, 0.0, 2.0),
        1.7e-3,
        (("exx", 1.0, 0.5), ("exy", 2.5, -0.5), ("exy", -1.5, 0.5), ("eyy", 1.8, 0.5)),
        {
            "friction_law_a": 0.008,
            "friction_law_b": 0.016,
            "friction_law_distance": 2e-5,
            "kick": 7e6,
        },
    ),
}
"""Scene, duration of the records, gauges and true values."""
NODES = 128


def recovered(name: str, seed: int) -> list[tuple[str, float, float, float]]:
    """Return each unknown of a rupture, its true and fitted value, and its standard error."""
    text, duration, places, true = RUPTURES[name]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "rupture.toml"
        path.write_text(text)
        scene = sf.find(path)
    late, random = LATE * duration, np.random.default_rng(seed)
    t = np.linspace(0.05, 1.0, 60) * duration
    made = sf.solve(scene, end_time=duration, nodes=NODES, estimate=False)
    gauges = []
    for of, x, y in places:
        values = made.strain(x, y, t)[("exx", "eyy", "exy").index(of)]
        noise = NOISE * float(np.abs(values).max())
        noisy = values + noise * random.standard_normal(len(t))
        gauges.append(sf.Gauge(x, t + late, noisy, noise, of, y))
    true = {**true, "t0": late}
    priors = {
        one: sf.Uniform((1 - SPREAD) * value, (1 + SPREAD) * value) for one, value in true.items()
    }
    found = sf.fit(gauges, scene, tuple(true), priors=priors, nodes=NODES)
    rows = zip(found.parameters, true.values(), found.values, found.standard_errors, strict=True)
    return [(one, *map(float, numbers)) for one, *numbers in rows]


def main(seeds: range = range(5)) -> None:
    """Write all values, and how many lie within two standard errors."""
    rows = [
        (name, seed, *row) for name in RUPTURES for seed in seeds for row in recovered(name, seed)
    ]
    with CSV.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("law", "seed", "parameter", "true", "value", "standard_error"))
        table.writerows((*row[:4], *(f"{one:.6g}" for one in row[4:])) for row in rows)
    within = sum(abs(value - true) < 2 * error for *_, true, value, error in rows)
    print(f"{within} of {len(rows)} values lie within two standard errors")


if __name__ == "__main__":
    main(*map(range, map(int, sys.argv[1:2])))
