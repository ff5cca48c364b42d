"""What commands print with --json: one envelope, a schema, nothing else on standard output."""

import json
from pathlib import Path

import jsonschema
import pytest
from json_checks import VALIDATOR, checked

import docs.studies.schema
from compare.comparison.documents import envelope
from compare.output.places import working_folder
from docs.studies.schema import DOCUMENTS, schema
from semianalytic import find
from semianalytic.scene.given.documents import scene_document
from slipfront.cli.commands import command_for, main

ROOT = Path(__file__).parents[3]


def commands(group=None, before=""):
    """(name, command) of the app, those of its groups included."""
    for name, command in (group or command_for([])).commands.items():
        yield f"{before}{name}", command
        if hasattr(command, "commands"):
            yield from commands(command, f"{before}{name} ")


# --- all commands ---------------------------------------------------------------------------------


def test_every_command_has_json_and_a_schema():
    for name, command in commands():
        assert "--json" in {word for param in command.params for word in param.opts}, name
        assert name in DOCUMENTS, name
    assert set(DOCUMENTS) == {name for name, _ in commands()}


def test_schema_and_table_are_up_to_date(tmp_path):
    (tmp_path / "data").mkdir()
    docs.studies.schema.write(tmp_path)
    for name in ("schema.json", "data/json-keys.csv"):
        assert (tmp_path / name).read_text() == (ROOT / "docs" / name).read_text(), name
    jsonschema.Draft202012Validator.check_schema(schema())


def test_a_document_with_another_key_or_without_one_does_not_fit():
    scene = scene_document(find("ramp"))
    good = envelope("init", {"scene": scene, "text": ""})
    assert VALIDATOR.is_valid(good)
    assert not VALIDATOR.is_valid({**good, "more": 1})
    assert not VALIDATOR.is_valid({key: value for key, value in good.items() if key != "text"})
    assert not VALIDATOR.is_valid({**good, "scene": {**scene, "friction": [0.3]}})


# --- commands that are quick ----------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_solve_names_the_files_it_wrote(printed):
    saved = printed("solve ramp --nodes 60 --save a.h5 --plot a.png")
    assert saved["files"] == ["a.h5", "a.png"]
    assert printed("solve stuck --plot b.png")["files"] == ["b.png"]


def test_scenes_and_init_fit_their_schema(printed):
    assert len(printed("scenes")["scenes"]) > 10
    document = printed("init a.toml --from viscous --units SI")
    assert document["files"] == ["a.toml"]
    assert document["units"]["scene"]["friction_law"] == {"viscosity": "Pa s/m"}
    assert printed("init -")["files"] == []


@pytest.mark.slow
def test_benchmark_fits_its_schema(printed):
    assert printed("benchmark")["sheets"]
    assert printed("benchmark show tap")["units"]["answers"]["pressure"] == "stress"
    shown = printed("benchmark show tpv101")
    assert shown["units"]["answers"]["shear_traction"] == "Pa"
    assert shown["sheet"]["scene"]["friction_law"]["kind"] == "rate-and-state"
    written = printed("benchmark export out stuck")["files"]
    assert "out/stuck/stuck.md" in written
    assert all(Path(path).is_file() for path in written)
    assert printed("benchmark score out/stuck/stuck.csv")["scores"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("benchmark --json show tap", "benchmark show --json"),  # of a group behind its command
        ("solve nowhere --json", "no scene called"),
        ("scenes --no --json", "no option"),
        ("init a.toml --units k --json", "--units must be"),
    ],
)
def test_errors_leave_standard_output_empty(line, said, refused):
    assert said in refused(line)


@pytest.mark.usefixtures("undrawn")
def test_field_fits_its_schema(printed):
    gauge = "--gauge 0.4,0.2 --samples 20 --points 20 --output f"
    document = printed(f"field preloaded {gauge}")
    assert document["gauges"] == [{"x": 0.4, "y": 0.2}]
    assert document["units"]["gauges"] == "length"
    assert "f/preloaded_speed.png" in document["files"]


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_simulate_compare_and_validate_fit_their_schema(printed, capsys):
    simulated = printed("simulate preloaded --resolution 30 --frames 2 --quiet --output run")
    assert simulated["files"] == ["run/simulation.h5", "run/snapshots"]
    assert [row["name"] for row in simulated["own_bars"]]
    capsys.readouterr()
    code = main(["compare", "--from", "run", "--quiet", "--json"])
    document = checked(capsys.readouterr().out)
    assert code == (document["verdict"] == "differs")
    assert document["status"] == document["verdict"]
    assert "run/report.json" in document["files"]
    assert "run/simulation.h5" not in document["files"]
    report = json.loads(Path("run/report.json").read_text())
    assert report == {key: document[key] for key in report}
    main(["benchmark", "export", "out", "stuck"])
    capsys.readouterr()
    main(["validate", "out/stuck/stuck.csv", "--scene", "stuck", "--json"])
    document = checked(capsys.readouterr().out)
    assert document["files"][-1].endswith("validation.png")


def test_files_are_what_is_new_or_changed(tmp_path):
    (tmp_path / "old").write_text("old")
    (tmp_path / "changed").write_text("old")
    with working_folder(tmp_path) as files:
        (tmp_path / "changed").write_text("newer")
        (tmp_path / "new").write_text("")
        (tmp_path / ".hidden").write_text("")
        assert files == []
    assert files == [tmp_path / "changed", tmp_path / "new"]
