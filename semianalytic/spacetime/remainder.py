"""What a march leaves on y = 0 once what has exact fields is taken off: continuous tractions.

Jumps of the loads on an interface that sticks have exact fields, and slip ahead of all waves sends
plane waves (`marched_bodies`).  Their tractions on the contact are taken off those recorded.  Of
what is left, and of the rest of the loads on the slot, this module makes a `Spectrum`.

The grid sees what is singular at the edge as if its first node lay 0.310 spacings from there, not
half a spacing (`edge_factors`).  Where the edge sticks that holds for all of the grid; where it
slips, for friction under a singular pressure, and for the stuck tractions that are taken off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.loading import Tractions
from semianalytic.scene.loads import LoadHistory, Pieces
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.resolution import nodes_for_loads
from semianalytic.spacetime.tuning import FIELD_MARGIN, FIELD_NODES, FIELD_VALUES
from semianalytic.spacetime.wavefield import (
    Spectrum,
    Window,
    along_line,
    kept_wavenumbers,
    tapered,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class SlotLoad:
    """Traction that is taken off the slot: jumps, and a continuous rest.

    Attributes
    ----------
    mode : Mode
        "I" of pressure, "II" or "III" of shear.
    jumps : tuple of (time, height)
        [time], [stress].
    rest : (m,) array
        At the stored levels [stress].
    """

    mode: Mode
    jumps: tuple[tuple[float, float], ...]
    rest: Array

    @classmethod
    def of(cls, mode: Mode, load: float, history: LoadHistory, times: Array) -> SlotLoad:
        """That of a load [stress] and its history at times [time]."""
        pieces = history.pieces
        rest = np.zeros(len(times))
        if load and (pieces.kinks or pieces.waves):
            rest = load * (history.value(times) - Pieces(jumps=pieces.jumps).value(times))
        return cls(mode, tuple((at, load * height) for at, height in pieces.jumps if load), rest)

    @property
    def varies(self) -> bool:
        """Whether there is a rest."""
        return bool(np.any(self.rest))

    def jumped(self, t: Array) -> Array:
        """Sum of the jumps until times (m,), [stress]."""
        return Pieces(jumps=self.jumps).value(t)


@dataclass(frozen=True, eq=False)
class Remainder:
    """Tractions of y = 0 that have no exact fields, on the nodes of a march and some more.

    Attributes
    ----------
    scene : Scene
    interface : InterfaceHistory
        Of the march.
    far : (m,) array
        Change of shear traction ahead of all waves at the stored levels [stress].
    normal, shear : SlotLoad
    """

    scene: Scene
    interface: InterfaceHistory
    far: Array
    normal: SlotLoad
    shear: SlotLoad

    @property
    def reach(self) -> float:
        """How far waves have come at the last level [length]."""
        return float(self.scene.fastest_speed * self.interface.t[-1])

    @property
    def _spacing(self) -> float:
        return 2 * float(self.interface.x[0])

    @cached_property
    def _reached(self) -> int:
        """Nodes that waves come to on one side."""
        return math.ceil(self.reach / self._spacing) + FIELD_MARGIN

    @property
    def _contact(self) -> int:
        """Nodes of the contact, the first of all."""
        return min(len(self.interface.x), self._reached)

    @property
    def _slot(self) -> int:
        """Nodes of the slot that is loaded, the last of all: its other end is not seen."""
        return 2 * self._reached if self.normal.varies or self.shear.varies else 0

    @cached_property
    def _nodes(self) -> int:
        from scipy.fft import next_fast_len  # here, for `import semianalytic` is to be quick

        return int(next_fast_len(2 * self._reached + self._slot, real=True))

    def spectra(self) -> tuple[Spectrum, ...]:
        """Of shear, and of pressure if its load does not only jump; together in plane."""
        scene, seen = self.scene, self.interface
        speed = scene.material.shear_speed
        steps = max(len(seen.t) - 1, 2 * FIELD_NODES)  # more than are stored, if those are few
        window = Window(speed * float(seen.t[-1]), steps)
        enough, _ = nodes_for_loads(scene, float(seen.t[-1]), self.reach, FIELD_NODES)
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
        """Amplitudes (m, n) at wavenumbers, level by level in blocks."""
        lines = np.empty((len(self.interface.t), len(q)), dtype=complex)
        block = max(1, FIELD_VALUES // self._nodes)
        offset, _ = edge_offset_and_factors()
        for first in range(0, len(lines), block):
            part = slice(first, first + block)
            singular, bounded = left(part)
            lines[part] = along_line(singular, self._spacing, offset, q)
            if np.any(bounded):
                lines[part] += along_line(bounded, self._spacing, 0.5, q)
        return lines

    def _pressure_left(self, part: slice) -> tuple[Array, Array]:
        """Change of sigma_yy (l, nodes), singular at the edge and not, at a part of the levels."""
        seen, contact = self.interface, self._contact
        singular = np.zeros((len(seen.t[part]), self._nodes))
        pressed = seen.pressure[part, :contact] - self._held.pressure
        singular[:, :contact] = self._stuck(self.normal, seen.t[part], contact) - pressed
        if self._slot:
            singular[:, -self._slot :] = self.normal.rest[part, None]
        return singular, np.zeros_like(singular)

    def _edge(self, part: slice) -> tuple[Flags, Array]:
        """Whether the first node slips (l, 1), and its shear traction over its pressure then."""
        pressure = self.interface.pressure[part, :1]
        slips = self.interface.slip_rate[part, :1] != 0
        rubbing = slips & (pressure > 0)
        shear = np.where(rubbing, self.interface.shear_traction[part, :1], 0.0)
        return slips, shear / np.where(rubbing, pressure, 1.0)

    @cached_property
    def singular_share(self) -> Array:
        """What slip leaves of the stuck intensity of shear at the edge, (m,)."""
        seen, every = self.interface, slice(None)
        slips, coefficient = (one[:, 0] for one in self._edge(every))
        stuck = self._stuck(self.shear, seen.t, 1)[:, 0] + self.shear.jumped(seen.t)
        pressed = seen.pressure[:, 0] - self._held.pressure + self._pressure_load(seen.t)
        known = slips & (stuck != 0)
        return np.where(known, coefficient * pressed / np.where(known, stuck, 1.0), 1.0)

    @property
    def _held(self) -> Tractions:
        """On the contact until waves come."""
        return self.scene.superposition.in_place

    def _pressure_load(self, t: Array) -> Array:
        return self.scene.superposition.taken_off.pressure * self.scene.pressure_history.value(t)

    def _shear_left(self, part: slice) -> tuple[Array, Array]:
        """Change of shear traction (l, nodes), singular at the edge and not, likewise."""
        seen, held, contact, t = self.interface, self._held, self._contact, self.interface.t
        slips, coefficient = self._edge(part)
        singular, bounded = np.zeros((2, len(t[part]), self._nodes))
        sheared = seen.shear_traction[part, :contact] - held.shear - self.far[part, None]
        pressed = seen.pressure[part, :contact] - held.pressure
        bounded[:, :contact] = np.where(slips, sheared - coefficient * pressed, 0.0)
        singular[:, :contact] = np.where(slips, coefficient * pressed, sheared)
        singular[:, :contact] -= self._stuck(self.shear, t[part], contact)
        # what is singular is the response together with the load, which begins at the edge itself
        offset, _ = edge_offset_and_factors()
        moved = coefficient[:, 0] * self._pressure_load(t[part]) - self.shear.jumped(t[part])
        bounded[:, 0] += (0.5 - offset) * np.where(slips[:, 0], moved, 0.0)
        if self._slot:
            rest = -self.shear.rest[part, None]
            bounded[:, -self._slot :] = np.where(slips, rest, 0.0)
            singular[:, -self._slot :] = np.where(slips, 0.0, rest)
        return singular, bounded

    def _stuck(self, slot: SlotLoad, t: Array, nodes: int) -> Array:
        """What jumps exert on a contact that sticks, as its grid sees it, (l, nodes) [stress]."""
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
            total[after] += height * ((step(u) + 1) * factors - 1)
        return total


def far_traction(scene: Scene, times: Array) -> Array:
    """Change of shear traction ahead of all waves at increasing times from 0 on, (m,) [stress].

    Not 0 where a remote load is more than the contact bears.
    """
    impedance, held = scene.material.shear_impedance / 2, scene.superposition.in_place
    stopping = np.array([abs(held.shear)])
    frictional = np.array([scene.friction * held.pressure])
    path, rates = np.zeros(1), np.zeros(len(times))
    for level, step in enumerate(np.diff(times, append=times[-1])):
        rates[level] = scene.friction_law.slip_speed(stopping, frictional, impedance, path)[0]
        path = path + step * rates[level]
    return np.asarray(-np.sign(held.shear) * impedance * rates)


def _resampled(lines: Complex, times: Array, at: Array) -> Complex:
    """Lines (m, n) at increasing times, linear between them, at others."""
    after = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
    share = (at - times[after - 1]) / (times[after] - times[after - 1])
    share = np.clip(share, 0.0, 1.0)[:, None]
    return np.asarray((1 - share) * lines[after - 1] + share * lines[after])
