"""Refusals: those that docs/limits.md explains are made, and limits of the theory are explained."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "limits.md").read_text()
EXPLAINED = re.findall(r"^> (.+)$", PAGE, re.MULTILINE)


def written(node):
    """A string as it stands in the code, with "…" for what is filled in."""
    if isinstance(node, ast.JoinedStr):
        return "".join(
            part.value if isinstance(part, ast.Constant) else "…" for part in node.values
        )
    return node.value if isinstance(node, ast.Constant) else "…"


def refusals():
    """Kind and message of all refusals of the four packages."""
    for package in ("semianalytic", "fem", "meshes", "compare", "slipfront"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text())):
                raised = node.exc if isinstance(node, ast.Raise) else None
                kind = getattr(raised.func, "id", "") if isinstance(raised, ast.Call) else ""
                if kind in ("SceneError", "TensionError"):
                    yield kind, written(raised.args[0])


MADE = list(refusals())


def explained(message):
    """Whether a line of the page begins a message; backquotes do not count."""
    return any(message.replace("`", "").startswith(line.replace("`", "")) for line in EXPLAINED)


@pytest.mark.parametrize("line", EXPLAINED)
def test_explained_refusal_is_made(line):
    line = line.replace("`", "")
    assert any(message.replace("`", "").startswith(line) for _, message in MADE)


def test_tension_and_refusals_that_point_to_the_page_are_explained_there():
    limits = [message for kind, message in MADE if kind == "TensionError" or "limits.md" in message]
    assert len(limits) >= 3
    assert [message for message in limits if not explained(message)] == []
    pointing = [message for message in limits if "limits.md" in message]
    assert all(re.search(r"\(docs/limits\.md\)\.?$", message) for message in pointing)
