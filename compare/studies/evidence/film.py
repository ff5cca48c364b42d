"""The whole field of a scene as an animation: frames within the page, moved by a slider."""

from __future__ import annotations

import shlex
from base64 import b64encode
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape

from compare.comparison.prediction import method_of
from compare.figures.fields import FieldPicture
from compare.figures.quantities import find_quantity
from compare.figures.saving import figure_png
from compare.studies.evidence.html import code, data_block, paragraph
from compare.studies.evidence.study import Evidence, SceneEvidence
from semianalytic import Marched, Solution
from semianalytic.results.answer import WholeFields
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import unit

SHOTS = 12
"""Number of frames; they are evenly spaced, the first one step after t = 0."""
POINTS, DPI = 200, 80
QUANTITY, NAME = "max-shear", "largest shear stress in the plane"
WIDE, TALL = 1.9, 1.4
"""Half width and height of the window over c_t T; the P front leaves it, the S front does not."""


@dataclass(frozen=True)
class Film:
    """A scene whose fields are shown, and the answer that supplies them."""

    evidence: SceneEvidence
    fields: WholeFields

    @property
    def scene(self) -> Scene:
        """Scene that is shown."""
        return self.evidence.scene

    @property
    def times(self) -> list[float]:
        """Times of the frames, until T [time]."""
        end = self.evidence.simulation.end_time
        return [end * shot / SHOTS for shot in range(1, SHOTS + 1)]

    @property
    def captions(self) -> list[str]:
        """Time of each frame in words, over T and in the units of the scene."""
        end, name = self.evidence.simulation.end_time, unit("time", self.scene.units)
        return [f"t = {time / end:.3f} T = {time:.4g} [{name}]" for time in self.times]

    def frames(self) -> Iterator[bytes]:
        """Yield the frames as PNG, all in the same window."""
        length = self.scene.material.shear_speed * self.evidence.simulation.end_time
        window = (-WIDE * length, WIDE * length, -TALL * length, TALL * length)
        quantity = find_quantity(QUANTITY, self.scene)
        picture = FieldPicture(self.fields, quantity, window, POINTS, self.times[-1])
        for time in self.times:
            picture.show(time)
            yield figure_png(picture.figure, dpi=DPI)


def films(evidence: Evidence) -> list[Film]:
    """Choose the first scene that is solved, and the first that can only be marched.

    If the evidence is quick, choose only the first of the two.
    """
    chosen: dict[type, Film] = {}
    for scene in evidence.scenes:
        if scene.judgements:
            fields = scene.judgements[0].prediction
            assert isinstance(fields, Solution | Marched)  # `predict_like` makes only these two
            chosen.setdefault(type(fields), Film(scene, fields))
    return list(chosen.values())[: 1 if evidence.quick else None]


def field_section(chosen: Iterable[Film]) -> str:
    """Return the section with the animations, and how they are made."""
    return (
        paragraph(
            "The tractions of the interface determine all that happens in the two bodies. The "
            f"{NAME} is shown through time, which photoelasticity measures; wave "
            "fronts are dashed, what slips is coloured on the interface, the slot is black."
        )
        + "".join(_player(f"field-{number}", film) for number, film in enumerate(chosen, 1))
        + paragraph("The same pictures, animations, grids and records at points are made by")
        + code(
            f"slipfront field {shlex.quote(film.evidence.source)} --of {QUANTITY} --animate {SHOTS}"
            for film in chosen
        )
    )


def _player(anchor: str, film: Film) -> str:
    """Return the last frame over a slider; the script of the page shows the others."""
    method, label = method_of(film.evidence.judgements[0].prediction), film.evidence.label
    words = f"{NAME.capitalize()} in both bodies of {label}, {method}"
    sources = [f"data:image/png;base64,{b64encode(one).decode()}" for one in film.frames()]
    data = {"words": words, "frames": sources, "captions": film.captions}
    last, caption = SHOTS - 1, escape(film.captions[-1])
    return (
        f'<figure class="film"><img src="{sources[-1]}" alt="{escape(words)}, {caption}">'
        f'<div class="time"><label for="{anchor}-time">time</label>'
        f'<input type="range" id="{anchor}-time" min="0" max="{last}" value="{last}" '
        f'aria-valuetext="{caption}"><output for="{anchor}-time">{caption}</output></div>'
        f"{data_block(data)}<figcaption>{escape(words)}.</figcaption>"
        "<noscript><p>The slider needs JavaScript; the last frame is shown.</p></noscript>"
        "</figure>\n"
    )
