"""A spectral march of two like half-planes on a periodic line: an independent witness, and plain.

Each Fourier mode answers slip rates of one side with tractions through the impedance of a
half-plane, tau = -rho c_t (V + memory), whose memory is a sum of exponentials of q c_t t fitted by
AAA.  At every node a given strength decides between stick and slip, with a predictor and two
corrections.  It shares nothing with `semianalytic`.  Units: mu = rho = c_t = 1.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.interpolate import AAA

STATIC = {"II": lambda a2: 2 * (1 - a2), "I": lambda a2: 2 * (1 - a2), "III": lambda a2: 1.0}


@dataclass(frozen=True)
class LineMarch:
    """Fields of one side at the last time at nodes x."""

    x: np.ndarray
    slip_rate: np.ndarray
    slip: np.ndarray
    traction: np.ndarray

    @property
    def edge(self):
        """Where slip ends on 0 < x < 0.35 L, where it falls to zero as a distance to the 3/2."""
        some = (self.x > 0) & (self.x < 0.7 * self.x[-1])
        share = self.slip[some] / self.slip[some].max()
        near = (share > 2e-3) & (share < 0.08)
        slope, height = np.polyfit(self.x[some][near], share[near] ** (2 / 3), 1)
        return float(-height / slope)


def impedance(mode, a2, s):
    """M of a half-plane over rho c_t at s over q c_t, k = i/s; a2 = (c_t / c_l)^2."""
    alpha, beta = np.sqrt(a2 + 1 / s**2), np.sqrt(1 + 1 / s**2)
    if mode == "III":
        return beta
    rayleigh = (1 + 2 / s**2) ** 2 - 4 / s**2 * alpha * beta
    return rayleigh / (beta if mode == "II" else alpha)


@cache
def exponentials(mode, nu, horizon):
    """Poles and residues of M less its values at both ends of s."""
    a2 = (1 - 2 * nu) / (2 - 2 * nu)
    instant = 1.0 if mode != "I" else 1 / np.sqrt(a2)
    low = 3.0 / horizon
    w = np.geomspace(1e-2 * low, 60, 500)
    fronts = [1.0] if mode == "III" else [1.0, 1 / np.sqrt(a2)]
    near = [f + side * np.geomspace(1e-2 * low, 0.4, 120) for f in fronts for side in (1, -1)]
    w = np.unique(np.concatenate([w, *near, np.geomspace(60, 300, 40)]))
    s = np.concatenate([low + 1j * w, low - 1j * w])
    rest = impedance(mode, a2, s) - instant - STATIC[mode](a2) / s
    with warnings.catch_warnings():  # what forty poles leave is far below the error of the grid
        warnings.simplefilter("ignore", RuntimeWarning)
        fit = AAA(s, rest, rtol=1e-7, max_terms=40)
    poles, residues = fit.poles(), fit.residues()
    keep = poles.real < 0.5 * low
    poles, residues = poles[keep], residues[keep]
    basis = 1 / (s[:, None] - poles)  # residues anew, for poles left out
    residues = np.linalg.lstsq(basis, rest, rcond=None)[0]
    return instant, np.append(poles, 0.0), np.append(residues, STATIC[mode](a2))


def march(mode, nu, nodes, length, end, held, strength, courant=0.4):
    """March until `end`; `held(x, t)` is the traction of a glued line, `strength(x, t)` its bound.

    Where strength is negative the node belongs to a slot and bears nothing.
    """
    h = length / nodes
    x = (np.arange(nodes) - nodes / 2 + 0.5) * h
    steps = int(np.ceil(end / (courant * h)))
    dt = end / steps
    q = 2 * np.pi * np.arange(nodes // 2 + 1) / length
    instant, poles, residues = exponentials(mode, nu, float(q[-1] * end))
    z = poles[:, None] * q * dt
    small = np.abs(z) < 1e-3
    safe = np.where(small, 1.0, z)
    phi1 = np.where(small, 1 + z / 2 + z**2 / 6, np.expm1(safe) / safe)
    phi2 = np.where(small, 0.5 + z / 6 + z**2 / 24, (phi1 - 1) / safe)
    decay, gain = np.exp(z), residues[:, None] * q * dt
    before, now = gain * (phi1 - phi2), gain * phi2
    feedback = now.sum(axis=0).real
    memory = np.zeros(z.shape, dtype=complex)
    rate, slip, rates = np.zeros(nodes), np.zeros(nodes), np.zeros(len(q), dtype=complex)
    for step in range(1, steps + 1):
        t = step * dt
        tau0, bound = held(x, t), strength(x, t)
        # poles come in pairs, of whose sums only the part that is real in x counts
        past = decay * memory + before * rates
        old, history = rate, past.sum(axis=0)
        for _ in range(3):
            stop = tau0 - np.fft.irfft(history + feedback * rates, nodes)
            over = np.where(bound < 0, stop, np.sign(stop) * np.maximum(np.abs(stop) - bound, 0))
            rate = over / instant
            rates = np.fft.rfft(rate)
        memory = past + now * rates
        slip += dt * (old + rate) / 2
    return LineMarch(x, rate, slip, stop - instant * rate)
