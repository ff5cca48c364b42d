"""What must hold whatever the numbers: edge, elements, opening, other materials, real loading."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from catalogue import PRELOADED, UNIT
from catalogue import SHOCK as REMOTE

import fem.model
import semianalytic as sf
from fem import simulate
from fem.elements.assembly import Space, tributary_length
from fem.interface import Joint, KickTractions
from fem.march import face_pair
from fem.model import build_model
from fem.plan import TWO_BLOCKS, Plan
from fem.settings import Settings
from meshes import Blocks, mesh_of
from tests.fem.runs import UNLOADED, l1


@cache
def exact(scene):
    return sf.solve(scene, rtol=1e-8)


def slip_rate_error(scene, history):
    """Relative L1 error at the final time over 0.02 < x / (c_t T) < 1.9."""
    shown = (history.x > 0.02) & (history.x < 1.9)
    expected = exact(scene).slip_rate(history.x[shown], history.t[-1])
    return l1(history.slip_rate[-1, shown], expected)


# --- the edge node ----------------------------------------------------------------------------


def edge_errors(resolutions):
    return [
        slip_rate_error(PRELOADED, simulate(PRELOADED, resolution=n, every=10**6).interface)
        for n in resolutions
    ]


def edge_belongs_to(side):
    """Tributary lengths that give the whole edge node to the slot or to the contact."""

    def lengths(space, name):
        nodes, length = tributary_length(space, name)
        edge = space.points[0, nodes] == 0
        # almost nothing: a contact node without any length would have no traction at all
        return nodes, np.where(edge, length * (2.0 if name.endswith(side) else 1e-9), length)

    return lengths


@pytest.mark.slow
def test_split_edge_node_is_several_times_better_than_a_whole_one(monkeypatch):
    split = edge_errors((50, 100))
    for side in ("slot", "contact"):
        monkeypatch.setattr(fem.model, "tributary_length", edge_belongs_to(side))
        whole = edge_errors((50, 100))
        print(side, split, whole)
        assert whole[0] > 2 * split[0]
        assert whole[1] > 3 * split[1]
        # it falls with h, as of an edge half an element off, while the split one falls faster
        assert whole[0] / whole[1] < split[0] / split[1]


def test_welded_edge_node_never_converges(monkeypatch):
    def welded(self, *stopped):
        held = strength(self, *stopped)
        held[0] = np.inf
        return held

    strength = Joint._strength
    monkeypatch.setattr(Joint, "_strength", welded)
    errors = edge_errors((25, 50))
    print(errors)
    assert min(errors) > 0.2
    assert errors[1] > 0.75 * errors[0]


# --- elements ---------------------------------------------------------------------------------


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    "mesh",
    # measured: 2.3e-3 and 1.9e-3
    ["squares", pytest.param("triangles", marks=[pytest.mark.slow, pytest.mark.gmsh])],
)
def test_every_element_agrees_with_the_exact_solution(mesh):
    run = simulate(PRELOADED, mesh=mesh)
    assert slip_rate_error(PRELOADED, run.interface) < 3e-3
    assert run.energy.residual < 1e-13
    increment = np.diff(run.interface.slip, axis=0)
    assert (increment * run.interface.shear_traction[:-1]).min() > -1e-13


# --- opening and closing ----------------------------------------------------------------------


def test_gap_converges_to_the_exact_one_with_second_order():
    """It opens from the edge at a constant speed, and no node that has opened closes again."""
    exact, errors = sf.solve(UNLOADED), []
    marched, x = sf.solve(UNLOADED, method="space-time", nodes=100), np.linspace(0.05, 1.0, 20)
    known = exact.gap(x, 1.0)
    assert np.abs(marched.gap(x, 1.0) - known).sum() < 0.02 * known.sum()
    for resolution in (40, 80):
        run = simulate(UNLOADED, resolution=resolution)
        history = run.interface
        expected = exact.gap(history.x, history.t[-1])
        errors.append(l1(history.gap[-1], expected))
    assert errors[0] < 5e-3
    assert errors[1] < 0.35 * errors[0]
    opened, speed = run.state == 2, exact.openings[0].outer
    tips = np.array([history.x[row].max(initial=0) for row in opened])
    assert np.abs(tips - speed * history.t)[history.t > 0.5].max() < 1.5 * run.element_size
    assert (np.diff(opened.astype(int), axis=0) >= 0).all()
    assert (np.diff(opened[-1].astype(int)) <= 0).all()
    assert (history.shear_traction[opened] == 0).all()


# --- two materials ----------------------------------------------------------------------------


def test_equal_lower_material_changes_nothing_but_the_walls():
    same = simulate(replace(REMOTE, lower_material=UNIT), resolution=24)
    assert same.model == TWO_BLOCKS
    almost = sf.Material(1.0 + 1e-9, 1.0, 1 / 3)
    run = simulate(replace(REMOTE, lower_material=almost), resolution=24)
    assert run.model == "two blocks of different materials"
    assert run.scene.lower_material == almost
    for name in ("slip_rate", "shear_traction", "pressure"):
        first, other = getattr(same.interface, name), getattr(run.interface, name)
        # the moduli differ by 1e-9; forerunners from the free walls stay below 1e-7
        np.testing.assert_allclose(first, other[:, : first.shape[1]], atol=2e-7, err_msg=name)


def test_slip_between_different_materials_changes_the_pressure():
    soft = sf.Material(0.25, 1.0, 1 / 3)
    run = simulate(replace(PRELOADED, lower_material=soft), resolution=40)
    assert np.abs(run.interface.pressure[-1] - 1).max() > 0.1
    assert run.energy.residual < 1e-13
    assert np.diff(run.energy.friction, prepend=0).min() >= -1e-15
    strength = 0.3 * run.interface.pressure
    assert (np.abs(run.interface.shear_traction) <= strength * (1 + 1e-14)).all()
    # the same interface seen from below: the soft body on top, and shear the other way
    turned = simulate(
        sf.Scene(soft, 0.3, sf.Tractions(1.0, 0.0), sf.Tractions(0.0, -1.0), lower_material=UNIT),
        end_time=1.0,
        resolution=20,  # h = c_t T / resolution, c_t of the upper block
        damping=0.01,
    )
    assert turned.element_size == run.element_size
    reach = min(len(run.interface.x), len(turned.interface.x))
    first, other = (s.interface.pressure[-1, :reach] for s in (run, turned))
    assert np.abs(first - other).max() < 0.02 * np.abs(first - 1).max()


def test_different_materials_cannot_slide_everywhere():
    scene = replace(REMOTE, friction=0.5)
    with pytest.raises(sf.SceneError, match="different materials"):
        simulate(replace(scene, lower_material=sf.Material(2.0, 1.0, 1 / 3)))


# --- loading from afar ------------------------------------------------------------------------


def remotely_loaded(resolution):
    """Slip rate after plane waves from the far side of the blocks meet the unloaded interface.

    The blocks carry tractions on their far sides, switched on so early that the plane P wave and
    the plane S wave arrive together; nothing acts on the slot or on the interface beforehand.  Each
    side sends half the load, and both halves meet at the interface.
    """
    size = 1 / resolution
    speeds = {0: UNIT.shear_speed, 1: UNIT.longitudinal_speed}
    height = round((UNIT.longitudinal_speed / 2 + 0.15) / size)
    blocks = Blocks(size, round(1.75 / size), round(2.15 / size), height)
    arrival = blocks.far / UNIT.shear_speed
    end = arrival + 1.0
    # its slot loads make it two blocks; they are left out below
    scene = sf.Scene(UNIT, REMOTE.friction, sf.Tractions(0.0, 0.0), REMOTE.load)
    plan = Plan(scene, end, Settings(resolution=round(end / size)))
    assert plan.name == TWO_BLOCKS
    assert plan.size == pytest.approx(size, rel=1e-12)
    mesh = mesh_of(blocks).translated((plan.edge, 0.0))
    model = build_model(plan, Space(mesh))
    model.joint.tractions = lambda level: KickTractions(0.0, 0.0, 0.0, 0.0)
    nodes, length = tributary_length(model.space, "far")
    tractions = {0: REMOTE.load.shear / 2, 1: -REMOTE.load.pressure / 2}
    for body in model.bodies:
        body.arrival[:] = 0.0
    for step in range(model.steps + 1):
        for body in model.bodies:
            body.activate(1.0)
            body.kick()
        for component in (0, 1):
            start = (arrival - blocks.far / speeds[component]) / model.time_step
            # the part of the interval around this time level in which the load is on
            on = np.clip(step + 0.5 - start, 0.0, 1.0)
            far = face_pair(model.bodies, model.place[nodes], length, model.time_step, component)
            far.push(np.asarray(on * tractions[component]), 1.0)
        model.walls.hold()
        model.joint.act(1, 1.0)
        if step < model.steps:
            model.drift()
    return model.contact_x, model.joint.sliding.mean_increment() / model.time_step


@pytest.mark.slow
def test_plane_waves_from_afar_do_what_the_superposed_model_does():
    """The superposition of theory, section 1, without using it."""
    differences, errors = [], []
    for resolution in (50, 100):
        x, rate = remotely_loaded(resolution)
        superposed = simulate(REMOTE, resolution=resolution, every=10**6).interface
        shown = (x > 0.02) & (x < 1.9)
        expected = exact(REMOTE).slip_rate(x[shown], 1.0)
        near = np.interp(x[shown], superposed.x, superposed.slip_rate[-1])
        scale = np.abs(expected).sum()
        differences.append(np.abs(rate[shown] - near).sum() / scale)
        errors.append(l1(rate[shown], expected))
    print(differences, errors)
    assert errors[1] < 0.05
    assert errors[1] < 0.8 * errors[0]
    assert differences[1] < 0.8 * differences[0]
