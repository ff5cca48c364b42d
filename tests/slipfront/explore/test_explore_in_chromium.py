"""The page of `slipfront explore` in a browser: it follows sliders, address and buttons."""

from __future__ import annotations

import time
from urllib.parse import urlencode

import pytest

from docs.chromium import served_page

pytestmark = pytest.mark.slow

RATE = """
Bokeh.documents[0].get_model_by_name('rate').renderers.map((one) => one.data_source.data.rate)
  .filter(Boolean).flatMap((column) => [...column]).reduce((sum, one) => sum + one, 0)
"""
SPEED = """
Bokeh.documents[0].get_model_by_name('field').renderers.map((one) => one.data_source.data.image)
  .filter((column) => column && column.length).flatMap((column) => [...column[0]])
  .reduce((sum, one) => sum + one, 0)
"""
THERE = "document.getElementById('pictures').dataset.late === 'false'"
TEXT = "document.getElementById('%s').textContent"
WIDER = """
[...document.querySelectorAll('*')].filter((one) =>
  one.getBoundingClientRect().right > innerWidth + 1 && !one.closest('pre')).length
"""


@pytest.fixture(scope="module")
def address():
    """The address of the page of the default scene, as the command serves it."""
    with served_page() as address:
        yield address


def opened(browser, address, width=1280):
    """The browser, once the page at an address is ready."""
    browser.open(address, width)
    _until(browser, "window.slipfrontTimes && slipfrontTimes.length > 0")
    return browser


@pytest.fixture
def page(browser, address):
    return opened(browser, address)


def _until(browser, expression, seconds=60.0):
    """Wait until an expression of JavaScript is true."""
    limit = time.monotonic() + seconds
    while not browser.value(f"Boolean({expression})"):
        assert time.monotonic() < limit, f"{expression} never came"
        time.sleep(0.05)


def _errors(browser, address):
    """Exceptions, errors and warnings of the console, and requests for what is elsewhere."""
    bad = []
    for event in browser.events:
        of = event["params"]
        kind = of.get("type") or of.get("entry", {}).get("level")
        url = of["request"]["url"] if event["method"] == "Network.requestWillBeSent" else address
        elsewhere = not url.startswith((address, "data:", "blob:"))
        thrown = event["method"] == "Runtime.exceptionThrown"
        if thrown or elsewhere or kind in ("error", "warning"):
            bad.append(of)
    return bad


@pytest.mark.parametrize("width", [1280, 400])
def test_it_loads_without_errors_and_fits(browser, address, width):
    opened(browser, address, width)
    _until(browser, THERE)
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.value(WIDER) == 0
    assert "converged" in browser.value(TEXT % "status")
    assert "sf.Scene" in browser.value(TEXT % "program")
    assert _errors(browser, address) == []


def test_labels_are_filled(page):
    assert page.value(
        "[...document.querySelectorAll('form input, form select')]"
        ".every((one) => one.labels.length && one.labels[0].textContent.trim())"
    )


ATTACKS = (
    "<script>document.title='owned'</script>",
    "\"'--></script><img src=x onerror=\"document.title='owned'\">",
)
INJECTED = """
one = document.createElement('div');
one.innerHTML = '<img src="x:" onerror="document.title = 1">';
two = document.createElement('script');
two.textContent = 'document.title = 2';
document.body.append(one, two);
"""


def test_no_program_from_an_address_runs(browser, address):
    """What is in the address is shown as it stands; and were something to get into the page, the
    policy would not let it run."""
    for name in ("friction", "law", "nonsense"):
        for attack in ATTACKS:
            opened(browser, f"{address}?" + urlencode({name: attack}))
            assert "The address is no scene" in browser.value(TEXT % "message")
            assert "<" in browser.value(TEXT % "message") or name == "nonsense"
            assert browser.value("document.title") == "slipfront explore"
            assert browser.value("document.querySelectorAll('img[src=x]').length") == 0
            assert _errors(browser, address) == []
    browser.value(INJECTED)
    _until(browser, "one.firstChild.complete")
    assert browser.value("document.title") == "slipfront explore"
    refused = [item for item in _errors(browser, address) if "Content Security Policy" in str(item)]
    assert len(refused) >= 2


def test_a_link_in_si_has_its_units_and_ranges_on_a_page_without_units(browser, address):
    steel = {"shear_modulus": 80e9, "density": 7800.0, "poisson_ratio": 0.29, "friction": 0.25}
    loads = {"base_pressure": 5e6, "base_shear": 0, "load_pressure": 0, "load_shear": 5e6}
    opened(browser, f"{address}?" + urlencode({**steel, **loads, "units": "SI"}))
    label = "document.getElementById('%s').labels[0].textContent"
    assert browser.value(label % "base_pressure") == "base pressure [Pa]"
    assert browser.value(label % "viscosity") == "viscosity [Pa s/m]"
    assert browser.value("document.getElementById('load_shear').max") == "10000000"
    scales = browser.value(TEXT % "scales")
    for scale in ("c_t T1 m", "T0.0003122 s", "τ₀5e+06 Pa", "V₀0.4003 m/s"):
        assert scale in scales
    browser.value(
        "named = document.getElementById('scenes');"
        "named.value = [...named.options].find((one) => one.text == 'tap').value;"
        "named.dispatchEvent(new Event('change'))"
    )
    _until(browser, "document.getElementById('base_pressure').value == '0.02'")
    assert browser.value(label % "base_pressure") == "base pressure [stress]"
    assert _errors(browser, address) == []


def test_a_slider_moved_by_keys_changes_the_pictures_and_the_address(page):
    _until(page, THERE)
    before, speed, address = (page.value(script) for script in (RATE, SPEED, "location.search"))
    steps = page.value("history.length")
    page.value("document.getElementById('friction').focus()")
    for _ in range(5):
        page.press("ArrowRight", 39)
    _until(page, "location.search.includes('friction=0.35')")
    _until(page, THERE)
    assert page.value(RATE) < 0.99 * before
    assert page.value(SPEED) != speed
    assert page.value("location.search") != address
    steps = page.value("history.length") - steps  # one, or more where keys come slowly
    assert steps > 0
    page.value(f"history.go(-{steps})")
    _until(page, "document.getElementById('friction').value == '0.3'")
    _until(page, f"({RATE.strip()}) === {before!r}")
    page.value(f"history.go({steps})")
    _until(page, "document.getElementById('friction').value == '0.35'")


def test_a_law_shows_its_own_controls_and_is_marched_with_a_bar(page):
    hidden = "document.querySelector('[data-name=distance]').hasAttribute('data-hidden')"
    assert page.value(hidden)
    page.value(
        "law = document.getElementById('law'); law.value = 'slip-weakening';"
        "law.dispatchEvent(new Event('input', {bubbles: true}))"
    )
    _until(page, "document.getElementById('status').textContent.startsWith('marching')")
    assert not page.value(hidden)
    _until(page, "!document.getElementById('progress').hidden", 90)
    _until(page, "document.getElementById('status').textContent.includes('error estimate')", 90)
    assert "sf.solve(scene, end_time=" in page.value(TEXT % "program")


def test_what_is_refused_is_said_and_the_last_picture_greyed(page):
    page.value(
        "one = document.getElementById('base_shear'); one.value = -0.9;"
        "one.dispatchEvent(new Event('input', {bubbles: true}))"
    )
    _until(page, "document.getElementById('message').textContent.includes('already slide')")
    assert page.value("document.getElementById('pictures').classList.contains('stale')")
    assert page.value(TEXT % "status") == "no answer"
    assert page.value(TEXT % "readings") == page.value(TEXT % "scales") == ""
    assert page.value("document.getElementById('measures').hidden")
    page.value("one.value = 0; one.dispatchEvent(new Event('input', {bubbles: true}))")
    _until(page, "!document.getElementById('pictures').classList.contains('stale')")
    assert page.value(TEXT % "message") == ""
    assert page.value(TEXT % "status").startswith("converged")
    assert "c_t" in page.value(TEXT % "readings")


CONTROLS = """
box = document.getElementById('friction-value');
box.value = '2.5'; box.dispatchEvent(new Event('input', {bubbles: true}));
"""
MOMENT = """
time = document.getElementById('share');
time.value = 0.5; time.dispatchEvent(new Event('input', {bubbles: true}));
"""
SHOWN = "document.getElementById('scenes').selectedOptions[0].text"


def test_a_box_takes_what_no_slider_reaches_and_the_menu_names_the_scene(page):
    _until(page, f"{SHOWN} === 'preloaded'")
    page.value(CONTROLS)
    _until(page, "location.search.includes('friction=2.5')")
    assert page.value("document.getElementById('friction').value") == "2"
    assert page.value(SHOWN) == "named scenes …"
    assert "friction=2.5" in page.value(TEXT % "program")
    before = page.value(RATE)
    page.value(MOMENT)
    _until(page, f"({RATE.strip()}) !== {before!r}")
    assert page.value("document.getElementById('share-value').value") == "0.5"
    _until(page, "location.search.endsWith('&time=0.5')")
    page.value("history.back()")
    _until(page, "document.getElementById('share').value === '1'")
    page.value("history.forward()")
    _until(page, "document.getElementById('share').value === '0.5'")
    page.value("document.getElementById('link').click()")
    _until(page, f"({TEXT % 'copied'}).includes('copied')")
    assert page.value("document.querySelector('a[href=\"help.html\"]').textContent") == "Help"


def test_buttons_bring_files(page):
    page.value(
        "names = []; HTMLAnchorElement.prototype.click = function () { names.push(this.download); }"
    )
    for form, name in (("csv", "slipfront.csv"), ("toml", "scene.toml"), ("svg", "slipfront.svg")):
        page.value(f"document.querySelector('[data-file={form}]').click()")
        _until(page, f"names.includes('{name}')")
