"""Quantities that instruments measure of a stress: strain gauges and polariscopes.

They take stress as `Solution.stress` returns it, (3, ...) or (5, ...), tension positive.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material


@checking
def strain(stress: ArrayLike, material: Material) -> Array:
    """Return the strain that a stress causes in plane strain, by Hooke's law.

    Base tractions do not determine the initial sigma_xx.  Give the change of stress since t = 0 to
    obtain the change of strain, which is the gradient of `displacement`.

    Parameters
    ----------
    stress : (3, ...) or (5, ...) array
        Stress, tension positive [stress].
    material : Material
        The solid.

    Returns
    -------
    array like stress
        eps_xx, eps_yy, eps_xy (and eps_xz, eps_yz), elongation positive; the shear strains are
        those of the tensor, half the engineering ones.

    Raises
    ------
    SceneError
        If the stress does not have 3 or 5 rows.

    Examples
    --------
    Uniaxial stress along x, in plane strain:

    >>> from semianalytic import Material, strain
    >>> solid = Material(shear_modulus=1.0, density=1.0, poisson_ratio=0.25)
    >>> strain([1.0, 0.0, 0.0], solid).tolist()
    [0.375, -0.125, 0.0]
    """
    rows = _rows(stress)
    with np.errstate(invalid="ignore"):  # inf less inf, where stress is infinite
        # In plane strain sigma_zz = nu (sigma_xx + sigma_yy) is not 0 and enters Hooke's law.
        volume = material.poisson_ratio * (rows[0] + rows[1])
        rows = np.concatenate([rows[:2] - volume, rows[2:]])
    return rows / (2 * material.shear_modulus)


def hooke(strain: Array, material: Material) -> Array:
    """Return the stress of a strain (n, ...) in plane strain, the inverse of `strain`."""
    nu = material.poisson_ratio
    stress = strain.copy()
    stress[:2] += nu / (1 - 2 * nu) * (strain[0] + strain[1])
    return np.asarray(2 * material.shear_modulus * stress)


def principal_difference(stress: ArrayLike) -> Array:
    """Return the difference sigma_1 - sigma_2 >= 0 of the principal stresses in the plane (x, y).

    The stress [stress] and the errors are those of `strain`; components along z have no influence.
    """
    sigma_xx, sigma_yy, sigma_xy, *_ = _rows(stress)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.hypot(sigma_xx - sigma_yy, 2 * sigma_xy))


@checking
def fringe_order(stress: ArrayLike, thickness: float, fringe_constant: float) -> Array:
    """Return the isochromatic fringe order of light that crosses a body along z.

    By the stress-optic law it is N = (sigma_1 - sigma_2) thickness / fringe_constant.

    Parameters
    ----------
    stress : (3, ...) or (5, ...) array
        Stress, tension positive [stress].
    thickness : float
        Thickness of the body along z [length].
    fringe_constant : float
        Material fringe constant f_sigma [stress length]: the wavelength of the light over the
        stress-optical coefficient.

    Raises
    ------
    SceneError
        If thickness or fringe constant is not a positive number, or the stress does not have 3 or 5
        rows.

    Examples
    --------
    >>> from semianalytic import fringe_order
    >>> float(fringe_order([2e6, 0.0, 0.0], thickness=0.01, fringe_constant=1e4))
    2.0
    """
    thickness = checked_size("fringes: thickness", thickness)
    fringe_constant = checked_size("fringes: fringe_constant", fringe_constant)
    return principal_difference(stress) * (thickness / fringe_constant)


@checking
def fringes(stress: ArrayLike, thickness: float, fringe_constant: float) -> Array:
    """Return the light intensity behind a dark-field circular polariscope, from 0 to 1.

    It is sin^2(pi N), dark where the fringe order N is a whole number, and nan where stress is
    infinite.  Parameters and errors are those of `fringe_order`.

    Examples
    --------
    >>> from semianalytic import fringes
    >>> stress = [[0.0, 0.5e6, 1e6], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    >>> fringes(stress, thickness=0.01, fringe_constant=1e4).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    order = fringe_order(stress, thickness, fringe_constant)
    with np.errstate(invalid="ignore"):
        return np.square(np.sin(np.pi * order))


def _rows(stress: ArrayLike) -> Array:
    """Return a stress as an array of 3 or 5 rows."""
    rows = np.asarray(stress, dtype=float)
    if rows.ndim == 0 or len(rows) not in (3, 5):
        raise SceneError(
            f"stress must have 3 rows, or 5 in antiplane shear, got shape {rows.shape}."
        )
    return rows
