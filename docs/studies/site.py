"""Read the built site in Chromium: nothing comes from elsewhere, formulas are set, search finds.

``python -m docs.studies.site results/site`` serves the folder to this machine, opens some pages and
searches for what slipfront does not do.  It ends with exit code 1 and a list if anything is wrong.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from docs.studies.chromium import CHROMIUM, Browser

PAGES = ("", "theory/", "tutorials/first_scene/", "api/scene/", "not_here/")
WITH_FORMULAS = "theory/"
OUTSIDE = ("3-D", "3D", "plasticity", "layers", "layered", "anisotropy", "viscoelastic")
"""Words whose first hit is the page of what slipfront does not do."""
PAGE = "not_here/"
SECONDS = 30.0
TYPED = """
box = document.querySelector('[data-md-component=search-query]');
box.focus(); box.value = %r; box.dispatchEvent(new Event('keyup')); box.dispatchEvent(
  new Event('input', {bubbles: true}));
"""
FIRST = "(document.querySelector('.md-search-result__link') || {href: ''}).href"


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Say nothing about each file."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Read the site and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("site", type=Path)
    site = parser.parse_args(arguments).site
    if CHROMIUM is None:
        raise SystemExit("There is no Chromium to read the site in; apt install chromium.")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(Path(profile))
        wrong = list(_faults(browser, f"http://127.0.0.1:{server.server_port}/"))
        browser.close()
    server.shutdown()
    print("\n".join(wrong) or f"{len(PAGES)} pages and {len(OUTSIDE)} searches are as they should.")
    return int(bool(wrong))


def _faults(browser: Browser, address: str) -> Iterator[str]:
    for page in PAGES:
        browser.open(address + page, 1280)
        if page == WITH_FORMULAS and not _becomes(browser, "document.querySelector('mjx-math')"):
            yield f"{page}: no formula is set"
        time.sleep(0.5)  # what scripts and style sheets ask for after the page has loaded
        for event in browser.events:
            if event["method"] == "Network.requestWillBeSent":
                asked = event["params"]["request"]["url"]
                if not asked.startswith((address, "data:", "blob:")):
                    yield f"{page}: asks for {asked}"
    for word in OUTSIDE:
        browser.open(address, 1280)
        browser.value(TYPED % word)
        if not _becomes(browser, f"{FIRST}.includes({PAGE!r})"):
            yield f"a search for {word} finds {browser.value(FIRST) or 'nothing'} first"


def _becomes(browser: Browser, expression: str) -> bool:
    """Wait until an expression of JavaScript is true; return whether it became so."""
    limit = time.monotonic() + SECONDS
    while not browser.value(f"Boolean({expression})"):
        if time.monotonic() > limit:
            return False
        time.sleep(0.1)
    return True


if __name__ == "__main__":
    sys.exit(main())
