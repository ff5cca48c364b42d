"""Fits of a rupture to strain in both bodies that was made with known values, and noise.

``python -m docs.studies.recovery`` fits it ten times, to other noise, and writes the fifty values
with their standard errors to docs/data/fits-recovered.csv.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

import slipfront as sf
from semianalytic.parameters.numbers import numbers_of

DATA = Path(__file__).resolve().parents[2] / "docs" / "data"
NAMES = ("base_shear", "friction_law_dynamic", "friction_law_distance", "centre", "t0")
GAUGES = ("exx", 1.5, 0.25), ("exy", 1.9, -0.25), ("exy", 2.3, 0.25), ("eyy", -1.2, 0.25)
NOISE, DURATION, LATE, NODES, FINER = 0.05, 3.0, 0.3, 256, 512
"""Noise over the largest value of a record, its end, time of the load, nodes of fit and records."""


def recovered(seed: int) -> list[list[str | float]]:
    """Return each unknown, its true and fitted value, and its standard error."""
    scene, random = sf.find(DATA / "rupture.toml"), np.random.default_rng(seed)
    made = sf.solve(scene, end_time=DURATION, nodes=FINER, estimate=False)
    t, gauges = np.linspace(0.05, 1.0, 60) * DURATION, []
    for of, x, y in GAUGES:
        values = made.strain(x, y, t)[("exx", "eyy", "exy").index(of)]
        noise = NOISE * float(np.abs(values).max())
        noisy = values + noise * random.standard_normal(len(t))
        gauges.append(sf.Gauge(x, t + LATE, noisy, noise, of, y))
    true = {**{name: number.value for name, number in numbers_of(scene).items()}, "t0": LATE}
    priors = {name: sf.Uniform(0.7 * true[name], 1.3 * true[name]) for name in NAMES}
    found = sf.fit(gauges, scene, NAMES, priors=priors, nodes=NODES)
    rows = zip(NAMES, found.values.tolist(), found.standard_errors.tolist(), strict=True)
    return [[name, true[name], value, error] for name, value, error in rows]


if __name__ == "__main__":
    with (DATA / "fits-recovered.csv").open("w", newline="") as file:
        file.write("# python -m docs.studies.recovery\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("seed", "parameter", "true", "value", "standard_error"))
        for seed in range(10):
            for name, true, value, error in recovered(seed):
                table.writerow((seed, name, true, f"{value:.6g}", f"{error:.3g}"))
