"""Scenes, laws, histories and figures of a package of a user's own, found by entry points."""

import json
import sys
from dataclasses import replace

import numpy as np
import packages
import pytest
from catalogue import under

import slipfront as sf
from semianalytic.scene import plugins
from semianalytic.scene.given.documents import scene_document, scene_from_document
from slipfront.cli.commands import main

RATE_LAW = '''
from dataclasses import dataclass
import slipfront as sf

@dataclass(frozen=True)
class Oil(sf.Law):
    """Coulomb friction with a viscosity under another name."""
    friction: float
    viscosity: float
    def strength(self, pressure, speed, state):
        return self.friction * pressure + self.viscosity * speed
    def rate_slopes(self, pressure, speed):
        none = 0 * pressure
        return none + self.friction, none + self.viscosity, none, none

OILED = sf.Scene(
    sf.Material(1.0, 1.0, 1 / 3), Oil(0.2, 0.01), sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0)
)
'''


METHOD = """
class Rigid:
    @staticmethod
    def refuses(problem):
        return None if isinstance(problem, str | dict) else "it takes blocks alone."

    @staticmethod
    def solve(problem, *, friction=0.5):
        return friction * problem["weight"]
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Installs packages for this process; their modules are forgotten at the end."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    before = set(sys.modules)

    def forget():
        plugins.plugins.cache_clear()

    def install(pyproject, files):
        packages.install(folder, pyproject, files)
        forget()

    forget()
    yield install
    forget()
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
            del sys.modules[name]


@pytest.fixture
def granite(installed):
    """The package of docs/extending.md, installed; its module."""
    installed(*packages.documented_package())
    import granite as module

    return module


# --- the package of the documentation ------------------------------------------------------------


@pytest.mark.slow
def test_the_documented_package_works_from_the_shell(tmp_path):
    folder = tmp_path / "site"
    folder.mkdir()
    packages.install(folder, *packages.documented_package())
    run = packages.run(folder, "init", "mine.toml", "--from", "granite", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    solve = ("--end-time", "1e-4", "--nodes", "200", "--json", "--figure", "slip", "--plot")
    run = packages.run(folder, "solve", "mine.toml", *solve, "slip.png", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    document = json.loads(run.stdout)
    assert document["scene"]["friction_law"]["kind"] == "hyperbolic-weakening"
    assert document["scene"]["shear_history"] == {"kind": "two-steps", "delay": 5e-5}
    assert document["units"]["scene"]["shear_history"] == {"delay": "s"}
    assert document["units"]["scene"]["friction_law"] == {"reduction": "1", "distance": "m"}
    assert document["largest_slip"] > 0
    assert (tmp_path / "slip.png").read_bytes().startswith(b"\x89PNG")
    assert document["files"] == ["slip.png"]


def test_a_law_of_a_package_is_one_like_ours(granite):
    scene = sf.find("granite")
    assert scene_from_document(scene_document(scene)) == scene
    marched = sf.solve(scene, method="space-time", end_time=1e-4, nodes=200)
    strength = scene.strength(scene.base.pressure, 0.0, marched.interface.slip[-1])
    np.testing.assert_allclose(marched.interface.shear_traction[-1, :20], strength[:20], rtol=1e-4)
    plain = replace(scene, friction=0.6)
    constant = sf.solve(plain, method="space-time", end_time=1e-4, nodes=200)
    assert marched.interface.slip[-1].max() > 1.01 * constant.interface.slip[-1].max()


def test_a_saved_march_of_a_package_is_read_again(granite, tmp_path):
    marched = sf.solve(sf.find("granite"), method="space-time", end_time=5e-5, nodes=100)
    marched.save(tmp_path / "march.h5")
    assert sf.Marched.load(tmp_path / "march.h5").scene == marched.scene


def test_finite_elements_take_a_law_of_a_package_too(granite):
    scene = sf.find("granite")
    simulation = sf.simulate(scene, 1e-4, resolution=30)
    slips = simulation.interface.slip_rate[-1] > 1e-3 * simulation.interface.slip_rate.max()
    last = simulation.interface
    strength = scene.strength(last.pressure[-1], last.slip_rate[-1], last.slip[-1])
    traction = simulation.interface.shear_traction[-1]
    assert np.count_nonzero(slips) > 5
    np.testing.assert_allclose(traction[slips][:-1], strength[slips][:-1], rtol=1e-9)


def test_a_file_of_an_interface_takes_a_law_of_a_package_along_x(granite, tmp_path):
    law = {"kind": '"hyperbolic-weakening"', "friction": '"0.3 + 0.1 * x**2"', "reduction": 0.5}
    solid = "material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}"
    text = (
        f"contact = 'whole line'\nperiod = 8.0\nbase = {{pressure = 1.0, shear = 0.35}}\n{solid}\n"
    )
    text += "run = {end_time = 0.5, nodes = 64}\n[friction_law]\n"
    rows = [f"{name} = {value}" for name, value in (law | {"distance": 0.1}).items()]
    (tmp_path / "face.toml").write_text(text + "\n".join(rows))
    done = sf.solve(tmp_path / "face.toml")
    slip, shear = done.interface.slip[-1], done.interface.shear_traction[-1]
    strength = (0.3 + 0.1 * done.interface.x**2) * (1 - 0.5 * slip / (slip + 0.1))
    np.testing.assert_allclose(shear[slip > 0.01], strength[slip > 0.01], 1e-3)
    assert 0 < np.count_nonzero(slip > 0.01) < 16


def test_a_method_of_a_package_is_asked_after_ours(installed, printed):
    installed(
        packages.brought("blocks", "blocks", methods=["rigid = Rigid"]), {"blocks.py": METHOD}
    )
    assert sf.solve({"weight": 2.0}) == 1.0
    assert sf.solve({"weight": 2.0}, method="rigid", friction=0.1) == 0.2
    assert isinstance(sf.solve("preloaded"), sf.Solution)
    with pytest.raises(sf.SceneError, match="force is no setting of rigid for a dict, which takes"):
        sf.solve({"weight": 2.0}, force=1.0)
    with pytest.raises(sf.SceneError, match=r"rigid: it takes blocks alone\."):
        sf.solve(None)
    assert ("method", "rigid") in {
        (plugin["what"], plugin["name"]) for plugin in printed("scenes")["brought"]
    }


@pytest.mark.slow
def test_a_law_of_slip_rate_is_solved_exactly(installed):
    installed(
        packages.brought("oil", "oil", laws=["oil = Oil"], scenes=["oiled = OILED"]),
        {"oil.py": RATE_LAW},
    )
    x = np.linspace(0.05, 1.0, 20)
    scene = sf.find("oiled")
    ours = sf.solve(under(scene, sf.Coulomb(1.0, viscosity=0.01))).slip_rate(x, 1.0)
    np.testing.assert_allclose(sf.solve(scene).slip_rate(x, 1.0), ours, rtol=1e-6)
    covering = sf.solve(under(scene, sys.modules["oil"].Oil(1.0, 0.1)))
    assert "no slip rate that agrees" in covering.status


def test_scenes_of_packages_are_listed_with_them(granite, shown, printed):
    document = printed("scenes")
    (row,) = [row for row in document["scenes"] if row["package"]]
    assert (row["name"], row["package"], row["problem"]) == ("granite", "granite", "")
    assert row["summary"].startswith("Granite that loses a third")
    assert row["scene"]["units"] == "SI"
    brought = {(plugin["what"], plugin["name"]) for plugin in document["brought"]}
    assert ("friction law", "hyperbolic-weakening") in brought
    assert ("figure", "slip") in brought
    assert "From other packages" in shown("scenes").out


def test_names_of_packages_are_among_what_one_could_have_meant(granite, refused):
    assert "did you mean granite?" in refused("solve granit")
    assert "did you mean slip?" in refused("solve stuck --plot a.png --figure slipp")
    document = scene_document(sf.find("granite"))
    document["friction_law"]["kind"] = "else"
    with pytest.raises(sf.SceneError, match="hyperbolic-weakening, got 'else'"):
        scene_from_document(document)


# --- packages that are broken, alike or in the way -----------------------------------------------


def test_names_of_ours_cannot_be_taken(installed, printed):
    installed(
        packages.brought("thief", "thief", scenes=["preloaded = S"], laws=["coulomb = S"]),
        {"thief.py": "raise RuntimeError('imported')"},
    )
    assert sf.find("preloaded").friction == 0.3
    (row,) = [row for row in printed("scenes")["scenes"] if row["package"] == "thief"]
    assert "has one of the same name" in row["problem"]
    assert "thief" not in sys.modules


def test_two_packages_of_one_name_are_refused_by_name(installed, refused):
    for name in ("first", "second"):
        installed(
            packages.brought(name, name, scenes=["mine = S"], figures=["mine = S"]),
            {f"{name}.py": "S = None"},
        )
    for line in ("solve mine", "solve stuck --plot a.png --figure mine"):
        assert "The packages first and second each bring a" in refused(line, 5)
    assert main(["scenes"]) == 0


@pytest.mark.thinned(5)
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import no_such_module", "cannot be imported (ModuleNotFoundError: No module"),
        ("raise SystemExit(7)", "cannot be imported (SystemExit: 7)"),
        ("other = 1", "cannot be imported (AttributeError"),
        ("def S():\n    raise ValueError('a\\nb')", "cannot be made (ValueError: a b)"),
        ("S = 3", "must be a Scene, or a function that returns one, not 3"),
        ("def S():\n    return 3", "must be a Scene, or a function that returns one, not 3"),
        ("def S(x):\n    return 3", "cannot be made (TypeError"),
    ],
)
def test_a_broken_scene_is_one_sentence_that_names_its_package(
    text, reason, installed, refused, printed
):
    installed(packages.brought("broken", "broken", scenes=["mine = S"]), {"broken.py": text})
    sentence = refused("solve mine", 5)
    assert sentence.startswith(f"The scene 'mine' of the package broken {reason}")
    assert main(["solve", "stuck"]) == 0
    assert sentence.startswith(printed("scenes")["scenes"][-1]["problem"])


LAW = """
from dataclasses import dataclass
import slipfront as sf

@dataclass(frozen=True)
class S(sf.Law):
    friction: float
    def strength(self, pressure, speed, state): return self.friction * pressure
    def slip_speed(self, stopping, pressure, impedance, state): return 0 * stopping
"""


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("old", "new", "code", "reason"),
    [
        ("    def strength(self, pressure, speed, state): return", "    #", 5, "lacks strength;"),
        ("speed, state)", "state)", 5, "must take the arguments (pressure, speed, state) in"),
        ("frozen=True", "frozen=False", 5, "must be a dataclass with frozen=True;"),
        ("sf.Law):\n    friction: float", "sf.Coulomb):", 5, "itself, not Coulomb"),
        ("sf.Law", "sf.LoadHistory", 5, "must be a class that inherits Law"),
        ("return 0 * stopping", "return 1 / 0", 5, "failed (ZeroDivisionError: division by zero)"),
        ("self.friction * pressure", "int('x')", 5, "failed (ValueError: invalid literal"),
        ("return self.friction * pressure", "return [0.3]", 2, "must return 3 finite numbers"),
        ("return 0 * stopping", "return (stopping - pressure) / impedance", 2, "V >= 0 at"),
        ("return 0 * stopping", "return float('nan') * stopping", 2, "it returns [nan, nan, nan]"),
    ],
)
def test_what_is_wrong_with_a_law_is_said_at_once(
    old, new, code, reason, installed, tmp_path, shown, refused
):
    assert old in LAW
    text = LAW.replace(old, new)
    installed(packages.brought("lawless", "lawless", laws=["mine = S"]), {"lawless.py": text})
    shown("init scene.toml --all")
    path = tmp_path / "scene.toml"
    path.write_text(path.read_text().replace('"coulomb"', '"mine"', 1))
    sentence = refused(["solve", path], code)
    assert code == 2 or sentence.startswith("The friction law 'mine' of the package lawless ")
    assert reason in sentence


HISTORY = """
from dataclasses import dataclass
import slipfront as sf
from semianalytic.scene.loads import Pieces

@dataclass(frozen=True)
class H(sf.LoadHistory):
    @property
    def pieces(self): return PIECES
    def turn(self, width, until): return 0.0
"""


@pytest.mark.parametrize(
    ("pieces", "code", "reason"),
    [
        ("[1, 2]", 2, "the pieces of the pressure_history must be a Pieces, got [1, 2]"),
        ("Pieces(jumps=((-1.0, 0.5),))", 2, "begin at t = 0 or later, got (-1.0, 0.5)"),
        ("Pieces(kinks=((float('nan'), 0.5),))", 2, "must be finite numbers that begin at t"),
        ("undefined", 5, "The load history 'mine' of the package pushy failed (NameError"),
    ],
)
def test_what_is_wrong_with_a_history_is_said_at_once(
    pieces, code, reason, installed, tmp_path, shown, refused
):
    text = HISTORY.replace("PIECES", pieces)
    installed(packages.brought("pushy", "pushy", histories=["mine = H"]), {"pushy.py": text})
    shown("init scene.toml --all")
    path = tmp_path / "scene.toml"
    path.write_text(path.read_text().replace('"step"', '"mine"'))
    assert reason in refused(["solve", path], code)


def test_a_broken_law_of_another_package_is_no_obstacle(granite, installed):
    installed(packages.brought("aaa", "aaa", laws=["aaa = S"]), {"aaa.py": "import nothing"})
    assert sf.find("granite").friction == granite.HyperbolicWeakening(0.6, 1 / 3, 2e-5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("S = 3", "must be a function of an answer, not 3"),
        ("def S(answer):\n    return 3", "must return a matplotlib Figure, not 3"),
        ("def S(answer):\n    return 1 / 0", "cannot be drawn (ZeroDivisionError"),
    ],
)
def test_a_broken_figure_is_one_sentence_that_names_its_package(
    text, reason, installed, tmp_path, refused
):
    installed(packages.brought("broken", "broken", figures=["mine = S"]), {"broken.py": text})
    path = tmp_path / "a.png"
    sentence = refused(["solve", "stuck", "--plot", path, "--figure", "mine"], 5)
    assert sentence.startswith(f"The figure 'mine' of the package broken {reason}")
    assert not path.exists()


@pytest.mark.slow
def test_nothing_is_looked_up_for_what_is_ours():
    code = (
        "import importlib.metadata as metadata\n"
        "def refuse(**asked): raise AssertionError('looked up')\n"
        "metadata.entry_points = refuse\n"
        "import slipfront as sf\n"
        "sf.solve('ramp', nodes=50)\n"
        "from slipfront.cli.commands import main\n"
        "raise SystemExit(main(['solve', 'preloaded', '--json']))"
    )
    run = packages.run("", "-c", code)
    assert run.returncode == 0, run.stderr
