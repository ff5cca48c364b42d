"""What answers say of the bodies: velocity, stress and displacement anywhere in them."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import Array
from semianalytic.results.gridded import Gridded
from semianalytic.scene.quantities import asked_in_units


@asked_in_units
class AnswerInBodies(Gridded):
    """An answer that knows the fields in both bodies.

    Exact answers know them exactly, up to one interpolation, by Smirnov and Sobolev's method: a
    picture of 100,000 points takes a tenth of a second, and about a second the first time, when
    what does not depend on the points is prepared.
    """

    @property
    def has_bodies(self) -> bool:
        """Whether the answer knows the fields in the bodies, as it does."""
        return True

    if TYPE_CHECKING:  # what the classes have that inherit from this one

        @property
        def error_estimate(self) -> float:
            """Estimate of the error of the answer, that of the edges of zones included."""

        @property
        def _bodies(self) -> Any:
            """The fields in both bodies (`BodyFields`), exact ones with their error."""

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity anywhere in the bodies [length / time].

        Parameters
        ----------
        x, y : arrays
            Positions [length] that broadcast with t: y > 0 is the upper body, y < 0 the lower one,
            0.0 and -0.0 are their faces, those of the slot x < 0 included.
        t : array
            Times [time]; until t = 0 the base state is at rest.

        Returns
        -------
        (2, ...) array
            v_x, v_y; in antiplane shear (3, ...), with v_z.  Infinite, with its sign, at the
            Rayleigh fronts of the slot, at that of the contact where slip covers it, and at other
            singular points.

        Raises
        ------
        SceneError
            If a position or a time is not a finite number, or beyond what was computed.

        Examples
        --------
        >>> import semianalytic as sa
        >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
        >>> pair = sa.Pair(gouge, rock, 0.4, sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6))
        >>> answer = sa.solve(pair, rtol=1e-6)
        >>> answer.velocity(1.0, [0.0, -0.0], 2e-3)[0].round(3)  # the slip rate is 0.25
        array([ 0.141, -0.109])
        """
        return np.asarray(self._bodies.velocity(x, y, t))

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress anywhere in the bodies, tension positive [stress]; parameters as
        `velocity`.

        Returns
        -------
        (3, ...) array
            sigma_xx, sigma_yy, sigma_xy; in antiplane shear (5, ...), with sigma_xz and sigma_yz.
            The base tractions are part of sigma_yy and sigma_xy (or sigma_yz); they do not
            determine the initial sigma_xx, so that one is the change since t = 0.  At the contact
            edge the value is that just ahead of it, where that is finite.
        """
        return np.asarray(self._bodies.stress(x, y, t))

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement since t = 0 anywhere in the bodies [length]; parameters as
        `velocity`.

        Returns
        -------
        (2, ...) array
            u_x, u_y; in antiplane shear (3, ...), with u_z.
        """
        return np.asarray(self._bodies.displacement(x, y, t))

    @cached_property
    def field_error(self) -> float:
        """Estimate of the error of fields in the bodies, relative to themselves plus the largest
        load.

        It adds the change on a coarser rule at some points and the error of the zone edges.
        """
        return float(self._bodies.error + self.error_estimate)
