"""The page as it is sent to a browser: its template, its scripts and the scenes that it knows."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from bokeh.resources import Resources
from bokeh.server.views.static_handler import StaticHandler
from jinja2 import Environment, Template

from semianalytic.scene.given.named import NAMED_SCENES
from slipfront.explore.controls import defaults, query_of


@cache
def template() -> Template:
    """Return the template of the page, which escapes all values that are filled in."""
    text = files("slipfront.explore").joinpath("page.html").read_text(encoding="utf-8")
    return Environment(autoescape=True).from_string(text)


def bokeh_scripts() -> list[str]:
    """Return the addresses of Bokeh's scripts that the page runs."""
    resources = Resources(
        mode="server",
        root_url="/",
        components=["bokeh", "bokeh-widgets"],
        path_versioner=StaticHandler.append_version,
    )
    return [str(address) for address in resources.js_files]


@cache
def known_queries() -> dict[str, str]:
    """Return the addresses of the named scenes that the page can show, by name."""
    slots = {
        name: named.scene
        for name, named in NAMED_SCENES.items()
        if named.scene.has_slot and not named.scene.grows
    }
    return {name: query_of(defaults(scene)) for name, scene in slots.items()}
