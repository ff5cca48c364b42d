"""A sweep as a sequence of solutions, its slip rates and its dataset."""

import numpy as np
import pytest
from catalogue import PRELOADED

from semianalytic import SceneError
from semianalytic.sweeps.sweep import Sweep, sweep

X = np.array([0.05, 0.2, 0.4])
T = np.array([0.5, 1.0])


@pytest.fixture(scope="module")
def swept():
    """Two zones under little friction, one under more."""
    return sweep(PRELOADED, [0.9, 0.2, 0.5], 1e-6)


def test_a_sweep_is_a_sequence_of_its_solutions(swept):
    assert len(swept) == 3
    assert list(swept) == list(swept.solutions)
    assert [one.scene.friction for one in swept] == [0.9, 0.2, 0.5]
    assert swept[0] is swept.solutions[0]
    assert swept[-1] is swept.solutions[2]
    for beyond in (3, -4):
        with pytest.raises(IndexError):
            swept[beyond]


def test_a_slice_is_the_sweep_over_some_frictions(swept):
    part = swept[::-2]
    assert isinstance(part, Sweep)
    assert part.friction.tolist() == [0.5, 0.9]
    assert part.solutions == (swept.solutions[2], swept.solutions[0])
    assert part.origin == (swept.origin[2], swept.origin[0])
    assert part.scene == swept.scene
    assert len(swept[3:]) == 0


def test_slip_rates_have_friction_first_and_broadcast(swept):
    rate = swept.slip_rate(X, T[:, None])
    assert rate.shape == (3, 2, 3)
    for row, solution in zip(rate, swept, strict=True):
        np.testing.assert_array_equal(row, solution.slip_rate(X, T[:, None]))
    assert swept.slip_rate(0.1, 1.0).shape == (3,)
    assert swept[3:].slip_rate(X, T[:, None]).shape == (0, 2, 3)
    with pytest.raises(SceneError, match="positive positions"):
        swept.slip_rate(-1.0, 1.0)


def test_edges_of_fewer_zones_are_padded_and_estimates_given(swept):
    assert swept.error_estimate.shape == (3,)
    assert np.all(swept.error_estimate <= 1e-6)
    assert swept.edges.shape == (3, 2, 2)
    assert np.isnan(swept.edges[0, 1]).all()
    for row, solution in zip(swept.edges, swept, strict=True):
        pairs = [(zone.inner, zone.outer) for zone in solution.zones]
        np.testing.assert_array_equal(row[: len(pairs)], pairs)
    assert swept[3:].edges.shape == (0, 0, 2)


def test_the_dataset_has_a_dimension_friction_and_units(swept):
    data = swept.to_xarray(X, T)
    assert data.slip_rate.dims == ("friction", "t", "x")
    assert data.friction.values.tolist() == [0.9, 0.2, 0.5]
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        for j, solution in enumerate(swept):
            exact = getattr(solution, name)(X, T[:, None])
            np.testing.assert_array_equal(data[name].values[j], exact)
    assert data.slip_rate.attrs["units"] == "length / time"
    assert all({"units", "long_name"} <= set(data[name].attrs) for name in (*data, *data.coords))
    np.testing.assert_array_equal(data.edges.sel(edge="outer"), swept.edges[..., 1])
    assert data.origin.values.tolist() == list(swept.origin)
    assert data.status.values.tolist() == ["converged"] * 3
    assert swept[3:].to_xarray(X, T).sizes["friction"] == 0


def test_a_sweep_says_in_one_line_what_it_is(swept):
    shown = repr(swept)
    assert "3 friction coefficients from 0.2 to 0.9" in shown
    assert "3 converged" in shown
    assert "\n" not in shown
    assert repr(swept[3:]) == "<Sweep: no friction coefficients>"
