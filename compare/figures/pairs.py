"""Figures of two different bodies: what they say, and the interface of an answer."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from compare.comparison.case import lower_of
from compare.comparison.scales import stress_scale
from compare.figures.style import describe, new_figure, scene_words, styled
from semianalytic import Material, PairSolution, Scene
from semianalytic.results.answer import Answer

DRAWN, SHOWN = 800, 1.5
"""Points of a curve over x/t, and least length of that axis over c_t."""


@styled
def pair_figure(answer: PairSolution) -> Figure:
    """Rates and tractions of two different bodies over x/(c_t t), c_t that of the upper one."""
    figure, pair = describe(new_figure(7, 5), words_of(answer)), answer.pair
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


def words_of(answer: Answer) -> str:
    """Return what a figure of an answer says of its bodies, friction and load."""
    return bodies_words(answer.scene, lower_of(answer))


def bodies_words(scene: Scene, lower: Material | None) -> str:
    """Return what a figure says of a scene, and of its lower body if that is another one."""
    upper = scene.material
    if lower is None or lower == upper:
        return scene_words(scene)
    moduli = lower.shear_modulus / upper.shear_modulus, lower.density / upper.density
    return (
        f"{scene_words(scene)},  lower body: {moduli[0]:.3g} μ, {moduli[1]:.3g} ρ, "
        f"ν = {lower.poisson_ratio:.4g}"
    )
