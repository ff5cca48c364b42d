"""Refusals name options of the command that was typed; what was meant is guessed."""

import pytest
from catalogue import UNIT_FILE

from semianalytic import solve
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.endings.refusals import in_options
from tests.slipfront.cli.test_lower_body_commands import FILE as TWO_BODIES
from tests.slipfront.surveys.test_interface_surveys import FAULT

RECORD = "t,x,slip\n1.0,0.5,0.1\n2.0,0.5,0.2\n"
RATES = "t,x,slip_rate\n0.3,0.4,1.0\n0.5,0.4,1.0\n0.9,0.4,0.8\n"


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


A_TIME = "--budget must be a time such as 60s, 5min or 1h, got '"
OTHERWISE = "slipfront solve, compare, explore, field, survey and simulate take others"
REFUSED = {
    "": [
        ("solve absent.toml", "cannot be read"),
        ("solve preloaded --save a\0b.h5", "contains a NUL character"),
        ("simulate preloaded --lower-shear-modulus 1e60", "wave speed of the lower body"),
        ("solve preloaded --plot a.docx", "end the name in"),
        ("solve preloaded --nodes 50", "add --method space-time"),
        ("solve lift-off --method space-time --length 1", "turn tensile"),
        ("compare lift-off --base-pressure 0", "nothing holds the contact together"),
        ("compare ramp --method self-similar", "use the space-time solver"),
        ("compare --from absent --resolution 40", "--resolution has no effect"),
        ("solve preloaded --end-time 0", "--end-time must be positive"),
        ("solve preloaded --poisson-ratio 0.7", "--poisson-ratio must lie strictly"),
        ("solve harmonic --nodes 20", "raise --nodes to "),
        ("solve harmonic --step-ratio 0.9", "--step-ratio is beyond the stable range"),
        ("solve ramp --nodes 100 --memory 1e-6", "lower --nodes, --end-time or --latest"),
        ("simulate harmonic --resolution 20", "raise --resolution from 20 to at least 36"),
        ("compare ramp --memory 0.1 --resolution 100", "lower --resolution to"),
        # what cannot be read, and what was meant
        ("solve preloaded --frction 1", "--friction"),
        ("sovle preloaded", "solve"),
        ("solve preloadd", "preloaded"),
        ("solve", "SCENE is missing; 'slipfront solve --help' describes it."),
        ("solve preloaded --load-shear 1e999", "--load-shear must be a finite number, got '1e"),
        ("solve preloaded --friction", "requires an argument; see 'slipfront "),
        ("--lgo info scenes", "slipfront has no option --lgo; did you mean --log?"),
        (
            "sliding --upper 12e9,2300,0.25 --lower 30e9,2700,0.25 --friction -1",
            "riction must be positive",
        ),
        ("docs docs/limit.md", "did you mean limits?"),
        ("solve stuck --figure interface", "give both"),
        # waves at an angle and moving loads
        ("solve moving-load --load-speed 1e-9", "slower than 0.0001 of the shear wave"),
        ("solve incident-sv --angle=-10 --wave-stress 2", "exceeds friction"),
        ("solve incident-p --method space-time --length 1", "would turn tensile"),
        # whole lines: commands of scenes with a slot name those that solve them
        ("solve whole-line-patch --load-on remote", "determines where it acts"),
        ("solve whole-line-patch --method magic", "--method must be one of auto"),
        ("solve whole-line-patch --nodes 100", "is for the space-time solver; leave it out"),
        ("simulate whole-line-patch", "slipfront solve"),
        # two different bodies: what knows identical bodies only says what can
        ("compare two.toml --method space-time", "march them as an interface"),
        (
            "compare ramp --lower-density 2",
            "shear_history: between different bodies the exact solver",
        ),
        ("field two.toml --method space-time", "is for a Scene, or"),
        ("fit slip.csv --scene preloaded --lower-density 2", OTHERWISE),
        ("solve two.toml --nodes 64", "is for the space-time solver; leave it out"),
        ("solve antiplane --lower-density 2", 'mode = "antiplane": between different bodies'),
        ("solve remote-shock --lower-density 2", 'load_on = "remote": between different bodies'),
        ("solve incident-p --lower-density 2", "the load is a wave or moves: between different"),
        ("solve whole-line-patch --lower-density 2", "of equal bodies and constant friction"),
        ("solve two.toml --friction 0.95", "and no answer exists"),
        (
            "survey two.toml --lower-density 1,2 --nodes 64",
            "two different bodies are solved exactly",
        ),
        ("survey two.toml --vary lower_material.dense=1,2", "did you mean lower_density?"),
        ("sliding --upper 1,1,0.25 --lower 1,1,0.5 --friction 0.3", "poisson_ratio must lie"),
    ],
    "solve preloaded": [
        ("--x -1", "must be positive"),
        ("--t 3", "--t needs --x"),
        ("--shear-modulus 80GPa", "--shear-modulus has a unit"),
        ("--units cgs", 'units must be "SI"'),
        (f"--x {','.join(['1'] * 1001)}", "more than 1000 points"),
        ("--units SI --x 5cm --t 30", "--t 30 has no unit while --x has one"),
    ],
    "field preloaded": [
        ("--of szz", "--of must be one of speed, pressure"),
        ("--format avi", "--format must be gif or mp4"),
        ("--grid 3,3", "--grid needs --vtu"),
        ("--format mp4", "--format is that of --animate; give both"),
        ("--samples 5", "--samples are those of --gauge; give both"),
        ("--vtu --grid 3,x", "--grid must be two whole numbers"),
        ("--thickness 1", "--of fringes"),
        ("--of fringes --thickness 1", "give both."),
        ("--of fringes --thickness 1 --stress-optical 0", "--stress-optical must be positive"),
        ("--nodes 100", "--nodes is for the space-time solver"),
    ],
    "survey preloaded --quiet": [
        ("--friction=-1:1:3:log", "--friction must be a number, a row as"),
        ("--friction 0.1:0.9:10000000000", "--friction must be at most 1e+07 values"),
        ("--friction 0.1:1e400:3", "--friction must be a finite number, got '1e400'"),
        ("--friction 0.2", "give values of at least one"),
    ],
    "survey preloaded --quiet --friction 0.1,0.2": [
        ("--output file/a.nc", "Cannot write file/a.nc", 3),
        ("--output file.nc", "cannot be read as a survey", 3),
        ("--scheduler there", "--scheduler must be an address"),
    ],
    "fit rates.csv --scene preloaded --friction 0.4 --parameters friction": [
        ("", "does not say how exact its slip_rate is", 3),
        ("--noise 3frob", "m, cm, mm, um or km; "),
    ],
    "fit rates.csv --scene preloaded --friction 0.4 --parameters friction --noise 0.1": [
        ("--prior friction=0.3", "--prior must be NAME=KIND(A,B)"),
        ("--setup x1=3", "--setup knows t0, x0, gain"),
        ("--plot fit.xyz", "Figures cannot be written as 'fit.xyz'"),
    ],
    "validate slip.csv --scene preloaded": [
        ("--scale mass=2", "nothing called 'mass' to scale"),
        ("--scale length=2 --length-unit mm", "given twice"),
        ("--length-unit psi", "--length-unit must be a unit of length such as mm, got 'psi'"),
        ("--slip double", "--slip must be one of relative, half, face"),
        ("--spacing 1mm", "--spacing has a unit, but the scene"),
    ],
    "sliding --lower 30e9,2700,0.25 --friction 0.4 --upper": [
        ("12e9,2300", "--upper has to be a solid"),
        ("12GPa,2300,0.25", "nits at all moduli and densities or at none"),
        ("12cm,2300,0.25", "--upper: the shear modulus must be a number alone or in Pa"),
    ],
    "fit slip.csv --scene fault.toml --noise slip=0.2 --parameters": [
        ("law.dyn", "must be among friction, shear_modulus"),
        ("friction_law.distance --prior friction_law.distance=normal(1mm,1)", "unit"),
        ("gain --nodes 30", "multiple of 4"),
    ],
    "compare stuck": [
        ("--budget=1year", A_TIME),
        (f"--budget {'9' * 400}", A_TIME),
        ("--budget 0.001s", "raise --budget, or give a --resolution."),
        ("--budget 60s --resolution 40", "--budget has no effect with --resolution; leave one"),
    ],
    "survey fault.toml": [
        ("--vary load_1_shear_factor=1 --vary friction_law.distance=1m,2m", "not say which"),
        ("--vary radius=1,2 --t 0.5", "give x as well"),
    ],
}
"""What follows a beginning of a command line, what is said, and an exit code other than 2."""


CASES = {
    f"{begun} {rest}": (words, *(code or [2]))
    for begun, cases in REFUSED.items()
    for rest, words, *code in cases
}


@pytest.mark.thinned(3)
@pytest.mark.parametrize("line", CASES, ids=lambda line: line[:80])
def test_what_cannot_be_is_refused_in_a_sentence(line, tmp_path, refused):
    """It names options of the command that was typed, and comes before anything is made."""
    (tmp_path / "two.toml").write_text(TWO_BODIES)
    (tmp_path / "fault.toml").write_text(FAULT)
    for name, text in (("file", ""), ("file.nc", ""), ("slip.csv", RECORD), ("rates.csv", RATES)):
        (tmp_path / name).write_text(text)
    before = sorted(tmp_path.rglob("*"))
    words, code = CASES[line]
    assert words in refused(line, code)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_contact_that_opens_is_refused_before_it_is_simulated(tmp_path, monkeypatch, refused):
    """Not after: the march, which cannot open, came when the simulation had run."""
    monkeypatch.setattr("slipfront.cli.compare_command.simulate_into", pytest.fail)
    opens = UNIT_FILE.replace("load = {pressure = 0.0", "load = {pressure = -1.0")
    opens += 'pressure_history = {kind = "ramp", rise_time = 0.5}\n'
    (tmp_path / "opens.toml").write_text(opens)
    said = refused("compare opens.toml --resolution 50")
    assert said.startswith("the pressure would turn tensile at x = ")
    assert [path.name for path in tmp_path.iterdir()] == ["opens.toml"]


def test_a_march_that_misses_the_edge_says_which_option_to_raise(monkeypatch, shown):
    monkeypatch.setenv("COLUMNS", "300")
    command = "solve ramp --friction 20 --nodes 64"
    said = shown(command, 4)  # an unresolved answer is printed, and ends with 4
    assert "raise --nodes " in said.out
    assert said.err.startswith("ramp is unresolved: the edge slips over a length")
    late = shown("solve ramp --units SI --end-time 40us --nodes 64", 4).err
    assert "until t = 4e-05 the shear of the load reaches only 8e-05 of its size" in late


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_comparison_that_misses_the_edge_says_so_too(shown, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    out = shown("compare ramp --friction 20 --resolution 20 --no-snapshots -q --output out").out
    assert "the march: the edge slips over a length of about" in out
    assert "may be resolved with --resolution 496, in about " in out


def test_no_words_at_all_show_the_help(shown):
    assert "solve" in "".join(shown("", 2))


def test_version(shown):
    name, number = shown("--version").out.split()
    assert name == "slipfront"
    assert number[0].isdigit()
    assert "--version" in shown("--help").out


def test_exact_solution_until_an_end_time(printed):
    end = printed("solve preloaded --end-time 0.25")["until_end_time"]
    solution = solve(find_scene("preloaded"))
    assert [zone["end"] for zone in end["zones"]] == [0.25 * zone.outer for zone in solution.zones]
    assert end["largest_slip"] == pytest.approx(0.25 * solution.edge_slip_rate, rel=1e-3)
    # a march of the same scene says the same
    march = printed("solve preloaded --end-time 0.25 --method space-time --nodes 200")
    for name in ("accumulated_slip", "frictional_work"):
        assert end[name] == pytest.approx(march[name], rel=2e-3)


def test_slip_ahead_of_all_waves_has_no_end(shown, printed):
    command = "solve remote-shock --friction 0.5 --end-time 0.5"
    assert "0 < x < ∞" in shown(command).out
    end = printed(command)["until_end_time"]
    assert end["zones"][-1]["end"] is None
    assert end["accumulated_slip"] is None
