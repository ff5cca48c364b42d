"""The page: one session of it takes what is asked in the browser and answers with pictures.

Browser and session talk through two hidden text inputs: `asked` holds what the controls say, as
JSON, and `told` what has come of it, numbers of pictures included.
"""

from __future__ import annotations

import base64
import json
import time
from collections.abc import Mapping
from dataclasses import asdict
from importlib.resources import files
from typing import Any

from bokeh.document import Document
from bokeh.models import TextInput
from jinja2 import Template

from compare.explore.controls import (
    CHOICES,
    HISTORIES,
    LAWS,
    defaults,
    query_of,
    scene_of,
    sliders,
    values_from_query,
)
from compare.explore.downloads import FILES, program
from compare.explore.jobs import MarchViews, marched_views, solved_field
from compare.explore.maps import RegimeMap, can_map, map_key, regime_map
from compare.explore.pictures import (
    CURVES,
    SHADES,
    Board,
    FieldPicture,
    InterfacePictures,
    MapPicture,
    SpaceTimePicture,
)
from compare.explore.views import NODES, FieldView, interface_view, space_time_view
from compare.explore.work import Worker
from semianalytic import Marched, Scene, Solution, solve
from semianalytic.prediction import chosen_method
from semianalytic.scene.errors import SlipfrontError
from semianalytic.scene.named import NAMED_SCENES
from semianalytic.scene.units import unit

MOVING_RTOL, RTOL = 1e-4, 1e-8
"""Of answers while a slider moves, and when it stands still."""
MOVING_NODES = 150
"""Along curves while a slider moves; what is not even is at edges and fronts."""
MOVING_POINTS, POINTS = 24, 90
"""Across the picture of the field, likewise."""
LISTEN = 40
"""Between looks at what processes have sent [ms]."""


class Session:
    """One page in one browser.

    Parameters
    ----------
    document : Document
        Of Bokeh, to which the pictures are added.
    start : Scene
        What the page shows at first, unless its address says more; the ranges of sliders.
    query : str
        Of the address, "" or "?friction=...".
    """

    def __init__(self, document: Document, start: Scene, query: str) -> None:
        self._start = start
        self._answer: Solution | Marched | None = None
        self._shown: Scene | None = None
        self._map_key: tuple[object, ...] | None = None
        self._field_worker, self._map_worker, self._march_worker = Worker(), Worker(), Worker()
        self._asked_field: tuple[Scene, int, float] | None = None
        self._board = board = Board()
        self._interface, self._space_time = InterfacePictures(board), SpaceTimePicture(board)
        self._field, self._map = FieldPicture(board), MapPicture(board)
        self._asked = TextInput(name="asked", value="")
        self._told = TextInput(name="told", value="")
        self._asked.on_change("value", lambda _, __, text: self._answer_to(json.loads(text)))
        self._number = 0
        self._document = document
        self._open(query)

    def _open(self, query: str) -> None:
        """Fill the document."""
        values, message = self._read(query)
        document = self._document
        document.title = "slipfront explore"
        roots = (
            self._interface.rate,
            self._interface.tractions,
            self._space_time.panel,
            self._field.panel,
            self._map.panel,
            self._asked,
            self._told,
        )
        for root in roots:
            document.add_root(root)
        parts = files("compare.explore")
        document.template = Template(parts.joinpath("page.html").read_text(encoding="utf-8"))
        document.template_variables.update(
            style=parts.joinpath("page.css").read_text(encoding="utf-8"),
            program=parts.joinpath("page.js").read_text(encoding="utf-8"),
            sliders=[asdict(one) for one in sliders(self._start)],
            choices=CHOICES,
            shown={"law": LAWS, "history": HISTORIES},
            values=values,
            message=message,
            shades=SHADES,
            curves=CURVES,
            scenes=_known_queries(),
        )
        document.add_periodic_callback(self._listen, LISTEN)
        document.on_session_destroyed(lambda _: self._end())

    def _read(self, query: str) -> tuple[dict[str, Any], str]:
        """Values of controls for an address, and what is wrong with it."""
        try:
            return values_from_query(query, self._start), ""
        except SlipfrontError as error:
            return defaults(self._start), f"The address is no scene: {error}"

    def _end(self) -> None:
        for worker in (self._field_worker, self._map_worker, self._march_worker):
            worker.stop()

    def _tell(self, **news: Any) -> None:
        """Send news to the browser, of pictures too; each text differs from the one before."""
        self._number += 1
        news |= {"number": self._number, "models": self._board.news()}
        self._told.value = json.dumps(news, separators=(",", ":"))

    def _answer_to(self, asked: Mapping[str, Any]) -> None:
        """What the browser asks for: an address, a file, or pictures of the controls' scene."""
        if "query" in asked:
            values, message = self._read(asked["query"])
            self._tell(values=values, message=message)
        elif "file" in asked:
            self._send_file(asked["file"])
        else:
            self._show(asked["values"], asked["moving"], asked["since"])

    def _send_file(self, form: str) -> None:
        if self._answer is None:
            self._tell(message="There is no answer yet to take home; wait for it.")
            return
        name, mime, content = FILES[form](self._answer)
        text = base64.b64encode(content).decode()
        self._tell(file={"name": name, "mime": mime, "content": text})

    def _show(self, values: Mapping[str, Any], moving: bool, since: float) -> None:
        """Draw the scene of the controls anew, or say why there is none."""
        self._march_worker.stop()
        self._shown = None
        try:
            scene = scene_of(values)
            self._map.place(scene.friction, scene.material.poisson_ratio)
            exact = chosen_method(scene) == "self-similar"
            if exact:
                self._show_solution(scene, moving, since, query_of(values))
            else:
                self._answer = None
                self._tell(
                    stale=True,
                    query=query_of(values),
                    moving=moving,
                    since=since,
                    status="let go of the slider to march it" if moving else "marching",
                )
                if not moving:
                    self._march_worker.start(marched_views, scene)
            if not moving:
                self._draw_map(scene)
        except SlipfrontError as error:
            self._answer = None
            self._tell(stale=True, message=str(error), since=since)

    def _show_solution(self, scene: Scene, moving: bool, since: float, query: str) -> None:
        began = time.perf_counter()
        solution = solve(scene, rtol=MOVING_RTOL if moving else RTOL)
        solved = time.perf_counter() - began
        space_time = space_time_view(solution)
        view = interface_view(solution, MOVING_NODES if moving else NODES)
        self._interface.draw(view, space_time)
        self._space_time.draw(space_time)
        self._answer, self._shown = solution, scene
        self._tell(
            since=since,
            query=query,
            moving=moving,
            status=solution.status,
            error=f"{solution.error_estimate:.1e}",
            solved=1e3 * solved,
            readings=_readings(solution),
            program=program(scene),
        )
        points, rtol = (MOVING_POINTS, MOVING_RTOL) if moving else (POINTS, RTOL)
        self._asked_field = (scene, points, rtol)
        if not self._field_worker.busy:
            self._next_field()

    def _next_field(self) -> None:
        if self._asked_field is not None:
            self._field_worker.start(solved_field, *self._asked_field)
            self._asked_field = None

    def _draw_map(self, scene: Scene) -> None:
        """Have the map drawn anew where more than friction and Poisson ratio have changed."""
        key = map_key(scene) if can_map(scene) else None
        if key == self._map_key:
            return
        self._map_key = key
        self._map.draw(None)
        if key is None:
            self._map_worker.stop()
            self._tell(regimes=[], map="Maps are drawn where the exact solver takes milliseconds.")
        else:
            self._map_worker.start(regime_map, scene)

    def _listen(self) -> None:
        """Draw what processes have sent."""
        for worker, draw in (
            (self._field_worker, self._field_news),
            (self._map_worker, self._map_news),
            (self._march_worker, self._march_news),
        ):
            news = worker.news()
            if news is not None:
                draw(news.kind, news.content)

    def _field_news(self, kind: str, content: Any) -> None:
        if self._shown is None:  # what is marched, or refused, has no field of the exact solver
            self._asked_field = None
        elif kind == "result" and isinstance(content, FieldView):
            self._field.draw(content)
            self._tell(field=self._asked_field is None)
        self._next_field()

    def _map_news(self, kind: str, content: Any) -> None:
        if kind == "progress":
            self._tell(map=f"mapping, {content[0]} of {content[1]}")
        elif kind == "result" and isinstance(content, RegimeMap):
            self._tell(regimes=self._map.draw(content), map="")
        else:
            self._tell(regimes=[], map=str(content))

    def _march_news(self, kind: str, content: Any) -> None:
        if kind == "progress":
            self._tell(progress=content[0] / content[1])
        elif kind == "result" and isinstance(content, MarchViews):
            self._answer = content.marched
            self._interface.draw(content.interface, content.space_time)
            self._space_time.draw(content.space_time)
            self._field.draw(content.field)
            self._tell(
                progress=1.0,
                status=content.marched.status,
                error=f"{content.marched.error_estimate:.1e}",
                readings=_readings(content.marched),
                program=program(content.marched.scene),
                field=True,
            )
        else:
            self._tell(stale=True, message=str(content), progress=1.0)


def _readings(answer: Solution | Marched) -> list[list[str]]:
    """What else is said of an answer: name, value."""
    scene = answer.scene
    if isinstance(answer, Marched):
        slip = float(answer.max_slip(answer.end_time))
        return [["largest slip", f"{slip:.4g} {unit('length', scene.units)}"]]
    speed = scene.material.shear_speed
    rows = [
        [
            "slip" if zone.sense > 0 else "reverse slip",
            f"{zone.inner / speed:.5g} … {zone.outer / speed:.5g} c_t",
        ]
        for zone in answer.zones
    ]
    rows += [
        ["open", f"{one.inner / speed:.5g} … {one.outer / speed:.5g} c_t"]
        for one in answer.openings
    ]
    return rows or [["interface", "sticks everywhere"]]


def _known_queries() -> dict[str, str]:
    """Addresses of the named scenes that the page can show, by name."""
    known = {}
    for name, one in NAMED_SCENES.items():
        known[name] = query_of(defaults(one.scene))
    return known
