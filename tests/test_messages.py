"""Messages of the packages: none unless asked, by a level on the command line or in a program."""

import logging
import re
from importlib import import_module

import packages
import pytest

import slipfront as sf
from fem import with_companions

PACKAGES = ("slipfront", "semianalytic", "fem", "meshes", "compare")
COLOURED = re.compile("\x1b\\[[0-9;]*3[0-9]")
"""A sequence that changes a colour; a 3 alone is italic."""


@pytest.mark.parametrize("name", PACKAGES)
def test_each_package_has_a_logger_that_is_silent(name):
    import_module(name)
    handlers = logging.getLogger(name).handlers
    assert any(isinstance(handler, logging.NullHandler) for handler in handlers)


def test_a_program_hears_what_it_asks_for(caplog):
    with caplog.at_level(logging.DEBUG, logger="semianalytic"):
        sf.solve(sf.find("preloaded"))
    assert any(row.message.startswith("solve: converged, error estimate") for row in caplog.records)
    said = caplog.records[-1]
    assert said.levelno == logging.INFO
    assert said.message.startswith("a Scene by self-similar: <Solution: slip at")
    with caplog.at_level(logging.INFO, logger="semianalytic"):
        sf.sweep(sf.find("preloaded"), [0.2, 0.3])
    assert caplog.records[-1].message.startswith("a Scene by self-similar: <Sweep: 2 friction")
    with caplog.at_level(logging.INFO, logger="fem"):
        done = with_companions(sf.simulate("preloaded", resolution=16))
    model, *_, estimate = (row.message for row in caplog.records if row.name.startswith("fem"))
    assert model == "simulate: antisymmetric half, squares of side 0.0625, 3450 unknowns"
    assert f"error estimate {done.error_estimate:.1e}" in estimate


def test_a_level_on_the_command_line_prints_messages_once(shown, refused):
    for _ in range(2):
        said = shown("--log debug solve preloaded --json").err
        assert said.count("solve: converged") == 1
    assert shown("solve preloaded --json").err == ""
    expected = "--log must be one of debug, info, warning, got 'all'."
    assert expected in refused("--log all solve preloaded")
    assert refused("--log info solve preloaded --end-time 0").startswith("--end-time must be")


@pytest.mark.thinned(2)
@pytest.mark.parametrize("without", [True, False])
def test_no_color_is_heeded(without):
    coloured = {"FORCE_COLOR": "1", "TERM": "xterm-256color"}
    coloured |= {"NO_COLOR": "1"} if without else {}
    run = packages.run("", "scenes", "--help", **coloured)
    assert run.returncode == 0, run.stderr
    assert bool(COLOURED.search(run.stdout)) is not without
