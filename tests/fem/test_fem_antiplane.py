"""The scalar model of antiplane shear: matrices, mesh edge, closed forms, the other solvers."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from catalogue import REMOTE, UNIT, solved, unit_scene

import semianalytic as sf
from docs.studies.article.stuck import stuck_shear
from fem import Settings, cost, simulate, with_companions
from fem.elements.assembly import OUT_OF_PLANE, Space, antiplane_stiffness
from fem.elements.edge import edge_offset, surface_stiffness
from fem.plan import ANTIPLANE, TWO_BLOCKS, TWO_MATERIALS, Plan
from fem.results import load_simulation
from meshes import Blocks, mesh_of
from semianalytic.reference import antiplane_slip, antiplane_slip_rate
from tests.fem.runs import SHEARED_ALONG_Z, interrupted, l1, run

SOFT = sf.Material(2.0, 3.0, 0.1)


def antiplane(friction, base=(1.0, 0.0), load=(0.0, 1.0), **parts):
    return unit_scene(friction, base, load, mode="antiplane", **parts)


# --- the matrix and the edge of a mesh ----------------------------------------------------------


@pytest.mark.parametrize("pattern", ["squares", pytest.param("triangles", marks=pytest.mark.gmsh)])
def test_energy_of_uniform_shear(pattern):
    """mu/2 (u_x^2 + u_y^2) times the area; a shift costs nothing."""
    space = Space(mesh_of(Blocks(0.25, 2, 3, 4, pattern=pattern)))
    stiffness = antiplane_stiffness(space, SOFT)
    x, y = space.points
    u = 0.3 * x + 0.2 * y
    energy = 5 * 4 * 0.25**2 * SOFT.shear_modulus / 2 * (0.3**2 + 0.2**2)
    assert u @ (stiffness @ u) / 2 == pytest.approx(energy, rel=1e-12)
    assert np.abs(stiffness @ np.ones(len(u))).max() < 1e-12


def test_edge_of_a_stuck_contact_in_closed_form():
    """g = sqrt(1 - s^2/3), s = sin(theta/2), puts it sqrt(2/3)/4 beside the first node; nu and
    moduli do not count."""
    angles = np.array([0.1, 1.0, 3.0])
    square = np.sin(angles / 2) ** 2
    found = surface_stiffness(SOFT, angles, OUT_OF_PLANE)[:, 0, 0]
    expected = SOFT.shear_modulus * 2 * np.sqrt(square * (1 - square / 3))
    np.testing.assert_allclose(found, expected, rtol=1e-11)
    for material in (UNIT, SOFT):
        assert edge_offset([material], held=2) == pytest.approx(np.sqrt(2 / 3) / 4, abs=1e-6)


def test_stuck_traction_is_seen_from_that_edge():
    """Errors of 0.012 %; 1.6 % with the edge at the first node."""
    scene = antiplane(80.0, load=(0.0, 0.01))
    sim = simulate(scene, resolution=100, every=10**6)
    interface, beside = sim.interface, edge_offset([UNIT], held=2)
    assert np.abs(interface.slip_rate).max() < 1e-15
    seen = (interface.x > 0.03) & (interface.x < 0.8)
    errors = []
    for shift in (beside * sim.element_size, 0.0):
        exact = stuck_shear(sf.Step(), 0.01, UNIT, interface.x[seen] + shift, 1.0, "III").value
        errors.append(l1(interface.shear_traction[-1, seen], exact))
    assert errors[0] < errors[1] / 15


# --- answers --------------------------------------------------------------------------------------


def test_slip_converges_to_the_closed_form():
    """0.83, 0.39, 0.13 % of slip rate, 0.23, 0.068, 0.024 % of slip at h = 1/40 ... 1/160."""
    scene, rates, slips = antiplane(0.5), [], []
    for resolution in (40, 80, 160):
        sim = simulate(scene, resolution=resolution)
        assert sim.model == ANTIPLANE
        x = sim.interface.x
        rates.append(l1(sim.interface.slip_rate[-1], antiplane_slip_rate(UNIT, 1.0, 0.5, x)))
        slips.append(l1(sim.interface.slip[-1], antiplane_slip(UNIT, 1.0, 0.5, x, 1.0)))
    assert rates[-1] < 2e-3
    assert slips[-1] < 3e-4
    assert np.log2(rates[0] / rates[-1]) / 2 > 1.0
    assert sim.energy.residual < 1e-10


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("scene", "name"),
    [
        (antiplane(1.0, **REMOTE), TWO_BLOCKS),
        (antiplane(0.5, law=sf.Coulomb(1.0, viscosity=0.25)), ANTIPLANE),
        (antiplane(0.3, (1.0, 0.3), (1.0, 0.6)), TWO_BLOCKS),
    ],
    ids=["shock", "viscous", "slip from the longitudinal front"],
)
def test_exact_solutions_are_met(scene, name):
    sim, exact = run(scene, 100), solved(scene)
    assert sim.model == name
    x = sim.interface.x[sim.interface.x > 0.02]
    found = sim.interface.slip[-1, -len(x) :]
    assert l1(found, exact.slip(x, sim.end_time)) < 5e-3


def test_slip_weakening_agrees_with_a_march():
    scene = antiplane(0.5, law=sf.SlipWeakening(1.0, 0.5, 0.1))
    seen, marched = (
        simulate(scene, resolution=64).interface,
        sf.solve(scene, method="space-time", nodes=320),
    )
    x = seen.x[seen.x < marched.interface.x[-1]]
    assert l1(seen.slip[-1, : len(x)], marched.slip(x, 1.0)) < 3e-3


def test_slot_faces_move_along_z_and_normally():
    scene = antiplane(1.0, **REMOTE)
    slot, exact = run(scene, 100).slot, solved(scene)
    x = slot.x[slot.x < -0.03]
    velocities = slot.velocity_x[-1, : len(x)], slot.velocity_y[-1, : len(x)]
    for found, wanted in zip(velocities, exact.slot_velocity(x, 1.0), strict=True):
        assert np.abs(found - wanted).mean() < 5e-3


# --- models ---------------------------------------------------------------------------------------


def test_mesh_is_as_large_as_shear_waves_reach():
    alone, pressed = (antiplane(0.5, load=load) for load in ((0.0, 1.0), (0.4, 1.0)))
    blocks = [Plan(scene, 1.0, Settings(resolution=40)).blocks for scene in (alone, pressed)]
    assert blocks[1].right > 1.7 * blocks[0].right
    assert cost(alone, resolution=40).unknowns == simulate(alone, resolution=40).unknowns
    assert cost(pressed, resolution=40).unknowns == simulate(pressed, resolution=40).unknowns


def test_two_materials_slide_under_constant_pressure_only():
    sim = simulate(replace(antiplane(0.5), lower_material=SOFT), 0.5, resolution=40)
    assert sim.model == TWO_MATERIALS
    assert sim.energy.residual < 1e-10
    with pytest.raises(sf.SceneError, match="slip along x as well"):
        simulate(replace(antiplane(0.5, load=(0.4, 1.0)), lower_material=SOFT), 0.5, resolution=40)


def test_saved_runs_companions_and_checkpoints_keep_the_mode(tmp_path):
    scene = antiplane(0.5, load=(0.4, 1.0))
    sim = with_companions(simulate(scene, 0.5, resolution=16))
    assert sim.companion.model == sim.model
    sim.save(tmp_path / "run.h5")
    assert load_simulation(tmp_path / "run.h5").scene == scene
    options = {"end_time": 0.5, "resolution": 16, "checkpoint": tmp_path / "run.check"}
    interrupted(scene, sim.steps // 2, checkpoint_every=1, **options)
    again = simulate(scene, **options, resume=True)
    np.testing.assert_array_equal(again.interface.slip, sim.interface.slip)


def test_snapshots_show_displacement_along_z(tmp_path):
    """Far left, behind the shear wave of the slot, stands the load; ahead of it the base."""
    simulate(SHEARED_ALONG_Z, resolution=40, snapshots=tmp_path, frames=1)
    frame = meshio.read(next(tmp_path.glob("*.vtu")))
    assert not frame.point_data["velocity"][:, :2].any()
    x, y, _ = frame.points[frame.cells[0].data].mean(axis=1).T
    stress = frame.cell_data["sigma_yz"][0]
    far = (x < -1.02) & (x > -1.15)
    for where, expected in ((np.abs(y) < 0.8, 0.2 - 0.5), (np.abs(y) > 1.1, 0.2)):
        assert (far & where).sum() > 10
        assert stress[far & where].mean() == pytest.approx(expected, abs=5e-3)
