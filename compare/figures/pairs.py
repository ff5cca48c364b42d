"""Figures of two different bodies: what they say, and the interface of an answer."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from compare.comparison.scales import stress_scale
from compare.figures.style import describe, new_figure, scene_words, styled
from semianalytic import Pair, PairSolution

DRAWN, SHOWN = 800, 1.5
"""Points of a curve over x/t, and least length of that axis over c_t."""


@styled
def pair_figure(answer: PairSolution) -> Figure:
    """Rates and tractions of two different bodies over x/(c_t t), c_t that of the upper one."""
    figure, pair = describe(new_figure(7, 5), pair_words(answer.pair)), answer.pair
    above, below = figure.subplots(2, 1, sharex=True)
    speed, load = pair.upper.shear_speed, stress_scale(pair.alike)
    x = np.linspace(0.0, 1.0, DRAWN + 1)[1:] * max(pair.upper.longitudinal_speed, SHOWN * speed)
    rate = load / pair.upper.shear_impedance
    above.plot(x / speed, answer.slip_rate(x, 1.0) / rate, label="slip rate")
    above.plot(x / speed, answer.gap_rate(x, 1.0) / rate, "--", label="rate of opening")
    above.set_ylabel(r"rate $/\ (\tau_0/\rho c_t)$")
    below.plot(x / speed, answer.shear_traction(x, 1.0) / load, label="shear traction")
    below.plot(
        x / speed, pair.friction * answer.pressure(x, 1.0) / load, "--", label="f × pressure"
    )
    below.set(ylabel=r"traction $/\ \tau_0$", xlabel=r"$x/(c_t t)$")
    for panel in (above, below):
        panel.legend()
    return figure


def pair_words(pair: Pair) -> str:
    """Return what the figure says of two bodies, friction and tractions."""
    upper, lower = pair.upper, pair.lower
    moduli = lower.shear_modulus / upper.shear_modulus, lower.density / upper.density
    return (
        f"{scene_words(pair.alike)},  lower body: {moduli[0]:.3g} μ, {moduli[1]:.3g} ρ, "
        f"ν = {lower.poisson_ratio:.3g}"
    )
