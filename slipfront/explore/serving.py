"""The server of the page, which only browsers on this machine can reach."""

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

from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from slipfront.explore.page import Session

HOST = "127.0.0.1"
NAMES = ("localhost", HOST)
"""Host names under which browsers may request the page."""
FILES = {"page.css": "text/css", "page.js": "text/javascript", "help.html": "text/html"}
"""Files of the page and their MIME types."""


def content_policy(port: int) -> str:
    """Return the content security policy: scripts may only be files of this server.

    Bokeh needs nothing else but inline styles, which it puts into its shadow roots.
    """
    sockets = " ".join(f"ws://{name}:{port}" for name in NAMES)
    return (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
        f"img-src 'self' data: blob:; connect-src 'self' {sockets}; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


class _Guarded(OutputTransform):
    """Adds the content security policy to every answer."""

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
    """Refuses requests under a host name that is not one of this server."""

    def prepare(self) -> None:
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("slipfront explore is served to this machine alone, at http://localhost.\n")


class _PageFile(RequestHandler):
    """Serves style and script of the page."""

    def get(self, name: str) -> None:
        self.set_header("Content-Type", f"{FILES[name]}; charset=utf-8")
        self.set_header("Cache-Control", "no-cache")
        self.finish(files("slipfront.explore").joinpath(name).read_text(encoding="utf-8"))


class _LocalTornado(BokehTornado):
    """Answers only requests under a name of this machine, and none from pages of other sites.

    This refuses a foreign page whose own name is made to point to 127.0.0.1 (DNS rebinding).  The
    browser takes such a page to have the same origin as this server, but still sends its name.
    """

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> Any:
        asked = [request.host]
        if "Origin" in request.headers:
            asked.append(request.headers["Origin"].removeprefix("http://"))
        # Bokeh's own check covers only sockets, and in 3.6 took 127.0.0.1.example.org for 127.0.0.1
        hosts = (host.lower() if ":" in host else f"{host.lower()}:80" for host in asked)
        if not all(host in self.websocket_origins for host in hosts):
            return self.get_handler_delegate(request, _Stranger)
        return super().find_handler(request, **kwargs)


def make_server(scene: Scene, port: int) -> BaseServer:
    """Make a server of the page for a scene; port 0 takes any free port.

    A port that is in use or not permitted is refused by a SceneError.
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
        sign_sessions=True,  # only the browser that received the page can open its session
        secret_key=generate_secret_key().encode(),
        unused_session_lifetime_milliseconds=5000,
        check_unused_sessions_milliseconds=3000,
    )
    listening = HTTPServer(application)
    listening.add_sockets(sockets)
    return BaseServer(IOLoop.current(), application, listening)


def serve(scene: Scene, port: int, *, browser: bool, tell: Callable[[str], None]) -> None:
    """Serve the page until it is interrupted, and print its address; a browser may open it."""
    logging.getLogger("bokeh").setLevel(logging.ERROR)
    logging.getLogger("tornado.access").setLevel(logging.ERROR)
    server = make_server(scene, port)
    server.start()
    address = f"http://localhost:{server.port}/"
    tell(address)
    if browser:
        server.io_loop.add_callback(webbrowser.open, address)
    try:
        server.io_loop.start()
    finally:
        server.stop()
