"""The fastest mode of a mesh, computed on a patch of a few elements: it limits the time step."""

from __future__ import annotations

import numpy as np
from skfem import MeshQuad

from fem.elements.assembly import STIFFNESS, Space, lumped_mass
from fem.stepping import highest_frequency, normalised
from semianalytic.scene.material import Material

PATCH = 24
"""Elements along a side of the patch."""


def highest_of_patch(size: float, material: Material, components: tuple[int, ...]) -> float:
    """Return the largest eigenfrequency of a free patch of squares [1 / time].

    The fastest mode of a block is localised in its corners, so a patch of a few elements has it,
    and no block that is larger or held exceeds it.  Squares have sides of a size [length].
    """
    side = size * np.arange(PATCH + 1.0)
    space = Space(MeshQuad.init_tensor(side, side))
    matrix, _ = normalised(STIFFNESS[components](space, material), lumped_mass(space, material))
    return highest_frequency(matrix, tol=1e-7)
