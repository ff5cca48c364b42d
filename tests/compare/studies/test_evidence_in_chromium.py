"""The evidence page in a browser: nothing overflows, and what is pressed is drawn."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from compare.cli.commands import main
from compare.studies.evidence.figures import FRAMES
from semianalytic.scene.named import NAMED_SCENES

LARGEST_PAGE = 12e6
"""Bytes of a page that may be sent around."""
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)


class Browser:
    """Headless Chromium, spoken to by its DevTools protocol over two pipes."""

    def __init__(self, profile: Path) -> None:
        to_child, self._out = os.pipe()
        self._in, from_child = os.pipe()
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        shell = f'exec "$@" 3<&{to_child} 4>&{from_child}'
        self._process = subprocess.Popen(
            ["bash", "-c", shell, "bash", CHROMIUM, *options, f"--user-data-dir={profile}"],
            pass_fds=(to_child, from_child),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_child)
        os.close(from_child)
        os.set_blocking(self._in, False)
        self._number, self._rest, self._session = 0, b"", None
        self.events: list[dict] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: object) -> dict:
        """Send a command and return its result; events that come meanwhile are kept."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def wait(self, event: str) -> None:
        while not any(known["method"] == event for known in self.events):
            self._receive()

    def _receive(self, seconds: float = 90.0) -> dict:
        limit = time.monotonic() + seconds
        while b"\0" not in self._rest:
            assert time.monotonic() < limit, "Chromium does not answer"
            try:
                self._rest += os.read(self._in, 1 << 20)
            except BlockingIOError:
                time.sleep(0.01)
        message, self._rest = self._rest.split(b"\0", 1)
        answer = json.loads(message)
        if "method" in answer:
            self.events.append(answer)
        return answer

    def open(self, path: Path, width: int, scheme: str) -> None:
        """Load a file in a window of some width and colour scheme, with an empty log."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=900,
            deviceScaleFactor=1,
            mobile=width < 600,
        )
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.call("Emulation.setEmulatedMedia", features=features)
        self.events.clear()
        self.call("Page.navigate", url=path.as_uri())
        self.wait("Page.loadEventFired")

    def value(self, expression: str) -> object:
        """What an expression of JavaScript comes to."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def press(self, key: str, code: int) -> None:
        for kind in ("rawKeyDown", "keyUp"):
            self.call(
                "Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code
            )

    def complaints(self) -> list[dict]:
        """Exceptions, console messages, log entries, and requests for anything else."""
        kinds = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
        found = [event for event in self.events if event["method"] in kinds]
        for event in self.events:
            if event["method"] == "Network.requestWillBeSent":
                address = event["params"]["request"]["url"]
                if not address.startswith(("file:", "data:")):
                    found.append(event)
        return found

    def close(self) -> None:
        os.close(self._out)
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._in)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if CHROMIUM is None:
        pytest.skip("no chromium: apt install chromium")
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def whole_page(tmp_path_factory):
    """The default page, by the command."""
    path = tmp_path_factory.mktemp("evidence") / "evidence.html"
    assert main(["evidence", "--quiet", "--output", str(path)]) == 0
    return path


POINTS = "[...document.querySelectorAll('.player polyline')].map(p => p.getAttribute('points'))"
OVERFLOWING = """
[...document.querySelectorAll('body *')].filter(e => !e.closest('.scroll table, svg, .wide')
  && e.getBoundingClientRect().right > innerWidth + 1).map(e => e.outerHTML.slice(0, 80))
"""


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 400])
def test_chromium_opens_the_page_and_nothing_overflows(browser, whole_page, width, scheme):
    browser.open(whole_page, width, scheme)
    browser.value("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    assert browser.value("innerWidth") == width
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.value(OVERFLOWING) == []
    assert browser.value("document.querySelectorAll('.player').length") == len(NAMED_SCENES)
    assert browser.value(
        "[...document.images].every(image => image.complete && image.naturalWidth > 0)"
    )
    assert browser.complaints() == []


@pytest.mark.slow
def test_page_is_under_twelve_megabytes(whole_page):
    assert whole_page.stat().st_size < LARGEST_PAGE


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
def test_keys_move_the_film(browser, whole_page, width):
    """Each film: the picture, its words and the time beside the slider."""
    browser.open(whole_page, width, "light")
    assert browser.value("document.querySelectorAll('.film').length") == 2
    for number in range(2):
        part = f"document.querySelectorAll('.film')[{number}].querySelector"
        browser.value(f"{part}('input').focus()")
        shown = []
        for key, code in (("End", 35), ("ArrowLeft", 37), ("Home", 36)):
            browser.press(key, code)
            time.sleep(0.2)  # for the picture to be read
            assert browser.value(f"{part}('img').complete && {part}('img').naturalWidth > 0")
            caption = browser.value(f"{part}('output').textContent")
            assert re.fullmatch(r"t = \d\.\d{3} T = [\d.]+ \[time\]", caption)
            assert browser.value(f"{part}('input').getAttribute('aria-valuetext')") == caption
            assert browser.value(f"{part}('img').alt").endswith(caption)
            shown.append((caption, browser.value(f"{part}('img').src")))
        assert len({caption for caption, _ in shown}) == 3
        assert len({source for _, source in shown}) == 3
    assert browser.complaints() == []


@pytest.mark.slow
def test_sliders_and_boxes_redraw_the_profiles(browser, whole_page):
    """By real key strokes, one scene after the other."""
    browser.open(whole_page, 1280, "light")
    last = FRAMES - 1
    for number in range(len(NAMED_SCENES)):
        before = browser.value(POINTS)
        assert not any("NaN" in points for points in before)
        slider = f"document.querySelectorAll('.player input[type=range]')[{number}]"
        browser.value(f"{slider}.focus()")
        for _ in range(3):
            browser.press("ArrowLeft", 37)
        assert browser.value(f"{slider}.value") == str(last - 3)
        output = browser.value(f"{slider}.parentElement.querySelector('output').textContent")
        assert output == browser.value(f"{slider}.getAttribute('aria-valuetext')")
        assert re.fullmatch(r"t = 0\.9\d\d T", output)
        assert browser.value(POINTS) != before
        browser.press("Home", 36)
        assert browser.value(f"{slider}.value") == "0"
        browser.value(f"{slider}.closest('.player').querySelector('[type=checkbox]').focus()")
        drawn = len(browser.value(POINTS))
        browser.press(" ", 32)
        assert len(browser.value(POINTS)) == drawn - 4
    assert browser.complaints() == []
