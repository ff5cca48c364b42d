"""Write what `slipfront explore` looks like, in Chromium: seven scenes at three widths.

``python -m docs.studies.explore_pictures [SCENE...]`` writes docs/figures/explore/SCENE-WIDTH.png,
whole pages of few colours, and ends with exit code 1 if one is wider than its window, has a large
hole or is not finished.
"""

from __future__ import annotations

import argparse
import base64
import io
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from semianalytic.scene.given.finding import find_scene
from slipfront.explore.chromium import CHROMIUM, Browser, served_page
from slipfront.explore.controls import defaults, query_of

FOLDER = Path(__file__).parents[1] / "figures" / "explore"
SCENES = ("preloaded", "remote-shock", "auxetic", "viscous", "antiplane", "lift-off-shear", "tap")
WIDTHS = (390, 1280, 1920)
COLOURS, KEPT = 256, 64
"""Colours of a picture, the most that PNG allows, and how many are the commonest of the page: no
pixel is off by more than 23 of 255 then; with none kept, white areas are tinted."""
READY = """
Boolean(window.slipfrontTimes && slipfrontTimes.length
  && document.getElementById('pictures').dataset.late === 'false'
  && (document.querySelectorAll('#regimes span').length
    || /^Maps are/.test(document.getElementById('map-words').textContent)))
"""
"""Whether pictures and field are those of the scene, and its map is drawn or said not to be."""
RESIZED = """
window.frames_after = 0;
if (!window.counts_frames)
  (function next() {
    window.frames_after += 1;
    window.counts_frames = requestAnimationFrame(next);
  })();
"""
SETTLED = "window.frames_after > 20 && Bokeh.documents.every((one) => one.is_idle)"
"""Whether the pictures have followed the width of the window: some frames on, nothing is drawn."""
LONGEST = 600.0
"""Time after which a page that is not finished is given up [s]; an idle machine needs five."""
HOLE = 0.12
"""Largest share of the area of the pictures that may be empty: a row of a shorter picture."""
EMPTY = """
(() => {
  const all = document.getElementById('pictures').getBoundingClientRect();
  const one = [...document.querySelectorAll('#pictures > section')]
    .map((part) => part.getBoundingClientRect());
  const filled = one.reduce((sum, part) => sum + part.width * part.height, 0);
  return all.width ? 1 - filled / (all.width * all.height) : 0;
})()
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the pictures and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=FOLDER, metavar="FOLDER")
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    given = parser.parse_args(arguments)
    folder, scenes = given.output, given.scenes
    if CHROMIUM is None:
        raise SystemExit("There is no Chromium to look at the page in; apt install chromium.")
    folder.mkdir(parents=True, exist_ok=True)
    wrong = []
    with tempfile.TemporaryDirectory() as profile, served_page() as address:
        browser = Browser(Path(profile))
        for name in scenes:
            browser.open(address + query_of(defaults(find_scene(name))), 1280)
            if not _wait(browser, READY):
                wrong.append(f"{name}: not finished after {LONGEST:g} s")
            for width in WIDTHS:
                browser.resize(width)
                browser.value(RESIZED)
                if not _wait(browser, SETTLED):
                    wrong.append(f"{name} at {width}: not drawn after {LONGEST:g} s")
                (folder / f"{name}-{width}.png").write_bytes(_picture(browser))
                if browser.value("document.documentElement.scrollWidth") > width:
                    wrong.append(f"{name} at {width}: wider than the window")
                if (hole := browser.value(EMPTY)) > HOLE:
                    wrong.append(f"{name} at {width}: {hole:.0%} of the pictures is empty")
        browser.close()
    print("\n".join(wrong) or f"{len(scenes) * len(WIDTHS)} pictures in {folder}")
    return int(bool(wrong))


def _wait(browser: Browser, condition: str) -> bool:
    """Wait until a condition holds on the page, and return whether it came to that."""
    limit = time.monotonic() + LONGEST
    while not (holds := browser.value(condition)) and time.monotonic() < limit:
        time.sleep(0.2)
    return bool(holds)


def _picture(browser: Browser) -> bytes:
    """Return the whole page as PNG of few colours: the commonest as they are, others that cover."""
    taken = browser.call("Page.captureScreenshot", captureBeyondViewport=True)
    image = Image.open(io.BytesIO(base64.b64decode(taken["data"]))).convert("RGB")
    colours, counts = np.unique(np.asarray(image).reshape(-1, 3), axis=0, return_counts=True)
    common = colours[np.argsort(-counts)[:KEPT]].ravel().tolist()
    cover = image.quantize(COLOURS - KEPT, Image.Quantize.MAXCOVERAGE).getpalette() or []
    palette, packed = Image.new("P", (1, 1)), io.BytesIO()
    palette.putpalette([*common, *cover][: 3 * COLOURS])
    few = image.quantize(palette=palette, dither=Image.Dither.NONE)
    few.save(packed, "PNG", optimize=True)
    return packed.getvalue()


if __name__ == "__main__":
    sys.exit(main())
