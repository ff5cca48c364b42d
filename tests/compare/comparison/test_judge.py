"""The judge on real simulations and on sampled ones with a known error; its verdicts and units."""

from dataclasses import fields, replace

import pytest
from catalogue import solved
from compare_cases import SELF_SIMILAR, differing, named, sampled_run, simulated
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from compare import judge
from compare.comparison.measures import NARROW
from compare.comparison.rows import ALARM, BEYOND, Row
from compare.comparison.scales import slip_rate_scale
from fem import simulate
from semianalytic import Material, Scene, Tractions
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.named import NAMED_SCENES

PRELOADED = find_scene("preloaded")
STEEL = Scene(
    Material(80e9, 7800.0, 0.29), 0.15, Tractions(5e6, 0.0), Tractions(0.0, 5e6), units="SI"
)
ORDINARY = {
    **{f"f = {f}": override_scene(PRELOADED, friction=f) for f in (0.1, 0.15, 0.5, 1.0, 2.0)},
    **{f"ν = {nu}": override_scene(PRELOADED, poisson_ratio=nu) for nu in (0.29, 0, 0.45, -0.9)},
    "steel": STEEL,
}
"""Scenes that were once judged wrongly."""
THIN = {"f = 0.1", "f = 0.15", "ν = 0.45", "steel"}
"""Ordinary scenes with a gap far narrower than four elements of any mesh."""


def end_time(scene):
    return 1 / scene.material.shear_speed


@pytest.fixture(scope="module")
def fair(solution, coarse):
    return judge(solution, coarse)


# --- what is right agrees -------------------------------------------------------------------


RAYLEIGH = "Rayleigh front, slot face (v_y)"
UNTOLD = {
    "preloaded": {RAYLEIGH: "the meshes do not converge"},
    "viscous": {RAYLEIGH: "the meshes do not converge"},
    "auxetic": {
        RAYLEIGH: "the meshes do not converge",
        "reverse slip, share of nodes and times": "its error bar is more than 0.5",
    },
    "remote-shock": {
        "zone 2, inner edge": "the zone is 0.063 c_t T wide, 6.3 elements",
        "zone 2, outer edge": "the zone is 0.063 c_t T wide, 6.3 elements",
    },
    "lift-off-shear": {
        "zone 1, outer edge": "the gap to the next zone is 0.08 c_t T wide",
        "zone 2, inner edge": "the gap to the next zone is 0.08 c_t T wide",
        "v_y of the slot face, L1": "the meshes do not converge",
        "open, share of nodes and times": "its error bar is more than 0.5",
    },
}
"""Rows that a resolution of 100 leaves unresolved even without any error, and why: parts that are
narrower than 8 elements, fronts too blurred at 4h or sharp between two nodes, and maps whose edges
move by much of what they enclose."""


@pytest.mark.thinned(12)
@pytest.mark.parametrize("name", SELF_SIMILAR)
def test_a_run_without_error_agrees_with_nothing_but_rounding(name):
    solution = solved(NAMED_SCENES[name].scene)
    judgement = judge(solution, sampled_run(solution))
    assert judgement.verdict == "agrees"
    unresolved = {row.name: row.obstacle for row in judgement.having("unresolved")}
    assert unresolved.keys() == UNTOLD.get(name, {}).keys()
    for row, reason in UNTOLD.get(name, {}).items():
        assert unresolved[row].startswith(reason), row
    # Waveforms are aligned through a table of 801 values: a fraction of its spacing is left.
    assert max(abs(row.difference) for row in judgement.rows) < 2e-3


@pytest.mark.thinned(12)
@pytest.mark.parametrize("name", ORDINARY)
def test_ordinary_scenes_agree_and_narrow_gaps_are_unresolved(name):
    scene = ORDINARY[name]
    judgement = judge(solved(scene), simulated(scene, 40, end_time(scene)))
    assert differing(judgement) == []
    assert judgement.verdict == "agrees"
    assert judgement.counts["agrees"] >= 10
    rows = named(judgement)
    if name in THIN:
        edges = rows["zone 1, outer edge"], rows["zone 2, inner edge"]
        gap = (edges[1].exact - edges[0].exact) / NARROW
        for row in edges:
            assert row.verdict == "unresolved"
            assert row.obstacle.startswith("the gap to the next zone is ")
            assert row.resolution == pytest.approx(1 / gap, abs=1)
            assert "`resolution` " in judgement.remedy(row)


def test_a_zone_edge_of_the_simulation_is_what_it_shows():
    """It slips through the gap at f = 0.15: one zone, from the edge to beyond c_t."""
    scene = ORDINARY["f = 0.15"]
    run = simulated(scene, 40)
    (zone,) = [zone for zone in run.zones_at(run.end_time) if zone.end > 0.1]
    rows = named(judge(solved(scene), run))
    outer, inner = rows["zone 1, outer edge"], rows["zone 2, inner edge"]
    assert outer.exact == pytest.approx(0.93226, abs=1e-5)
    assert inner.exact == pytest.approx(0.93279, abs=1e-5)
    # Half an element: the edge is read with another threshold, at several times.
    assert outer.simulated == pytest.approx(zone.end, abs=0.0125)
    assert inner.simulated == zone.start == 0.0
    assert outer.at_nodes > 1.3  # nor do the nodes of this mesh show the gap in the exact answer
    assert "elements" in outer.obstacle


@pytest.mark.parametrize(
    "resolution", [14, *(pytest.param(n, marks=pytest.mark.slow) for n in (8, 11))]
)
def test_without_companions_nothing_agrees_and_nothing_differs(solution, resolution):
    """Not even of a sampled run without any error, or of one with a large one."""
    runs = [sampled_run(solution, resolution, gain=gain, companions=0) for gain in (1.0, 2.0)]
    for run in [*runs, simulate(PRELOADED, resolution=resolution)]:
        judgement = judge(solution, run)
        assert judgement.simulation.companion is None
        assert judgement.verdict == "unresolved"
        assert [name for name in differing(judgement) if "unpredicted" not in name] == []
        for row in judgement.rows:
            # what a simulation has to hold by itself is seen on one mesh
            assert row.verdict != "agrees" or row.kind == "law"
            assert row.kind == "law" or (row.bar is None and row.obstacle)
        reasons = {row.obstacle for row in judgement.rows if row.kind == "slip"}
        assert reasons == {"no coarser mesh shows it, so that it has no error bar"}
    assert any(row.resolution == 2 * resolution for row in judgement.rows)
    assert judge(solution, sampled_run(solution, resolution=16)).counts["agrees"] > 0


# --- three values, and nothing shifted ------------------------------------------------------


def test_a_difference_is_between_what_is_read_off_both(fair):
    for row in fair.rows:
        if row.difference is not None and not row.relative and "largest" not in row.name:
            assert row.difference == pytest.approx(row.simulated - row.at_nodes, abs=1e-15)
        if row.relative:
            # norms: | |a| - |b| | <= |a - b|
            assert abs(row.simulated - row.at_nodes) <= row.difference * row.at_nodes * (1 + 1e-9)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("friction", [0.25, 0.31])
def test_another_prediction_moves_nothing_of_the_simulation(fair, coarse, friction):
    """Fronts are read in windows that depend on it; the part of the map that differs is of both."""
    other = named(judge(solved(override_scene(PRELOADED, friction=friction)), coarse))
    moved = 0
    for name, row in named(fair).items():
        if row.kind in ("arrival", "local") or name == "other sense, share of nodes and times":
            continue
        assert other[name].simulated == row.simulated, name
        assert (other[name].order or 0) == pytest.approx(row.order or 0, rel=1e-9), name
        moved += other[name].at_nodes != row.at_nodes
    assert moved >= 10


def test_bars_come_from_the_simulation():
    """Whatever is predicted; but for what the prediction has that is too narrow for the mesh, and
    here it has one wide zone, narrow only at first."""
    scenes = [override_scene(PRELOADED, friction=friction) for friction in (1.0, 1.02)]
    run = simulated(scenes[0], 40)
    fair, other = (named(judge(solved(scene), run)) for scene in scenes)
    compared = 0
    for name, row in fair.items():
        if row.kind in ("arrival", "local", "sense") or "(x, t)" in name:
            continue  # windows, places and edges in maps depend on the prediction
        scales = (row.at_nodes, other[name].at_nodes) if row.relative else (1.0, 1.0)
        bars = [entry.bar * scale for entry, scale in zip((row, other[name]), scales, strict=True)]
        assert bars[0] == pytest.approx(bars[1], rel=1e-3, abs=1e-5), name
        compared += row.at_nodes != other[name].at_nodes
    assert compared >= 6


# --- units ----------------------------------------------------------------------------------


@pytest.mark.slow
@given(
    friction=st.sampled_from([0.15, 0.3, 1.0]),
    resolution=st.sampled_from([32, 48, 50]),
    modulus=st.floats(1e-3, 1e12),
    density=st.floats(1e-3, 1e5),
    stress=st.floats(1e-3, 1e9),
    time=st.floats(1e-6, 1e6),
)
@example(  # rounding took four nodes from right at the first front
    friction=0.15,
    resolution=32,
    modulus=345189.93357197515,
    density=2618.909489753386,
    stress=0.005718496539732717,
    time=1e5,
)
@example(  # rounding took the first level from the window over which slip rates are averaged
    friction=0.3,
    resolution=32,
    modulus=258084848461.2538,
    density=22417.95000839834,
    stress=335966205.17093617,
    time=0.99999,
)
@example(  # a stored level lies at two thirds of the run, where the record of edges begins
    friction=0.15, resolution=48, modulus=24.99, density=73.16, stress=496.1, time=54.767
)
@example(  # two nodes are equally near to 0.75 c_t T
    friction=0.3, resolution=50, modulus=0.7234, density=0.013, stress=22.96, time=1e4
)
@settings(max_examples=3, deadline=None, phases=(Phase.explicit, Phase.generate))
def test_units_do_not_matter(friction, resolution, modulus, density, stress, time):
    """A run in other units is judged alike, to the digits that rounding leaves."""
    run = simulated(override_scene(PRELOADED, friction=friction), resolution)
    plain = judge(solved(run.scene), run)
    scene = Scene(
        Material(modulus, density, run.scene.material.poisson_ratio),
        friction,
        Tractions(stress, 0.0),
        Tractions(0.0, stress),
    )
    other = judge(solved(scene), rescaled(run, scene, time))
    assert [row.verdict for row in other.rows] == [row.verdict for row in plain.rows]
    for line, row in zip(plain.rows, other.rows, strict=True):
        assert (line.name, line.unit, line.resolution) == (row.name, row.unit, row.resolution)
        # a node at a threshold may fall on either side of it
        least = 1e-3 if line.kind == "sense" else 1e-8
        for field in ("exact", "at_nodes", "simulated", "difference", "bar"):
            value = getattr(line, field)
            expected = None if value is None else pytest.approx(value, rel=1e-6, abs=least)
            assert getattr(row, field) == expected, (line.name, field)


def rescaled(run, scene, time):
    """A run of a scene in units of one, and its companions, as runs of the same in other units."""
    length = time * scene.material.shear_speed
    stress = scene.load.shear
    rate = slip_rate_scale(scene) / slip_rate_scale(run.scene)
    units = {
        **dict.fromkeys(("end_time", "time_step", "rate_window", "t"), time),
        **dict.fromkeys(("element_size", "x"), length),
        **dict.fromkeys(("slip_rate", "velocity_x", "velocity_y"), rate),
        **dict.fromkeys(("slip", "slip_after", "final_path"), rate * time),
        **dict.fromkeys(("shear_traction", "pressure"), stress),
        "final_work_density": stress * rate * time,
    }

    def scaled(left, **others):
        known = {part.name: getattr(left, part.name) for part in fields(left) if part.name in units}
        return replace(
            left, **{name: units[name] * value for name, value in known.items()}, **others
        )

    return scaled(
        run,
        scene=scene,
        interface=scaled(run.interface),
        slot=scaled(run.slot),
        companion=run.companion and rescaled(run.companion, scene, time),
    )


# --- verdicts -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("difference", "bar", "obstacle", "verdict"),
    [
        (0.01, 0.02, "", "agrees"),
        (-0.02, 0.02, "", "agrees"),
        (0.02 * ALARM, 0.02, "", "unresolved"),
        (-0.021 * ALARM, 0.02, "", "differs"),
        (None, 0.02, "", "differs"),
        (0.01, None, "", "unresolved"),
        (1.0, 0.02, "too narrow", "unresolved"),
        (0.0, 0.02, "too narrow", "unresolved"),
    ],
)
def test_verdict_of_a_row(difference, bar, obstacle, verdict):
    row = Row("speed", "arrival", 1.0, 1.0, 1.0, difference, bar, obstacle=obstacle)
    assert row.verdict == verdict


def test_verdict_of_a_judgement(fair):
    row = next(row for row in fair.rows if row.kind == "slip rate")
    front = next(row for row in fair.rows if row.kind == "arrival")
    agrees, differs, unresolved = (
        replace(row, difference=difference, bar=1.0, obstacle=obstacle)
        for difference, obstacle in ((0.0, ""), (9.0, ""), (9.0, "coarse"))
    )
    for rows, verdict in (
        ((agrees, unresolved), "agrees"),
        ((agrees, replace(agrees, difference=1.2, obstacle=BEYOND)), "unresolved"),
        ((agrees, unresolved, differs), "differs"),
        ((unresolved,), "unresolved"),
        ((unresolved, replace(front, obstacle="coarse")), "unresolved"),
        ((unresolved, replace(front, difference=9.0, bar=1.0)), "differs"),
        ((), "unresolved"),
    ):
        judgement = replace(fair, rows=rows)
        assert judgement.verdict == verdict
        assert judgement.counts == {
            given: sum(row.verdict == given for row in rows)
            for given in ("agrees", "differs", "unresolved")
        }
    assert replace(fair, rows=(agrees, differs)).having("differs") == (differs,)


@pytest.mark.slow
def test_beyond_the_bar_by_little_is_unresolved_and_a_finer_mesh_is_named(solution):
    """Between one and `ALARM` bars: neither agreement nor a difference.

    Changes of 3 % and 6 % allow 3.75 % for first order, where 5 % are missing.
    """
    run = None
    for resolution, gain in ((25, 1.14), (50, 1.08), (100, 1.05)):
        alone = sampled_run(solution, resolution=resolution, gain=gain, companions=0)
        run = replace(alone, companion=run)
    rows = [row for row in judge(solution, run).rows if "beyond its error bar" in row.obstacle]
    assert rows
    for row in rows:
        assert row.bar < abs(row.difference) <= ALARM * row.bar
        assert (row.verdict, row.resolution) == ("unresolved", 200)
