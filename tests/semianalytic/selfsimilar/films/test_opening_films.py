"""Films of high viscosity whose contact opens, and friction that falls with slip rate: answers or
one sentence, in bounded memory."""

import tracemalloc

import pytest

from semianalytic import (
    Material,
    RateWeakening,
    Scene,
    Tractions,
    ViscousFriction,
    solve,
)
from semianalytic.selfsimilar.zones import tuning


def film(
    nu: float, friction: float, base: float, load: tuple[float, float], viscosity: float
) -> Scene:
    law = ViscousFriction(viscosity)
    return Scene(
        Material(1.0, 1.0, nu),
        friction,
        Tractions(base, 0.0),
        Tractions(*load),
        friction_law=law,
    )


FORETOLD = 1.1  # nodes over those that were foretold, at the most
STRONG = film(-0.3873, 0.04297, 0.05138, (-1.0, -0.4025), 6794.0)
# those of the first two zones once met both ends at the shear front
FILMS = [
    film(0.0, 0.13935, 0.017959, (-1.0, 0.041486), 1460.3),
    film(1 / 3, 0.02, 0.0047, (1.0, 0.43), 321.0),
    film(0.25, 0.2, 0.05, (-1.0, 0.5), 889.0),
    film(0.25, 0.05, 0.05, (-1.0, -0.3), 401.0),
    film(0.45, 0.05, 0.2, (-1.0, 0.4), 889.0),
]


@pytest.mark.thinned(4)
@pytest.mark.parametrize("scene", FILMS)
@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_strong_films_that_open_are_solved(scene: Scene, rtol: float) -> None:
    solution = solve(scene, rtol=rtol)
    assert solution.status == "converged"
    assert solution.openings


@pytest.mark.slow
@pytest.mark.parametrize("reduction", [0.314, 0.4])
@pytest.mark.parametrize("load", [-10.4, 10.1])
def test_falling_friction_is_answered_or_refused(reduction: float, load: float) -> None:
    """Zone edges pass the shear front on the way, and leave the nodes of slip rate behind."""
    scene = Scene(
        Material(1.0, 1.0, 1 / 3),
        0.33,
        Tractions(0.13, 0.0),
        Tractions(0.0, load),
        friction_law=RateWeakening(0.33, reduction),
    )
    solution = solve(scene, rtol=1e-5)
    assert solution.zones
    assert solution.status == "converged" or "which no rule resolves" in solution.status


@pytest.mark.slow
def test_what_would_take_more_than_seconds_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tuning, "MOST_NODES", 4_000)
    solution = solve(STRONG, rtol=1e-11)
    # nodes are foretold from a looser rule, which the layout of panels and films makes longer
    assert solution.statistics.nodes < FORETOLD * 4_000
    assert 1e-11 < solution.error_estimate < 1e-3
    assert solution.status.endswith(
        "for which more than 4,000 nodes and far more than seconds are needed"
    )


@pytest.mark.slow
def test_memory_of_a_strong_film_is_bounded() -> None:
    """Gigabytes when tables of thirty-two rules were kept and rules had 20,000 nodes."""
    tracemalloc.start()
    try:
        solution = solve(STRONG, rtol=1e-12)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert solution.statistics.nodes < FORETOLD * tuning.MOST_NODES
    assert peak < 600e6


@pytest.mark.slow
@pytest.mark.parametrize(("poisson_ratio", "friction"), [(0.25, 0.6), (1 / 3, 0.05)])
def test_falling_friction_whose_exponent_rounds_to_zero_is_told(
    poisson_ratio: float, friction: float
) -> None:
    """A zone edge comes so close to c_R that slip rate has the power 0 beside it."""
    law = RateWeakening(0.33, 0.314)
    solid = Material(1.0, 1.0, poisson_ratio)
    scene = Scene(solid, friction, Tractions(0.13, 0.0), Tractions(0.0, -10.4), friction_law=law)
    assert "which no rule resolves" in solve(scene).status


def test_an_edge_on_the_end_of_an_opening_is_told() -> None:
    """Draw 242 of the campaign: on the way an edge came to within an ulp of where the contact
    closes, and no panel fits between them."""
    solid, law = Material(1.0, 1.0, 1 / 3), ViscousFriction(25.477720953237093)
    friction, pressure = 0.12567124170729066, 2.322356715388106e-05
    base = Tractions(pressure, friction * pressure)
    scene = Scene(solid, friction, base, Tractions(1.0, 1.0), mode="antiplane", friction_law=law)
    solution = solve(scene, rtol=1e-9)
    assert solution.openings
    assert solution.status == "converged" or "Coulomb's law" in solution.status
