"""SCEC TPV205 in two dimensions against what PyLith computed at seven stations.

``python -m docs.studies.peers.tpv205 FOLDER`` writes rows of docs/data/peers.csv.  FOLDER is a
checkout of github.com/chunhuizhao478/farms, which holds the stations in
postprocess/tpv2052d/benchmark_data; its files are not part of this package.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import semianalytic as sf
from docs.studies.peers.rows import Array, GridRun, fields_of, places, record, timed_run

COMMAND = "python -m docs.studies.peers.tpv205 FOLDER"
NODES = (480, 960, 1920, 3840)
MEGA = 1e6


def stations(folder: Path) -> dict[float, Array]:
    """Return t [s], slip [m], slip rate [m/s] and shear [MPa], (n, 4), by position [km]."""
    found = {}
    for path in (folder / "postprocess/tpv2052d/benchmark_data").glob("pylith_strike*.txt"):
        place = re.search(r"strike(.*?)_", path.name)
        if place:
            found[float(place[1])] = np.loadtxt(path)[:, :4]
    if not found:
        raise SystemExit(f"{folder} holds no stations of TPV205-2D; give a checkout of farms.")
    return dict(sorted(found.items()))


def our_run(nodes: int, t: Array, x: Array) -> tuple[GridRun, Array]:
    """Run the problem; return its fields after t = 0 at positions x, and the shear at t = 0.

    Shear tractions are changes.
    """
    found = sf.find("tpv205")
    done, seconds = timed_run(found, float(t[-1]), nodes, t)
    where = np.abs(done.interface.x[:, None] - x).argmin(axis=0)
    whole = fields_of(done, "slip", "slip rate", "shear traction")
    fields = {name: values[1:, where] for name, values in whole.items()}
    before = whole["shear traction"][0, where]
    fields["shear traction"] = fields["shear traction"] - before
    return GridRun(f"{found.period / nodes:g} m", fields, seconds), before


def main() -> None:
    """Run the problem on all grids and write the rows."""
    (folder,) = places(__doc__, "FOLDER")
    found = stations(folder)
    x, t = 1e3 * np.array(list(found)), next(iter(found.values()))[:, 0]
    runs = [our_run(nodes, t, x) for nodes in NODES]
    slip, rate, shear = (np.array([entry[1:, i] for entry in found.values()]).T for i in (1, 2, 3))
    # PyLith writes a shear traction of 0 at t = 0; the next one is the initial one except in the
    # patch that slips at once, where ours is taken
    fields = {"slip": slip, "slip rate": rate, "shear traction": MEGA * shear - runs[-1][1]}
    theirs = GridRun("200 m", fields, None)
    record("PyLith", "tpv205", COMMAND, [(theirs, ours) for ours, _ in runs])


if __name__ == "__main__":
    main()
