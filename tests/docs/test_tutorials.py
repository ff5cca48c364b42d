"""Every notebook in docs/tutorials runs, asserts what it teaches, and is kept with its outputs."""

import ast
import itertools
import json
import re
import sys
from pathlib import Path

import nbclient
import nbformat
import pytest
from jupyter_client import AsyncKernelManager
from jupyter_client.kernelspec import KernelSpec, KernelSpecManager

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "tutorials"
LESSONS = re.findall(r"\]\((\w+)\.ipynb\)", (FOLDER / "index.md").read_text())
LONGEST = 290
"""Seconds a cell may take: most lessons are of five minutes."""
TITLE = re.compile(r"ν.*\bf\b|\bf\b.*ν", re.DOTALL)
"""What the title of a figure says."""
UNIT = re.compile(r"\[.+\]'$|ratio|coefficient|cells")
"""What a label of an axis ends in, or a word that needs none."""


class ThisInterpreter(KernelSpecManager):
    """Whatever kernels are installed, the one of the interpreter that runs the tests."""

    def get_kernel_spec(self, kernel_name):
        command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        return KernelSpec(argv=command, language="python", display_name=kernel_name)


@pytest.fixture(autouse=True)
def _pictures_in_the_notebook(monkeypatch):
    """Kernels draw into their notebook, also where a command has set another backend before."""
    monkeypatch.delenv("MPLBACKEND", raising=False)


def run(notebook, folder):
    """The notebook, executed with a folder for its working directory."""
    manager = AsyncKernelManager(kernel_spec_manager=ThisInterpreter())
    client = nbclient.NotebookClient(
        notebook, manager, timeout=LONGEST, resources={"metadata": {"path": str(folder)}}
    )
    try:
        return client.execute()
    except nbclient.exceptions.CellExecutionError as error:
        pytest.fail(f"a cell of a tutorial failed:\n{error}", pytrace=False)


def read(name):
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def code_of(notebook):
    return [cell.source for cell in notebook.cells if cell.cell_type == "code"]


def calls(tree, function):
    """Where a cell calls a method of this name."""
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == function
    ]


def text_of(notebook):
    return [cell.source for cell in notebook.cells if cell.cell_type == "markdown"]


def kinds(cell):
    """Kinds of output of a cell; a kernel sends printed text in any number of pieces."""
    outputs = [(output.output_type, output.get("name")) for output in cell.get("outputs", ())]
    return [kind for kind, _ in itertools.groupby(outputs)]


@pytest.mark.thinned(20)
@pytest.mark.parametrize("name", LESSONS)
def test_tutorial_runs_and_draws(name, tmp_path):
    kept, done = read(name), run(read(name), tmp_path)
    assert list(map(kinds, done.cells)) == list(map(kinds, kept.cells))
    outputs = [output for cell in done.cells for output in cell.get("outputs", ())]
    pictures = sum("image/png" in output.get("data", ()) for output in outputs)
    assert pictures >= 2
    warned = [output.text for output in outputs if output.get("name") == "stderr"]
    # Matplotlib warns when the search for the place of a legend takes a second of the clock, which
    # a pause of the machine makes of its hundredth.
    assert [text for text in warned if "Creating legend with loc" not in text] == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", LESSONS)
def test_tutorial_is_kept_with_its_outputs(name):
    """In the order of its cells, as a code host shows them."""
    document = json.loads((FOLDER / f"{name}.ipynb").read_text())
    nbformat.validate(document)
    cells = [cell for cell in document["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    assert str(document).count("image/png") >= 2


@pytest.mark.parametrize("name", LESSONS)
def test_tutorial_says_what_it_is_for_and_asks(name):
    notebook = read(name)
    head, *_, end = text_of(notebook)
    assert "**At the end you know**" in head
    assert "**Time:**" in head
    assert f"]({name}.ipynb)" in head  # to download it from the site
    assert end.startswith("## Where to go on")
    cells = [cell.source for cell in notebook.cells]
    asked = [number for number, source in enumerate(cells) if "**Question" in source]
    assert 2 <= len(asked) <= 3
    assert [cells[number] for number in asked if "\nassert " not in cells[number + 1]] == []


@pytest.mark.parametrize("name", LESSONS)
def test_figures_of_tutorials_say_poisson_ratio_friction_and_units(name):
    cells = [ast.parse(source) for source in code_of(read(name))]
    drawn = [cell for cell in cells if calls(cell, "subplots")]
    assert len(drawn) >= 2
    words = {
        node.targets[0].id
        for cell in cells
        for node in ast.walk(cell)
        if isinstance(node, ast.Assign) and TITLE.search(ast.unparse(node.value))
    }
    for cell in drawn:
        titles = [call.args[0] for call in calls(cell, "set_title") + calls(cell, "suptitle")]
        names = {sub.id for title in titles for sub in ast.walk(title) if isinstance(sub, ast.Name)}
        assert words & names or TITLE.search(" ".join(map(ast.unparse, titles)))
        labels = [
            ast.unparse(label.value)
            for call in calls(cell, "set")
            for label in call.keywords
            if label.arg in ("xlabel", "ylabel")
        ]
        assert labels
        assert [label for label in labels if not UNIT.search(label)] == []


@pytest.mark.parametrize("name", LESSONS)
def test_links_of_tutorials_lead_somewhere(name):
    targets = re.findall(r"\]\(([^)#:]+)(?:#[\w-]+)?\)", "\n".join(text_of(read(name))))
    assert [target for target in targets if not (FOLDER / target).is_file()] == []


def test_every_tutorial_is_in_the_table_and_in_the_site():
    site = (ROOT / "mkdocs.yml").read_text()
    assert sorted(LESSONS) == sorted(path.stem for path in FOLDER.glob("*.ipynb"))
    assert re.findall(r": tutorials/(\w+)\.ipynb$", site, re.MULTILINE) == LESSONS
