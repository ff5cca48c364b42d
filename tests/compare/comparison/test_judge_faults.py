"""Scenes that were judged wrongly, and simulations at fault: what the judge says of both."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from catalogue import solved, under
from compare_cases import differing, named, simulated

from compare import judge
from compare.comparison.case import Case
from compare.comparison.fields.fronts import jump_times
from compare.comparison.judging import FEW
from compare.comparison.measures import NOTHING
from compare.comparison.prediction import planned, predict_like
from compare.comparison.quantities.arrival_rows import arrival_rows
from compare.comparison.quantities.local_rows import _beside_motion
from compare.comparison.quantities.own_rows import own_rows
from compare.comparison.rows import AWAY, REST
from docs.studies.trials.wrong_answers import FAULTS, RUNS
from fem import simulate, with_companions
from semianalytic import Coulomb, IncidentWave, Material, RateWeakening, Scene, Tabulated, Tractions
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.finding import find_scene

ROCK = Material(1.0, 1.0, 0.25)
PRELOADED, SHOCK = find_scene("preloaded"), find_scene("remote-shock")


def judged(scene, resolution=None):
    """The judgement on the mesh that `slipfront compare` chooses, or on another."""
    prediction, choice = planned(scene, snapshots=True, resolution=resolution)
    run = simulated(scene, choice.resolution, 1 / scene.material.shear_speed)
    return judge(prediction or predict_like(run), run)


@pytest.mark.parametrize("mistake", ["scaled", "late"])
@pytest.mark.parametrize("number", [1, 2])
def test_coarser_runs_are_the_run_itself_until_parts_of_its_end(number, mistake):
    """A run that is wrong by 0.1 % agrees with nothing, whatever its bars."""
    run = simulated(PRELOADED, 40)
    assert judge(solved(PRELOADED), run).verdict == "agrees"
    runs = [run, run.companion, run.companion.companion]
    runs[number] = RUNS[True][mistake](runs[number], 1e-3)
    wrong = replace(run, companion=replace(runs[1], companion=runs[2]))
    assert judge(solved(PRELOADED), wrong).verdict == "unresolved"


def test_slip_in_a_zone_of_an_element_is_unresolved():
    """A film lets 1.2 elements slip at the edge, where the nodes show one or two that do."""
    film, load = Coulomb(1.32874, viscosity=0.61624), Tractions(1.73746, 1.70107)
    scene = Scene(Material(1.0, 1.0, 1 / 3), film, Tractions(1.0, 0.0), load)
    judgement = judged(scene, 100)
    assert (judgement.verdict, differing(judgement)) == ("unresolved", [])


def test_places_where_slip_has_stopped_are_left_out():
    """Slip until x = 0.5 ends everywhere at t = 0.5; tractions keep a kink at its edge."""
    x = t = np.linspace(0.0, 1.0, 101)
    slips, none = ((x < 0.5) & (t[:, None] < 0.5)).astype(float), np.zeros((101, 101))
    run = SimpleNamespace(interface=InterfaceHistory(x, t, none, slips, none, none, none))
    run.element_size = 0.01
    given = {"seen": run.interface, "at_nodes": run.interface, "runs": (run, run, run)}
    units = {"simulation": run, "shear_speed": 1.0, "rate": 1.0, "end_time": 1.0}
    moving = _beside_motion(SimpleNamespace(**given, **units))
    assert moving[[20, 90, 90], [50, 50, 20]].tolist() == [True, True, False]


@pytest.mark.slow
def test_edges_of_a_gap_that_coarser_meshes_bridge_are_unresolved():
    judgement = judged(override_scene(PRELOADED, friction=0.25))
    assert judgement.verdict == "agrees"
    for edge in ("zone 1, outer edge", "zone 2, inner edge"):
        row = named(judgement)[edge]
        assert row.obstacle.startswith("the gap to the next zone is 0.024 c_t T wide")
        assert row.resolution > 300


class TestSlipThatIsLittleOfWhatDrivesIt:
    """Slip is what is left of a load that strength nearly bears: errors of strength drive it."""

    SCENE = Scene(Material(1, 1, 0.27), 0.219, Tractions(0.1, 0), Tractions(1.0, 0.124))

    @pytest.mark.parametrize("resolution", [60, pytest.param(100, marks=pytest.mark.slow)])
    def test_it_agrees(self, resolution):
        assert differing(judged(self.SCENE, resolution)) == []

    @pytest.mark.slow
    def test_a_third_more_slip_differs(self):
        other = judge(solved(replace(self.SCENE, friction=0.2)), simulated(self.SCENE, 100))
        assert other.verdict == "differs"


def test_slip_on_too_few_nodes_to_tell_its_rate_is_left_to_tractions():
    """A zone of eight elements beside the edge, of which four are left out: its slip rate has no
    bar, which does not keep tractions and its edge from agreeing."""
    wave = IncidentWave("SH", -66.0, stress=-0.166, from_="above")
    scene = Scene(ROCK, 0.4, Tractions(1.0, 0.0), wave, mode="antiplane")
    judgement = judged(scene, 540)
    assert judgement.verdict == "agrees"
    assert judgement.basis == REST
    assert judgement.quoted.startswith("shear traction")
    assert named(judgement)["slip rate over (x, t), L1"].obstacle == FEW


class TestOpeningsThatNoMeshShows:
    """An opening of four elements: nothing that depends on it is said to differ.

    The map over x and t leaves out the elements next to the edge, in which it lies.
    """

    SCENE = Scene(Material(1, 1, 0.25), 0.3, Tractions(1, 0), Tractions(-0.45, 0))

    def test_it_is_unresolved(self):
        judgement = judged(self.SCENE, 60)
        assert judgement.verdict == "unresolved"
        assert differing(judgement) == []
        rows = named(judgement)
        for name in ("gap, L1", "opening 1, outer edge"):
            assert rows[name].verdict == "unresolved", name
            assert rows[name].resolution > 60


def own(run):
    """Rows of what a simulation has to hold by itself."""
    return {row.name: row for row in own_rows(Case(run, run, run.interface, None))}


def spoilt(run, field, factor=1.0, at=..., more=0.0):
    """A simulation with a field of its record changed, everywhere or at some levels and nodes."""
    values = getattr(run.interface, field).copy()
    values[at] = factor * values[at] + more
    return replace(run, interface=replace(run.interface, **{field: values}))


class TestTractionsBeforeTheWaves:
    """At t = 0 the contact carries the base, and a load that has come everywhere at once."""

    NAME = "traction before the waves"

    @pytest.mark.thinned(3)
    @pytest.mark.parametrize(
        "name", ["tap", "remote-shock", "incident-sv", "moving-load", "antiplane", "ramp"]
    )
    def test_a_simulation_begins_with_them_and_a_factor_on_them_is_caught(self, name):
        run = simulate(find_scene(name), resolution=24)
        right, wrong = (own(answer)[self.NAME] for answer in (run, spoilt(run, "pressure", 1.02)))
        assert (right.verdict, right.difference) == ("agrees", 0.0)
        assert wrong.verdict == "differs"

    @pytest.mark.parametrize("friction", [0.0, 0.24])
    def test_a_sudden_load_that_friction_does_not_hold_slips_by_then(self, friction):
        load = Tractions(1.0, -0.79)
        scene = Scene(Material(1, 1, 0.25), friction, Tractions(0, 0), load, load_on="remote")
        run = simulate(scene, resolution=24)
        assert np.abs(run.interface.shear_traction[0] + 0.79).max() > 0.5
        assert next(iter(own(run))) == self.NAME
        assert own(run)[self.NAME].verdict == "agrees"

    def test_a_pulse_at_an_angle_is_on_the_contact_by_then(self):
        run = simulate(find_scene("incident-pulse"), resolution=24)
        assert list(own(run)) == ["traction beyond friction", "slip rate against slip"]


class TestLevelsThatAreStoredFarApart:
    """Between stored levels slip comes and goes: neither slip rates nor strength are condemned."""

    @pytest.mark.thinned(5)
    @pytest.mark.parametrize("every", [2, 3, 10, 30])
    @pytest.mark.parametrize("name", ["viscous", "pressure-drop", "auxetic", "antiplane"])
    def test_what_is_right_holds_the_laws(self, name, every):
        run = simulate(find_scene(name), resolution=24, every=every)
        rows = own(run)
        assert [row.name for row in rows.values() if row.verdict == "differs"] == []
        strength = rows["traction beyond friction"]
        if name == "viscous":  # which depends on the rate of each step
            assert strength.verdict == "unresolved"
            assert strength.obstacle.startswith("only some steps of the simulation are stored")
        else:
            assert strength.verdict == "agrees"

    def test_windows_whose_ends_are_stored_are_held_to_the_last_digit(self):
        """Every third step of windows of six."""
        run = simulate(PRELOADED, resolution=32, every=3)
        assert run.rate_window == pytest.approx(6 * run.time_step)
        row = own(run)["slip rate against slip"]
        assert (row.verdict, row.bar) == ("agrees", NOTHING)
        assert row.difference < 1e-12
        wrong = spoilt(run, "slip_rate", at=(len(run.interface.t) // 2, 3), more=1e-5)
        assert own(wrong)["slip rate against slip"].verdict == "differs"

    def test_the_sum_of_all_slip_rates_catches_slip_that_came_of_none(self):
        run = simulate(PRELOADED, resolution=32, every=2)
        row = own(run)["slip rate against slip"]
        assert (row.verdict, row.difference) == ("agrees", pytest.approx(0, abs=row.bar))
        wrong = spoilt(run, "slip", 2.0, at=np.s_[:, 10])
        assert own(wrong)["slip rate against slip"].verdict == "differs"

    @pytest.mark.slow
    @pytest.mark.parametrize("every", [2, 3, 5, 10])
    @pytest.mark.parametrize("name", ["preloaded", "viscous"])
    def test_faults_are_caught_all_the_same(self, name, every):
        scene = find_scene(name)
        run, right = with_companions(simulate(scene, resolution=40, every=every)), solved(scene)
        assert judge(right, run).verdict == "agrees"
        faults = {fault: make(run) for fault, make in FAULTS.items()}
        assert judge(right, faults["slip × 1.05"]).verdict != "agrees"
        for fault in ("shear reversed", "node × 10, slip", "node × 10, shear"):
            assert judge(right, faults[fault]).verdict == "differs", fault

    def test_a_front_that_no_level_shows_is_unresolved(self):
        """At the first level that is stored the P wave has left the record."""
        scene = find_scene("pressure-drop")
        run = simulate(scene, resolution=16, every=40)
        rows = arrival_rows(Case(solved(scene), run, run.interface, None))
        fronts = [row for row in rows if row.name.startswith("P front")]
        assert fronts
        for row in fronts:
            assert row.verdict == "unresolved"
            assert row.obstacle.endswith("store all of them")


class TestSimulationsAtFault:
    """A fault in the finest run does not agree with anything, whatever bars it makes."""

    @pytest.mark.thinned(12)
    @pytest.mark.parametrize("fault", [name for name in FAULTS if name != "not a number"])
    def test_it_differs(self, solution, coarse, fault):
        assert judge(solution, FAULTS[fault](coarse)).verdict == "differs"

    @pytest.mark.slow
    def test_a_pressure_that_no_coarser_mesh_has_does_not_agree_where_nothing_slips(self):
        right, run = solved(find_scene("tap")), simulated(find_scene("tap"), 100)
        assert judge(right, run).verdict == "agrees"
        # at t = 0 already, and from the second level on
        assert judge(right, spoilt(run, "pressure", 1.02)).verdict == "differs"
        assert judge(right, spoilt(run, "pressure", 1.02, at=np.s_[1:])).verdict == "unresolved"

    @pytest.mark.parametrize("field", ["slip", "slip_rate", "shear_traction", "pressure", "gap"])
    def test_what_is_not_finite_is_refused(self, solution, coarse, field):
        with pytest.raises(DataFileError, match=f"has a {field.replace('_', ' ')} that is not"):
            judge(solution, spoilt(coarse, field, np.nan, at=(3, 5)))

    @pytest.mark.parametrize("level", [10, -20, -3, -2, -1])
    def test_a_stored_slip_rate_is_that_of_the_slip_at_every_level(self, solution, coarse, level):
        """Also at the last ones, whose windows end after the end of the run."""
        node = int(np.argmax(np.abs(coarse.interface.slip_rate[level])))
        wrong = spoilt(coarse, "slip_rate", 1.01, at=(level, node))
        assert "slip rate against slip" in differing(judge(solution, wrong))

    @pytest.mark.slow
    @pytest.mark.parametrize("more", [0.97, 1.02, 1.05])
    @pytest.mark.parametrize("name", ["viscous", "preloaded", "remote-shock", "antiplane"])
    def test_a_finest_run_of_another_load_does_not_agree(self, name, more):
        """It widens its own bars, so that it is within some of them."""
        film = under(PRELOADED, Coulomb(1.0, viscosity=0.2))
        scene = film if name == "viscous" else find_scene(name)
        pressure, shear = scene.load.pressure, scene.load.shear
        other = replace(scene, load=Tractions(more * pressure, more * shear))
        right = simulated(scene, 60)
        wrong = replace(simulate(other, resolution=60), scene=scene, companion=right.companion)
        assert judge(solved(scene), right).verdict == "agrees"
        assert judge(solved(scene), wrong).verdict != "agrees"

    def test_so_is_a_companion(self, solution, coarse):
        values = np.full_like(coarse.companion.final_path, np.inf)
        wrong = replace(coarse, companion=replace(coarse.companion, final_path=values))
        with pytest.raises(DataFileError, match="resolution 30 has a final path"):
            judge(solution, wrong)

    @pytest.mark.slow
    @pytest.mark.parametrize("field", ["slip", "slip_rate", "shear_traction", "pressure"])
    def test_any_field_of_one_node_counts_wherever_it_is(self, solution, coarse, field):
        """A tenth more at one node and time that nothing else happens at."""
        for place in (0.15, 0.25):
            node = int(np.argmin(np.abs(coarse.interface.x - place)))
            at = 2 * len(coarse.interface.t) // 3, node
            assert judge(solution, spoilt(coarse, field, 1.1, at)).verdict == "differs", place


class TestMeshesThatDoNotTellTheirErrors:
    """Right scenes that were said to differ: agreed, or unresolved with the reason."""

    FLANKS = (
        ((0.0, 0.005, 0.4, 0.405, 1.0), (0.0, 1.0, 1.0, 0.0, 0.0)),
        ((0.0, 0.089219, 0.37116, 0.37491), (0.0, 0.74062, 0.05626, -0.87007)),
    )

    @pytest.mark.parametrize("flanks", [FLANKS[0], pytest.param(FLANKS[1], marks=pytest.mark.slow)])
    def test_flanks_of_a_load_within_an_element_are_fronts(self, flanks):
        scene = replace(PRELOADED, shear_history=Tabulated(*flanks))
        assert differing(judged(scene, 60)) == []

    def test_so_are_those_of_no_finely_tabulated_load(self):
        t = np.linspace(0, 1, 401)
        smooth = replace(PRELOADED, shear_history=Tabulated(t, np.sin(3 * t)))
        assert jump_times(smooth, 0.1) == ()
        steep = replace(PRELOADED, shear_history=Tabulated((0, 0.4, 0.41), (0.0, 0.2, 1.0)))
        assert jump_times(steep, 0.1) == (0.4, 0.41)

    WEAKENING = Scene(
        Material(1.0, 1.0, -0.1399),
        RateWeakening(0.71814, 0.4763494434, 2.4376),
        Tractions(1.3057, 0.70224),
        Tractions(0.0, 1.7844),
    )

    @pytest.mark.parametrize("law", ["falls", "is constant"])
    def test_short_waves_that_grow_are_named(self, law):
        """Only where friction falls with slip rate, or bodies are different."""
        scene = self.WEAKENING
        if law == "is constant":
            scene = under(scene, Coulomb(1.0))
        case = judged(scene, 100).case
        rough = case.seen.slip_rate + 0.1 * case.rate * (-1.0) ** np.arange(len(case.seen.x))
        wrong = replace(case.simulation, interface=replace(case.seen, slip_rate=rough))
        amplified = replace(case, simulation=wrong).amplified
        assert ("waves of a few elements grow" in amplified) == (law == "falls")
        assert differing(judged(scene, 100)) == []


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_finest_run_under_another_load_never_agrees(share):
    """The fault widens its own bar, from 4 to 16 % of slip rate under 2 % too much load: what the
    coarser meshes do not let expect is not known to be right."""
    film = Coulomb(0.85398, viscosity=0.19451)
    base, load = Tractions(1.1658, -0.16276), Tractions(0.0, -0.67647)
    scene = Scene(Material(0.36468, 1.0, -0.433), film, base, load)
    right = judged(scene)
    assert right.verdict == "agrees"
    other = replace(scene, load=Tractions(0.0, share * load.shear))
    wrong = simulate(other, resolution=right.simulation.resolution)
    wrong = replace(wrong, scene=scene, companion=right.simulation.companion)
    shown = judge(right.prediction, wrong)
    assert shown.verdict != "agrees"
    assert shown.having("differs") or any(row.obstacle.startswith(AWAY) for row in shown.rows)


PULSE = Tabulated(t=(0.0, 0.005, 0.4, 0.405, 1.0), value_at_t=(0.0, 1.0, 1.0, 0.0, 0.0))
DRAWN = Tabulated(t=(0.0, 0.089219, 0.37116, 0.37491), value_at_t=(0.0, 0.74062, 0.05626, -0.87007))


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [
        Scene(ROCK, 0.1, Tractions(1.0, 0.0), Tractions(0.0, 1.0), shear_history=PULSE),
        Scene(
            Material(1.707, 1.0, 0.35239),
            0.26903,
            Tractions(0.10748, -0.02518),
            Tractions(0.0, -0.70029),
            shear_history=DRAWN,
        ),
    ],
    ids=["pulse", "drawn"],
)
def test_loads_with_flanks_of_half_an_element_agree(scene):
    assert judged(scene).verdict == "agrees"
