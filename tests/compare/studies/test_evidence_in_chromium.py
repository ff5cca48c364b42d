"""The evidence page in a browser: nothing overflows, and what is pressed is drawn."""

from __future__ import annotations

import re
import time

import pytest

from compare.studies.evidence.figures import FRAMES
from compare.studies.evidence.study import SCENES
from slipfront.cli.commands import main

LARGEST_PAGE = 12e6
"""Bytes of a page that may be sent around."""


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
    browser.open(whole_page.as_uri(), width, scheme)
    browser.value("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    assert browser.value("innerWidth") == width
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.value(OVERFLOWING) == []
    assert browser.value("document.querySelectorAll('.player').length") == len(SCENES)
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
    browser.open(whole_page.as_uri(), width, "light")
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
    browser.open(whole_page.as_uri(), 1280, "light")
    last = FRAMES - 1
    for number in range(len(SCENES)):
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
