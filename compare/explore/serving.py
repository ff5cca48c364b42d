"""The server of the page, for browsers on this machine alone."""

from __future__ import annotations

import errno
import logging
import webbrowser
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import bind_sockets
from bokeh.util.token import generate_secret_key
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

from compare.explore.page import Session
from semianalytic import Scene
from semianalytic.scene.errors import SceneError

HOST = "127.0.0.1"
NAMES = ("localhost", HOST)
"""By which browsers may ask for the page."""
FILES = {"page.css": "text/css", "page.js": "text/javascript"}
"""Files of the page, and what they are."""


def content_policy(port: int) -> str:
    """What browsers let the page do: run no program that is not a file of this server.

    Bokeh needs no more than that and inline styles, which it puts into its shadow roots.
    """
    sockets = " ".join(f"ws://{name}:{port}" for name in NAMES)
    return (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
        f"img-src 'self' data: blob:; connect-src 'self' {sockets}; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


class _Guarded(OutputTransform):
    """Puts on every answer what browsers have to keep to."""

    def __init__(self, policy: str, request: HTTPServerRequest) -> None:
        self._policy = policy

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        headers["Content-Security-Policy"] = self._policy
        headers["Cross-Origin-Resource-Policy"] = "same-origin"
        headers["Referrer-Policy"] = "no-referrer"
        headers["X-Content-Type-Options"] = "nosniff"
        return status_code, headers, chunk


class _Stranger(RequestHandler):
    """Refuses what was asked of a host that this server is not."""

    def prepare(self) -> None:
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("slipfront explore is served to this machine alone, at http://localhost.\n")


class _PageFile(RequestHandler):
    """Style and program of the page."""

    def get(self, name: str) -> None:
        self.set_header("Content-Type", f"{FILES[name]}; charset=utf-8")
        self.set_header("Cache-Control", "no-cache")
        self.finish(files("compare.explore").joinpath(name).read_text(encoding="utf-8"))


class _LocalTornado(BokehTornado):
    """Answers only if asked by a name of this machine, and not from pages of others.

    A page from elsewhere whose own name is made to point to 127.0.0.1 is refused: the browser
    takes it to be of the same origin as this server, but still says by which name it asks.
    """

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> Any:
        asked = [request.host]
        if "Origin" in request.headers:
            asked.append(request.headers["Origin"].removeprefix("http://"))
        if not all(self._is_own(host.lower()) for host in asked):
            return self.get_handler_delegate(request, _Stranger)
        return super().find_handler(request, **kwargs)

    def _is_own(self, host: str) -> bool:
        """Whether a host is this server, letter for letter: Bokeh's own comparison, of sockets
        alone, has taken 127.0.0.1.example.org to be 127.0.0.1 (in 3.6)."""
        return (host if ":" in host else f"{host}:80") in self.websocket_origins


def make_server(scene: Scene, port: int) -> BaseServer:
    """A server of the page for a scene; port 0 takes any that is free.

    Raises
    ------
    SceneError
        If the port is taken, or may not be used.
    """

    def open_page(document: Document) -> None:
        context = document.session_context
        query = context.request.query if context is not None else ""
        Session(document, scene, query)

    if not 0 <= port < 65536:
        raise SceneError(f"port must lie between 0 and 65535, got {port}.")
    try:
        sockets, port = bind_sockets(HOST, port)
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        reason = "is in use" if taken else f"cannot be used ({error.strerror})"
        raise SceneError(
            f"port {port} {reason}; give another with --port, or 0 for any."
        ) from error
    application = _LocalTornado(
        {"/": Application(FunctionHandler(open_page))},
        extra_websocket_origins=[f"{name}:{port}" for name in NAMES],
        extra_patterns=[(rf"/({'|'.join(FILES)})", _PageFile)],
        transforms=[partial(_Guarded, content_policy(port))],
        sign_sessions=True,  # a session is for whoever was given its page
        secret_key=generate_secret_key().encode(),
        unused_session_lifetime_milliseconds=5000,
        check_unused_sessions_milliseconds=3000,
    )
    listening = HTTPServer(application)
    listening.add_sockets(sockets)
    return BaseServer(IOLoop.current(), application, listening)


def address_of(server: BaseServer) -> str:
    """Where browsers find the page."""
    return f"http://localhost:{server.port}/"


def serve(scene: Scene, port: int, *, browser: bool, tell: Callable[[str], None]) -> None:
    """Serve the page until interrupted.

    Parameters
    ----------
    scene : Scene
    port : int
    browser : bool
        Whether to open one.
    tell : callable
        Gets the address.
    """
    logging.getLogger("bokeh").setLevel(logging.ERROR)
    logging.getLogger("tornado.access").setLevel(logging.ERROR)
    server = make_server(scene, port)
    server.start()
    address = address_of(server)
    tell(address)
    if browser:
        server.io_loop.add_callback(webbrowser.open, address)
    try:
        server.io_loop.start()
    finally:
        server.stop()
