"""``slipfront explore``: a page in the browser whose pictures follow its sliders."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import typer
from rich.console import Console

from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.extras import EXPLORE, PLOT, require
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import DEFAULT_SCENE
from slipfront.cli.options import LOWER_OPTIONS, SCENE_OPTIONS, AsJson, option, with_options
from slipfront.cli.scenes.completion import scene_names
from slipfront.cli.terminal import print_json

_OPTIONS: Mapping[str, Any] = {
    "scene_name": typer.Argument(
        metavar="[SCENE]", help="Name of a scene, or a TOML file.", autocompletion=scene_names
    ),
    "port": option("Port of the page; 0 for any free port."),
    "browser": option("Open the page in a browser.", flag="--browser/--no-browser"),
}


@with_options(_OPTIONS, overrides=SCENE_OPTIONS, lower=LOWER_OPTIONS)
def explore_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    scene_name: str = DEFAULT_SCENE,
    port: int = 5006,
    browser: bool = True,
    as_json: AsJson = False,
) -> None:
    """Explore a scene in the browser, where all pictures follow the sliders; Ctrl-C ends it.

    The page is served to this machine only.  Its address contains the scene.  Its buttons download
    the figure, a table, the scene file and a program that reproduces the answer.  The lower body
    may be another one: that of the file's [lower_material], or with the numbers that are given.
    """
    require("slipfront explore", *EXPLORE, *PLOT)
    scene = override_scene(find_scene(scene_name), **overrides, **lower)
    from slipfront.explore.controls import defaults

    defaults(scene)  # refuses scenes that the controls cannot describe
    from slipfront.explore.serving import serve  # takes seconds, which a refusal does not wait for

    def tell(address: str) -> None:
        if as_json:
            document = {"scene": scene_document(scene), "address": address}
            print_json("explore", document, "serving")
            sys.stdout.flush()
        else:
            words = f"Open {address} (Ctrl-C ends it)"
            Console().print(words, highlight=False, soft_wrap=True)

    serve(scene, port, browser=browser, tell=tell)
