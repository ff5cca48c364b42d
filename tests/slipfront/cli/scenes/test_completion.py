"""What the shells complete, by the variables that their scripts set."""

import re

import packages
import pytest

from compare.figures.named import DEFAULT_FIGURE
from compare.figures.quantities import QUANTITIES, find_quantity
from fem.elements.assembly import FAMILIES
from meshes.blocks import PATTERNS
from semianalytic import find
from semianalytic.methods import chosen
from semianalytic.scene.given.named import NAMED_LINES, NAMED_SCENES
from semianalytic.scene.loading import LOADED
from semianalytic.scene.scene import MODES
from slipfront.cli import commands
from slipfront.cli.commands import COMMANDS, _group
from slipfront.cli.scenes import completion

RUN = "from slipfront.cli.entry import main; raise SystemExit(main())"


@pytest.fixture
def completed(monkeypatch, shown):
    """Words that a shell is offered behind a line that is being typed."""

    def words(shell, line):
        typed = line.split() + ([""] if line.endswith(" ") else [])
        variables = {
            "bash": {"COMP_WORDS": "\n".join(typed), "COMP_CWORD": str(len(typed) - 1)},
            "zsh": {"_TYPER_COMPLETE_ARGS": line},
            "fish": {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
        }[shell]
        for name, value in {**variables, "_SLIPFRONT_COMPLETE": f"complete_{shell}"}.items():
            monkeypatch.setenv(name, value)
        captured = shown([])
        assert captured.err == ""
        if shell == "zsh":
            return [word.split('":"')[0] for word in re.findall(r'"([^\n]*)"', captured.out)]
        return [word.split("\t")[0] for word in captured.out.split("\n") if word]

    return words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_is_given_its_script_and_scenes(shell, completed, monkeypatch, shown):
    assert completed(shell, "slipfront solve pre") == ["preloaded", "pressure-drop"]
    monkeypatch.setenv("_SLIPFRONT_COMPLETE", f"source_{shell}")
    assert f"complete_{shell}" in shown([]).out


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("slipfront sol", ["solve"]),
        ("slipfront field preloaded --of max", ["max-shear"]),
        ("slipfront solve preloaded --method s", ["self-similar", "space-time"]),
        ("slipfront solve preloaded --figure ", ["interface"]),
        ("slipfront solve preloaded --mode ", ["in-plane", "antiplane"]),
        ("slipfront benchmark show lift", ["lift-off", "lift-off-shear"]),
        ("slipfront solve ramp --figure x", []),
        ("slipfront init --from ta", ["tap"]),
    ],
)
def test_names_are_completed(line, words, completed):
    assert completed("bash", line) == words


@pytest.mark.parametrize(
    ("shell", "line", "count"),
    [
        ("bash", "slipfront solve pre", 1),
        ("zsh", "slipfront --log info solve ", 1),
        ("fish", "slipfront solve", len(COMMANDS)),  # which may become another word
    ],
)
def test_no_command_is_imported_but_the_one_whose_words_are_completed(
    shell, line, count, completed, monkeypatch
):
    groups = []
    monkeypatch.setattr(commands, "_group", lambda item: groups.append(_group(item)) or groups[-1])
    assert completed(shell, line)
    assert {len(group.commands) for group in groups} == {count}


def test_names_of_packages_and_files_are_completed(tmp_path):
    packages.install(tmp_path, *packages.documented_package())
    (tmp_path / "granular.toml").write_text("")
    (tmp_path / "granular.txt").write_text("")
    variables = {"COMP_WORDS": "slipfront\nsolve\ngran", "COMP_CWORD": "2"}
    instruction = {"_SLIPFRONT_COMPLETE": "complete_bash"}
    run = packages.run(tmp_path, "-c", RUN, cwd=tmp_path, **variables, **instruction)
    assert (run.stdout.split(), run.stderr) == (["granite", "granular.toml"], "")


def test_files_below_a_folder_are_completed(tmp_path):
    (tmp_path / "a.toml").write_text("")
    assert completion.scene_names(f"{tmp_path}/") == [f"{tmp_path}/a.toml"]
    assert completion.scene_names("no/such/folder/") == []


def test_names_are_those_of_the_functions_that_take_them():
    preloaded = find("preloaded")
    antiplane = find("antiplane")
    for name in completion.QUANTITIES:
        find_quantity(name, antiplane if name.endswith("z") else preloaded, None)
    assert set(QUANTITIES) <= set(completion.QUANTITIES)
    assert (DEFAULT_FIGURE,) == completion.FIGURES
    assert completion.MODES == MODES
    assert completion.LOADED == LOADED
    assert completion.MESH_NAMES["mesh"] == PATTERNS == tuple(FAMILIES)
    for method in completion.METHODS:
        assert chosen(preloaded, method).name in completion.METHODS
    assert set(completion.scene_names("")) >= {*NAMED_SCENES, *NAMED_LINES}
