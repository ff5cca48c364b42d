"""Solve a whole line with one zone that spreads, and refuse lines on which other zones arise."""

from __future__ import annotations

from semianalytic.halfplane.rayleigh import Mode, rayleigh_factors
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import HalfLine, Patch, PointForce
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve as solve_scene
from semianalytic.whole_line.drive import Drive, slot_scene
from semianalytic.whole_line.solution import LineSolution
from semianalytic.whole_line.spreading import Spreading, least_missing, spread

_STEP = 1e-4
"""Relative change of the edge by which the slope of the condition is formed."""


def refuses(scene: Scene) -> None:
    """Return None: whether a second zone would start is seen when the line is solved."""


def solve(scene: Scene) -> LineSolution | Solution:
    """Solve a scene without a slot for slip or opening around its load.

    For a `HalfLine` the `Solution` of a scene with a slot is returned, since the interface moves in
    the same way on x > 0.

    Raises
    ------
    SceneError
        If nothing moves or the base alone slides (`Drive`), or no closed form is known: the patch
        or the edge of motion would be faster than the Rayleigh wave, or a second zone would start.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
    >>> patch = sa.solve(sa.Scene(solid, 0.5, base, sa.Patch(speed=0.3, shear=1.0)))
    >>> round(patch.edge_speed, 12)
    0.395154376971
    >>> force = sa.solve(sa.Scene(solid, 1.0, base, sa.PointForce(shear=1.0)))
    >>> round(force.edge_speed, 12)
    0.290552362024
    """
    drive, load = Drive(scene), scene.load
    if isinstance(load, HalfLine):
        return solve_scene(slot_scene(drive))
    mode: Mode = "I" if drive.opens else "III" if scene.antiplane else "II"
    factors = rayleigh_factors(scene.material.poisson_ratio, mode)
    speed, unit = scene.material.shear_speed, drive.excess
    patch = 0.0
    if isinstance(load, Patch):
        patch = load.speed / speed
        slowest = speed / factors.c
        if not load.speed < slowest:
            wave = "Rayleigh" if factors.has_rayleigh_wave else "shear"
            raise SceneError(
                f"whole line: the patch must grow slower than the {wave} wave, {slowest:.6g}, for "
                "motion around a faster one has no known closed form; lower its speed, got "
                f"{load.speed:.6g}."
            )
    elif isinstance(load, PointForce):
        # The unit of stress under a force F_0 t is F_0 / c_t (`spreading`).
        unit /= speed
    found = spread(factors, patch, drive.missing / unit)
    if mode == "II":
        _check_one_zone(drive, found, unit)
    error = _error(found, drive.missing / unit)
    status = "converged"
    if error > 1e-9:
        status = f"the error estimate {error:.1e} exceeds 1e-09"
    return LineSolution(scene, status, error, found)


def _check_one_zone(drive: Drive, found: Spreading, unit: float) -> None:
    """Raise SceneError if shear meets strength ahead of the zone, of either sense."""
    at_shear, at_rayleigh = found.turning
    missing = drive.missing / unit
    if at_shear > missing:
        least = least_missing(found.factors, found.patch)
        raise SceneError(
            "whole line: a second zone of slip starts at the shear wave, where the shear rises by "
            f"{at_shear / missing:.3g} times what the base lacks to overcome friction, and no "
            f"closed form is known for two zones; the base must lack more than {least:.4g} of what "
            f"the load adds, got {missing:.4g}: raise friction, or lower the load or the speed of "
            "its patch."
        )
    # Reverse slip needs s tau < -f P_b, that is a rise below -(f P_b + s Q_b) = d - 2 f P_b.
    if at_rayleigh < missing - 2 * drive.strength / unit:
        raise SceneError(
            "whole line: a zone of reverse slip starts at the Rayleigh wave, which has no closed "
            "form; raise the base shear, or friction."
        )


def _error(found: Spreading, missing: float) -> float:
    """Return the error estimate of the edge speed, by the condition at the edge evaluated twice."""
    # A coarser quadrature, whose difference counts as an error.
    residual = abs(found.missing_again - missing) + abs(found.missing(0.3) - missing)
    nearer = (found.edge + found.lead * _STEP, found.lead * (1 - _STEP))
    if not found.patch:
        nearer = (found.edge * (1 + _STEP), found.lead)
    other = Spreading(found.factors, found.patch, *nearer)
    share = (nearer[0] - found.edge) / found.edge
    slope = abs(other.missing() - found.missing()) / share
    # Next to a patch that is nearly as fast as the edge, fields change with their distance.
    distance = 1.0 if not found.patch else found.lead / (found.lead + found.edge)
    # Rounding that both evaluations share.
    return float(residual / (slope * distance) + 1e-14 / distance)
