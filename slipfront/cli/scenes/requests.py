"""Options of ``slipfront field``, which are checked before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

from semianalytic import Scene
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.tables.units import si_size
from semianalytic.scene.units import measure
from slipfront.cli.options import asked, option_name

GRID = (200, 200)
"""Default number of cells of a grid, along x and y."""
MOST_POINTS, MOST_FRAMES, MOST_SAMPLES = 4000, 10_000, 1_000_000
"""Limits of points and cells along an axis, of frames, and of times; more are a typing error."""


def fringe_stress(of: str, thickness: float | None, stress_optical: float | None) -> float | None:
    """Return the difference of principal stresses per fringe [stress], if it is given."""
    if thickness is None and stress_optical is None:
        return None
    if of != "fringes":
        raise SceneError("--thickness and --stress-optical are for --of fringes; add that.")
    if thickness is None or stress_optical is None:
        raise SceneError("fringes follow from --thickness and --stress-optical; give both.")
    constant = checked_size("field: stress_optical", stress_optical)
    return constant / checked_size("field: thickness", thickness)


def count_of(name: str, value: int, least: int, most: int) -> int:
    if not least <= value <= most:
        raise SceneError(
            f"{option_name(name)} must be a whole number from {least} to {most}, got "
            f"{shown(value)}."
        )
    return value


def window_of(scene: Scene, text: str) -> tuple[float, float, float, float]:
    required = "be four numbers x0,x1,y0,y1 with x0 < x1 and y0 < y1"
    x0, x1, y0, y1 = _numbers("window", text, 4, required, scene)
    if not (x0 < x1 and y0 < y1):
        raise SceneError(f"--window must {required}, got {shown(text)}.")
    return x0, x1, y0, y1


def place_of(scene: Scene, text: str) -> tuple[float, float]:
    x, y = _numbers("gauge", text, 2, "be two numbers x,y", scene)
    return x, y


def cells_of(text: str) -> tuple[int, int]:
    required = f"be two whole numbers nx,ny from 2 to {MOST_POINTS}"
    nx, ny = _numbers("grid", text, 2, required)
    if not all(count.is_integer() and 2 <= count <= MOST_POINTS for count in (nx, ny)):
        raise SceneError(f"--grid must {required}, got {shown(text)}.")
    return int(nx), int(ny)


def _numbers(
    name: str, text: str, count: int, required: str, scene: Scene | None = None
) -> Iterator[float]:
    """Parse a given count of finite numbers that are separated by commas.

    They are lengths that may have units if there is a scene.
    """
    numbers: list[Any] = []
    with suppress(ValueError, SceneError):
        parts = text.split(",")
        if scene is None:
            numbers = [float(part) for part in parts]
        else:
            numbers = [measure(part, "length", si_size) for part in parts]
    if scene is not None:
        numbers = [asked(scene, name, number, "length") for number in numbers]
    if len(numbers) != count:
        raise SceneError(f"{option_name(name)} must {required}, got {shown(text)}.")
    return iter([checked_number(option_name(name), number) for number in numbers])
