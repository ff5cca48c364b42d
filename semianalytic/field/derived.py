"""What instruments see of a stress: strain gauges, polariscopes.

Plain functions of stress (3, ...), sigma_xx, sigma_yy, sigma_xy, or in antiplane shear (5, ...),
with sigma_xz and sigma_yz, as `Solution.stress` has it, tension positive.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

Array = NDArray[np.float64]


def strain(stress: ArrayLike, material: Material) -> Array:
    """Strain that a stress causes in plane strain, by Hooke's law.

    Base tractions do not determine the initial sigma_xx: give the change of stress since t = 0 for
    that of strain, which is the gradient of `displacement`.

    Parameters
    ----------
    stress : (3, ...) or (5, ...) array
        [stress].
    material : Material

    Returns
    -------
    array like stress
        eps_xx, eps_yy, eps_xy (and eps_xz, eps_yz), elongation positive; the shear strains are
        those of the tensor, half the engineering ones.

    Raises
    ------
    SceneError
        If the stress does not have 3 or 5 rows.
    """
    rows = _rows(stress)
    with np.errstate(invalid="ignore"):  # inf less inf, where stress is infinite
        volume = material.poisson_ratio * (rows[0] + rows[1])
        rows = np.concatenate([rows[:2] - volume, rows[2:]])
    return rows / (2 * material.shear_modulus)


def principal_difference(stress: ArrayLike) -> Array:
    """sigma_1 - sigma_2 >= 0 of the principal stresses in the plane (x, y) [stress].

    Parameters
    ----------
    stress : (3, ...) or (5, ...) array
        [stress]; what acts along z does not matter.

    Raises
    ------
    SceneError
        If the stress does not have 3 or 5 rows.
    """
    sigma_xx, sigma_yy, sigma_xy, *_ = _rows(stress)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.hypot(sigma_xx - sigma_yy, 2 * sigma_xy))


def fringe_order(stress: ArrayLike, thickness: float, fringe_constant: float) -> Array:
    """Isochromatic fringe order N of light that crosses a body along z (stress-optic law).

    N = (sigma_1 - sigma_2) thickness / fringe_constant.

    Parameters
    ----------
    stress : (3, ...) or (5, ...) array
        [stress].
    thickness : float
        Of the body along z [length].
    fringe_constant : float
        Material fringe constant f_sigma [stress length] at the wavelength of the light, which is
        that over the stress-optical coefficient.

    Raises
    ------
    SceneError
        If thickness or fringe constant are not positive numbers, or the stress does not have 3 or
        5 rows.
    """
    thickness = checked_size("fringes: thickness", thickness)
    fringe_constant = checked_size("fringes: fringe_constant", fringe_constant)
    return principal_difference(stress) * (thickness / fringe_constant)


def fringes(stress: ArrayLike, thickness: float, fringe_constant: float) -> Array:
    """Light intensity behind a dark-field circular polariscope, sin^2(pi N), from 0 to 1.

    Dark where the fringe order N is whole; nan where stress is infinite.  Parameters and raises as
    `fringe_order`.
    """
    order = fringe_order(stress, thickness, fringe_constant)
    with np.errstate(invalid="ignore"):
        return np.square(np.sin(np.pi * order))


def _rows(stress: ArrayLike) -> Array:
    """Stress as an array of 3 or 5 rows."""
    rows = np.asarray(stress, dtype=float)
    if rows.ndim == 0 or len(rows) not in (3, 5):
        raise SceneError(
            f"stress must have 3 rows, or 5 in antiplane shear, got shape {rows.shape}."
        )
    return rows
