"""Tolerance classes: what a first-order scheme reaches on 200, 100 and 50 cells over c_t T."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from compare.benchmarks.answers import DATA
from semianalytic.scene.errors import DataFileError

CLASSES = ("A", "B", "C")
BEYOND = "D"
COPIED = "?"
"""Stands for a class where a run is nearer to the answer than any code comes."""
FILE = "classes.csv"
COMMAND = "python -m docs.studies.league classes"


@dataclass(frozen=True)
class Tolerance:
    """Largest errors of the classes for one quantity of a sheet, relative, or over T for arrivals.

    Attributes
    ----------
    sheet, quantity : str
    A, B, C : float
        Of our finite elements on 200, 100 and 50 cells, rounded up to two digits; never a
        smaller one on coarser cells.
    march : float
        Of our marcher on 100 cells; nan where it does not take the scene, and where it is the
        reference.
    """

    sheet: str
    quantity: str
    A: float
    B: float
    C: float
    march: float


@cache
def tolerances() -> Mapping[tuple[str, str], Tolerance]:
    """All classes by sheet and quantity.

    Raises
    ------
    DataFileError
        If their file cannot be read.
    """
    path = DATA / FILE
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            stream.readline()
            rows = [
                Tolerance(
                    row["sheet"],
                    row["quantity"],
                    *(float(row[name]) for name in (*CLASSES, "march")),
                )
                for row in csv.DictReader(stream, strict=True)
            ]
    except (OSError, KeyError, ValueError, csv.Error) as error:
        raise DataFileError(f"{path} cannot be read ({error}).") from error
    return {(row.sheet, row.quantity): row for row in rows}


def tolerance_class(sheet: str, quantity: str, error: float) -> str:
    """The class of an error: A, B, C, D beyond all of them; "" where there is none."""
    bounds = tolerances().get((sheet, quantity))
    if bounds is None or math.isnan(error):
        return ""
    return next((name for name in CLASSES if error <= getattr(bounds, name)), BEYOND)
