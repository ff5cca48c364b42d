"""Slip from an over-stressed half-line: nine digits of an independent quadrature, and limits."""

import numpy as np
import pytest
from dissimilar_pairs import PAIRS, contrast

import semianalytic as sf
from docs.studies.dissimilar.half_line import half_line_exponent, half_line_speed
from semianalytic.dissimilar.compliance import compliance_of
from semianalytic.dissimilar.phase import slip_phase
from tests.semianalytic.dissimilar.half_line import half_line_slip_rate

SOLID = sf.Material(1.0, 1.0, 1 / 3)
ALIKE = compliance_of(SOLID, SOLID)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("ratio", "friction", "chi", "positive", "negative", "exponents"),
    [
        (1.2, 0.2, 1, None, 0.360433044, ()),
        (1.4, 0.2, 1, 0.385976303, 0.379830317, (0.508394, 0.491661)),
        (1.4, 0.2, 2, 0.173637764, 0.166726952, ()),
        (1.5, 0.2, 1, 0.394936752, 0.387292149, (0.509919, 0.490159)),
        (1.5, 0.2, 2, 0.178058450, 0.169609086, ()),
        (1.5, 0.4, 1, 0.398972442, 0.383686269, (0.519904, 0.480408)),
        (1.5, 0.4, 2, 0.182392415, 0.165496831, ()),
        (1.8, 0.4, 1, 0.421397689, 0.397512913, (0.527052, 0.473538)),
        (1.8, 0.4, 2, 0.194551541, 0.169523728, ()),
    ],
)
def test_half_line(ratio, friction, chi, positive, negative, exponents):
    """Two-body marches have the speeds to a cell: 0.39538, 0.38682 for the fourth row.

    Exponents are those of slip at the edge, ahead and behind.
    """
    bodies = contrast(ratio)
    if positive is None:
        with pytest.raises(sf.SceneError, match="waves grow"):
            half_line_speed(bodies, friction, chi)
    else:
        assert half_line_speed(bodies, friction, chi) == pytest.approx(positive, abs=8e-10)
    assert half_line_speed(bodies.mirrored, friction, chi) == pytest.approx(negative, abs=8e-10)
    assert half_line_speed(bodies, -friction, chi) == pytest.approx(negative, abs=8e-10)
    for sign, speed, known in zip((1, -1), (positive, negative), exponents, strict=False):
        exponent = half_line_exponent(bodies, sign * friction, speed)
        assert 1 - exponent == pytest.approx(known, abs=6e-7)


@pytest.mark.slow
def test_like_bodies():
    assert half_line_speed(ALIKE, 0.3, 1.0) == pytest.approx(0.375, rel=1e-13)
    assert half_line_speed(ALIKE, 0.3, 0.5) == pytest.approx(2 / 3, rel=1e-13)


def test_slip_rate_of_like_bodies_is_that_beside_a_slot():
    scene = sf.Scene(SOLID, 0.5, sf.Tractions(2.0, 0.0), sf.Tractions(0.0, 1.0))
    x = np.array([0.02, 0.1, 0.3, 0.37, 0.4])
    # the slot of chi_b = 1 takes 1 of the 2 that are too much and missing together
    rate = 2 * half_line_slip_rate(ALIKE, 0.0, 1.0, x)
    np.testing.assert_allclose(rate, sf.solve(scene, rtol=1e-11).slip_rate(x, 1.0), rtol=1e-9)


@pytest.mark.parametrize(
    ("ratio", "friction", "regular"),
    [
        (1.2, 0.05, False),
        (1.2, 0.5, False),
        (1.4, 0.4, False),
        (1.4, 0.29, True),
        (1.2, -0.2, True),
        (1.4, -0.4, True),
        (1.5, 0.4, True),
    ],
)
def test_the_limit_of_the_phase_tells_whether_waves_grow(ratio, friction, regular):
    """theta tends to pi / 2 + arctan(f beta), and to 2 pi less for a wave that grows."""
    bodies = contrast(ratio)
    phase = slip_phase(bodies, friction)
    limit = np.pi / 2 + np.arctan(friction * bodies.dundurs) - (0 if regular else 2 * np.pi)
    assert phase.limit == pytest.approx(limit, abs=1e-6)
    assert phase.is_regular(friction) == regular


def test_dundurs_parameter_is_that_of_the_moduli():
    assert contrast(1.5).dundurs == pytest.approx(0.12821, abs=6e-6)
    assert compliance_of(*PAIRS["0"]).dundurs == pytest.approx(0.15183, abs=6e-6)
    assert compliance_of(*PAIRS["PMMA on aluminium"]).dundurs == pytest.approx(0.2093, abs=6e-5)


def test_what_cannot_be_is_refused():
    with pytest.raises(sf.SceneError, match="slower than all waves"):
        half_line_speed(ALIKE, 0.2, 1e-6)
