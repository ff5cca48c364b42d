"""Bases at friction or next to it, and bases that dwarf the load or are dwarfed by it."""

from typing import Any

import numpy as np
import pytest
from catalogue import unit_scene

from semianalytic import Solution, ViscousFriction, solve
from semianalytic.cut.load import scaled_load
from semianalytic.selfsimilar.zones.collocation import slip_on_grid

# nu, friction, base pressure, load, and what else a scene says
AT_FRICTION: list[tuple[float, float, float, tuple[float, float], dict[str, Any]]] = [
    (0.45, 1.3186, 1.0, (24.54, 1.2), {}),
    (1 / 3, 0.3, 1.0, (0.5, 1.0), {}),
    (1 / 3, 0.3, 1.0, (0.0, 1.0), {}),
    (0.2, 0.6, 2.0, (0.5, -0.4), {}),
    (0.2, 0.6, 2.0, (0.5, 0.4), {"mode": "antiplane"}),
    (0.2, 0.6, 2.0, (0.0, 0.4), {"mode": "antiplane"}),
    (1 / 3, 0.3, 1.0, (0.5, 1.0), {"friction_law": ViscousFriction(0.2)}),
]
X = np.array([0.02, 0.1, 0.3, 0.5, 0.7, 1.3, 1.45])


def readings(solution: Solution) -> dict[str, np.ndarray]:
    """What is held against another answer, each relative to its largest."""
    read = {
        "power": np.array([solution.frictional_power(1.0)]),
        "intensity": np.array(solution.stress_intensity(1.0)),
        "slip": solution.slip(X, 1.0),
        "traction": solution.shear_traction(X, 1.0),
    }
    return {name: value / (np.abs(value).max() or 1.0) for name, value in read.items()}


def beyond(solution: Solution, truth: Solution) -> dict[str, float]:
    """Errors over what either answer says that they may be, of those beyond it."""
    own, exact = readings(solution), readings(truth)
    bound = solution.error_estimate + truth.error_estimate
    ratios = {name: float(np.abs(own[name] - exact[name]).max()) / bound for name in own}
    return {name: ratio for name, ratio in ratios.items() if not ratio <= 1}


@pytest.mark.thinned(28)
@pytest.mark.parametrize("case", AT_FRICTION)
@pytest.mark.parametrize("lacking", [0.0, 1e-16, 1e-8, 5e-7])
def test_a_base_just_below_friction_is_solved_as_well_as_any(
    case: tuple[float, float, float, tuple[float, float], dict[str, Any]], lacking: float
) -> None:
    """A strip of width lacking^2 sticks behind the longitudinal front; power is smooth in it."""
    nu, friction, pressure, load, parts = case
    base = (pressure, friction * pressure * (1 - lacking))
    scene = unit_scene(friction, base, load, nu=nu, **parts)
    truth = solve(scene, rtol=1e-11)
    assert truth.status == "converged"
    for rtol in (1e-6, 1e-9):
        solution = solve(scene, rtol=rtol)
        assert solution.status == "converged"
        assert len(solution.zones) == len(truth.zones)
        assert not beyond(solution, truth)
        if not lacking and load[0]:
            assert solution.zones[-1].outer == scene.fastest_speed


@pytest.mark.parametrize(
    ("nu", "friction", "base", "load", "mode"),
    [
        # 6e-14 of stick behind the longitudinal front
        (0.45, 9.789590288760547, (0.889358275355356, 8.7064518379986), (1.0, 1.0), "antiplane"),
        # slips on 2e-7 behind that front, 1.7e-7 of the largest slip rate
        (
            0.0009693860568606993,
            0.4852161606462533,
            (0.5384870640002458, 0.26128262575187255),
            (1.0, -1.9279800274844288),
            "in-plane",
        ),
    ],
)
def test_fields_beside_a_strip_narrower_than_a_loose_rule_reaches(
    nu: float, friction: float, base: tuple[float, float], load: tuple[float, float], mode: str
) -> None:
    """Two rules that both end before the strip agree with each other and not with the truth."""
    scene = unit_scene(friction, base, load, nu=nu, mode=mode)
    solution, truth = solve(scene, rtol=1e-6), solve(scene, rtol=1e-11)
    assert len(solution.zones) == len(truth.zones)
    assert not beyond(solution, truth)
    bound = solution.error_estimate + truth.error_estimate
    own, exact = solution.stress_intensity(1.0), truth.stress_intensity(1.0)
    np.testing.assert_allclose(own, exact, rtol=bound)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("pressure", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("nu", [0.25, 0.0, -0.5])
def test_without_friction_slip_does_not_feel_how_little_the_contact_opens(
    nu: float, pressure: float
) -> None:
    opening = solve(unit_scene(0.0, (pressure, 0.0), (-1.0, 1.0), nu=nu))
    closed = solve(unit_scene(0.0, (pressure, 0.0), (0.0, 1.0), nu=nu))
    bound = opening.error_estimate + closed.error_estimate
    assert opening.openings
    for name in ("slip", "slip_rate"):
        difference = getattr(opening, name)(X, 1.0) - getattr(closed, name)(X, 1.0)
        assert np.abs(difference).max() <= bound, name


SMALL_LOADS = [
    (1 / 3, 0.3, (0.0, 1.0), "in-plane"),
    (0.0, 1.2, (0.4, -1.0), "in-plane"),
    (-0.5, 0.6, (-1.0, 1.0), "in-plane"),
    (0.25, 0.3, (0.4, 1.0), "antiplane"),
]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("ratio", [1e3, 1e6])
@pytest.mark.parametrize(("nu", "friction", "load", "mode"), SMALL_LOADS)
def test_tractions_under_a_base_that_dwarfs_the_load(
    nu: float, friction: float, load: tuple[float, float], mode: str, ratio: float
) -> None:
    """Slip ends at the edge, at 1 / ratio^2 of the way to the front."""
    scene = unit_scene(friction, (ratio, 0.0), load, nu=nu, mode=mode)
    truth = solve(scene, rtol=1e-11)
    assert truth.status == "converged"
    for rtol in (1e-4, 1e-6):
        solution = solve(scene, rtol=rtol)
        assert solution.status == "converged"
        changes = [one.shear_traction(X, 1.0) - scene.base.shear for one in (solution, truth)]
        assert np.abs(changes[0] - changes[1]).max() <= (
            solution.error_estimate + truth.error_estimate + 1e-15 * ratio
        )
        assert [zone.sense for zone in solution.zones] == [zone.sense for zone in truth.zones]


@pytest.mark.thinned(5)
@pytest.mark.parametrize("lacking", [1e-12, 1e-11, 1e-9])
@pytest.mark.parametrize("pressure", [4.8e4, 4.8e5])
@pytest.mark.parametrize("nu", [0.25, -0.1136])
def test_a_second_zone_is_not_hidden_by_what_is_left_at_the_edge_of_the_first(
    nu: float, pressure: float, lacking: float
) -> None:
    """The load drives slip at the contact edge alone, and so little of it that the traction left at
    that edge to 1e-4 exceeds all that another strip at friction behind the first front slips by."""
    friction = 0.0046
    base = (pressure, friction * pressure * (1 - lacking))
    scene = unit_scene(friction, base, (1.53, -2.07), nu=nu)
    loose, fine = solve(scene, rtol=1e-4), solve(scene, rtol=1e-8)
    if fine.status != "converged":
        assert loose.status != "converged"
        assert "let the base be exactly at friction" in loose.status
        assert loose.error_estimate > 1e-4
        return
    assert (loose.status == "converged") == (len(fine.zones) == len(loose.zones))
    speeds = np.array([(zone.inner, zone.outer) for zone in fine.zones])
    x = np.concatenate([np.linspace(inner, outer, 13)[1:-1] for inner, outer in speeds])
    rates = [one.slip_rate(x, 1.0) for one in (loose, fine)]
    error = np.abs(rates[0] - rates[1]).max() / np.abs(rates[1]).max()
    assert error <= loose.error_estimate + fine.error_estimate


NARROW_OPENINGS = [
    (1 / 3, 0.1547, -0.89, (-1.0, 1.0), {}),
    (-0.86, 0.1477, -0.2, (-1.0, 1.0), {}),
    (1 / 3, 0.0479, -0.61, (-1.0, 0.389), {"mode": "antiplane"}),
    (0.0, 0.0475, -0.88, (-1.0, 0.363), {"friction_law": ViscousFriction(2.85)}),
    (0.2, 0.3, 0.4, (-1.0, 1.0), {}),
    # base and step nearly balance: the sense is not that of the stuck traction at the opening
    (0.21, 0.9516, -0.977, (-1.0, 1.0), {"mode": "antiplane"}),
]


@pytest.mark.thinned(3)
@pytest.mark.parametrize(("nu", "friction", "share", "load", "parts"), NARROW_OPENINGS)
def test_slip_around_openings_that_no_grid_resolves(
    nu: float, friction: float, share: float, load: tuple[float, float], parts: dict[str, Any]
) -> None:
    """The step opposes the base: at the edge it prevails, and a grid shows only the base.

    Close to the edge traction rises like the inverse root of the distance alone, so that opening
    and slip under a base ten times as large are a hundred times as narrow.
    """
    ends = []
    for pressure in (1e5, 1e6):
        base = (pressure, share * friction * pressure)
        scene = unit_scene(friction, base, load, nu=nu, **parts)
        solution = solve(scene, rtol=1e-6)
        assert solution.status == "converged"
        assert not beyond(solution, solve(scene, rtol=1e-10))
        (zone,) = solution.zones
        assert zone.sense == np.sign(load[1])
        assert zone.inner == solution.openings[0].outer < zone.outer
        ends.append((zone.inner, zone.outer))
    # The next term of traction is smaller by the root of the distance, 1e-5.
    np.testing.assert_allclose(np.divide(*ends), 100.0, rtol=1e-3)


def test_antiplane_slip_that_ends_ahead_of_the_rayleigh_front() -> None:
    """The pressure of a stuck edge that reaches ahead of c_R: its factor changes sign there, and
    fields were no numbers.  A complementarity problem on a grid knows no factors."""
    scene = unit_scene(0.4, (2.0, 0.8), (1.0, -0.5755), nu=-0.695, mode="antiplane")
    solution = solve(scene)
    assert solution.status == "converged"
    (zone,) = (zone for zone in solution.zones if zone.outer == scene.fastest_speed)
    assert scene.material.rayleigh_speed < zone.inner < scene.material.shear_speed
    load, stress = scaled_load(scene)
    grid = slip_on_grid(-0.695, load, 192, "III")
    inside = (grid.xi > zone.inner + 0.02) & (grid.xi < zone.outer - 0.02)
    own = solution.slip_rate(grid.xi[inside], 1.0) * scene.material.shear_impedance / (2 * stress)
    largest = np.abs(own).max()
    assert np.abs(own - grid.slip_rate[inside]).max() < 0.02 * largest
    finer = solve(scene, rtol=1e-11)
    assert not beyond(solution, finer)


@pytest.mark.parametrize("law", [{}, {"friction_law": ViscousFriction(0.0033154838)}])
def test_slip_against_a_base_at_friction_does_not_begin_at_the_front(law: dict[str, Any]) -> None:
    """A weak base at friction and a strong load against it: slip begins a little behind the front.

    It was placed at the front itself, as if the base drove it, and the answer was that to the base
    of the other sign: 1e-5 of slip off, with an estimate of 1e-10.  The base alone slips at the
    front, in a strip of 3e-10 c_t.
    """
    friction, pressure = 0.069, 5.1037e-5
    base, load = friction * pressure, (0.017016, -0.659087)
    at, below, other = (
        solve(unit_scene(friction, (pressure, shear), load, nu=-0.0945, **law), rtol=1e-10)
        for shear in (base, base * (1 - 1e-6), -base)
    )
    assert at.status == below.status == other.status == "converged"
    front = at.scene.material.longitudinal_speed
    assert [zone.sense for zone in at.zones] == [-1, -1, 1]
    assert at.zones[-1].outer == pytest.approx(front, rel=1e-12)
    assert 1e-5 < 1 - at.zones[-2].outer / front < 1e-3
    slip, near, far = (one.slip(X, 1.0) for one in (at, below, other))
    largest = np.abs(slip).max()
    assert np.abs(slip - near).max() < 1e-9 * largest
    assert np.abs(slip - far).max() > 1e-6 * largest
