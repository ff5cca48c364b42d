"""Bases at friction or next to it, or that dwarf the load or are dwarfed by it, weak friction, and
thresholds of zones: all converge."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from catalogue import REMOTE, unit_scene

from semianalytic import ComputationError, Coulomb, Tractions, solve
from semianalytic.cut.load import scaled_load
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.selfsimilar.zones import guesses
from semianalytic.selfsimilar.zones.collocation import slip_on_grid
from semianalytic.selfsimilar.zones.weak_friction import frictionless_profile, slip_senses
from tests.semianalytic.selfsimilar.test_separation import errors

# nu, friction, base pressure, load, and what else a scene says
AT_FRICTION = [
    (1 / 3, 0.3, 1.0, (0.5, 1.0), {}),
    (0.45, 1.3186, 1.0, (24.54, 1.2), {}),
    (1 / 3, 0.3, 1.0, (0.0, 1.0), {}),
    (0.2, 0.6, 2.0, (0.5, -0.4), {}),
    (0.2, 0.6, 2.0, (0.5, 0.4), {"mode": "antiplane"}),
    (0.2, 0.6, 2.0, (0.0, 0.4), {"mode": "antiplane"}),
    (1 / 3, 0.3, 1.0, (0.5, 1.0), {"law": Coulomb(1.0, viscosity=0.2)}),
]
X = np.array([0.02, 0.1, 0.3, 0.5, 0.7, 1.3, 1.45])


def beyond(solution, truth):
    """Errors beyond what the two answers say that they may be, by name."""
    bound = solution.error_estimate + truth.error_estimate
    return {name: off for name, off in errors(solution, truth).items() if not off <= bound}


def check_against_truth(scene, *rtols):
    """Answers of a scene at some tolerances, within what they and the last one say of errors."""
    truth = solve(scene, rtol=1e-11)
    assert truth.status == "converged"
    answers = [solve(scene, rtol=rtol) for rtol in rtols]
    for solution in answers:
        assert solution.status == "converged"
        assert [zone.sense for zone in solution.zones] == [zone.sense for zone in truth.zones]
        assert not beyond(solution, truth)
    return answers


@pytest.mark.thinned(28)
@pytest.mark.parametrize("case", AT_FRICTION)
@pytest.mark.parametrize("lacking", [0.0, 1e-16, 1e-8, 5e-7])
def test_a_base_just_below_friction_is_solved_as_well_as_any(case, lacking):
    """A strip of width lacking^2 sticks behind the longitudinal front; power is smooth in it."""
    nu, friction, pressure, load, parts = case
    base = (pressure, friction * pressure * (1 - lacking))
    scene = unit_scene(friction, base, load, nu=nu, **parts)
    for solution in check_against_truth(scene, 1e-6, 1e-9):
        if not lacking and load[0]:
            assert solution.zones[-1].outer == scene.fastest_speed


BARELY = (0.5384870640002458, 0.26128262575187255)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("nu", "friction", "base", "load", "mode"),
    [
        # 6e-14 of stick behind the longitudinal front
        (0.45, 9.789590288760547, (0.889358275355356, 8.7064518379986), (1.0, 1.0), "antiplane"),
        # slips on 2e-7 behind that front, 1.7e-7 of the largest slip rate
        (9.693860568606993e-4, 0.4852161606462533, BARELY, (1.0, -1.9279800274844288), "in-plane"),
    ],
)
def test_fields_beside_a_strip_narrower_than_a_loose_rule_reaches(nu, friction, base, load, mode):
    """Two rules that both end before the strip agree with each other and not with the truth."""
    check_against_truth(unit_scene(friction, base, load, nu=nu, mode=mode), 1e-6)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("pressure", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("nu", [0.25, 0.0, -0.5])
def test_without_friction_slip_does_not_feel_how_little_the_contact_opens(nu, pressure):
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
def test_tractions_under_a_base_that_dwarfs_the_load(nu, friction, load, mode, ratio):
    """Slip ends at the edge, at 1 / ratio^2 of the way to the front."""
    scene = unit_scene(friction, (ratio, 0.0), load, nu=nu, mode=mode)
    truth = solve(scene, rtol=1e-11)
    assert truth.status == "converged"
    for rtol in (1e-4, 1e-6):
        solution = solve(scene, rtol=rtol)
        assert solution.status == "converged"
        changes = [answer.shear_traction(X, 1.0) - scene.base.shear for answer in (solution, truth)]
        assert np.abs(changes[0] - changes[1]).max() <= (
            solution.error_estimate + truth.error_estimate + 1e-15 * ratio
        )
        assert [zone.sense for zone in solution.zones] == [zone.sense for zone in truth.zones]


@pytest.mark.thinned(5)
@pytest.mark.parametrize("lacking", [1e-12, 1e-11, 1e-9])
@pytest.mark.parametrize("pressure", [4.8e4, 4.8e5])
@pytest.mark.parametrize("nu", [0.25, -0.1136])
def test_a_second_zone_is_not_hidden_by_what_is_left_at_the_edge_of_the_first(
    nu, pressure, lacking
):
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
    rates = [answer.slip_rate(x, 1.0) for answer in (loose, fine)]
    error = np.abs(rates[0] - rates[1]).max() / np.abs(rates[1]).max()
    assert error <= loose.error_estimate + fine.error_estimate


NARROW_OPENINGS = [
    (1 / 3, 0.1547, -0.89, (-1.0, 1.0), {}),
    (-0.86, 0.1477, -0.2, (-1.0, 1.0), {}),
    (1 / 3, 0.0479, -0.61, (-1.0, 0.389), {"mode": "antiplane"}),
    (0.0, 0.0475, -0.88, (-1.0, 0.363), {"law": Coulomb(1.0, viscosity=2.85)}),
    (0.2, 0.3, 0.4, (-1.0, 1.0), {}),
    # base and step nearly balance: the sense is not that of the stuck traction at the opening
    (0.21, 0.9516, -0.977, (-1.0, 1.0), {"mode": "antiplane"}),
]


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("nu", "friction", "share", "load", "parts"), NARROW_OPENINGS)
def test_slip_around_openings_that_no_grid_resolves(nu, friction, share, load, parts):
    """The step opposes the base: at the edge it prevails, and a grid shows only the base.

    Close to the edge traction rises like the inverse root of the distance alone, so that opening
    and slip under a base ten times as large are a hundred times as narrow.
    """
    ends = []
    for pressure in (1e5, 1e6):
        base = (pressure, share * friction * pressure)
        scene = unit_scene(friction, base, load, nu=nu, **parts)
        (solution,) = check_against_truth(scene, 1e-6)
        (zone,) = solution.zones
        assert zone.sense == np.sign(load[1])
        assert zone.inner == solution.openings[0].outer < zone.outer
        ends.append((zone.inner, zone.outer))
    # The next term of traction is smaller by the root of the distance, 1e-5.
    np.testing.assert_allclose(np.divide(*ends), 100.0, rtol=1e-3)


def test_antiplane_slip_that_ends_ahead_of_the_rayleigh_front():
    """The pressure of a stuck edge that reaches ahead of c_R: its factor changes sign there, and
    fields were no numbers.  A complementarity problem on a grid knows no factors."""
    scene = unit_scene(0.4, (2.0, 0.8), (1.0, -0.5755), nu=-0.695, mode="antiplane")
    solution = solve(scene)
    assert solution.status == "converged"
    assert not beyond(solution, solve(scene, rtol=1e-11))
    (zone,) = (zone for zone in solution.zones if zone.outer == scene.fastest_speed)
    assert scene.material.rayleigh_speed < zone.inner < scene.material.shear_speed
    load, stress = scaled_load(scene)
    grid = slip_on_grid(-0.695, load, 128, "III")
    inside = (grid.xi > zone.inner + 0.02) & (grid.xi < zone.outer - 0.02)
    own = solution.slip_rate(grid.xi[inside], 1.0) * scene.material.shear_impedance / (2 * stress)
    largest = np.abs(own).max()
    assert np.abs(own - grid.slip_rate[inside]).max() < 0.02 * largest


@pytest.mark.thinned(2)
@pytest.mark.parametrize("law", [{}, {"law": Coulomb(1.0, viscosity=0.0033154838)}])
def test_slip_against_a_base_at_friction_does_not_begin_at_the_front(law):
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
    slip, near, far = (answer.slip(X, 1.0) for answer in (at, below, other))
    largest = np.abs(slip).max()
    assert np.abs(slip - near).max() < 1e-9 * largest
    assert np.abs(slip - far).max() > 1e-6 * largest


# --- friction that is weak against the load, thresholds of zones, bases at friction ---------------


def edges_from_c(solution):
    """Zone edges in slowness over that of the Rayleigh wave, less 1, from the front inward."""
    speed = solution.scene.material.rayleigh_speed
    edges = [edge for zone in solution.zones[::-1] for edge in (zone.outer, zone.inner)]
    return np.array([speed / edge - 1 for edge in edges[1:-1]])


def random_weak_scenes(count, seed=5):
    """Friction 1e-13 ... 1e-2, base up to friction, shear step with and without pressure."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        nu = float(random.choice([1 / 3, 0.25, 0.0, 0.45, -0.5, random.uniform(-0.95, 0.49)]))
        friction = float(10 ** random.uniform(-13, -2))
        share = float(random.choice([0, 0, random.uniform(-1, 1), 1, -1]))
        pressure = float(random.choice([0, 1, min(random.lognormal(), 2.0)]))  # more may open it
        yield unit_scene(
            friction, (1.0, share * friction), (pressure, float(random.normal() + 0.01)), nu=nu
        )


@pytest.mark.parametrize("nu", [-0.5, 0.0])
def test_gaps_shrink_to_where_a_frictionless_interface_changes_sense(nu):
    """Gaps are 4 f p / (pi m |V'|) wide, and off by no more than a few widths."""
    factors = rayleigh_factors(nu)
    load, _ = scaled_load(unit_scene(0.0, nu=nu))
    profile = frictionless_profile(factors, load, rule_for(1e-10))
    senses, changes = slip_senses(profile)
    assert senses == [1, -1, 1]
    for friction, error in ((1e-5, 0.05), (1e-7, 2e-3), (1e-9, 1e-3)):
        solution = solve(unit_scene(friction, nu=nu), rtol=1e-9)
        assert [zone.sense for zone in solution.zones] == senses
        v = factors.c * (1 + edges_from_c(solution))
        for change, start, end in zip(changes, v[::2], v[1::2], strict=True):
            beside = factors.cut(change.v + np.array([-1e-5, 1e-5]))
            slope = np.diff(profile.slip_rate_at(beside))[0] / 2e-5
            impedance = factors.impedance_behind(change)[0]
            width = abs(4 * friction / (np.pi * impedance * slope))
            assert end - start == pytest.approx(width, rel=error)
            assert abs((start + end) / 2 - change.v[0]) < 10 * width


@pytest.mark.parametrize("nu", [0.25, 1 / 3, 0.42])
def test_reversed_strip_begins_at_a_gap_of_the_same_shape_whatever_its_width(nu):
    """Beside c the slip rate is r ln(|v - c| / d): with the impedance m' |v - c| the strip is there
    below f P = m' r d."""
    factors = rayleigh_factors(nu)
    profile = frictionless_profile(factors, scaled_load(unit_scene(0.0, nu=nu))[0], rule_for(1e-10))
    change = slip_senses(profile)[1][0]
    distance = abs(change.from_c[0])
    near = factors.beside("c", [-1e-3 * distance, -1e-6 * distance])
    residue = abs(np.diff(profile.slip_rate_at(near))[0] / np.log(1e-3))
    impedance = abs(factors.impedance_behind(near)[1] / near.from_c[1])
    threshold = impedance * residue * distance
    for share, senses in ((0.99, [1, -1, 1]), (1.01, [1, 1])):
        solution = solve(unit_scene(share * threshold, nu=nu), rtol=1e-8)
        assert solution.status == "converged"
        assert [zone.sense for zone in solution.zones] == senses
        if share > 1:  # a gap twice as wide as the frictionless strip
            np.testing.assert_allclose(
                np.abs(edges_from_c(solution)), 2 * distance / factors.c, rtol=1e-3
            )


@pytest.mark.slow
def test_weak_friction_converges_and_its_estimates_are_honest():
    random = np.random.default_rng(1)
    for scene in random_weak_scenes(200):
        rtol = float(10 ** random.uniform(-10, -3))
        rough, fine = solve(scene, rtol=rtol), solve(scene, rtol=1e-11)
        assert rough.status == fine.status == "converged", scene
        assert len(rough.zones) == len(fine.zones), scene
        shift = np.abs(edges_from_c(rough) - edges_from_c(fine)).max(initial=0.0)
        assert shift <= rough.error_estimate + fine.error_estimate, scene
        xi = np.concatenate([np.linspace(0.02, 0.85, 40), np.linspace(1.01, 1.1, 5)])
        rates = [solution.slip_rate(xi, 1.0) for solution in (rough, fine)]
        error = np.abs(rates[0] - rates[1]).mean() / np.abs(rates[1]).max()
        assert error <= rough.error_estimate + fine.error_estimate, scene


@pytest.mark.thinned(12)
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-11])
@pytest.mark.parametrize(
    ("nu", "friction", "base_shear", "load"),
    [
        # a zone at the contact edge, 2e-8 to 1e-3 c_t wide
        (-0.668412, 1.175155, 0.0, (0.144159, -0.155212)),
        (-0.341855, 2.053364, 0.0, (0.196097, 0.360653)),
        (0.25, 6.490977552443996, 1.9762036453781235, (0.0, -0.15675240784210584)),
        (-0.5135369447652877, 6.550784944967467, -6.550784944967467, (0.0, 0.05347031962798677)),
        # a zone that begins at the shear front
        (0.106102, 5.370015, 3.293087, (7.085569, 8.792634)),
        # two zones that have just met ahead of the shear front
        (1 / 3, 0.9720500888564216, 0.9720500888564216, (2.606598022703546, -0.6606035659153582)),
        # a base at friction against the step slips from the longitudinal front, hardly at all
        (-0.0016717099939256297, 0.0425947043849407, 0.0425947043849407, (1.51, -0.58)),
        # a reversed strip of 1e-11 c_R, and friction near its threshold
        (0.4309416337316456, 6.722243237448132e-13, -4.14e-14, (0.1856025051715419, 1.0)),
        (0.40531283926675066, 1.0056741452272527e-10, -9.47e-11, (9.429929, 0.273157)),
        (0.2, 5.6e-7, 0.0, (0.0, 1.0)),
        (0.2, 1e-12, 0.0, (0.0, 1.0)),
    ],
)
def test_thresholds_that_used_to_end_in_a_status(nu, friction, base_shear, load, rtol):
    solution = solve(unit_scene(friction, (1.0, base_shear), load, nu=nu), rtol=rtol)
    assert solution.status == "converged"
    assert solution.error_estimate <= rtol


@pytest.mark.parametrize(
    ("excess", "rtol"),
    [(1e-3, 1e-8), (1e-4, 1e-10), (1e-5, 1e-8), (2e-6, 1e-8), (1e-8, 1e-4)],
)
def test_edge_just_below_its_threshold(excess, rtol):
    """Remote load at nu = 1/3: the zone is 8 (1 - chi / sqrt(b/a)) c_t wide.

    Slip falls like the square of the excess: rounding leaves it fewer digits.
    """
    near = unit_scene(np.sqrt(2) * (1 - excess), **REMOTE)
    solution = solve(near, rtol=rtol)
    assert solution.status == "converged"
    (zone,) = solution.zones
    assert zone.inner == 0.0
    assert zone.outer == pytest.approx(8 * excess, rel=min(20 * excess + 1e-15 / excess, 0.01))


@pytest.mark.parametrize("sign", [1, -1])
def test_nothing_happens_without_a_step_though_the_base_is_at_friction(sign):
    for friction in (1e-3, 0.3, 1 / 3):
        solution = solve(unit_scene(friction, (1.0, sign * friction), (0.0, 0.0), nu=0.25))
        assert solution.status == "converged"
        assert solution.zones == ()
        assert not solution.slip_rate(np.linspace(0.1, 2.0, 5), 1.0).any()


def test_a_base_above_friction_by_rounding_does_not_slide():
    friction = 8.783039916140936e-05
    just_above = unit_scene(friction, (1.0, float(np.nextafter(friction, 1.0))))
    assert just_above.far_slip_rate == 0.0
    nothing, sliding = Tractions(0.0, 0.0), Tractions(1.0, friction * 1.001)
    remote = replace(just_above, base=nothing, load=sliding, load_on="remote")
    assert remote.far_slip_rate > 0
    solution = solve(just_above)
    assert solution.status == "converged"
    assert solution.zones[-1].outer == pytest.approx(just_above.material.longitudinal_speed)


def test_grids_on_which_pivoting_fails_are_passed_over(monkeypatch):
    """Lemke's method may end on a ray by rounding; then the next grid is tried, or a status."""
    slip_on_grid, sizes = guesses.slip_on_grid, []

    def failing(poisson_ratio, load, size, mode, most=1):
        sizes.append(size)
        if len(sizes) <= most:
            raise ComputationError("ended on a ray")
        return slip_on_grid(poisson_ratio, load, size, mode)

    expected = solve(unit_scene(0.3, nu=0.25)).zones
    monkeypatch.setattr(guesses, "slip_on_grid", failing)
    found = solve(unit_scene(0.3, nu=0.25))
    assert sizes == [48, 96]
    assert found.status == "converged"
    assert found.zones[0].outer == pytest.approx(expected[0].outer, rel=1e-8)
    monkeypatch.setattr(guesses, "slip_on_grid", partial(failing, most=99))
    failed = solve(unit_scene(0.3, nu=0.25))
    assert "no set of slip zones" in failed.status
    assert failed.error_estimate == np.inf


def test_friction_that_rounding_takes_from_the_load_is_none():
    none = solve(unit_scene(0.0, nu=0.25))
    for friction in (1e-300, 1e-16):
        faint = solve(unit_scene(friction, nu=0.25))
        assert faint.status == "converged"
        assert faint.zones == none.zones
