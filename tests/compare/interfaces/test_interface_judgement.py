"""Interfaces by both methods: right answers agree, wrong ones differ, and the command says so."""

from dataclasses import replace

import numpy as np
import pytest

import semianalytic as sf
from compare.comparison.interfaces import comparing
from compare.comparison.interfaces.comparing import compare_interface, judge_interface
from compare.comparison.rows import UNLIKE
from docs.studies.lines import scene_along
from docs.studies.trials.wrong_answers import RUNS
from semianalytic.scene.errors import DataFileError, SceneError
from slipfront.cli.commands import main

ROCK, GOUGE = sf.Material(1.0, 1.0, 0.25), sf.Material(0.4, 0.85, 0.25)


def push(x, t):
    return 0.2 * np.clip((0.3 * t - abs(x)) / 0.4 + 0.5, 0, 1)


FAULT = scene_along(
    ROCK,
    sf.Coulomb(0.4),
    12.0,
    shear=0.3,
    loads=[sf.InterfaceLoad(push, history=None)],
    lower_material=GOUGE,
)


@pytest.fixture(scope="module")
def judged():
    return compare_interface(FAULT, 2.0, 256)


def test_different_bodies_agree(judged):
    assert judged.verdict == "agrees"
    rows = {row.kind: row for row in judged.rows}
    fields = {"slip", "slip rate", "shear traction", "pressure"}
    assert set(rows) == fields | {"zone edge", "local", "law"}
    assert rows["slip"].difference < 0.02
    assert rows["slip"].bar < 0.1
    assert rows["pressure"].over_bar < 1
    assert [simulation.nodes for simulation in judged.case.simulations] == [256, 128, 64]
    assert all(abs(simulation.imbalance) < 1e-12 for simulation in judged.case.simulations)


@pytest.mark.parametrize("mistake", ["scaled", "late"])
@pytest.mark.parametrize("number", [1, 2])
def test_a_coarser_run_that_is_wrong_alone_leaves_all_unresolved(judged, number, mistake):
    """A factor or a delay of all slip does not grow with the elements as errors of meshes do."""
    runs = list(judged.case.simulations)
    runs[number] = RUNS[False][mistake](runs[number], 0.05)
    wrong = judge_interface(judged.prediction, runs)
    assert wrong.verdict != "agrees"
    assert any(row.obstacle == UNLIKE for row in wrong.rows)


def run_of(judged, **change):
    """A run like that of a judgement, of another interface."""
    run = judged.prediction
    times = run.interface.t.tolist()
    given = {"end_time": times[-1], "nodes": run.nodes, "times": times}
    return sf.solve(replace(run.scene, **change), **given)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"material": GOUGE, "lower_material": ROCK}, "pressure"),
        ({"friction": 0.44}, "slip"),
        ({"base": sf.Tractions(FAULT.base.pressure, -0.3)}, "slip"),
        ({"lower_material": None}, "slip"),
    ],
)
def test_a_run_of_another_interface_differs(judged, change, kind):
    other = judge_interface(run_of(judged, **change), list(judged.case.simulations))
    assert other.verdict == "differs"
    assert next(row for row in other.rows if row.kind == kind).verdict == "differs"


@pytest.mark.slow
def test_slots_openings_and_halves_agree():
    # some nodes beside the slot of different bodies open, by 2e-4 of the slip, on any grid
    slot, solid = sf.Contact([(-6.0, -1.0), (1.0, 6.0)]), sf.Material(1.0, 1.0, 0.25)
    burst = sf.InterfaceLoad(
        pressure=lambda x, t: -2 * np.exp(-4 * x**2) * min(2 * t, 1), history=None
    )
    pair, slotted, lifted = (
        scene_along(solid, sf.Coulomb(0.3), 12.0, **given)
        for given in (
            {
                "loads": [sf.InterfaceLoad(1.0, on="slot")],
                "contact": slot,
                "lower_material": sf.Material(2.8, 1.1, 0.25),
            },
            {"loads": [sf.InterfaceLoad(0.8, on="slot")], "contact": slot, "even": True},
            {"shear": 0.2, "loads": [burst]},
        )
    )
    judged = compare_interface(pair, 2.0, 512, mesh_nodes=128)
    assert judged.prediction.error_estimates["gap"] > 0.5
    assert judged.prediction.status == "done"
    assert "gap" not in {row.kind for row in judged.rows}
    assert compare_interface(slotted, 1.5).verdict == "agrees"
    judged = compare_interface(lifted, 1.5, 192)
    assert judged.verdict == "agrees"
    assert {row.kind for row in judged.rows if row.verdict == "agrees"} >= {"gap", "slip"}


def test_a_contact_that_opens_beside_a_slot_agrees():
    judged = compare_interface(replace(sf.find("tap"), period=10.0), 1.0, 256)
    assert judged.verdict == "agrees"
    assert {row.kind for row in judged.rows} == {"gap", "pressure", "local", "law"}


def spoilt(first, name, times, everywhere):
    """A simulation with a field wrong at three nodes of four, or at one place and time."""
    values, contact = getattr(first, name).copy(), np.flatnonzero(first.touching)
    if everywhere:
        values[:, np.arange(values.shape[1]) % 4 != 0] *= times
    else:
        level, node = np.unravel_index(np.argmax(np.abs(values[:, contact])), (20, len(contact)))
        values[level, contact[node]] *= times
    return replace(first, **{name: values})


SPOILT = {
    "slip": ("slip", 10),
    "slip rate": ("slip_rate", 10),
    "shear traction": ("shear_traction", 2),
    "pressure": ("pressure", 0.5),
}


def changed(run, **fields):
    """A run with other fields."""
    return replace(run, interface=replace(run.interface, **fields))


@pytest.mark.parametrize("everywhere", [False, True])
@pytest.mark.parametrize("what", SPOILT)
def test_no_node_of_the_finest_mesh_is_left_out(judged, everywhere, what):
    finest, *coarser = judged.case.simulations
    runs = [spoilt(finest, *SPOILT[what], everywhere), *coarser]
    wrong = judge_interface(judged.prediction, runs)
    assert wrong.verdict == "differs"


def test_stored_strength_is_that_of_the_law_and_carried_where_the_contact_slides(judged):
    """At one node and time of those that slide."""
    finest, *coarser = judged.case.simulations
    slides = np.isclose(finest.strength, np.abs(finest.shear_traction), rtol=1e-12)
    fast = np.where(slides & finest.touching, np.abs(finest.slip_rate), 0.0)
    place = np.unravel_index(np.argmax(fast), fast.shape)
    for field, times, row in (
        ("pressure", 10, "strength against pressure"),
        ("shear_traction", 0.5, "traction below friction"),
        ("shear_traction", 2, "traction beyond friction"),
    ):
        values = getattr(finest, field).copy()
        values[place] *= times
        wrong = judge_interface(judged.prediction, [replace(finest, **{field: values}), *coarser])
        assert row in [row.name for row in wrong.having("differs")]


def test_stored_slip_rates_are_those_of_the_stored_slip(judged):
    """Wrong on all meshes alike, and in the run: no comparison shows it, but slip does."""
    scaled = [replace(run, slip_rate=1.01 * run.slip_rate) for run in judged.case.simulations]
    run = changed(judged.prediction, slip_rate=1.01 * judged.prediction.interface.slip_rate)
    wrong = judge_interface(run, scaled)
    assert [row.name for row in wrong.having("differs")] == ["slip rate against slip"]


@pytest.mark.parametrize("field", ["slip", "slip_rate", "shear_traction", "pressure", "gap"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_that_are_not_finite_are_refused(judged, field, value):
    finest, *coarser = judged.case.simulations
    every = np.full_like(finest.slip, value)
    values = getattr(finest, field).copy()
    values[3, 5] = value
    for spoilt in (every, values):
        with pytest.raises(DataFileError, match=r"256 nodes has .* not a finite number"):
            judge_interface(judged.prediction, [replace(finest, **{field: spoilt}), *coarser])
    everywhere = [
        replace(entry, **{field: np.full_like(entry.slip, value)}) for entry in (finest, *coarser)
    ]
    with pytest.raises(DataFileError, match="not a finite number"):
        judge_interface(judged.prediction, everywhere)
    with pytest.raises(DataFileError, match="the run has"):
        judge_interface(changed(judged.prediction, **{field: every}), list(judged.case.simulations))


@pytest.mark.parametrize("contact", [None, sf.Contact([(-2.0, 1.5)])])
def test_contacts_that_stick_are_decided_by_their_tractions(contact):
    load = sf.InterfaceLoad(lambda x: 0.3 * np.exp(-(x**2) / 0.3))
    where = {} if contact is None else {"contact": contact}
    face = scene_along(ROCK, sf.Coulomb(0.9), 10.0, shear=0.05, loads=[load], **where)
    judged = compare_interface(face, 1.0, mesh_nodes=None if contact else 128)
    assert judged.prediction.status == "done"
    assert judged.verdict == "agrees"
    assert {row.kind for row in judged.rows} == {"shear traction", "local", "law"}
    wrong = run_of(judged, base=sf.Tractions(1.0, 0.06))
    other = changed(judged.prediction, shear_traction=wrong.interface.shear_traction)
    coarse = replace(wrong.companion, scene=face)
    shown = judge_interface(replace(other, companion=coarse), list(judged.case.simulations))
    assert shown.verdict == "differs"


def test_rate_and_state_friction_agrees():
    law = sf.RateAndState(a=0.02, b=0.03, f0=0.6, v0=1e-3, distance=0.2)
    load = sf.InterfaceLoad(lambda x: 0.5 * np.exp(-(x**2)), history=lambda t: min(t, 1.0))
    fault = scene_along(ROCK, law, 12.0, shear=0.55, rate=1e-6, loads=[load])
    judged = compare_interface(fault, 2.0, 128)
    assert {row.verdict for row in judged.rows} == {"agrees"}
    assert judged.rows[0].difference < 0.02
    wrong = run_of(judged, friction=replace(law, evolution="slip"))
    assert judge_interface(wrong, list(judged.case.simulations)).verdict == "differs"


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        ({}, {"mesh_nodes": 100}, "mesh_nodes must be a multiple of 4 that divides"),
        ({"friction": 0.9}, {}, "between these bodies is ill-posed"),
        ({"held": 3.0}, {}, "no stiffness for the mean slip"),
    ],
)
def test_what_cannot_be_compared_is_refused(change, options, words):
    with pytest.raises(SceneError, match=words):
        compare_interface(replace(FAULT, **change), 2.0, 256, **options)


COMMON = ["compare", "rock-on-gouge", "--nodes", "256", "--end-time", "1e-3", "--quiet"]


def test_the_command_compares(judged, capsys, printed, monkeypatch):
    def compared(interface, end_time, *, nodes, mesh_nodes, **_):
        assert interface.lower_material != interface.material
        assert (end_time, nodes, mesh_nodes) == (1e-3, 256, 256)
        return judged

    monkeypatch.setattr(comparing, "compare_interface", compared)
    assert main([*COMMON, "--mesh-nodes", "256"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "Verdict: agrees" in shown
    assert "finite elements of 256 nodes along the interface" in shown
    document = printed([*COMMON, "--mesh-nodes", "256"])
    assert document["status"] == "agrees"
    assert [mesh["nodes"] for mesh in document["comparison"]["meshes"]] == [256, 128, 64]
    assert {row["kind"] for row in document["comparison"]["rows"]} >= {"slip", "pressure"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--resolution", "128"], "is for scenes with a slot; rock-on-gouge takes"),
        (["--from", "a"], "is for scenes with a slot; rock-on-gouge takes"),
        (["--mesh-nodes", "100"], "--mesh-nodes must be a multiple of 4"),
    ],
)
def test_options_without_effect_are_refused(options, said, refused):
    assert said in refused([*COMMON, *options])


def test_a_difference_ends_with_1(monkeypatch, capsys):
    honest = comparing.line_of
    monkeypatch.setattr(
        comparing,
        "line_of",
        lambda finest, *grid: honest(replace(finest, friction=sf.Coulomb(0.3)), *grid),
    )
    assert main([*COMMON, "--mesh-nodes", "128"]) == 1
    assert "Verdict: differs" in " ".join(capsys.readouterr().out.split())


def test_an_interface_on_which_nothing_happens_agrees(tmp_path, capsys):
    path = tmp_path / "quiet.toml"
    path.write_text(
        "period = 16.0\ncontact = 'whole line'\nfriction = 0.3\n"
        "[material]\nshear_modulus = 1.0\ndensity = 1.0\npoisson_ratio = 0.25\n"
        "[base]\npressure = 1.0\nshear = 0.1\n[run]\nend_time = 0.5\nnodes = 64\n"
    )
    main(["compare", str(path), "--mesh-nodes", "64", "--quiet"])
    shown = " ".join(capsys.readouterr().out.split())
    assert shown.startswith("Verdict: agrees (rows: 4 agree).")
    assert "Nothing slips or opens in either answer, and no traction changes." in shown
