"""``slipfront explore``: a page in the browser that follows its sliders."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer
from rich.console import Console

from compare.cli.options import SCENE_OPTIONS, with_options
from semianalytic.scene.extras import EXPLORE, PLOT, require
from semianalytic.scene.named import DEFAULT_SCENE, find_scene, override_scene


@with_options(overrides=SCENE_OPTIONS)
def explore_command(
    overrides: Mapping[str, Any],
    scene_name: Annotated[
        str, typer.Argument(metavar="[SCENE]", help="Name of a scene, or a TOML file.")
    ] = DEFAULT_SCENE,
    port: Annotated[int, typer.Option(help="Port of the page; 0 for any that is free.")] = 5006,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
) -> None:
    """Explore a scene in the browser: all pictures follow the sliders; Ctrl-C ends it.

    The page is served to this machine alone.  Its address holds the scene, its buttons bring
    figure, table, scene file and the program that makes the same.
    """
    require("slipfront explore", *EXPLORE, *PLOT)
    from compare.explore.controls import defaults
    from compare.explore.serving import serve

    scene = override_scene(find_scene(scene_name), **overrides)
    defaults(scene)  # refuses what has no controls
    console = Console()

    def tell(address: str) -> None:
        console.print(f"Open {address} (Ctrl-C ends it)", highlight=False, soft_wrap=True)

    serve(scene, port, browser=browser, tell=tell)
