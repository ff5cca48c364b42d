"""The continuous tractions of y = 0 after a march, without the parts that have exact fields.

Jumps of the loads on an interface that sticks have exact fields, and slip ahead of all waves sends
plane waves (`marched_bodies`).  Their tractions are subtracted from the recorded ones.  From the
remainder, and from the continuous part of the loads on the slot, this module makes a `Spectrum`.

The grid sees tractions that are singular at the edge as if its first node lay 0.310 spacings from
there, not half a spacing (`edge_factors`; docs/theory.md, "The edge on a grid").  Where the edge
sticks, that holds for the whole traction.  Where it slips, it holds for the friction under a
singular pressure, and for the stuck tractions that are subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.wavefield import (
    Spectrum,
    TimeWindow,
    along_line,
    kept_wavenumbers,
    tapered,
)
from semianalytic.engine.resolution import nodes_for_loads
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.loading import Tractions
from semianalytic.scene.loads import LoadHistory, Pieces
from semianalytic.scene.scene import Scene

FIELD_NODES = 128
"""Nodes on the reach of waves: fields are off by 2e-4 in L1, with 64 by 8e-4, with 256 by 7e-5."""

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class SlotLoad:
    """A traction that is taken off the slot, as a sum of jumps and a continuous rest.

    Attributes
    ----------
    mode : Mode
        "I" for pressure, "II" or "III" for shear.
    jumps : tuple of (time, height)
        Times [time] and heights [stress] of the jumps.
    rest : (m,) array
        The continuous rest at the stored levels [stress].
    """

    mode: Mode
    jumps: tuple[tuple[float, float], ...]
    rest: Array

    @classmethod
    def of(cls, mode: Mode, load: float, history: LoadHistory, times: Array) -> SlotLoad:
        """Make it from a load [stress] and its history at times (m,) [time]."""
        pieces = history.pieces
        rest = np.zeros(len(times))
        if load and (pieces.kinks or pieces.waves):
            rest = load * (history.value(times) - Pieces(jumps=pieces.jumps).value(times))
        return cls(mode, tuple((at, load * height) for at, height in pieces.jumps if load), rest)

    @property
    def varies(self) -> bool:
        """Whether there is a continuous rest."""
        return bool(np.any(self.rest))

    def jumped(self, t: Array) -> Array:
        """Return the sum of the jumps until times (m,), [stress]."""
        return Pieces(jumps=self.jumps).value(t)


@dataclass(frozen=True, eq=False)
class Remainder:
    """The tractions of y = 0 that have no exact fields, on the nodes of a march and some more.

    Attributes
    ----------
    scene : Scene
        The scene that was marched.
    interface : InterfaceHistory
        Recorded fields of the contact.
    far : (m,) array
        Change of shear traction ahead of all waves at the stored levels [stress].
    normal, shear : SlotLoad
        Pressure and shear that are taken off the slot.
    share : float
        Part of the wavenumbers that are summed.
    """

    scene: Scene
    interface: InterfaceHistory
    far: Array
    normal: SlotLoad
    shear: SlotLoad
    share: float

    @property
    def reach(self) -> float:
        """Distance that waves have travelled at the last level [length]."""
        return float(self.scene.fastest_speed * self.interface.t[-1])

    @property
    def _spacing(self) -> float:
        """Node distance: the first node is half of it from the edge [length]."""
        return 2 * float(self.interface.x[0])

    @cached_property
    def _reached(self) -> int:
        """Number of nodes that waves reach on one side of the edge."""
        return math.ceil(self.reach / self._spacing) + 8

    @property
    def _contact(self) -> int:
        """Number of nodes of the contact, which come first."""
        return min(len(self.interface.x), self._reached)

    @property
    def _slot(self) -> int:
        """Number of nodes of the loaded slot, which come last."""
        # twice as long as waves reach, so that the waves of its other end come too late
        return 2 * self._reached if self.normal.varies or self.shear.varies else 0

    @cached_property
    def _nodes(self) -> int:
        """Number of nodes in a period along x."""
        from scipy.fft import next_fast_len  # here, for `import semianalytic` is to be quick

        return int(next_fast_len(2 * self._reached + self._slot, real=True))

    def spectra(self) -> tuple[Spectrum, ...]:
        """Return the spectra of shear and, unless its load consists of jumps only, of pressure.

        In plane strain one spectrum holds both; in antiplane shear there is one for each.
        """
        scene, seen = self.scene, self.interface
        speed = scene.material.shear_speed
        nodes = math.ceil(self.share * FIELD_NODES)
        steps = max(len(seen.t) - 1, 2 * FIELD_NODES)  # more than are stored, if those are few
        window = TimeWindow(speed * float(seen.t[-1]), steps)
        enough, _ = nodes_for_loads(scene, float(seen.t[-1]), self.reach, nodes)
        share = enough * self._spacing / self.reach
        q = kept_wavenumbers(self._nodes * self._spacing, self._nodes, share)
        omega = window.frequencies(scene.fastest_speed / speed * q[-1])
        taper = tapered(q, omega)

        def transformed(part: Callable[[slice], tuple[Array, Array]]) -> Complex:
            lines = self._along_line(part, q)
            return taper * window.transformed(
                _resampled(lines, seen.t, window.times / speed), omega
            )

        shear = transformed(self._shear_left)
        normal = transformed(self._pressure_left) if self.normal.varies else None
        if scene.antiplane and normal is not None:
            return Spectrum(q, omega, None, normal), Spectrum(q, omega, shear, None)
        return (Spectrum(q, omega, shear, normal),)

    def _along_line(self, left: Callable[[slice], tuple[Array, Array]], q: Array) -> Complex:
        """Return the amplitudes (m, n) at the wavenumbers q, level by level in blocks.

        `left` returns the tractions of a part of the levels, singular at the edge and bounded.
        """
        lines = np.empty((len(self.interface.t), len(q)), dtype=complex)
        block = max(1, (1 << 22) // self._nodes)  # tractions transformed at once, 32 MB
        offset, _ = edge_offset_and_factors()
        for first in range(0, len(lines), block):
            part = slice(first, first + block)
            singular, bounded = left(part)
            # the two have their first node at 0.310 and at half a spacing from the edge
            lines[part] = along_line(singular, self._spacing, offset, q)
            if np.any(bounded):
                lines[part] += along_line(bounded, self._spacing, 0.5, q)
        return lines

    def _pressure_left(self, part: slice) -> tuple[Array, Array]:
        """Return the change of sigma_yy at a part of the levels, singular and bounded at the edge.

        Both have the shape (l, nodes).  All of it is taken as singular; the second one is zero.
        """
        seen, contact = self.interface, self._contact
        singular = np.zeros((len(seen.t[part]), self._nodes))
        pressed = seen.pressure[part, :contact] - self._held.pressure
        # sigma_yy is minus the pressure: -(pressed - stuck)
        singular[:, :contact] = self._stuck(self.normal, seen.t[part], contact) - pressed
        if self._slot:
            singular[:, -self._slot :] = self.normal.rest[part, None]
        return singular, np.zeros_like(singular)

    def _edge(self, part: slice) -> tuple[Flags, Array]:
        """Return whether the first node slips, and its shear traction over its pressure if so.

        Both have the shape (l, 1).
        """
        pressure = self.interface.pressure[part, :1]
        slips = self.interface.slip_rate[part, :1] != 0
        rubbing = slips & (pressure > 0)
        shear = np.where(rubbing, self.interface.shear_traction[part, :1], 0.0)
        return slips, shear / np.where(rubbing, pressure, 1.0)

    @cached_property
    def singular_share(self) -> Array:
        """Share of the stuck shear intensity at the edge that slip leaves, (m,)."""
        # Where the edge slips, tau = s f p holds up to it: the shear is as singular as the friction
        # under the singular pressure.
        seen, every = self.interface, slice(None)
        slips, coefficient = (one[:, 0] for one in self._edge(every))
        stuck = self._stuck(self.shear, seen.t, 1)[:, 0] + self.shear.jumped(seen.t)
        pressed = seen.pressure[:, 0] - self._held.pressure + self._pressure_load(seen.t)
        known = slips & (stuck != 0)
        return np.where(known, coefficient * pressed / np.where(known, stuck, 1.0), 1.0)

    @property
    def _held(self) -> Tractions:
        """Tractions of the contact ahead of the waves."""
        return self.scene.superposition.in_place

    def _pressure_load(self, t: Array) -> Array:
        """Return the pressure P_0 f_p that is taken off the slot at times t, (m,) [stress]."""
        return self.scene.superposition.taken_off.pressure * self.scene.pressure_history.value(t)

    def _shear_left(self, part: slice) -> tuple[Array, Array]:
        """Return the change of shear traction, singular and bounded at the edge, (l, nodes)."""
        seen, held, contact, t = self.interface, self._held, self._contact, self.interface.t
        slips, coefficient = self._edge(part)
        singular, bounded = np.zeros((2, len(t[part]), self._nodes))
        sheared = seen.shear_traction[part, :contact] - held.shear - self.far[part, None]
        pressed = seen.pressure[part, :contact] - held.pressure
        # at an edge that slips, friction under the singular pressure is singular, the rest is not
        bounded[:, :contact] = np.where(slips, sheared - coefficient * pressed, 0.0)
        singular[:, :contact] = np.where(slips, coefficient * pressed, sheared)
        singular[:, :contact] -= self._stuck(self.shear, t[part], contact)
        # Singular is the response plus the load; the load is a constant on the contact, subtracted
        # again.  On nodes of which the first is 0.310 h from the edge, that constant would begin
        # (0.5 - 0.310) h before the edge; the excess is taken off the first node.
        offset, _ = edge_offset_and_factors()
        moved = coefficient[:, 0] * self._pressure_load(t[part]) - self.shear.jumped(t[part])
        bounded[:, 0] += (0.5 - offset) * np.where(slips[:, 0], moved, 0.0)
        if self._slot:
            rest = -self.shear.rest[part, None]
            bounded[:, -self._slot :] = np.where(slips, rest, 0.0)
            singular[:, -self._slot :] = np.where(slips, 0.0, rest)
        return singular, bounded

    def _stuck(self, slot: SlotLoad, t: Array, nodes: int) -> Array:
        """Return the tractions of load jumps on a contact that sticks, as its grid sees them.

        The shape is (l, nodes) [stress]; `t` (l,) are times [time].
        """
        offset, near = edge_offset_and_factors()
        factors = np.ones(nodes)
        factors[: len(near)] = near[:nodes]
        x = (np.arange(nodes) + offset) * self._spacing
        material = self.scene.material
        step = stuck_traction(material.poisson_ratio, slot.mode)
        total = np.zeros((len(t), nodes))
        for start, height in slot.jumps:
            after = t > start
            u = np.multiply.outer(material.shear_speed * (t[after] - start), 1 / x)
            # the response plus the load, q* + 1, is singular and takes the factors of the grid
            total[after] += height * ((step(u) + 1) * factors - 1)
        return total


def far_traction(scene: Scene, times: Array) -> Array:
    """Return the change of shear traction ahead of all waves, (m,) [stress].

    It is zero unless a remote load is more than the contact bears.

    Parameters
    ----------
    scene : Scene
        Material, friction law and tractions.
    times : (m,) array
        Increasing times from 0 on [time].
    """
    impedance, held = scene.material.shear_impedance / 2, scene.superposition.in_place
    stopping = np.array([abs(held.shear)])
    pressure = np.array([held.pressure])
    # There V is uniform and the waves it sends are plane: no memory, only the local term of (4.40).
    path, rates = np.zeros(1), np.zeros(len(times))
    for level, step in enumerate(np.diff(times, append=times[-1])):
        rates[level] = scene.law.slip_speed(stopping, pressure, impedance, path)[0]
        path = path + step * rates[level]
    return np.asarray(-np.sign(held.shear) * impedance * rates)


def _resampled(lines: Complex, times: Array, at: Array) -> Complex:
    """Interpolate lines (m, n), given at increasing times, linearly at other times."""
    after = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
    share = (at - times[after - 1]) / (times[after] - times[after - 1])
    share = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray((1 - share) * lines[after - 1] + share * lines[after])
