"""Refusals: those that docs/limits.md explains are made, and limits of the theory are explained."""

import ast
import re
from pathlib import Path

import pytest
from catalogue import UNIT_FILE, unit_scene

from semianalytic import SceneError, find

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


@pytest.fixture(scope="module")
def made():
    """Kind and message of all refusals of the packages."""
    found = []
    for package in ("semianalytic", "fem", "meshes", "compare", "slipfront"):
        for path in sorted((ROOT / package).rglob("*.py")):
            text = path.read_text()
            if "SceneError(" not in text and "TensionError(" not in text:
                continue
            for node in ast.walk(ast.parse(text)):
                raised = node.exc if isinstance(node, ast.Raise) else None
                kind = getattr(raised.func, "id", "") if isinstance(raised, ast.Call) else ""
                if kind in ("SceneError", "TensionError"):
                    found.append((kind, written(raised.args[0])))
    return found


def explained(message):
    """Whether a line of the page begins a message; backquotes do not count."""
    return any(message.replace("`", "").startswith(line.replace("`", "")) for line in EXPLAINED)


@pytest.mark.parametrize("line", EXPLAINED)
def test_explained_refusal_is_made(line, made):
    line = line.replace("`", "")
    assert any(message.replace("`", "").startswith(line) for _, message in made)


def test_tension_and_refusals_that_point_to_the_page_are_explained_there(made):
    limits = [message for kind, message in made if kind == "TensionError" or "limits.md" in message]
    assert len(limits) >= 3
    assert [message for message in limits if not explained(message)] == []
    pointing = [message for message in limits if "limits.md" in message]
    assert all(re.search(r"\(docs/limits\.md\)\.?$", message) for message in pointing)


OUTSIDE = {
    "three dimensions": 'mode = "3-D"\n',
    "layers": "layers = 3\n",
    "plasticity": "yield_stress = 2.0\n",
    "thermal pressurisation": "[thermal_pressurisation]\ndiffusivity = 1e-6\n",
    "anisotropic": "[stiffness]\nc11 = 3.0\n",
    "finite size": "height = 0.5\n",
}
"""Lines of a scene that ask for something, by words of its row on the page."""


@pytest.mark.parametrize("words", OUTSIDE)
def test_what_slipfront_does_not_do_is_refused_with_its_page(words, tmp_path, refused):
    rows = (ROOT / "docs" / "not_here.md").read_text().splitlines()
    assert any(line.startswith("|") and words in line for line in rows)
    path, line = tmp_path / "scene.toml", OUTSIDE[words]
    path.write_text(UNIT_FILE)
    find(str(path))
    path.write_text(UNIT_FILE + line)
    assert re.search(r"\(docs/not_here\.md\)\.\n$", refused(["solve", path]))


@pytest.mark.parametrize("given", [{"mode": "3-D"}, {"layers": 3}, {"evolution": "ageing"}])
def test_parameters_of_what_slipfront_does_not_do_name_its_page(given):
    with pytest.raises(SceneError, match=r"\(docs/not_here\.md\)\.$"):
        unit_scene(**given)


def test_a_misspelt_parameter_is_not_taken_for_one():
    with pytest.raises(SceneError, match=r"did you mean lower_material\?$"):
        unit_scene(lower_materal=1)
