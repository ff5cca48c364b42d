"""The server of the page, for browsers on this machine alone."""

from __future__ import annotations

import errno
import logging
import socket
import webbrowser
from collections.abc import Callable

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import Server

from compare.explore.page import Session
from semianalytic import Scene
from semianalytic.scene.errors import SceneError

HOST = "127.0.0.1"


def make_server(scene: Scene, port: int) -> Server:
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
        port = port or _free_port()
        server = Server(
            {"/": Application(FunctionHandler(open_page))},
            address=HOST,
            port=port,
            allow_websocket_origin=[f"{name}:{port}" for name in ("localhost", HOST)],
            unused_session_lifetime_milliseconds=5000,
            check_unused_sessions_milliseconds=3000,
            quiet=True,
        )
    except OSError as error:
        taken = error.errno == errno.EADDRINUSE
        reason = "is in use" if taken else f"cannot be used ({error.strerror})"
        raise SceneError(
            f"port {port} {reason}; give another with --port, or 0 for any."
        ) from error
    return server


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


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
    address = f"http://localhost:{server.port}/"
    tell(address)
    if browser:
        server.io_loop.add_callback(webbrowser.open, address)
    try:
        server.io_loop.start()
    finally:
        server.stop()
