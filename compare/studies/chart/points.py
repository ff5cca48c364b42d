"""Points of the chart: what a row of its file holds, and the machine that it was measured on."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from compare.output.tables import read_rows
from compare.studies.chart.methods import METHODS
from semianalytic.scene.errors import DataFileError

SCENES = ("preloaded", "remote-shock", "auxetic", "ramp")
FILE_NAME = "data/chart.csv"
COMMAND = "slipfront chart --output docs"
VERSIONS = ("python", "numpy", "scipy", "slipfront")
"""Programs whose versions a point records: it counts for these versions alone."""


@dataclass(frozen=True)
class Point:
    """One measured point, a row of the CSV file; for `reference_*` see `reference.Reference`.

    Attributes
    ----------
    setup, solving : float
        Median times [s]; the chart shows their sum.
    memory : float
        Peak memory of the process [MB].
    error, edge_error : float
        Relative L1 error of the slip rate, and worst error of a zone edge over c_t, which is inf
        if a zone is missed.
    status : str
        "measured", or what to distrust.
    """

    scene_name: str
    method: str
    setting: float
    setup: float
    solving: float
    runs: int
    memory: float
    error: float
    edge_error: float
    status: str
    reference: str
    reference_error: float
    reference_edge_error: float
    python: str
    numpy: str
    scipy: str
    slipfront: str
    machine: str
    cores: int
    date: str

    @property
    def seconds(self) -> float:
        """Time of set-up and solving [s]."""
        return self.setup + self.solving

    @property
    def name(self) -> str:
        """The setting with its name, as in "rtol 1e-08"."""
        return f"{METHODS[self.method].parameter} {self.setting:g}"


def stamp() -> dict[str, Any]:
    """Return versions and machine of a measurement."""
    versions = {name: version(name) for name in VERSIONS[1:]}
    cores = os.cpu_count() or 1
    return {"python": platform.python_version(), **versions, "machine": _machine(), "cores": cores}


def _machine() -> str:
    """Return the model of the processor, as far as the system reports it."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def read_points(path: Path) -> list[Point]:
    """Return the points of an earlier run; none if there is no file.

    Raises
    ------
    DataFileError
        If the file is damaged or not a chart.
    """
    points = read_rows(path, Point, "a chart", COMMAND)
    for point in points:
        if point.method not in METHODS or point.scene_name not in SCENES:
            raise DataFileError(
                f"{path} cannot be read as a chart (unknown {point.method} on {point.scene_name}); "
                "move it away to measure again."
            )
    return points


def same_machine(point: Point, machine: Mapping[str, Any] | None = None) -> bool:
    """Return whether a point was measured on this machine with its versions, or on a given one."""
    return all(getattr(point, name) == value for name, value in (machine or stamp()).items())
