"""A spectral march of two different half-planes with a slot: an independent witness, and plain.

One periodic line; every body answers velocities of its face with tractions through impedances

    tau = -Z_11 v_x - Z_12 v_y,  sigma = Z_12 v_x - Z_22 v_y        (upper; lower mirrored),

whose memory is a sum of exponentials of q c_t t, fitted by set-valued AAA.  At every node slot,
stick, Coulomb slip or opening is decided in closed form, with a predictor and one correction.  It
shares nothing with `semianalytic` but the description of a pair.  First order in the spacing.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg


@dataclass(frozen=True)
class March:
    """Fields on the contact at the last time, over x/t; state 0 stuck, +-1 slipping, 2 open."""

    velocity: np.ndarray
    slip_rate: np.ndarray
    pressure: np.ndarray
    gap: np.ndarray
    spacing: float

    @property
    def zones(self):
        """(state, inner, outer) of what moves, in order; slip below a thousandth is none."""
        slow = np.abs(self.slip_rate) < 1e-3 * np.abs(self.slip_rate).max()
        state = np.where(self.gap > 0, 2, np.where(slow, 0, np.sign(self.slip_rate))).astype(int)
        bounds = [0, *(np.flatnonzero(np.diff(state)) + 1), len(state)]
        half = self.spacing / 2
        return [
            (state[i], self.velocity[i] - half, self.velocity[j - 1] + half)
            for i, j in pairwise(bounds)
            if state[i]
        ]


def kernels(ratio, s):
    """Z_11 - 1, Z_22 - 1/g and the memory of Z_12, over rho c_t, at s over q c_t; g = c_t / c_l."""
    alpha, beta = np.sqrt(ratio**2 * s * s + 1), np.sqrt(s * s + 1)
    bulk = (ratio**2 * s**4 + (1 + ratio**2) * s * s) / (alpha * beta + 1)
    return np.array([s * alpha / bulk - 1, s * beta / bulk - 1 / ratio, (2 - s * s / bulk) / s])


def exponentials(ratio, horizon, tolerance=1e-5):
    """Poles (m,) and residues (3, m) of the kernels, in conjugate pairs."""
    low = 2.0 / horizon
    fronts = [
        front + side * np.geomspace(1e-2 * low, 0.4, 80)
        for front in (1.0, 1 / ratio)
        for side in (1, -1)
    ]
    w = np.concatenate([np.geomspace(1e-2 * low, 30, 260), *fronts, np.geomspace(30, 3000, 30)])
    w = np.unique(w[w > 0])
    s = np.concatenate([low + 1j * w, low - 1j * w])
    static = np.array([2.0, 2.0, 2 * ratio**2]) / (1 + ratio**2)
    values = kernels(ratio, s) - static[:, None] / s
    scaled = values / np.abs(values).max(axis=1)[:, None]
    fitted, support = np.tile(scaled.mean(axis=1)[:, None], (1, len(s))), []
    for _ in range(30):
        error = np.abs(scaled - fitted).max(axis=0)
        worst = int(np.argmax(error))
        if error[worst] < tolerance:
            break
        support += [worst, (worst + len(w)) % len(s)]
        rest = np.setdiff1d(np.arange(len(s)), support)
        cauchy = 1 / (s[rest, None] - s[support])
        loewner = [entry[rest, None] * cauchy - cauchy * entry[support] for entry in scaled]
        weight = np.linalg.svd(np.concatenate(loewner), full_matrices=False)[2][-1].conj()
        fitted = scaled.copy()
        fitted[:, rest] = (cauchy @ (weight * scaled[:, support])[..., None])[..., 0] / (
            cauchy @ weight
        )
    size = len(support)
    left = np.zeros((size + 1, size + 1), dtype=complex)
    left[0, 1:], left[1:, 0] = weight, 1.0
    left[1:, 1:] = np.diag(s[support])
    mass = np.diag([0.0, *np.ones(size)])
    poles = scipy.linalg.eigvals(left, mass)
    poles = poles[np.isfinite(poles) & (np.abs(poles) < 1e4)]
    poles = poles[(poles.real < 0.2 * low) & (poles.imag > -1e-12)]
    poles = np.minimum(poles.real, -1e-9) + 1j * poles.imag
    columns = [
        factor / (s - pole) + np.conj(factor) / (s - pole.conj())
        for pole in poles
        for factor in (1.0, 1j)
    ]
    matrix = np.concatenate([np.real(columns).T, np.imag(columns).T])
    parts = np.linalg.lstsq(matrix, np.concatenate([values.real, values.imag], axis=1).T)[0]
    residues = (parts[0::2] + 1j * parts[1::2]).T
    poles = np.append(poles, -1e-12)
    residues = np.concatenate([residues, static[:, None] / 2], axis=1)
    return np.append(poles, poles.conj()), np.concatenate([residues, residues.conj()], axis=1)


class Body:
    """Memory of one half-plane for all wave numbers."""

    def __init__(self, material, q, dt, duration, sign):
        self.sign, speed = sign, material.shear_speed
        ratio = speed / material.longitudinal_speed
        poles, residues = exponentials(ratio, q[-1] * speed * duration)
        self.shear = material.density * speed
        self.normal = self.shear / ratio
        z = poles[:, None] * q * speed * dt
        self.decay = np.exp(z)
        small = np.abs(z) < 1e-3
        safe = np.where(small, 1.0, z)
        first = np.where(small, 1 + z / 2 + z * z / 6, (self.decay - 1) / safe)
        second = np.where(small, 0.5 + z / 6 + z * z / 24, (self.decay - 1 - z) / safe**2)
        self.before, self.after = ((first - second) * dt * q * speed, second * dt * q * speed)
        self.residues = residues * self.shear
        self.turn = np.where(q > 0, -1j, 0.0)
        self.states = [np.zeros_like(z), np.zeros_like(z)]

    def begun(self, velocity):
        """The states after a step but for the velocities at its end."""
        spectra = [np.fft.rfft(speed) for speed in velocity]
        return [
            self.decay * state + self.before * spectrum
            for state, spectrum in zip(self.states, spectra, strict=True)
        ]

    def ended(self, begun, velocity):
        """The states with those, and the tractions they carry."""
        states = [old + self.after * np.fft.rfft(v) for old, v in zip(begun, velocity, strict=True)]
        along, normal, mixed = self.residues[..., None]
        tau = -self.sign * (along * states[0]).sum(axis=0) - self.turn * (mixed * states[1]).sum(
            axis=0
        )
        sigma = self.turn * (mixed * states[0]).sum(axis=0) - self.sign * (normal * states[1]).sum(
            axis=0
        )
        count = 2 * (len(tau) - 1)
        return states, np.fft.irfft(tau, count), np.fft.irfft(sigma, count)


def march(pair, nodes, reach, viscosity=0.0, courant=0.4):
    """March a pair to t = 1, undisturbed by the periodic images for x/t < reach."""
    solids, base, load = (pair.material, pair.lower_material), pair.base, pair.load
    length = 2 * (max(solid.longitudinal_speed for solid in solids) + reach)
    spacing = length / nodes
    x = (np.arange(nodes) - nodes // 2 + 0.31) * spacing  # where a stuck edge puts the first node
    q = 2 * np.pi * np.fft.rfftfreq(nodes, spacing)
    steps = int(np.ceil(max(solid.shear_speed for solid in solids) / (courant * spacing)))
    dt = 1.0 / steps
    upper, lower = (Body(solid, q, dt, 1.0, s) for solid, s in zip(solids, (1, -1), strict=True))
    slot, gap = x < 0, np.zeros(nodes)
    velocities = [[np.zeros(nodes), np.zeros(nodes)] for _ in range(2)]
    free = np.where(slot, load.pressure, base.pressure)
    series = upper.shear * lower.shear / (upper.shear + lower.shear)
    for _ in range(steps):
        begun = [solid.begun(v) for solid, v in zip((upper, lower), velocities, strict=True)]
        new = velocities
        for _ in range(2):
            (_, tau_1, sigma_1), (_, tau_2, sigma_2) = (
                body.ended(start, v)
                for body, start, v in zip((upper, lower), begun, new, strict=True)
            )
            parted = (sigma_1 - free) / upper.normal, (free - sigma_2) / lower.normal
            opening = parted[0] - parted[1]
            shut = ~slot & (gap > 0) & (gap + dt * opening <= 0)
            closing = np.where(shut, -gap / dt, 0.0)
            both = upper.normal + lower.normal
            together = (sigma_1 - sigma_2 + lower.normal * closing) / both
            pressure = base.pressure - (sigma_1 - upper.normal * together)
            opened = (slot | (pressure < 0) | (gap > 0)) & ~shut
            normal = [np.where(opened, parted[0], together)]
            normal.append(np.where(opened, parted[1], together - closing))
            pressure = np.where(opened, 0.0, np.maximum(pressure, 0.0))
            stuck = (tau_1 - tau_2) / (upper.shear + lower.shear)
            total = base.shear + tau_1 - upper.shear * stuck
            excess = np.maximum(np.abs(total) - pair.coefficient * pressure, 0.0)
            rate = np.sign(total) * excess / (series + viscosity)
            tau = np.where(opened, -base.shear, total - series * rate - base.shear)
            tau = np.where(slot, -load.shear, tau)
            along = (tau_1 - tau) / upper.shear, (tau - tau_2) / lower.shear
            new = [[along[k], normal[k]] for k in range(2)]
        for body, start, v in zip((upper, lower), begun, new, strict=True):
            body.states = body.ended(start, v)[0]
        velocities = new
        gap = np.where(opened & ~slot, np.maximum(gap + dt * (normal[0] - normal[1]), 0.0), 0.0)
    seen = ~slot & (x < reach)
    rate = along[0] - along[1]
    return March(x[seen], rate[seen], pressure[seen], gap[seen], spacing)
