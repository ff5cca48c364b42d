"""Measure the time from a move of a slider to its picture in `slipfront explore`, in Chromium.

``python -m docs.studies.latency --csv docs/data`` moves the friction slider of some scenes step
by step.  It writes explore-latency.csv there, and pictures of the page to docs/figures.
"""

from __future__ import annotations

import argparse
import base64
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from semianalytic.scene.given.finding import find_scene
from slipfront.explore.chromium import CHROMIUM, Browser, served_page
from slipfront.explore.controls import defaults, query_of

DOCS = Path(__file__).parents[2] / "docs"
SCENES = ("preloaded", "remote-shock", "auxetic", "viscous", "antiplane", "lift-off-shear", "tap")
MOVES = 40
STOLEN = 7
"""Index of the time taken by other guests of the same host in the first line of /proc/stat."""
MOVE = """
slider = document.getElementById('friction');
slider.value = +slider.value + (%d %% 2 ? 1 : 3) * slider.step;
slider.dispatchEvent(new Event('input', {bubbles: true}));
"""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure the latencies, and write table and picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv", type=Path, required=True, metavar="FOLDER")
    folder = parser.parse_args(arguments).csv
    if CHROMIUM is None:
        raise SystemExit("There is no Chromium to measure in; apt install chromium.")
    folder.mkdir(parents=True, exist_ok=True)  # before minutes of measurements, not after them
    rows = [
        "# python -m docs.studies.latency --csv docs/data",
        "scene,moves,median_ms,most_ms,stolen_percent",
    ]
    with tempfile.TemporaryDirectory() as profile, served_page() as address:
        browser = Browser(Path(profile))
        for name in SCENES:
            _open(browser, address, name)
            seen, before = int(browser.value("slipfrontTimes.length")), _processor()
            for move in range(MOVES):
                browser.value(MOVE % move)
                _wait(browser, seen + move + 1)
            times = np.array(browser.value(f"slipfrontTimes.slice({seen}, {seen + MOVES})"))
            spent = _processor() - before
            stolen = 100 * spent[STOLEN] / spent.sum()
            rows.append(f"{name},{MOVES},{np.median(times):.0f},{times.max():.0f},{stolen:.0f}")
            print(rows[-1])
        _open(browser, address, SCENES[0])
        picture = browser.call("Page.captureScreenshot", captureBeyondViewport=True)
        (DOCS / "figures" / "explore.png").write_bytes(base64.b64decode(picture["data"]))
        browser.close()
    (folder / "explore-latency.csv").write_text("\n".join(rows) + "\n")


def _processor() -> np.ndarray:
    """Return the times that the processor has spent so far, by kind, as Linux counts them."""
    first = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0]
    return np.array([int(one) for one in first.split()[1:9]])


def _wait(browser: Browser, count: int) -> None:
    while browser.value("window.slipfrontTimes ? slipfrontTimes.length : 0") < count:
        time.sleep(0.005)


def _open(browser: Browser, address: str, name: str) -> None:
    """Show a scene, and wait for its field and map."""
    browser.open(address + query_of(defaults(find_scene(name))), 1280)
    _wait(browser, 1)
    late = "document.getElementById('pictures').dataset.late !== 'false'"
    there = "document.querySelectorAll('#regimes span').length"
    while browser.value(late) or not browser.value(there):
        time.sleep(0.2)
    time.sleep(1.0)


if __name__ == "__main__":
    main()
