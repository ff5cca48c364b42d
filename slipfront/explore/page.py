"""The page: each of its sessions receives requests from the browser and answers with pictures.

Browser and session communicate through two hidden text inputs.  `asked` holds the requests of the
controls, and `told` the answers, including the numbers of pictures; both are JSON.
"""

from __future__ import annotations

import base64
import json
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from bokeh.document import Document
from bokeh.models import TextInput

from semianalytic import Marched, Scene, Tractions, solve
from semianalytic.methods import chosen
from semianalytic.results.answer import method_of
from semianalytic.scene.errors import SlipfrontError
from slipfront.explore import jobs, views
from slipfront.explore.board import Board
from slipfront.explore.controls import (
    CHOICES,
    PARTS,
    defaults,
    query_of,
    scene_of,
    serve_for,
    sliders,
    values_from_query,
)
from slipfront.explore.downloads import FILES, program
from slipfront.explore.jobs import Worker
from slipfront.explore.maps import RegimeMap, can_map, highest_friction, map_key, regime_map
from slipfront.explore.pictures import (
    CURVES,
    SHADES,
    EdgePicture,
    InterfacePictures,
    MapPicture,
    SpaceTimePicture,
)
from slipfront.explore.template import bokeh_scripts, known_queries, template
from slipfront.explore.views import readings, scales

MOVING_RTOL, RTOL = 1e-4, 1e-8
"""Accuracy of answers while a slider moves, and when it stands still."""
MOVING_NODES = 150
"""Nodes along curves while a slider moves; at edges and fronts, more are added."""
MOVING_POINTS, POINTS = 24, 90
"""Points across the picture of the field while a slider moves, and when it stands still."""
NO_FIELD = "If the front of a load moves, only slipfront field draws the bodies after a march."
LISTEN = 40
"""Interval at which messages of other processes are read [ms]."""


class Session:
    """One page in one browser, whose pictures are added to a document of Bokeh.

    It shows a problem at first, which sets the sliders, unless the query of its address, "" or
    "?friction=...", says more.
    """

    def __init__(self, document: Document, start: Scene, query: str) -> None:
        self._start = self._ruled = start
        self._answer: Any = None
        self._shown: Scene | None = None
        self._marching: Scene | None = None
        self._map_key: tuple[object, ...] | None = ()  # the map of no scene yet
        self._map_to = 0.0  # its largest friction
        self._maps: dict[tuple[object, ...], RegimeMap] = {}
        self._moment = jobs.Moment()
        self._field_worker, self._map_worker, self._march_worker = Worker(), Worker(), Worker()
        self._asked_field: tuple[Any, ...] | None = None
        self._board = board = Board()
        self._interface, self._space_time = InterfacePictures(board), SpaceTimePicture(board)
        self._field, self._map = EdgePicture(board), MapPicture(board)
        self._asked = TextInput(name="asked", value="")
        self._told = TextInput(name="told", value="")
        self._asked.on_change("value", lambda _, __, text: self._answer_to(json.loads(text)))
        self._number = 0
        self._document = document
        self._open(query)

    def _open(self, query: str) -> None:
        """Fill the document."""
        document = self._document
        document.title = "slipfront explore"
        interface, others = self._interface, (self._space_time, self._field, self._map)
        panels = (interface.rate, interface.tractions, interface.slip)
        roots = (*panels, *(other.panel for other in others), self._asked, self._told)
        # One search for all models in place of eight, each through all roots so far.
        with document.models.freeze():
            for root in roots:
                document.add_root(root)
        document.template = template()
        document.template_variables.update(
            scripts=bokeh_scripts(),
            sliders=[slider.name for slider in sliders(self._start)],
            choices=CHOICES,
            scenes=known_queries(),
            quantities=(views.SPEED, views.DISPLACEMENT),
            given={
                **self._opened(query),
                "shown": PARTS,
                "kinds": list(SHADES.items()),
                "curves": [(name, f"{dash} {colour}") for name, (colour, dash) in CURVES.items()],
            },
        )
        document.add_periodic_callback(self._listen, LISTEN)
        document.on_session_destroyed(lambda _: self._end())

    def _opened(self, query: str) -> dict[str, Any]:
        """Return the values, sliders and message with which the page of an address opens.

        The sliders of the start scene are kept if they suit the values.
        """
        moment = jobs.Moment()
        try:
            moment, query = jobs.moment_in(query)
            values, message = values_from_query(query, self._start), ""
        except SlipfrontError as error:
            values = defaults(self._start)
            message = f"The address is no scene: {error} The scene of the command is shown instead."
        if not serve_for(self._ruled, values):
            self._ruled = scene_of(values)
        ruled = [asdict(slider) for slider in sliders(self._ruled)]
        shown = {"values": values, "sliders": ruled, "message": message}
        return {**shown, "moment": moment._asdict()}

    def _end(self) -> None:
        for worker in (self._field_worker, self._map_worker, self._march_worker):
            worker.stop()

    def _tell(self, **news: Any) -> None:
        """Send news to the browser, pictures included; each message differs from the one before."""
        self._number += 1
        news |= {"number": self._number, "models": self._board.news()}
        self._told.value = json.dumps(news, separators=(",", ":"))

    def _answer_to(self, asked: Mapping[str, Any]) -> None:
        """Answer a request of the browser: an address, a file, or pictures of the current scene."""
        if "query" in asked:
            self._tell(**self._opened(asked["query"]))
        elif "file" in asked:
            self._send_file(asked["file"])
        else:
            share = min(max(float(asked.get("share", 1.0)), jobs.LEAST_SHARE), 1.0)
            self._moment = jobs.Moment(
                share, views.DISPLACEMENT if asked.get("of") == views.DISPLACEMENT else views.SPEED
            )
            self._show(asked["values"], asked["moving"], asked["since"])

    def _send_file(self, form: str) -> None:
        if self._answer is None:
            self._tell(message="There is no answer to download.")
            return
        name, mime, content = FILES[form](self._answer)
        text = base64.b64encode(content).decode()
        self._tell(file={"name": name, "mime": mime, "content": text})

    def _show(self, values: Mapping[str, Any], moving: bool, since: float) -> None:
        """Draw the scene of the controls, or say why it does not exist."""
        # the address follows the controls where there is no answer as well
        query = query_of(values) + self._moment.query
        told = {"since": since, "query": query, "moving": moving}
        try:
            scene = scene_of(values)
            if method_of(self._answer) == "space-time" and self._answer.scene == scene:
                self._show_march(self._answer, told)
                return
            if self._march_worker.busy and self._marching == scene:
                self._tell(since=since, moving=moving)  # drawn when the march is done
                return
            self._march_worker.stop()
            self._shown = self._marching = None
            self._map.place(scene.coefficient, scene.material.poisson_ratio)
            if chosen(scene).name == "self-similar":
                self._show_solution(scene, told)
            else:
                self._march(scene, told)
            if not moving:
                self._draw_map(scene)
        except SlipfrontError as error:
            self._refuse(str(error), since=since, query=query)
        except Exception as error:
            # after an error in a solver, the previous answer must not stay on the page as if it
            # were the current one; the server logs the traceback
            self._refuse(f"There is no answer ({type(error).__name__}: {error}).", since=since)
            raise

    def _refuse(self, message: str, **news: Any) -> None:
        """Say why there is no answer, and remove everything that belongs to an answer."""
        self._march_worker.stop()
        self._answer = self._shown = None
        self._tell(stale=True, status="no answer", message=message, readings=[], scales=[], **news)

    def _march(self, scene: Scene, told: Mapping[str, Any]) -> None:
        """Start the march of a scene once its slider stands still."""
        self._answer = None
        status = "let go of the slider to march it" if told["moving"] else "marching"
        self._tell(**told, stale=True, status=status, readings=[], scales=scales(scene))
        if not told["moving"]:
            self._marching = scene
            self._march_worker.start(jobs.marched, scene)

    def _show_march(self, marched: Marched, told: Mapping[str, Any]) -> None:
        """Draw another moment of a march that is done; its field comes when the slider stops."""
        self._draw_contact(marched, views.NODES)
        self._tell(**told, status=marched.status, error=f"{marched.error_estimate:.1e}")
        if not told["moving"]:
            self._draw_field(marched)

    def _draw_field(self, marched: Marched) -> bool:
        """Have the field of a march computed; return whether there is one to be known."""
        if known := isinstance(marched.scene.load, Tractions):
            self._march_worker.start(jobs.marched_field, marched, self._moment)
        return known

    def _draw_contact(self, answer: Any, nodes: int) -> None:
        """Draw the pictures of the contact at the present moment."""
        share, space_time = self._moment.share, views.space_time_view(answer)
        self._interface.draw(views.interface_view(answer, nodes, share), space_time, share)
        self._space_time.draw(space_time)
        self._space_time.mark(share)

    def _show_solution(self, scene: Scene, told: Mapping[str, Any]) -> None:
        moving, began = told["moving"], time.perf_counter()
        solution = solve(scene, rtol=MOVING_RTOL if moving else RTOL)
        seconds = time.perf_counter() - began
        self._draw_contact(solution, MOVING_NODES if moving else views.NODES)
        self._answer, self._shown = solution, scene
        self._tell(
            **told,
            status=solution.status,
            error=f"{solution.error_estimate:.1e}",
            solved=1e3 * seconds,
            readings=readings(solution),
            scales=scales(solution.scene),
            program=program(scene),
        )
        points, rtol = (MOVING_POINTS, MOVING_RTOL) if moving else (POINTS, RTOL)
        self._asked_field = (scene, points, rtol, self._moment)
        if not self._field_worker.busy:
            self._next_field()

    def _next_field(self) -> None:
        if self._asked_field is not None:
            self._field_worker.start(jobs.solved_field, *self._asked_field)
            self._asked_field = None

    def _draw_map(self, scene: Scene) -> None:
        """Draw another map if anything but friction and Poisson ratio has changed.

        A map is kept while friction lies on it, and found again when a scene comes back.  Two
        different bodies have none.
        """
        key = map_key(scene) if can_map(scene) else None
        if key == self._map_key and (key is None or scene.coefficient <= self._map_to):
            return
        self._map_key, self._map_to = key, highest_friction(scene)
        known = None if key is None else self._maps.get(key)
        if known is not None and scene.coefficient <= known.friction[1]:
            self._map_worker.stop()
            self._map_to = known.friction[1]
            self._tell(regimes=self._map.draw(known), map="")
            return
        self._map.draw(None)
        if key is None:
            self._map_worker.stop()
            self._tell(regimes=[], map="Maps are drawn where the exact solver takes milliseconds.")
        else:
            self._map_worker.start(regime_map, scene)

    def _listen(self) -> None:
        """Draw what other processes have sent."""
        for worker, draw in (
            (self._field_worker, self._field_news),
            (self._map_worker, self._map_news),
            (self._march_worker, self._march_news),
        ):
            news = worker.news()
            if news is not None:
                draw(news.kind, news.content)

    def _field_news(self, kind: str, content: Any) -> None:
        if self._shown is None:  # a marched or refused scene has no field of the exact solver
            self._asked_field = None
        elif kind == "result" and isinstance(content, views.FieldView):
            self._field.draw(content)
            self._tell(field=self._asked_field is None)
        elif kind == "refusal":
            self._tell(message=f"The field is that of an earlier scene: {content}")
        self._next_field()

    def _map_news(self, kind: str, content: Any) -> None:
        if kind == "progress":
            self._tell(map=f"mapping, {content[0]} of {content[1]}")
        elif kind == "result" and isinstance(content, RegimeMap):
            if self._map_key is not None:
                self._maps[self._map_key] = content
            self._tell(regimes=self._map.draw(content), map="")
        else:
            self._tell(regimes=[], map=str(content))

    def _march_news(self, kind: str, content: Any) -> None:
        if kind == "progress":
            self._tell(progress=content[0] / content[1])
        elif kind == "result" and isinstance(content, Marched):
            self._answer = content
            self._draw_contact(content, views.NODES)
            self._tell(
                progress=1.0,
                status=content.status,
                error=f"{content.error_estimate:.1e}",
                readings=readings(content),
                program=program(content.scene),
                field=False,
                **({} if self._draw_field(content) else {"message": NO_FIELD}),
            )
        elif kind == "result" and isinstance(content, views.FieldView):
            self._field.draw(content)
            self._tell(field=True)
        else:
            self._refuse(str(content), progress=1.0)
