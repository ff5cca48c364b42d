"""The static equilibrium of two blocks that touch along a joint, with friction.

Each block is condensed onto its face, row by row from its far side on.  On the joint an active set
of pairs is open, stuck or sliding until no pair contradicts its state.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import lapack

from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

ALIKE = 1e-12
"""Part of the stiffness by which a block may differ from its mirror image: its rounding."""
PASSES = 60
"""Most passes of the active set; partial slip takes 5 to 10."""
SLACK = 1e-9
"""Part of the largest force, or displacement, that is taken for 0 in tests of signs."""
LARGEST = 1e9
"""Displacement of the faces, over force and stiffness, from which on a specimen is loose."""
LOOSE = (
    "simulate: the specimen would fall apart or slide as a whole under its preload; fix more of "
    "its sides, press the joint, or raise friction."
)


def condensed(stiffness: sparse.csr_array, force: Array, row: int) -> tuple[Array, Array]:
    """Return stiffness (row, row) and forces (row,) of a block on the first row of its unknowns.

    Rows have as many unknowns each, from the face to the far side, and are coupled to the next one.
    A part of the block that hangs on nothing raises SceneError.
    """
    # What is even and what is odd about the middle of a block is apart: a quarter of the work.
    places = np.arange(row).reshape(-1, 2)[::-1].ravel()
    signs = np.tile([-1.0, 1.0], row // 2)  # x turns its sense
    mirror = sparse.csr_array((signs, (np.arange(row), places)))
    rows = sparse.eye_array(stiffness.shape[0] // row)
    turned = sparse.kron(rows, mirror, "csr")
    if abs(turned @ stiffness @ turned - stiffness).max() > ALIKE * abs(stiffness).max():
        return _condensed(stiffness, force, row)
    total, carried = np.zeros((row, row)), np.zeros(row)
    for sign in (1.0, -1.0):
        part = (sparse.eye_array(row) + sign * mirror).tocsc()[:, places >= np.arange(row)]
        size = np.sqrt(part.power(2).sum(axis=0))
        part = part[:, size > 0] @ sparse.diags_array(1 / size[size > 0])
        basis = sparse.kron(rows, part, "csr")
        own, along = _condensed(basis.T @ stiffness @ basis, basis.T @ force, part.shape[1])
        total, carried = total + part @ (part @ own).T, carried + part @ along
    return total, carried


def _condensed(stiffness: sparse.csr_array, force: Array, row: int) -> tuple[Array, Array]:
    """Return what `condensed` does, row by row."""
    starts = range(0, stiffness.shape[0], row)
    total, carried = np.zeros((row, row)), np.zeros(row)
    for start in reversed(starts):
        own = slice(start, start + row)
        total = stiffness[own, own].toarray() - total
        carried = force[own] - carried
        if not start:
            break
        coupling = stiffness[start - row : start, own]
        factor, failed = lapack.dpotrf(total)
        if failed:
            raise SceneError(LOOSE)
        inverse, _ = lapack.dpotri(factor)
        inverse = np.triu(inverse) + np.triu(inverse, 1).T
        passed = coupling @ inverse
        total, carried = passed @ coupling.T, passed @ carried
    return total, carried


def contact_forces(
    faces: list[tuple[Array, Array]], pairs: list[NDArray[np.int64]], friction: Array
) -> tuple[Array, Array]:
    """Return normal and shear forces of pairs in equilibrium, (n,) [stress length].

    Faces are stiffness and force of upper and lower block, condensed, a lower one described by its
    mirror image; pairs are the columns (n,) of the nodes that touch on each, and friction (n,) is
    the shear force over normal force that is carried at most.  SceneError is raised if there is no
    equilibrium, or none is found.
    """
    count, sizes = len(friction), [len(force) for _, force in faces]
    total, n = sum(sizes), np.arange(count)
    matrix = np.zeros((total + 2 * count, total + 2 * count))
    right = np.concatenate([*(force for _, force in faces), np.zeros(2 * count)])
    jumps = np.zeros((2 * count, total))  # of u_y, then of u_x
    for number, ((stiffness, _), nodes) in enumerate(zip(faces, pairs, strict=True)):
        own = slice(number * sizes[0], number * sizes[0] + sizes[number])
        matrix[own, own] = stiffness
        jumps[n, own.start + 2 * nodes + 1] = 1.0
        jumps[count + n, own.start + 2 * nodes] = -1.0 if number else 1.0
    # a pressure opens the joint, and shear drags the upper face back
    matrix[:total, total:] = jumps.T * np.repeat([-1.0, 1.0], count)
    stiff = float(max(np.diag(matrix)[:total]))
    is_open, slides = np.zeros(count, dtype=bool), np.zeros(count)
    for _ in range(PASSES):
        rules = np.zeros((2 * count, total + 2 * count))
        rules[:, :total] = stiff * jumps
        rules[n[is_open]] = 0.0
        rules[n[is_open], total + n[is_open]] = 1.0
        free = is_open | (slides != 0)
        rules[count + n[free]] = 0.0
        rules[count + n[free], total + count + n[free]] = 1.0
        rules[count + n[free], total + n[free]] = -(slides * friction)[free]
        matrix[total:] = rules
        try:
            found = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            raise SceneError(LOOSE) from None
        moved, normal, shear = found[:total], found[total:-count], found[-count:]
        opening, slip = np.split(jumps @ moved, 2)
        force = max(float(np.abs(right).max()), float(np.abs(normal).max()))
        if not np.abs(moved).max() * stiff <= LARGEST * force:
            raise SceneError(LOOSE)
        small = SLACK * force
        pulled, closes = ~is_open & (normal < -small), is_open & (opening * stiff < -small)
        starts = ~free & (np.abs(shear) > friction * normal + small)
        stops = ~is_open & (slides * slip * stiff < -small)
        if not (pulled | closes | starts | stops).any():
            return np.maximum(normal, 0.0), shear
        is_open = (is_open | pulled) & ~closes
        slides = np.where(stops | is_open, 0.0, np.where(starts, np.sign(shear), slides))
    raise SceneError(
        "simulate: no equilibrium of the specimen is found; lower friction or preload."
    )
