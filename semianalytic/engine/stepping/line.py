"""The periodic line y = 0 with both half-planes: nodes, the transform along x, and memories."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np

from semianalytic.dissimilar.kernels import pair_of
from semianalytic.engine.stepping.tuning import LARGEST_HORIZON
from semianalytic.memory.exponentials import fit_memory, fit_shared
from semianalytic.memory.impedance import Antiplane, InPlane, Opening
from semianalytic.memory.line_memory import Kernels, LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.line.loads import InterfaceLoad
from semianalytic.scene.scene import Scene


def grid_of(scene: Scene, nodes: int, shift: float | None = None, held: float = 0.0) -> Grid:
    """Return the grid of an interface on a number of nodes of a period.

    It is moved by `shift` [length], or by what suits the ends of its contacts, which no grid of an
    even interface can be.
    """
    contact = scene.contact
    if shift is None:
        shift = 0.0 if scene.even else contact.shift(scene.period, nodes)
    between = not contact.is_whole
    return Grid(scene.period, nodes, between, scene.even, held, shift)


def with_period(scene: Scene, end_time: float) -> Scene:
    """Return a scene with a period: by default so long that no wave comes back within a time.

    Raises
    ------
    SceneError
        If it has no period, and fields that vary along x, whose extent is not known.
    """
    if math.isfinite(scene.period):
        return scene
    loads = [load for load in scene.loads if isinstance(load, InterfaceLoad)]
    tractions: list[Any] = [scene.base, *loads]
    given = [value for part in tractions for value in (part.pressure, part.shear)]
    parts = [*vars(scene.law).values(), *(vars(scene.adhesion).values() if scene.adhesion else ())]
    if any(map(callable, (*given, *parts, scene.rate))):
        raise SceneError("scene: fields vary along x; give the `period` of the line.")
    ends = [abs(end) for part in scene.contact.intervals for end in part if math.isfinite(end)]
    # waves from an end that the period has as well reach a quarter of it (`Marched.caution`)
    return replace(scene, period=2 * max(ends, default=0.0) + 4 * scene.fastest_speed * end_time)


def fitting_nodes(scene: Scene, least: int, halvings: int) -> int:
    """Return the nodes, `least` or more, on which ends of contacts fit best, as grids can be moved.

    See `Contact.fitting_nodes`.
    """
    return scene.contact.fitting_nodes(scene.period, least, halvings, movable=not scene.even)


@dataclass(frozen=True)
class Grid:
    """Evenly spaced nodes on one period of the line, or on half of it if both halves are alike.

    Parameters
    ----------
    length : float
        Period of the line [length].
    nodes : int
        Nodes of the whole period, an even number.
    between : bool
        Whether x = 0 lies midway between two nodes, as edges of contacts do, or on a node.
    even : bool
        Whether all fields are even in x, so that x >= 0 is enough.
    held : float
        Wavenumber of the stiffness that mean slip meets [1 / length]; 0 for none.
    shift : float
        Distance by which the nodes are moved along x [length]; 0 if it is even.
    """

    length: float
    nodes: int
    between: bool = False
    even: bool = False
    held: float = 0.0
    shift: float = field(default=0.0, repr=False)  # fingerprints of earlier runs know none

    @property
    def spacing(self) -> float:
        """Node distance h [length]."""
        return self.length / self.nodes

    @property
    def shown(self) -> slice:
        """The slice of all nodes that are recorded: all of them."""
        return slice(None)

    @cached_property
    def x(self) -> Array:
        """Positions of nodes, (n,) [length]."""
        half, shift = self.nodes // 2, 0.5 if self.between else 0.0
        if self.even:
            return np.asarray(self.spacing * (np.arange(half + (not self.between)) + shift))
        return np.asarray(self.spacing * (np.arange(self.nodes) - half + shift) + self.shift)

    @cached_property
    def weights(self) -> Array:
        """Length of the line for which each node stands, (n,) [length]."""
        weights = np.full(len(self.x), self.spacing)
        if self.even:
            # Nodes at x = 0 and length / 2 are their own mirror images.
            weights[self.x > 0] *= 2
            weights[self.x >= self.length / 2] /= 2
        return weights

    @cached_property
    def wavenumbers(self) -> Array:
        """Wavenumbers of the amplitudes, (m,) [1 / length]."""
        count = len(self.x) if self.even else self.nodes // 2 + 1
        q = 2 * np.pi / self.length * np.arange(count)
        q[0] = self.held
        return np.asarray(q)

    @property
    def rows(self) -> int:
        """Amplitudes per wavenumber: 1 of cosines, 2 of a periodic line."""
        return 1 if self.even else 2

    def amplitudes(self, values: Array, out: Array | None = None) -> Array:
        """Return the amplitudes of waves along x, real (rows, m), written to `out` if given."""
        if self.even:
            out = np.empty((1, len(values))) if out is None else out
            _cosines(values, out[0], 2 if self.between else 1)
            return out
        lines = _transforms().r2c(values, (0,), True, 0)
        out = np.empty((2, len(lines))) if out is None else out
        out[0], out[1] = lines.real, lines.imag
        return out

    def values(self, amplitudes: Array, out: Array | None = None) -> Array:
        """Return the values at nodes (n,) of amplitudes (rows, m), written to `out` if given."""
        if self.even:
            out = np.empty(amplitudes.shape[1]) if out is None else out
            _from_cosines(amplitudes[0], out, 2 if self.between else 1)
            return out
        lines = amplitudes[0] + 1j * amplitudes[1]
        found: Array = _transforms().c2r(lines, (0,), self.nodes, False, 2)
        if out is None:
            return found
        out[:] = found
        return out


def _cosines(values: Array, out: Array, kind: int = 2) -> None:
    """Write the amplitudes of the cosines of values at the nodes (size,) to another array.

    The line is even about both of its ends, which lie half a spacing from the outermost nodes
    (kind 2) or on them (kind 1).
    """
    _transforms().dct(values, kind, (0,), 0, out)


def _from_cosines(amplitudes: Array, out: Array, kind: int = 2) -> None:
    """Write the values at the nodes (size,) that have these amplitudes to another array."""
    # the inverse of type 2 is type 3, and that of type 1 is itself
    _transforms().dct(amplitudes, 3 if kind == 2 else 1, (0,), 2, out)


@cache
def _transforms() -> Any:
    """Return scipy's `dct` (values, type, axes, 2 to divide by 2 n or 0, out), `r2c` and `c2r`."""
    from scipy.fft import dct, idct, irfft, rfft  # here, for `import semianalytic` is to be quick

    # scipy.fft spends 12 microseconds around each call of these, twice what 500 nodes take.  They
    # are not public: where a version of scipy has others, or elsewhere, scipy.fft serves.
    given, found, waves = np.arange(4.0), np.empty((5, 4)), np.zeros(3, complex)
    try:
        direct = import_module("scipy.fft._pocketfft.pypocketfft")
        for row, (kind, scaling) in enumerate(((2, 0), (3, 2), (1, 0), (1, 2))):
            direct.dct(given, kind, (0,), scaling, found[row])
        waves = direct.r2c(given, (0,), True, 0)
        found[4] = direct.c2r(waves, (0,), 4, False, 2)
    except (ImportError, AttributeError, TypeError, ValueError, RuntimeError):
        found[:] = np.nan
    known = [dct(given), idct(given), dct(given, type=1), idct(given, type=1), given]
    if np.allclose(found, known, rtol=1e-12) and np.allclose(waves, rfft(given), rtol=1e-12):
        return direct

    def public(values: Array, kind: int, axes: tuple[int], scaling: int, out: Array) -> None:
        turned = idct if scaling else dct  # scipy names an inverse by the type that it inverts
        out[:] = turned(values, type=1 if kind == 1 else 2)

    return SimpleNamespace(
        dct=public,
        r2c=lambda values, *_: rfft(values),
        c2r=lambda lines, _, count, *__: irfft(lines, count),
    )


def memories(
    scene: Scene, grid: Grid, end_time: float, tolerance: float
) -> tuple[LineMemory, LineMemory | None, float]:
    """Return the memories of slip and opening, and the traction over wavenumber and slip [stress].

    That of opening is None where nothing opens.  `tolerance` is the relative error of the transform
    between identical bodies.
    """
    material, pair = scene.material, pair_of(scene)
    speed = material.shear_speed if pair is None else pair.speed
    # The memory of an event with its echoes; later only the static stiffness acts.
    reach = math.pi / grid.spacing * min(speed * end_time, 20.0 * scene.period)
    horizon = min(max(reach, 100.0), LARGEST_HORIZON)
    # rounded up to a power of 2, so that runs of different lengths share a fit
    horizon = min(2.0 ** math.ceil(math.log2(horizon)), LARGEST_HORIZON)
    # Rungs whose tables are kept: 8 MB each at 4,096 nodes and 42 poles.
    line = grid.wavenumbers, 1 if grid.even else 2, 8
    if pair is not None:
        # The three kernels of different bodies take 33 to 59 poles.
        fit = fit_shared(pair.kernels, horizon, 1e-6)
        direct = pair.kernels.direct
        slip, gap = (
            LineMemory(Kernels.coupled(fit, own, float(direct[own])), *line) for own in (0, 1)
        )
        return slip, gap, pair.stiffness
    ratio = material.shear_speed / material.longitudinal_speed
    impedance = Antiplane() if scene.mode == "antiplane" else InPlane(ratio)
    memory = LineMemory(fit_memory(impedance, horizon, tolerance), *line)
    stiffness = impedance.static * material.shear_modulus / 2
    if not scene.may_open:
        return memory, None, stiffness
    return memory, LineMemory(fit_memory(Opening(ratio), horizon, tolerance), *line), stiffness
