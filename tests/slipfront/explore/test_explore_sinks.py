"""Nothing that comes from an address, a name or a file runs as a program on a page, and the page of
`slipfront explore` answers nobody but browsers that ask this machine for it."""

from __future__ import annotations

import asyncio
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urlencode

import pytest
from bokeh.document import Document
from catalogue import UNIT_FILE, unit_scene
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import NAMED_SCENES, NamedScene
from slipfront.explore import controls, page
from slipfront.explore.serving import content_policy, make_server
from slipfront.explore.template import known_queries

ROOT = Path(__file__).parents[3]
ATTACK = (
    "\"'--></script><script>document.title='owned'</script><img src=x onerror=alert(1)><!--<script>"
)
START = find_scene("preloaded")


class Pieces(HTMLParser):
    """Tags with their attributes, and texts by the tag they are in."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self._within = [], [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self._within = tag

    def handle_endtag(self, tag):
        self._within = ""

    def handle_data(self, data):
        self.texts.append((self._within, data))


def check_harmless(text):
    """No tag, attribute or program of the attack is in a page; returns its pieces."""
    pieces = Pieces(text)
    for tag, attributes in pieces.tags:
        assert attributes.get("src") != "x"
        assert not any(name.startswith("on") for name in attributes), (tag, attributes)
        assert not str(attributes.get("href", "")).startswith("javascript:")
    return pieces


@pytest.fixture(scope="module")
def ask():
    """A function that asks a running server and returns its response, whatever its code."""
    server = make_server(START, 0)
    server.start()

    def respond(path="/", host=None):
        headers = {} if host is None else {"Host": host.format(port=server.port)}
        request = HTTPRequest(f"http://127.0.0.1:{server.port}{path}", headers=headers)
        client = AsyncHTTPClient(force_instance=True)
        return server.io_loop.run_sync(lambda: client.fetch(request, raise_error=False))

    respond.server = server
    yield respond
    server.stop()


@pytest.fixture(scope="module")
def front(ask):
    """The page itself, whose session takes a second."""
    return ask("/", "localhost:{port}")


def given(body):
    """What the page hands to its program."""
    found = re.search(r'<script id="given" type="application/json">(.*?)</script>', body, re.DOTALL)
    return json.loads(found[1])


@pytest.mark.thinned(8)
@pytest.mark.parametrize(
    "name", ["friction", "viscosity", "law", "mode", "history", "shape", "units", ATTACK]
)
def test_what_stands_in_an_address_is_shown_as_text(name, ask):
    response = ask("/?" + urlencode({name: ATTACK}))
    assert response.code == 200
    body = response.body.decode()
    assert ATTACK not in body
    check_harmless(body)
    message = given(body)["message"]
    assert "The address is no scene" in message
    assert "<" in message  # the attack, which the program of the page writes as text


def test_an_address_asked_for_later_is_a_message_too():
    session = page.Session(Document(), START, "")
    session._answer_to({"query": "?" + urlencode({"friction": ATTACK})})
    assert "friction must be a number" in json.loads(session._told.value)["message"]


@pytest.mark.slow
def test_names_of_scenes_are_shown_as_text(ask, monkeypatch):
    monkeypatch.setitem(NAMED_SCENES, ATTACK, NamedScene(unit_scene(), "of a package"))
    known_queries.cache_clear()
    body = ask().body.decode()
    known_queries.cache_clear()
    assert ATTACK not in body
    assert ("option", ATTACK) in check_harmless(body).texts


@pytest.mark.parametrize(
    "line", ["units = {}", "mode = {}", "shear_history = {{kind = {}}}", "friction = {}", "{} = 1"]
)
def test_texts_of_a_scene_file_reach_no_page(line, tmp_path):
    """Those that a scene may hold are among known words, or it is refused before there is one."""
    rest = UNIT_FILE.partition("\n")[2] if line.startswith("friction") else UNIT_FILE
    text = line.format(json.dumps(ATTACK)) + "\n" + rest
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(SceneError):
        controls.defaults(find_scene(str(tmp_path / "scene.toml")))


@pytest.mark.slow
def test_the_page_holds_no_program_of_its_own(ask):
    """So that its policy can do without any."""
    body = ask().body.decode()
    for tag, attributes in check_harmless(body).tags:
        assert "style" not in attributes
        if tag == "script":
            assert "src" in attributes or attributes["type"] == "application/json"


def test_the_program_of_the_page_writes_text_only():
    program = (ROOT / "slipfront" / "explore" / "page.js").read_text()
    sinks = ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "Function(")
    assert [sink for sink in sinks if sink in program] == []


@pytest.mark.parametrize("path", ["/", "/page.js", "/page.css", "/static/js/bokeh.min.js", "/none"])
def test_every_answer_carries_the_policy(path, ask, front):
    response = front if path == "/" else ask(path)
    assert response.code == (404 if path == "/none" else 200)
    policy = response.headers["Content-Security-Policy"]
    assert policy == content_policy(ask.server.port)
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert rules["script-src"] == "'self'"
    assert rules["frame-ancestors"] == "'none'"
    assert response.headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize(
    "path", ["/", "/?friction=0.5", "/page.js", "/ws", "/static/js/bokeh.min.js"]
)
@pytest.mark.parametrize(
    "host", ["evil.example:{port}", "127.0.0.1.evil.example:{port}", "localhost:1"]
)
def test_other_hosts_are_refused(path, host, ask):
    """The name of an attacker's own page may be made to point to this machine."""
    response = ask(path, host)
    assert response.code == 403
    assert b"this machine alone" in response.body


@pytest.mark.parametrize("host", ["localhost:{port}", "127.0.0.1:{port}", "LOCALHOST:{port}"])
def test_this_machine_is_answered_by_its_names(host, ask, front):
    assert front.code == ask("/page.css", host).code == 200


def test_every_control_has_a_label(front):
    """Whose text the program of the page writes: `test_labels_are_filled`, in Chromium."""
    tags = Pieces(front.body.decode()).tags
    named = {attributes.get("for") for tag, attributes in tags if tag == "label"}
    controls = [tag for tag in enumerate(tags) if tag[1][0] in ("input", "select")]
    assert len(controls) > 20
    for index, (tag, attributes) in controls:
        assert attributes["id"] in named or (tag, tags[index - 1][0]) == ("select", "label")


def connected(server, origin, token):
    """Whether a session can be reached from a page of some origin with some token."""

    async def attempt():
        request = HTTPRequest(
            f"ws://127.0.0.1:{server.port}/ws",
            headers={"Origin": origin, "Host": f"localhost:{server.port}"},
        )
        try:
            socket = await websocket_connect(request, subprotocols=["bokeh", token])
            first = await asyncio.wait_for(socket.read_message(), 20)
        except HTTPClientError:
            return False
        socket.close()
        return first is not None

    return server.io_loop.run_sync(attempt)


def test_a_session_is_for_the_page_it_was_given_to(ask, front):
    """Not for pages of others, nor for whoever makes up a token."""
    server = ask.server
    body = front.body.decode()
    (documents,) = (text for _, text in Pieces(body).texts if text.startswith('[{"'))
    token = json.loads(documents)[0]["token"]
    own = f"http://localhost:{server.port}"
    assert not connected(server, "http://evil.example", token)
    assert not connected(server, f"http://evil.example:{server.port}", token)
    assert not connected(server, f"http://127.0.0.1.evil.example:{server.port}", token)
    assert not connected(server, "null", token)
    assert not connected(server, own, token.partition(".")[0])  # its signature is missing
    assert not connected(server, own, "A" + token[1:])
    assert connected(server, own, token)
