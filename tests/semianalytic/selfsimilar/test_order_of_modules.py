"""A scene goes one way through the solver: each stage knows only those before it."""

import ast
from pathlib import Path

import pytest

import semianalytic

HOUSE = Path(semianalytic.__file__).parent
FOLDERS = ("cut", "separation", "selfsimilar")
STAGES = (
    "cut.quadrature.layout",
    "cut.quadrature.panels",
    "cut.quadrature.laying",
    "cut.quadrature.running",
    "cut.load",
    "cut.canonical",
    "cut.strength",
    "cut.given_zones",
    "cut.transform",
    "cut.slopes",
    "cut.zones",
    "cut.profile",
    "cut.slot_faces",
    "cut.totals",
    "separation.opening",
    "separation.normal",
    "selfsimilar.zones.tuning",
    "selfsimilar.zones.edges",
    "selfsimilar.zones.placement",
    "selfsimilar.zones.coulomb",
    "selfsimilar.zones.collocation",
    "selfsimilar.zones.first_front",
    "selfsimilar.zones.weak_friction",
    "selfsimilar.zones.guesses",
    "selfsimilar.zones.motion",
    "selfsimilar.zones.corrections",
    "selfsimilar.zones.estimate",
    "selfsimilar.rated.law",
    "selfsimilar.rated.steepness",
    "selfsimilar.rated.newton",
    "selfsimilar.rated.approach",
    "selfsimilar.search",
)
"""In the order of docs/solver.md; `solver` leads through them, `solution` is what it gives."""


def neighbours(source):
    """Modules of the two folders that a source imports."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ImportFrom):
            continue
        _, *rest = node.module.split(".")
        if rest and rest[0] in FOLDERS:
            folder = ".".join(rest)
            if (HOUSE / f"{folder.replace('.', '/')}.py").exists():
                yield folder
            else:  # modules themselves are imported from their folder
                yield from (f"{folder}.{alias.name}" for alias in node.names)


def source(module):
    return (HOUSE / f"{module.replace('.', '/')}.py").read_text()


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_knows_only_those_before_it(stage):
    before = set(STAGES[: STAGES.index(stage)])
    assert set(neighbours(source(stage))) <= before


def test_an_import_against_the_order_is_seen():
    planted = "from semianalytic.selfsimilar.zones import tuning\n" + (
        "from semianalytic.selfsimilar.zones.guesses import guesses\n"
    )
    assert list(neighbours(planted)) == ["selfsimilar.zones.tuning", "selfsimilar.zones.guesses"]


def test_the_solver_goes_through_every_stage():
    seen, waiting = set(), ["selfsimilar.solver"]
    while waiting:
        module = waiting.pop()
        if module not in seen:
            seen.add(module)
            waiting += neighbours(source(module))
    assert set(STAGES) < seen
