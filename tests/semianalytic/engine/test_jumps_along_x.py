"""Fields that jump between nodes: a node beside a jump stands for both of its sides."""

import numpy as np
import pytest

import semianalytic as sf
from semianalytic.interface.fields import Table, at_nodes, moving, sampled

NODES = 0.1 * np.arange(-20, 21)
END = 1.5


def step(at):
    return lambda x: np.where(x < at, 1.0, 3.0)


@pytest.mark.parametrize("at", [0.0, 0.02, -0.037, 0.05, 1.2345])
def test_a_node_beside_a_jump_takes_the_mean(at):
    found = sampled("f", step(at), NODES, 0.1)
    part = np.clip((NODES + 0.05 - at) / 0.1, 0.0, 1.0)  # of its cell beyond the jump
    np.testing.assert_allclose(found, 1 + 2 * part, atol=2 / 100)
    assert np.sum((found != 1) & (found != 3)) <= 1
    # the integral is that of the field, which nodal values miss by up to half a node distance
    assert 0.1 * found.sum() == pytest.approx(1 * (at + 2.05) + 3 * (2.05 - at), abs=2e-3)


@pytest.mark.parametrize(
    "field",
    [
        lambda x: x**2,
        np.abs,
        lambda x: np.exp(-((x / 0.3) ** 2)),
        lambda x: np.tanh(x / 0.2),
        lambda x: 0 * x + 2,
        lambda x: 2.0,
        Table([-2.0, 0.01, 2.0], [0.0, 1.0, -1.0]),
    ],
)
def test_smooth_fields_keep_the_values_at_nodes(field):
    np.testing.assert_array_equal(sampled("f", field, NODES, 0.1), sampled("f", field, NODES))


def test_tables_and_formulas_need_not_reach_beyond_the_nodes():
    table = Table([-2.0, 0.02, 0.02, 2.0], [1.0, 1.0, 3.0, 3.0])
    np.testing.assert_allclose(
        sampled("f", table, NODES, 0.1), sampled("f", step(0.02), NODES, 0.1), atol=1e-12
    )
    inside = NODES[NODES > 0]
    root = sampled("f", lambda x: np.sqrt(x - 0.06), inside, 0.1)
    np.testing.assert_array_equal(root, np.sqrt(inside - 0.06))
    on_slot = at_nodes("f", step(0.0), NODES, NODES > 0.5, 0.1)
    np.testing.assert_array_equal(on_slot, np.where(NODES > 0.5, 3.0, 0.0))


@pytest.mark.parametrize("t", [0.0, 0.13, 0.15, 0.42])
def test_a_jump_that_moves_loads_its_share_of_a_cell(t):
    found = moving(lambda x, t: (np.abs(x) < t) * 2.0, NODES, t, 0.1)
    assert 0.1 * found.sum() == pytest.approx(4 * t, abs=5e-3)
    smooth = moving(lambda x, t: np.cos(x - t), NODES, t, 0.1)
    np.testing.assert_array_equal(smooth, np.cos(NODES - t))


def test_a_law_takes_means_but_of_barriers():
    weak, barrier = (sf.Coulomb(lambda x, to=to: np.where(x < 0.02, 0.3, to)) for to in (0.9, 90.0))
    assert 0.4 < weak.on(NODES, 0.1).friction[20] < 0.8
    assert barrier.on(NODES, 0.1).friction[20] == 0.3
    assert weak.on(NODES).friction[20] == 0.3


def patch(contact, friction=0.4):
    loads = [sf.InterfaceLoad(lambda x: 0.8 * (abs(x - 3) < 1))]
    solid = sf.Material(1.0, 1.0, 0.3)
    return sf.Interface(
        solid, sf.Coulomb(friction), 20.0, contact=contact, pressure=1.0, loads=loads
    )


@pytest.mark.parametrize("contact", [sf.Contact(), sf.Contact.half_line()], ids=["line", "slot"])
def test_slip_of_a_patch_does_not_depend_on_where_its_ends_meet_the_grid(contact):
    truth = sf.run(patch(contact), END, 2048, times=[END], estimate=False)

    def off(interface, nodes):
        done = sf.run(interface, END, nodes, times=[END], estimate=False)
        exact = np.interp(done.x, truth.x, truth.slip[-1])[done.touching]
        return np.abs(done.slip[-1][done.touching] - exact).sum() / np.abs(exact).sum()

    # ends at 20, 20.48 and 20.8 node distances: values at nodes were off by 1 to 5 %
    for nodes in (400, 408, 416):
        assert off(patch(contact), nodes) < 3e-3
    assert off(patch(contact, 0.4 * 0.97), 400) > 1e-2
