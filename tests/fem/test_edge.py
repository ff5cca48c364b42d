"""Where the edge of a closed contact is on a mesh, and what it is worth to put it at x = 0."""

from unittest.mock import PropertyMock

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene

from fem import Settings, prepare, simulate
from fem.elements.assembly import FAMILIES, make_space, tributary_length
from fem.elements.edge import FARTHEST, edge_offset, surface_stiffness
from fem.plan import Plan
from meshes import Blocks, cached_mesh
from semianalytic import solve
from semianalytic.scene.scene import Material
from tests.fem.runs import l1

Q1 = FAMILIES["Q1"]
LINEAR = pytest.mark.parametrize("element", ["Q1", "P1"])
POISSON_RATIOS = pytest.mark.parametrize("nu", [-0.9, 0.0, 1 / 3, 0.48])


def pressed(nu=1 / 3, shear=0.0):
    return unit_scene(0.4, load=(1.0, shear), nu=nu)


@LINEAR
@POISSON_RATIOS
def test_long_waves_meet_the_stiffness_of_a_half_plane(element, nu):
    """Normal or tangential load alone: mu k / (1 - nu), k the wave number."""
    material, angles = Material(2.0, 3.0, nu), np.array([0.005, 0.01])
    stiffness = surface_stiffness(material, FAMILIES[element], angles)
    np.testing.assert_allclose(stiffness, stiffness.conj().transpose(0, 2, 1), atol=1e-12)
    compliance = np.linalg.inv(stiffness)
    for i in (0, 1):
        expected = (1 - nu) / (2.0 * angles)
        np.testing.assert_allclose(compliance[:, i, i].real, expected, rtol=1e-3)


@LINEAR
@POISSON_RATIOS
def test_edge_is_the_same_on_finer_rules_and_for_any_moduli(element, nu, monkeypatch):
    family = FAMILIES[element]
    offset = edge_offset([Material(1.0, 1.0, nu)], family)
    assert edge_offset([Material(5.0, 2.0, nu)], family) == offset
    monkeypatch.setattr("fem.elements.edge.ANGLES", np.pi * (np.arange(100) + 0.5) / 100)
    assert edge_offset([Material(1.0, 1.0, nu)], family) == pytest.approx(offset, abs=2e-6)


def test_softer_block_counts_more():
    stiff, soft = Material(9.0, 1.0, 0.0), Material(1.0, 1.0, -0.9)
    one, other = edge_offset([stiff], Q1), edge_offset([soft], Q1)
    both = edge_offset([stiff, soft], Q1)
    assert one < both < other
    assert other - both < 0.1 * (other - one)


@pytest.mark.thinned(4)
@pytest.mark.parametrize(
    ("element", "nu"), [("Q1", -0.5), ("Q1", 1 / 3), ("Q1", 0.45), ("P1", 1 / 3), ("P1", 0.0)]
)
def test_pressure_converges_to_that_of_an_edge_at_zero(element, nu, monkeypatch):
    """Nodes that are laid at 0, h, 2 h are first order; the fraction of h takes most of it away."""
    exact = solve(pressed(nu))
    x = np.linspace(0.1, 0.9, 81) * exact.scene.material.longitudinal_speed

    def error():
        run = simulate(exact.scene, 1.0, resolution=48, element=element, every=10**6)
        return l1(run.pressure(x, 1.0) - 1, exact.pressure(x, 1.0) - 1)

    beside = error()
    monkeypatch.setattr(Plan, "edge", PropertyMock(return_value=0.0))
    assert beside < 0.2 * error()


@pytest.mark.parametrize("model", ["auto", "two-blocks"])
def test_slot_and_contact_meet_at_zero_wherever_the_node_is(model):
    model = prepare(pressed(shear=0.5), resolution=20, model=model)
    edge = model.plan.edge
    assert edge == pytest.approx(0.2417 * model.plan.size, rel=1e-3)
    for side in ("upper_contact", "upper_slot"):
        nodes, length = tributary_length(model.space, side)
        places = model.space.points[0, nodes]
        assert edge in places
        assert length.sum() == pytest.approx(np.abs(places).max(), rel=1e-12)
    np.testing.assert_allclose(model.contact_x[:2], [edge, edge + model.plan.size])
    assert model.slot_x[-1] == pytest.approx(edge - model.plan.size)


def test_node_is_nearer_to_the_edge_than_any_other():
    """Slot and contact meet at the node nearest to x = 0, so its place has to stop before h/2."""
    for nu in (-0.9, 0.49):
        assert edge_offset([Material(1.0, 1.0, nu)], FAMILIES["P1"]) == FARTHEST
    model = prepare(pressed(0.49), resolution=8)
    assert model.contact_x[0] == pytest.approx(FARTHEST * model.plan.size)
    assert model.interface.length[0] == pytest.approx((0.5 + FARTHEST) * model.plan.size)


def test_edge_node_stays_at_zero_under_shear_alone_and_where_its_place_is_not_known():
    assert Plan(PRELOADED, 1.0, Settings()).edge == 0
    for options in ({"element": "Q2"}, {"element": "P1", "mesh": "triangles"}):
        assert Plan(pressed(), 1.0, Settings(**options)).edge == 0
    space = make_space(cached_mesh(Blocks(0.5, 2, 2, 2)), Q1)
    for side in ("upper_contact", "upper_slot"):
        assert tributary_length(space, side)[1].sum() == pytest.approx(1.0)
