"""The fastest mode of a mesh, computed on a patch of a few elements: it limits the time step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad

from fem.elements.assembly import STIFFNESS, lumped_mass, make_space
from fem.elements.families import Family
from fem.stepping import highest_frequency, normalised
from semianalytic.scene.material import Material

PATCH = 24
"""Elements along a side of the patch."""


def highest_of_patch(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    family: Family,
    material: Material,
    components: tuple[int, ...],
) -> float:
    """Return the largest eigenfrequency of a free patch of squares [1 / time].

    The fastest mode of a block is localised in its corners, so a patch of a few elements has it,
    and no block that is larger or held exceeds it.  x and y are its columns and rows of nodes
    [length].
    """
    space = make_space(MeshQuad.init_tensor(x, y), family)
    one = {"upper": material}
    matrix, _ = normalised(STIFFNESS[components](space, one), lumped_mass(space, one))
    return highest_frequency(matrix, tol=1e-7)
