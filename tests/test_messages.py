"""Messages of the packages: none unless asked, by a level on the command line or in a program."""

import logging
import os
import re
import subprocess
import sys
from importlib import import_module

import pytest

import slipfront as sf
from slipfront.cli.commands import main

PACKAGES = ("slipfront", "semianalytic", "fem", "meshes", "compare")
COLOURED = re.compile("\x1b\\[[0-9;]*3[0-9]")
"""A sequence that changes a colour; a 3 alone is italic."""


@pytest.mark.parametrize("name", PACKAGES)
def test_each_package_has_a_logger_that_is_silent(name):
    import_module(name)
    handlers = logging.getLogger(name).handlers
    assert any(isinstance(one, logging.NullHandler) for one in handlers)


def test_a_program_hears_what_it_asks_for(caplog):
    with caplog.at_level(logging.DEBUG, logger="semianalytic"):
        sf.solve(sf.find_scene("preloaded"))
    assert any(one.message.startswith("solve: converged, 2 zones") for one in caplog.records)


def test_a_level_on_the_command_line_prints_messages_once(capsys):
    for _ in range(2):
        assert main(["--log", "debug", "solve", "preloaded", "--json"]) == 0
        assert capsys.readouterr().err.count("solve: converged") == 1
    assert main(["solve", "preloaded", "--json"]) == 0
    assert capsys.readouterr().err == ""
    assert main(["--log", "all", "solve", "preloaded"]) == 2
    assert "--log must be one of debug, info, warning, got 'all'." in capsys.readouterr().err


@pytest.mark.thinned(2)
@pytest.mark.parametrize("without", [True, False])
def test_no_color_is_heeded(without):
    environment = {**os.environ, "FORCE_COLOR": "1", "TERM": "xterm-256color"}
    environment |= {"NO_COLOR": "1"} if without else {}
    command = "import sys; from slipfront.cli.entry import main; sys.exit(main())"
    run = [sys.executable, "-c", command, "solve", "--help"]
    shown = subprocess.run(run, capture_output=True, text=True, check=True, env=environment)
    assert bool(COLOURED.search(shown.stdout)) is not without
