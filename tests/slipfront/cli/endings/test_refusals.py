"""Refusals name options of the command that was typed; what was meant is guessed."""

import pytest
from catalogue import UNIT_FILE, unit_scene

from semianalytic import Ramp, TensionError, march, solve
from semianalytic.scene.given.finding import find_scene
from semianalytic.spacetime.march import check_march
from slipfront.cli.commands import main
from slipfront.cli.endings.refusals import in_options


@pytest.mark.parametrize(
    ("sentence", "expected"),
    [
        ("march: nodes must be a whole number.", "--nodes must be a whole number."),
        ("end_time must be positive.", "--end-time must be positive."),
        ("scene: base pressure must not be -1.", "--base-pressure must not be -1."),
        ("raise `nodes` to 3 or lower `end_time`.", "raise --nodes to 3 or lower --end-time."),
        ("march: latest must be 1.", "march: latest must be 1."),
        ("a.toml: scene: friction must be 1.", "a.toml: scene: friction must be 1."),
    ],
)
def test_arguments_become_options(sentence, expected):
    assert in_options(sentence, {"nodes", "end_time", "base_pressure", "friction"}) == expected


def test_nodes_follow_from_the_resolution():
    assert in_options("raise `nodes` 3 times.", {"resolution"}) == "raise --resolution 3 times."


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("solve absent.toml", "Cannot read the scene file"),
        ("solve preloaded --plot a.docx", "end the name in"),
        ("solve preloaded --nodes 50", "add --method space-time"),
        ("solve lift-off --method space-time", "turn tensile"),
        ("compare lift-off --base-pressure 0", "nothing holds the contact together"),
        ("compare ramp --method self-similar", "use the space-time solver"),
        ("solve preloaded --viscosity -1", "--viscosity must be a finite number, 0 or"),
        ("solve preloaded --mode sideways", "--mode must be in-plane or antiplane, got 'side"),
        ("compare --from absent --resolution 40", "--resolution has no effect"),
        (
            "simulate preloaded --poisson-ratio 0.4999 --resolution 40 --memory 2 --no-snapshots",
            "and 2 GB are allowed; lower --resolution to",
        ),
        ("solve ramp --nodes 3", "--nodes must be a whole number from 16"),
        ("solve ramp --end-time -1", "--end-time must be above 0"),
        ("solve preloaded --end-time 0", "--end-time must be positive"),
        ("solve preloaded --friction -1", "--friction must not be negative"),
        ("solve preloaded --load-shear nan", "--load-shear must be a finite number"),
        ("solve preloaded --poisson-ratio 0.7", "--poisson-ratio must lie strictly"),
        ("solve harmonic --nodes 20", "raise --nodes to "),
        ("solve harmonic --step-ratio 0.9", "--step-ratio is beyond the stable range"),
        ("solve ramp --nodes 100 --memory 1e-6", "lower --nodes, --end-time or --latest"),
        ("solve ramp --method self-similar", "--method space-time"),
        ("solve ramp --method sideways", "--method must be one of"),
        ("simulate ramp --resolution -3", "--resolution must be an integer of at least 8"),
        ("simulate harmonic --resolution 20", "raise --resolution from 20 to at least 36"),
        ("simulate ramp --step-ratio 9", "--step-ratio must be above 0"),
        ("compare ramp --memory 0.1 --resolution 100", "lower --resolution to"),
    ],
)
def test_refusals_name_options(command, sentence, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    assert sentence in refused(command)
    assert list(tmp_path.iterdir()) == []


def test_a_contact_that_opens_is_refused_before_it_is_simulated(tmp_path, monkeypatch, refused):
    """Not after: the march, which cannot open, came when the simulation had run."""
    monkeypatch.setattr("slipfront.cli.compare_command.simulate_into", pytest.fail)
    monkeypatch.chdir(tmp_path)
    opens = UNIT_FILE.replace("load = {pressure = 0.0", "load = {pressure = -1.0")
    opens += 'pressure_history = {kind = "ramp", rise_time = 0.5}\n'
    (tmp_path / "opens.toml").write_text(opens)
    said = refused("compare opens.toml --resolution 50")
    assert said.startswith("the pressure would turn tensile at x = ")
    assert [one.name for one in tmp_path.iterdir()] == ["opens.toml"]


@pytest.mark.parametrize("pressure", [-1.0, 0.3])
def test_what_a_march_would_refuse_is_known_before_its_first_step(pressure):
    ramp = Ramp(0.5)
    scene = unit_scene(load=(pressure, 1.0), pressure_history=ramp, shear_history=ramp)

    def refusal(run):
        try:
            run()
        except TensionError as error:
            return str(error)
        return ""

    marched = refusal(lambda: march(scene, 1.0, 64, length=1.0, companion=False))
    assert bool(marched) is (pressure < 0)
    assert refusal(lambda: check_march(scene, 1.0, 64, 1.0)) == marched


def test_a_march_that_misses_the_edge_says_which_option_to_raise(capsys, monkeypatch, printed):
    monkeypatch.setenv("COLUMNS", "300")
    command = "solve ramp --friction 20 --nodes 64"
    assert main(command.split()) == 0
    assert "raise --nodes " in capsys.readouterr().out
    assert "raise `nodes` " in printed(command)["caution"]


@pytest.mark.slow
def test_a_comparison_that_misses_the_edge_says_so_too(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    command = ["compare", "ramp", "--friction", "20", "--resolution", "20", "--no-snapshots", "-q"]
    main([*command, "--output", str(tmp_path)])
    out = capsys.readouterr().out
    assert "the march: the edge slips over a length of about" in out
    assert "(resolution 495, h = 0.002: " in out


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("solve preloaded --frction 1", "--friction"),
        ("solve preloaded --endtime 1", "--end-time"),
        ("sovle preloaded", "solve"),
        ("solve preloadd", "preloaded"),
        ("solve", "SCENE is missing; 'slipfront solve --help' describes it."),
        ("fit records.csv", "--scene is missing; 'slipfront fit --help' describes it."),
        ("solve preloaded --friction much", "--friction must be a number alone or in %, got 'm"),
        ("solve preloaded --load-shear 1e999", "--load-shear must be a finite number, got '1e"),
        ("solve preloaded --end-time 3furlong", "--end-time must be a number alone or in s, ms"),
        ("simulate ramp --resolution 3.5", "--resolution must be a whole number."),
        ("simulate ramp --memory much", "--memory must be a number."),
        ("solve preloaded --friction", "requires an argument; see 'slipfront "),
        ("solve preloaded ramp", "unexpected extra argument"),
        ("--lgo info scenes", "slipfront has no option --lgo; did you mean --log?"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence_without_a_box(command, sentence, refused):
    """A word that is nearly a command or a scene is answered by the word that was meant."""
    assert sentence in refused(command)


def test_no_words_at_all_show_the_help(capsys):
    assert main([]) == 2
    captured = capsys.readouterr()
    assert "solve" in captured.out + captured.err


def test_version(capsys):
    assert main(["--version"]) == 0
    name, number = capsys.readouterr().out.split()
    assert name == "slipfront"
    assert number[0].isdigit()
    assert main(["--help"]) == 0
    assert "--version" in capsys.readouterr().out


def test_exact_solution_until_an_end_time(printed):
    end = printed("solve preloaded --end-time 0.25")["until_end_time"]
    solution = solve(find_scene("preloaded"))
    assert [zone["end"] for zone in end["zones"]] == [0.25 * zone.outer for zone in solution.zones]
    assert end["largest_slip"] == pytest.approx(0.25 * solution.edge_slip_rate, rel=1e-3)
    # a march of the same scene says the same
    march = printed("solve preloaded --end-time 0.25 --method space-time")
    for name in ("accumulated_slip", "frictional_work"):
        assert end[name] == pytest.approx(march[name], rel=2e-3)


def test_slip_ahead_of_all_waves_has_no_end(capsys, printed):
    command = "solve remote-shock --friction 0.5 --end-time 0.5"
    assert main(command.split()) == 0
    assert "0 < x < ∞" in capsys.readouterr().out
    end = printed(command)["until_end_time"]
    assert end["zones"][-1]["end"] is None
    assert end["accumulated_slip"] is None


def test_large_snapshots_are_announced(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("slipfront.cli.simulate_command.WORTH_KEEPING", 0.0)
    options = ["--resolution", "16", "--frames", "1", "--output", str(tmp_path / "out")]
    assert main(["simulate", "preloaded", *options]) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "field snapshots will take about" in said
    assert "--no-snapshots leaves them out" in said
