"""A scene goes one way through the solver: each stage knows only those before it."""

import ast
from pathlib import Path

import pytest

import semianalytic.selfsimilar

FOLDER = Path(semianalytic.selfsimilar.__file__).parent
STAGES = (
    "tuning",
    "load",
    "layout",
    "panels",
    "canonical",
    "zones",
    "profile",
    "edges",
    "coulomb",
    "collocation",
    "guesses",
    "corrections",
    "estimate",
)
"""In the order of docs/solver.md; `solver` leads through them, `solution` is what it gives."""


def neighbours(source):
    """Modules of the folder that a source imports."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module == "semianalytic.selfsimilar":
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module.startswith(
            "semianalytic.selfsimilar."
        ):
            yield node.module.split(".")[2]


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_knows_only_those_before_it(stage):
    before = set(STAGES[: STAGES.index(stage)])
    assert set(neighbours((FOLDER / f"{stage}.py").read_text())) <= before


def test_an_import_against_the_order_is_seen():
    planted = "from semianalytic.selfsimilar import tuning\n" + (
        "from semianalytic.selfsimilar.guesses import guesses\n"
    )
    assert list(neighbours(planted)) == ["tuning", "guesses"]


def test_the_solver_goes_through_every_stage():
    seen, waiting = set(), ["solver"]
    while waiting:
        module = waiting.pop()
        if module not in seen:
            seen.add(module)
            waiting += neighbours((FOLDER / f"{module}.py").read_text())
    assert set(STAGES) < seen
