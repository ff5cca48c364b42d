"""Which mesh a scene gets within a budget, and what that mesh leaves unresolved."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from catalogue import over, solved, under
from compare_cases import SELF_SIMILAR

import fem.budget
from compare import choose_mesh
from compare.comparison import mesh_choice
from compare.comparison.judgement import side_by_side
from compare.comparison.measures import NARROW
from compare.comparison.mesh_choice import (
    DEFAULT_BUDGET,
    SPARE,
    STRIDE,
    USUAL,
    Prices,
    duration,
    toll,
)
from fem import cost, simulate
from fem.budget import machine_pace as measured_pace
from fem.resolution import WEAKENING_ELEMENTS, weakening_caution
from semianalytic import (
    Harmonic,
    Material,
    Pulse,
    RateWeakening,
    Scene,
    SceneError,
    SlipWeakening,
    Tractions,
)
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.finding import find_scene

WEAKENING = Scene(
    Material(1.0, 1.0, 0.25),
    SlipWeakening(1.0, 1 / 3, 0.05).with_coefficient(0.6),
    Tractions(1.0, 0.4),
    Tractions(0.0, 0.4),
)


@pytest.fixture(autouse=True)
def pace(monkeypatch):
    """A machine as fast as `fem.Cost` has it, on which comparing takes no time; called with another
    pace, one of that."""
    monkeypatch.setattr(mesh_choice, "DRAWN", 0.0)
    monkeypatch.setattr(mesh_choice, "JUDGED", 0.0)

    def set_pace(value):
        monkeypatch.setattr(fem.budget, "machine_pace", lambda: value)

    set_pace(1.0)
    return set_pace


def gap_scene(friction):
    """A scene with a gap between two zones of one sense, wider the more friction there is."""
    scene = override_scene(find_scene("preloaded"), friction=friction)
    return solved(scene), scene


def gap_width(solution):
    """Over c_t T."""
    first, second = solution.zones
    return (second.inner - first.outer) / solution.scene.material.shear_speed


NARROWEST = {
    "remote-shock": ("the zone between 0.9789 and 1.0421 c_t", 0.0632430901),
    "lift-off-shear": ("the gap between 0.8916 and 0.9714 c_t", 0.0797166643),
}
"""Named scenes with a part that the usual mesh has fewer than `NARROW` elements for: its name, and
its width over c_t T."""


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", SELF_SIMILAR)
def test_named_scenes_get_the_mesh_that_their_narrowest_part_asks_for(name):
    scene = find_scene(name)
    choice = choose_mesh(solved(scene), scene)
    assert choice.unresolved == ()
    if name in NARROWEST:
        part, width = NARROWEST[name]
        least = math.ceil(NARROW / width)
        assert USUAL < least <= choice.resolution == choice.needed < least + STRIDE
        assert choice.reason == f"for {part}"
    else:
        assert (choice.resolution, choice.needed) == (USUAL, USUAL)
        assert choice.reason == "nothing asks for a finer one"


def gap_name(solution):
    """What the choice calls it."""
    first, second = solution.zones
    return f"the gap between {first.outer:.4f} and {second.inner:.4f} c_t"


@pytest.mark.parametrize("friction", [0.26, 0.25])
def test_a_gap_within_reach_sets_the_mesh(friction):
    solution, scene = gap_scene(friction)
    choice = choose_mesh(solution, scene)
    assert USUAL < choice.resolution == choice.needed
    assert choice.resolution % STRIDE == 0
    assert NARROW <= choice.resolution * gap_width(solution) < NARROW * 1.05
    assert choice.reason == f"for {gap_name(solution)}"
    assert choice.unresolved == ()


def test_a_gap_out_of_reach_is_said_with_what_it_would_take():
    solution, scene = gap_scene(0.25)
    half = choose_mesh(solution, scene, resolution=340).seconds / 2
    for options in ({"budget": half}, {"memory": 200e6}, {"resolution": 200}):
        choice = choose_mesh(solution, scene, **options)
        (gap,) = choice.unresolved
        assert gap.name == gap_name(solution)
        assert choice.resolution < gap.resolution == choice.needed
        assert NARROW <= gap.resolution * gap_width(solution) < NARROW * 1.01
        assert (gap.seconds, gap.memory) > (choice.seconds, choice.memory)
        whole = STRIDE * math.ceil(gap.resolution / STRIDE)
        just = choose_mesh(solution, scene, resolution=whole)
        assert (just.seconds, just.memory) == (gap.seconds, gap.memory)
        assert just.unresolved == ()
        assert gap.meshable


def test_a_gap_that_no_mesh_reaches_does_not_set_it_unasked():
    solution, scene = gap_scene(0.15)
    choice = choose_mesh(solution, scene)
    assert (choice.resolution, choice.reason) == (USUAL, "the usual one")
    (gap,) = choice.unresolved
    assert not gap.meshable
    assert gap.resolution == choice.needed == math.ceil(NARROW / gap_width(solution))
    with pytest.raises(SceneError, match="elements are more than"):
        cost(scene, resolution=gap.resolution)
    coarser = choose_mesh(solution, scene, resolution=gap.resolution // 16)
    assert gap.seconds == pytest.approx(16**3 * coarser.seconds, rel=0.05)
    assert gap.memory == pytest.approx(16**2 * coarser.memory, rel=0.05)


def narrowest_width(solution):
    """Width of the gap or of a zone, whichever is less, over c_t T: at friction 0.3 it is that of
    the second zone."""
    zones = [
        (zone.outer - zone.inner) / solution.scene.material.shear_speed for zone in solution.zones
    ]
    return min(gap_width(solution), *zones)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("friction", [0.15, 0.24, 0.3])
def test_a_budget_is_kept_and_used(friction):
    solution, scene = gap_scene(friction)
    needed = NARROW / narrowest_width(solution)
    usual = choose_mesh(solution, scene, resolution=USUAL).seconds
    budgets = [part * usual for part in (0.4, 0.9, 1.1, 5.0, 20.0)]
    choices = [choose_mesh(solution, scene, budget=budget) for budget in budgets]
    for choice, budget in zip(choices, budgets, strict=True):
        assert choice.seconds <= budget
        assert choice.resolution % STRIDE == 0
        assert choice.resolution < max(USUAL, needed) + STRIDE
        assert bool(choice.unresolved) == (choice.resolution < needed)
        if choice.unresolved or choice.resolution < USUAL:
            finer = choose_mesh(solution, scene, resolution=round(1.2 * choice.resolution))
            assert finer.seconds > budget
            assert choice.reason == "the finest within budget and memory"
    assert all(choice.resolution <= other.resolution for choice, other in pairwise(choices))
    assert choices[0].resolution < choices[-1].resolution


def test_a_slow_machine_gets_a_coarser_mesh_for_its_budget_and_the_same_without(pace):
    solution, scene = gap_scene(0.15)
    quick = [choose_mesh(solution, scene, budget=budget) for budget in (10.0, None)]
    pace(2.0)
    slow = [choose_mesh(solution, scene, budget=budget) for budget in (10.0, None)]
    assert slow[0].resolution < quick[0].resolution
    assert slow[0].seconds <= 10.0
    assert slow[1].resolution == quick[1].resolution
    assert slow[1].seconds == pytest.approx(2 * quick[1].seconds)


def test_snapshots_and_companions_are_paid_for():
    solution, scene = gap_scene(0.3)
    bare = choose_mesh(solution, scene)
    assert bare.seconds == pytest.approx((1 + 1 / 8 + 1 / 64) * cost(scene).seconds)
    pictured = choose_mesh(solution, scene, snapshots=True)
    run = cost(scene, snapshots=True)
    assert pictured.seconds == pytest.approx(run.seconds + bare.seconds - cost(scene).seconds)
    assert pictured.memory == run.memory


@pytest.mark.thinned(2)
@pytest.mark.parametrize("memory", [70e6, 150e6, 400e6])
def test_what_is_chosen_fits_into_the_memory(memory):
    solution, scene = gap_scene(0.15)
    choice = choose_mesh(solution, scene, budget=60.0, memory=memory)
    assert choice.memory <= memory
    assert cost(scene, resolution=choice.resolution, memory=memory).memory == choice.memory
    with pytest.raises(SceneError, match="of memory"):
        cost(scene, resolution=choice.resolution + 20, memory=memory)


def test_some_of_the_memory_that_is_free_now_is_left_alone(monkeypatch):
    solution, scene = gap_scene(0.15)
    usual = cost(scene).memory
    for free, finest in ((1.05, False), (1.2, True)):
        monkeypatch.setattr(
            "semianalytic.results.memory.available_memory", lambda free=free: free * usual / 0.7
        )
        assert (choose_mesh(solution, scene).resolution == USUAL) == finest
    assert SPARE < 1


def test_a_weakening_front_takes_some_elements():
    width = process_zone(WEAKENING)
    for end_time in (1.0, 2.0, 20.0):
        choice = choose_mesh(None, WEAKENING, end_time)
        needed = math.ceil(WEAKENING_ELEMENTS * end_time / width)
        assert (needed <= choice.resolution) == (end_time <= 2.0)
        seen = not weakening_caution(WEAKENING, end_time, choice.resolution)
        assert seen == (end_time <= 2.0)
        assert [gap.resolution for gap in choice.unresolved] == [needed] * (end_time > 2.0)
    assert choice.unresolved[0].name.startswith("the weakening front, 0.0")


def test_coarser_meshes_follow_the_loads_too_if_they_can():
    scene = find_scene("harmonic")
    finest = choose_mesh(None, scene)
    assert finest.reason == "for error bars under the shear history"
    for resolution in (finest.resolution, finest.resolution // 2, finest.resolution // 4):
        cost(scene, resolution=resolution)
    usual = choose_mesh(None, scene, resolution=USUAL).seconds
    middle = choose_mesh(None, scene, budget=1.1 * usual)
    assert USUAL <= middle.resolution < finest.resolution
    assert middle.unresolved == ()
    assert choose_mesh(None, scene, resolution=50).unresolved == ()


def test_loads_set_the_coarsest_mesh():
    scene = under(WEAKENING, find_scene("ramp").law)
    fast = replace(scene, shear_history=Harmonic(4.0))
    choice = choose_mesh(None, fast)
    assert choice.resolution > USUAL
    cost(fast, resolution=choice.resolution)
    with pytest.raises(SceneError, match=r"compare: the coarsest mesh .* raise `budget`"):
        choose_mesh(None, find_scene("harmonic"), budget=0.01)
    hopeless = replace(scene, shear_history=Pulse(1e-6))
    with pytest.raises(SceneError, match=r"turns back faster .* raise `resolution` from 100 to"):
        choose_mesh(None, hopeless)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"budget": -1.0}, "compare: budget must be positive and finite, got -1"),
        ({"budget": math.nan}, "compare: budget must be"),
        ({"budget": "60s"}, "compare: budget must be"),
        ({"budget": 1e-9}, "the coarsest mesh there is to choose, resolution 32, takes"),
        ({"memory": 1e6}, "of memory, and 0.001 GB are allowed"),
        ({"resolution": 4}, "simulate: resolution must be an integer of at least 8"),
        ({"damping": -1.0}, "simulate: damping must lie"),
        ({"mesh": "hexagons"}, "mesh"),
        ({"end_time": 1e300}, "simulate: end_time must lie"),
    ],
)
def test_what_cannot_be_is_refused(options, sentence):
    scene = find_scene("stuck")
    with pytest.raises(SceneError) as caught:
        choose_mesh(None, scene, **options)
    assert sentence in str(caught.value)


@pytest.mark.thinned(30)
@over("exact")
def test_every_exact_scene_gets_a_mesh(problem):
    choice = choose_mesh(solved(problem.scene), problem.scene)
    assert cost(problem.scene, resolution=choice.resolution).memory == choice.memory
    assert choice.seconds <= DEFAULT_BUDGET or choice.resolution <= USUAL
    for unseen in choice.unresolved:
        assert choice.resolution < unseen.resolution <= choice.needed
        assert choice.seconds < unseen.seconds < math.inf


def test_units_of_a_scene_do_not_matter():
    solution, scene = gap_scene(0.24)
    steel = replace(scene, material=Material(80e9, 7800.0, scene.material.poisson_ratio))
    end_time = 1 / steel.material.shear_speed
    budget = choose_mesh(solution, scene, resolution=140).seconds
    chosen = choose_mesh(solved(steel), steel, end_time, budget=budget)
    expected = choose_mesh(solution, scene, budget=budget)
    assert (chosen.resolution, chosen.needed) == (expected.resolution, expected.needed)
    assert chosen.unresolved[0].name == expected.unresolved[0].name


def test_the_remedy_of_a_row_costs_what_the_choice_says(pace):
    pace(3.0)
    solution, scene = gap_scene(0.15)
    run = simulate(scene, resolution=8)
    *_, gap = choose_mesh(solution, scene, resolution=8).unresolved
    remedy = side_by_side(run, run).remedy
    expected = f"it would take `resolution` {gap.resolution}, more than a mesh may have"
    assert remedy(gap.resolution) == gap.advice == expected
    for asked, advised in ((32, "100, the default"), (100, "100, the default"), (118, "120")):
        taken = duration(Prices(scene, None).here(int(advised[:3]))[0])
        expected = f"may be resolved with `resolution` {advised}, in about {taken}"
        assert remedy(asked) == f"{expected} without snapshots"


@pytest.mark.parametrize("snapshots", [False, True])
def test_a_budget_pays_for_the_comparison_too(snapshots, monkeypatch):
    solution, scene = gap_scene(0.15)
    free = choose_mesh(solution, scene, resolution=USUAL, snapshots=snapshots).seconds
    monkeypatch.setattr(mesh_choice, "DRAWN", 3.0)
    monkeypatch.setattr(mesh_choice, "JUDGED", 2.0)
    frames = cost(scene, snapshots=True).seconds - cost(scene).seconds if snapshots else 0.0
    paid = choose_mesh(solution, scene, resolution=USUAL, snapshots=snapshots).seconds
    assert paid == pytest.approx(free + 3.0 + 2 * frames)
    kept = choose_mesh(solution, scene, budget=0.99 * paid, snapshots=snapshots)
    assert kept.resolution < USUAL
    assert kept.seconds <= 0.99 * paid
    # unasked it is the same mesh on every machine, however long drawing takes
    assert choose_mesh(solution, scene, snapshots=snapshots).resolution == USUAL


def test_times_and_sizes_in_words():
    words = {
        **{0.123: "0.12 s", 89: "89 s", 90: "1.5 minutes", 120: "2 minutes", 5399: "90 minutes"},
        **{5400: "1.5 hours", 3e5: "83 hours", 1e6: "12 days", 1e9: "32 years"},
        1e12: "more than 1,000 years",
    }
    assert {seconds: duration(seconds) for seconds in words} == words
    assert toll(216000, 5e11) == "60 hours, 500 GB"
    assert toll(5, 1.234e12) == "5 s, 1,200 GB"


def test_the_pace_of_a_machine_counts_what_others_leave_of_it(monkeypatch):
    """Two products of the usual time, then one that has waited for its core: a mean of 4."""
    waited = 10 * fem.budget.PACE_TIME
    clock = iter([0.0, fem.budget.PACE_TIME, 2 * fem.budget.PACE_TIME, 2.0 + waited])
    with monkeypatch.context() as patch:
        patch.setattr(fem.budget, "PACE_SECONDS", 10 * fem.budget.PACE_TIME)
        patch.setattr(fem.budget.time, "perf_counter", lambda: next(clock))
        mean = (2.0 + waited) / 3 / fem.budget.PACE_TIME
        assert measured_pace.__wrapped__() == pytest.approx(mean)
    assert measured_pace() == measured_pace() > 0


def test_a_scene_without_a_load_gets_the_usual_mesh():
    still = replace(find_scene("stuck"), load=Tractions(0.0, 0.0))
    assert choose_mesh(solved(still), still).resolution == USUAL


@pytest.mark.parametrize(
    ("name", "given", "damping"),
    [("preloaded", {}, 0.02), ("pair-slip", {}, 0.1), ("pair-slip", {"damping": 0.05}, 0.05)],
)
def test_waves_of_a_few_elements_are_damped_where_they_may_grow(name, given, damping):
    scene = find_scene(name)
    assert choose_mesh(None, scene, resolution=40, **given).damping == damping
    falling = replace(find_scene("preloaded"), friction=RateWeakening(0.5, 0.3, 1.0))
    assert choose_mesh(None, falling, resolution=40).damping == 0.1


def test_marches_and_their_fields_are_counted(monkeypatch):
    """25 s of an idle core for `ramp` with snapshots, 9.5 s for `preloaded`."""
    monkeypatch.undo()
    monkeypatch.setattr(fem.budget, "machine_pace", lambda: 1.0)
    for name, seconds in (("ramp", 25.0), ("preloaded", 9.5)):
        choice = choose_mesh(None, find_scene(name), resolution=100, snapshots=True)
        assert seconds / 1.3 < choice.seconds < 1.3 * seconds
