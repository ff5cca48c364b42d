"""The published algorithm: its kernels' primitives, its readings, and what it cannot do."""

import mpmath as mp
import numpy as np
import pytest

from docs.studies.article.published import (
    ARTICLE_SHEAR_SLOWNESS,
    DEFAULT_READING,
    REVERSE_LIMIT,
    AlgorithmReading,
    examine_all,
    examine_reading,
    kernel_primitives,
    published_grid,
    published_slip,
    readings,
)
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.errors import SceneError


def test_primitives_against_quadrature():
    """(7.9) and (7.10) with b^3 are the primitives of the kernels of (4.42)."""
    a, u = mp.mpf(1) / 2, mp.mpf("1.7")
    four, square = kernel_primitives(1 / 3, np.array([1.7, 0.4]))
    expected = mp.quad(lambda v: 4 * v * mp.sqrt(v**2 - a**2), [a, u])
    assert four[0] == pytest.approx(float(expected), rel=1e-13)
    expected = mp.quad(lambda v: (1 - 2 * v**2) ** 2 / (v * mp.sqrt(v**2 - 1)), [1, u])
    assert square[0] == pytest.approx(float(expected), rel=1e-9)
    assert four[1] == square[1] == 0


def test_printed_arctan_in_the_papers_units():
    """(7.10) as printed, b = 0.2, over b^3: the arctan is 125 times too large."""
    u, b = 0.31, ARTICLE_SHEAR_SLOWNESS
    printed = 4 / 3 * (b**2 - u**2) ** 2 / np.sqrt(u**2 - b**2) + np.arctan(
        np.sqrt(u**2 - b**2) / b
    )
    _, found = kernel_primitives(1 / 3, np.array([u / b]), printed_arctan=True)
    assert found[0] * b**3 == pytest.approx(
        (u**2 - b**2) ** 1.5 * 4 / 3 + np.arctan(np.sqrt(u**2 - b**2) / b), rel=1e-12
    )
    # and its first term is the same in both forms
    assert printed == pytest.approx(found[0] * b**3, rel=1e-12)


@pytest.mark.parametrize("basis", ["box", "hat"])
def test_matrix_against_quadrature(basis):
    """L_j(u_k) by mpmath, kernel by kernel, delays from their own fronts."""
    grid = published_grid(AlgorithmReading(basis=basis), 6)
    a, edges = mp.mpf(1) / 2, [mp.mpf(e) for e in grid.edges]

    def kernel(lag):
        u, w = lag + a, lag + 1
        square = (1 - 2 * w**2) ** 2 / (w * mp.sqrt(w**2 - 1))
        return (4 * u * mp.sqrt(u**2 - a**2) - square) / mp.pi

    def weight(j, u):
        if basis == "box":
            return mp.mpf(1)
        return 1 - abs(u - edges[j]) / (edges[1] - edges[0])

    for k, j in ((4, 2), (3, 3), (5, 0), (2, 1)):
        point = mp.mpf(grid.points[k])
        left = edges[j - 1] if basis == "hat" and j else edges[j]
        ends = [e for e in (left, edges[j], edges[j + 1]) if e < point]
        ends = sorted({*ends, min(point, edges[j + 1])})
        expected = mp.quad(lambda u: weight(j, u) * kernel(point - u), ends)  # noqa: B023
        assert grid.matrix[k, j] == pytest.approx(float(expected), rel=1e-6)
    assert np.all(grid.matrix[np.triu_indices(6, 2)] == 0)


def test_delays_as_printed_leave_no_equation():
    """With (4.44) taken literally the last unknowns do not enter: singular for every choice."""
    literal = [reading for reading in readings() if reading.delay == "printed"]
    assert len(literal) == 72
    assert all(np.isinf(published_grid(reading, 10).condition) for reading in literal)
    with pytest.raises(SceneError, match="singular"):
        published_slip(0.5, AlgorithmReading(delay="printed"))


def test_default_reading():
    """It settles; points off the middle ruin it; slip is reversed at every chi, so no 0.0575."""
    result = examine_reading(DEFAULT_READING)
    assert result.settled
    assert result.change < 0.05
    assert result.condition < 1e3
    assert result.off_middle > 1
    assert np.isinf(result.reverse_limit)
    assert result.maximum < 0.7  # x / (c_t t): it lags the shear front
    # where p* = 0, rather than at a/b = 0.5
    assert result.slip_end == pytest.approx(0.590, abs=0.02)


def test_slip_solves_its_own_equation():
    slip = published_slip(0.5, size=100)
    grid = published_grid(DEFAULT_READING, 100)
    assert slip.settled
    shear = stuck_traction(1 / 3, "II")(grid.points) / 0.5
    bound = np.sign(slip.slip_rate) * stuck_traction(1 / 3, "I")(grid.points)
    np.testing.assert_allclose(grid.matrix @ slip.slip_rate, shear - bound, atol=1e-11)
    assert slip.at(np.array([0.9]))[0] == 0


@pytest.mark.slow
def test_no_reading_gives_the_published_limit():
    results = examine_all(60)
    limits = np.array([r.reverse_limit for r in results if r.settled])
    assert len(results) == 144
    assert np.all(np.abs(limits[np.isfinite(limits)] - REVERSE_LIMIT) > 0.02)
    assert {r.reading.delay for r in results if np.isinf(r.condition)} == {"printed"}
