"""What figures say of two different bodies."""

from __future__ import annotations

from compare.comparison.case import lower_of
from compare.figures.style import scene_words
from semianalytic import Material, Scene
from semianalytic.results.answer import Answer


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
