"""Stiffness, mass and frequencies of the blocks, and where the edge of a closed contact is."""

from unittest.mock import PropertyMock

import numpy as np
import pytest
from catalogue import PRELOADED, UNIT, unit_scene
from skfem import Basis, ElementVector, FacetBasis, LinearForm, asm
from skfem.models.elasticity import linear_elasticity

from fem import Settings, simulate
from fem.elements.assembly import Space, lumped_mass, stiffness, tributary_length
from fem.elements.edge import FARTHEST, edge_offset, surface_stiffness
from fem.plan import Plan
from fem.stepping import critical_step, highest_frequency, normalised
from meshes import Blocks, causal_blocks, mesh_of
from semianalytic import solve
from semianalytic.scene.scene import Material
from tests.fem.runs import l1, prepare

every_element = pytest.mark.parametrize(
    "pattern", ["squares", pytest.param("triangles", marks=pytest.mark.gmsh)]
)


def block(pattern="squares"):
    return Space(mesh_of(Blocks(size=0.5, left=2, right=4, height=3, pattern=pattern)))


@every_element
def test_uniform_strain_stores_its_exact_energy(pattern):
    material = Material(2.0, 3.0, 0.2)
    mu = material.shear_modulus
    lam = material.density * material.longitudinal_speed**2 - 2 * mu
    gradient = np.array([[0.3, -0.7], [0.2, 0.5]])
    strain = (gradient + gradient.T) / 2
    density = lam * np.trace(strain) ** 2 / 2 + mu * (strain**2).sum()
    space = block(pattern)
    u = (gradient @ space.points).T.ravel()
    area = 3.0 * np.ptp(space.points[1])
    energy = u @ (stiffness(space, material) @ u) / 2
    assert energy == pytest.approx(density * area, rel=1e-13)


@every_element
def test_quadrature_at_the_nodes_sees_one_node_each(pattern):
    """What makes the mass matrix diagonal, not merely lumped."""
    space = block(pattern)
    values = Basis(space.mesh, space.family.kind, quadrature=space.family.nodal).basis
    each = np.array([np.asarray(value[0])[0] for value in values])
    np.testing.assert_allclose(np.sort(each, axis=0)[:-1], 0, atol=1e-14)
    np.testing.assert_allclose(each.max(axis=0), 1, atol=1e-14)


@every_element
def test_assembly_by_shapes_is_that_of_every_element(pattern):
    """Assemble by scikit-fem, with vector-valued shape functions."""
    space, material = block(pattern), Material(4.0, 3.0, -0.3)
    nodes, family = space.points.shape[1], space.family
    mu, poisson = material.shear_modulus, material.poisson_ratio
    basis = Basis(space.mesh, ElementVector(family.kind), intorder=family.order)
    whole = asm(linear_elasticity(2 * mu * poisson / (1 - 2 * poisson), mu), basis).toarray()
    scalar = Basis(space.mesh, family.kind, quadrature=family.nodal)
    mass = material.density * asm(unit_load, scalar)
    unknowns = vector_unknowns(space)
    place = np.random.default_rng(1).permutation(nodes)
    order = np.argsort(place)
    seen = stiffness(space, material)
    np.testing.assert_allclose(
        seen.toarray(), whole[np.ix_(unknowns, unknowns)], atol=1e-13 * np.abs(whole).max()
    )
    moved = stiffness(space, material, place).toarray().reshape(nodes, 2, nodes, 2)
    again = seen.toarray().reshape(nodes, 2, nodes, 2)[order][:, :, order]
    np.testing.assert_allclose(moved, again, atol=1e-15 * np.abs(whole).max())
    np.testing.assert_allclose(lumped_mass(space, material), mass, rtol=1e-13)
    np.testing.assert_allclose(lumped_mass(space, material, place)[place], mass, rtol=1e-13)
    assert mass.min() > 0


@LinearForm
def unit_load(v, _):
    return v


def vector_unknowns(space):
    """Unknowns of scikit-fem's vector-valued element in the order of ours."""
    basis = Basis(space.mesh, ElementVector(space.family.kind), intorder=1)
    component = np.arange(basis.N)
    ours = np.empty(basis.N, dtype=int)
    for row, dofs in enumerate(basis.element_dofs):
        ours[2 * space.element_nodes[row // 2] + row % 2] = component[dofs]
    return ours


def test_equal_elements_are_integrated_once():
    shapes = block().shapes
    assert shapes.samples.nelements == shapes.kind.max() + 1 == 1
    assert len(shapes.kind) == 6 * 3


@pytest.mark.gmsh
def test_unstructured_triangles_are_integrated_one_by_one():
    triangles = block("triangles").shapes
    assert triangles.samples.nelements > len(triangles.kind) / 2


def test_tributary_lengths_are_integrals_of_the_shape_functions():
    space = block()
    for side in ("slot", "contact", "far"):
        nodes, lengths = tributary_length(space, side)
        facets = space.mesh.facets_satisfying(
            lambda x, ends=space.points[:, nodes]: (
                np.isclose(x[1], ends[1, 0]) & (ends[0, 0] < x[0]) & (x[0] < ends[0, -1])
            ),
            boundaries_only=True,
        )
        per_node = asm(unit_load, FacetBasis(space.mesh, space.family.kind, facets=facets))
        np.testing.assert_allclose(per_node[nodes], lengths, atol=1e-15)


@every_element
def test_highest_frequency_is_the_largest_eigenvalue(pattern):
    space = block(pattern)
    mass = lumped_mass(space, UNIT)
    matrix, root = normalised(stiffness(space, UNIT), mass)
    exact = np.sqrt(np.linalg.eigvalsh(matrix.toarray())[-1])
    # never below, or the step could be unstable; above by its tolerance at most
    assert exact <= highest_frequency(matrix) < exact * 1.0002
    np.testing.assert_allclose(root**2, np.repeat(mass, 2))


@pytest.mark.parametrize("damping_time", [0.0, 0.01, 0.3, 4.0])
def test_critical_step_separates_stable_from_unstable(damping_time):
    omega = 7.0

    def growth(step):
        """Spectral radius of one step of (u, d) for a single oscillator."""
        a = (omega * step) ** 2
        kick = np.array([[1, 0], [-a, 1 - a * damping_time / step]])
        drift = np.array([[1, 1], [0, 1]])
        return np.abs(np.linalg.eigvals(drift @ kick)).max()

    limit = critical_step(omega, damping_time)
    assert growth(0.999 * limit) <= 1 + 1e-12
    assert growth(1.001 * limit) > 1 + 1e-4


def test_fastest_mode_sits_in_the_outer_corners():
    """So the critical step is safe, and a step slightly above it may go unnoticed."""
    h = 1 / 20
    space = Space(mesh_of(causal_blocks(UNIT.longitudinal_speed, 1.0, h)))
    mass = lumped_mass(space, UNIT)
    matrix, _ = normalised(stiffness(space, UNIT), mass)
    (x, y), margin = space.points, 4 * h
    inside = (x > x.min() + margin) & (x < x.max() - margin) & (y < y.max() - margin)
    kept = np.repeat(inside, 2)
    ratio = highest_frequency(matrix[kept][:, kept]) / highest_frequency(matrix)
    assert ratio == pytest.approx(1 - 0.016, abs=2e-3)


# --- where the edge of a closed contact is ------------------------------------------------------

POISSON_RATIOS = pytest.mark.parametrize("nu", [-0.9, 0.0, 1 / 3, 0.48])


def pressed(nu=1 / 3, shear=0.0):
    return unit_scene(0.4, load=(1.0, shear), nu=nu)


@POISSON_RATIOS
def test_long_waves_meet_the_stiffness_of_a_half_plane(nu):
    """Normal or tangential load alone: mu k / (1 - nu), k the wave number."""
    material, angles = Material(2.0, 3.0, nu), np.array([0.005, 0.01])
    stiffness = surface_stiffness(material, angles)
    np.testing.assert_allclose(stiffness, stiffness.conj().transpose(0, 2, 1), atol=1e-12)
    compliance = np.linalg.inv(stiffness)
    for i in (0, 1):
        expected = (1 - nu) / (2.0 * angles)
        np.testing.assert_allclose(compliance[:, i, i].real, expected, rtol=1e-3)


@POISSON_RATIOS
def test_edge_is_the_same_on_finer_rules_and_for_any_moduli(nu, monkeypatch):
    offset = edge_offset([Material(1.0, 1.0, nu)])
    assert edge_offset([Material(5.0, 2.0, nu)]) == offset
    monkeypatch.setattr("fem.elements.edge.ANGLES", np.pi * (np.arange(100) + 0.5) / 100)
    assert edge_offset([Material(1.0, 1.0, nu)]) == pytest.approx(offset, abs=2e-6)


def test_softer_block_counts_more():
    stiff, soft = Material(9.0, 1.0, 0.0), Material(1.0, 1.0, -0.9)
    first, other = edge_offset([stiff]), edge_offset([soft])
    both = edge_offset([stiff, soft])
    assert first < both < other
    assert other - both < 0.1 * (other - first)


@pytest.mark.thinned(4)
@pytest.mark.parametrize("nu", [-0.5, 1 / 3, 0.45])
def test_pressure_converges_to_that_of_an_edge_at_zero(nu, monkeypatch):
    """Nodes that are laid at 0, h, 2 h are first order; the fraction of h takes most of it away."""
    exact = solve(pressed(nu))
    x = np.linspace(0.1, 0.9, 81) * exact.scene.material.longitudinal_speed

    def error():
        run = simulate(exact.scene, 1.0, resolution=48, every=10**6)
        return l1(run.pressure(x, 1.0) - 1, exact.pressure(x, 1.0) - 1)

    beside = error()
    monkeypatch.setattr(Plan, "edge", PropertyMock(return_value=0.0))
    assert beside < 0.2 * error()


@pytest.mark.parametrize("model", ["auto", "two-blocks"])
def test_slot_and_contact_meet_at_zero_wherever_the_node_is(model):
    model = prepare(pressed(shear=0.5), resolution=20, model=model)
    edge = model.plan.edge
    assert edge == pytest.approx(0.2417 * model.plan.size, rel=1e-3)
    for side in ("contact", "slot"):
        nodes, length = tributary_length(model.space, side)
        places = model.space.points[0, nodes]
        assert edge in places
        assert length.sum() == pytest.approx(np.abs(places).max(), rel=1e-12)
    np.testing.assert_allclose(model.contact_x[:2], [edge, edge + model.plan.size])
    assert model.slot_x[-1] == pytest.approx(edge - model.plan.size)


def test_node_is_nearer_to_the_edge_than_any_other():
    """Slot and contact meet at the node nearest to x = 0, so its place has to stop before h/2."""
    assert edge_offset([Material(1.0, 1.0, 0.49)]) == FARTHEST
    model = prepare(pressed(0.49), resolution=8)
    assert model.contact_x[0] == pytest.approx(FARTHEST * model.plan.size)
    assert model.joint.length[0] == pytest.approx((0.5 + FARTHEST) * model.plan.size)


def test_edge_node_stays_at_zero_under_shear_alone_and_where_its_place_is_not_known():
    assert Plan(PRELOADED, 1.0, Settings()).edge == 0
    assert Plan(pressed(), 1.0, Settings(mesh="triangles")).edge == 0
    space = Space(mesh_of(Blocks(0.5, 2, 2, 2)))
    for side in ("contact", "slot"):
        assert tributary_length(space, side)[1].sum() == pytest.approx(1.0)
