"""The space-time solver in plane and under antiplane shear: against the self-similar solver and
closed forms, and its invariants."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import UNIT, problems, unit_scene
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import j1

import semianalytic as sf
from docs.studies.article.stuck import stuck_pressure, stuck_shear
from semianalytic.engine.nodes import causal_grid
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Antiplane, InPlane
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.scene import MODES
from tests.semianalytic.engine.scenes.runs import march, preloaded, relative_l1


def error_of_step(scene, nodes, **options):
    marched = march(scene, nodes=nodes, every=10**6, **options)
    x = marched.interface.x
    seen = (x > 0.02) & (x < 1.9)
    return relative_l1(
        marched.interface.slip_rate[-1, seen], sf.solve(scene).slip_rate(x[seen], 1.0)
    )


def total_error_of_order(errors):
    return np.log2(errors[0] / errors[-1]) / (len(errors) - 1)


# --- the memory of the interface ------------------------------------------------------------


@pytest.mark.parametrize("nu", [-0.9, -0.3, 0.0, 1 / 3, 0.499])
def test_transform_is_the_mode_two_impedance(nu):
    """G(s) = M(k) b / (mu b^2) at slowness k = i/s, M from the Rayleigh function; in mode III
    sqrt(b^2 - k^2) / b."""
    factors = rayleigh_factors(nu)
    s = np.array([0.01 + 0.3j, 0.2 + 1.4j, 3.0 + 0j, 0.5 + 9j])
    k = 1j / s
    alpha, beta = np.sqrt(factors.a**2 - k**2), np.sqrt(1 - k**2)
    expected = ((1 - 2 * k**2) ** 2 + 4 * k**2 * alpha * beta) / beta
    np.testing.assert_allclose(InPlane(factors.a)(s), expected, rtol=1e-9)
    np.testing.assert_allclose(Antiplane()(s), np.sqrt(1 - k**2), rtol=1e-13)


@pytest.mark.thinned(9)
@pytest.mark.parametrize("nu", [-0.9, 0.0, 1 / 3, 0.49])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_memory_in_the_time_domain(nu, tolerance):
    """h against its inverse Laplace transform on a line, minus the slow tail known at s = 0."""
    ratio = rayleigh_factors(nu).a
    memory = fit_memory(InPlane(ratio), 200.0, tolerance)
    assert memory.poles.real.max() < 0
    assert memory.static == pytest.approx(1 / (1 - nu))
    x = np.array([0.0, 0.3, 1.0, 3.0, 10.0])
    # G - 1 - (first terms at infinity) decays fast enough for a plain trapezoid
    shift, step = 1.0, 0.02
    omega = step * np.arange(-200_000, 200_001)
    s = shift + 1j * omega
    second = 3.5 - 4 * ratio
    values = InPlane(ratio)(s) - 1 - second / (s * s + 1)
    exact = [(values @ np.exp(s * v)).real * step / (2 * np.pi) + second * np.sin(v) for v in x]
    np.testing.assert_allclose(memory(x), exact, atol=500 * tolerance + 1e-7)


def test_edge_of_the_grid():
    """Nodal values follow 1/sqrt(n + offset) ever closer; the static problem gives them too."""
    offset, factors = edge_offset_and_factors()
    assert 0.3 < offset < 0.32
    assert np.abs(factors[100:200] - 1).max() < np.abs(factors[10:20] - 1).max() / 4
    assert np.abs(factors[300:] - 1).max() < 1e-3


# --- step loads: the self-similar solver ----------------------------------------------------


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("name", "finest", "order"),
    [("preloaded", 2e-4, 1.2), ("antiplane", 4e-4, 1.0), ("remote-shock", 1e-3, 0.8)],
)
def test_step_converges_to_the_self_similar_solution(name, finest, order):
    """Measured 0.071, 0.027, 0.0098 %, 0.14, 0.061, 0.026 % and 0.33, 0.12, 0.066 % at 256, 512,
    1024 nodes."""
    errors = [error_of_step(find_scene(name), nodes) for nodes in (256, 512, 1024)]
    assert errors[-1] < finest
    assert total_error_of_order(errors) > order


@pytest.mark.thinned(3)
@pytest.mark.parametrize(("nu", "error"), [(-0.5, 3e-3), (0.0, 1.5e-3), (0.45, 5e-4)])
def test_step_at_other_poisson_ratios(nu, error):
    """Measured 0.20, 0.087, 0.025 %; worst where the step is small next to c_l dt = h."""
    scene = replace(preloaded(0.4), material=sf.Material(1.0, 1.0, nu))
    marched = march(scene, nodes=600, length=1.5, every=10**6)
    x = marched.interface.x[5:]
    found = marched.interface.slip_rate[-1, 5:]
    assert relative_l1(found, sf.solve(scene).slip_rate(x, 1.0)) < error


@pytest.mark.slow
@pytest.mark.parametrize("step_ratio", [0.1, 0.5])
def test_short_waves_are_damped(step_ratio):
    """Undamped, odd-even waves stay: the smaller the step, the more (0.24 % against 0.027 %)."""
    errors = [
        error_of_step(preloaded(), 512, step_ratio=step_ratio, damping=damping)
        for damping in (0.0, 0.7)
    ]
    assert errors[1] < 4e-4
    assert errors[1] < (0.3 if step_ratio < 0.5 else 1.1) * errors[0]


def test_units_do_not_matter():
    steel = sf.Material(80e9, 7800.0, 1 / 3)
    scene = sf.Scene(steel, 0.3, sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 5e6))
    unit = march(preloaded(), nodes=64)
    real = march(scene, end_time=1e-4, nodes=64)
    scale = 5e6 / steel.shear_impedance
    # the memory of a small grid has single precision, 1.2e-7 of each number
    np.testing.assert_allclose(
        real.interface.slip_rate, scale * unit.interface.slip_rate, atol=1e-6 * scale
    )


def test_everything_slips_below_unit_strength():
    """Remote load with friction below shear over pressure: uniform sliding ahead of all waves."""
    scene = replace(find_scene("remote-shock"), friction=0.5)
    marched = march(scene, nodes=400, every=10**6)
    x = marched.interface.x
    ahead = x > 1.02 * scene.material.longitudinal_speed
    assert relative_l1(marched.interface.slip_rate[-1], sf.solve(scene).slip_rate(x, 1.0)) < 3e-3
    np.testing.assert_allclose(
        marched.interface.slip_rate[-1, ahead], scene.far_slip_rate, rtol=1e-3
    )


# --- the edge -------------------------------------------------------------------------------


def stuck_error(history, where, mode):
    """Shear traction of a stuck interface by the grid against (3.20), x = where(n) h."""
    scene = preloaded(1e6, shear_history=history, mode=mode)
    marched = march(scene, nodes=300, every=10**6, estimate=False)
    assert not marched.interface.slip_rate.any()
    offset, factors = edge_offset_and_factors()
    x = (np.arange(60) + (offset if where is None else where)) * marched.spacing
    load = float(history.value(1.0))
    exact = stuck_shear(history, 1.0, UNIT, x, 1.0, scene.shear_mode).value + load
    found = marched.interface.shear_traction[-1, :60] + load
    return relative_l1(found / (factors[:60] if where is None else 1.0), exact)


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("history", "mode", "most"),
    [
        (sf.Step(), "in-plane", 2e-3),
        (sf.Ramp(0.5), "in-plane", 2e-3),
        (sf.Step(), "antiplane", 1e-3),
    ],
)
def test_edge_of_the_grid_is_where_the_stuck_traction_says(history, mode, most):
    """With the grid's own edge 0.1 %; with the nodes taken at face value 30 times worse."""
    right = stuck_error(history, None, mode)
    assert right < most
    assert stuck_error(history, 0.5, mode) > 10 * right
    assert stuck_error(history, 0.1, mode) > 10 * right


# --- other histories: superposition and invariants -------------------------------------------

# What turns faster than 120 nodes on a length of 1 follow is refused: see test_resolution.py.
# Friction is none or more than the ripples of the grid, which are a millionth of the load.
FRICTIONS = st.just(0.0) | st.floats(1e-3, 0.8)
# Loads of 5e-324 have no digits left for two per cent of a slip rate to mean anything.
LEVELS = st.floats(-1.0, 1.0).map(lambda value: round(value, 6))
HISTORIES = st.one_of(
    st.builds(sf.Ramp, st.one_of(st.just(0.0), st.floats(1e-3, 2.0))),
    st.builds(
        sf.Pulse,
        st.floats(0.14, 1.5),
        st.sampled_from(["rectangle", "triangle", "half-sine", "haversine"]),
    ),
    st.builds(sf.Harmonic, st.floats(0.3, 4.0)),
    st.lists(st.tuples(st.floats(0.0, 1.0), LEVELS), min_size=1, max_size=5).map(
        lambda pairs: sf.Tabulated(
            tuple(np.cumsum([step + 0.14 for step, _ in pairs])), tuple(v for _, v in pairs)
        )
    ),
)


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(HISTORIES)
def test_stuck_traction_of_any_history(history):
    """High friction: shear traction is the exact stuck one, and nothing moves."""
    scene = sf.Scene(UNIT, 1e3, sf.Tractions(5.0, 0.0), sf.Tractions(0.1, 1.0), history, history)
    marched = march(scene, nodes=200, every=10**6)
    assert not marched.interface.slip_rate.any()
    x = marched.interface.x[20:]
    shear = stuck_shear(history, 1.0, UNIT, x, 1.0).value
    pressure = 5 + stuck_pressure(history, 0.1, UNIT, x, 1.0).value
    assert np.abs(marched.interface.shear_traction[-1, 20:] - shear).mean() < 0.01
    assert np.abs(marched.interface.pressure[-1, 20:] - pressure).mean() < 0.001


def in_excess(marched, strength):
    """Nodes and levels at which the traction at rest exceeds the strength, as on either side.

    Elsewhere a zone may end within the stretch of a node, which slips by the mean (`area_means`).
    """
    impedance = marched.scene.material.shear_impedance / 2
    fields = marched.interface
    # Signed, since a weak strength may be exceeded in one sense beside the other: slip turns there.
    rest = fields.shear_traction + impedance * fields.slip_rate
    sense = np.where(np.abs(rest) > strength, np.sign(rest), 0)
    inside = sense != 0
    inside[:, 1:-1] &= (sense[:, :-2] == sense[:, 1:-1]) & (sense[:, 2:] == sense[:, 1:-1])
    inside[:, -1] = False  # its neighbour is beyond what is stored
    return inside


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(HISTORIES, FRICTIONS, st.floats(-0.9, 0.9), st.floats(-0.4, 0.45))
def test_invariants(history, friction, share, nu):
    """Coulomb's inequality, dissipation, causality, for shear from rest under any history."""
    scene = unit_scene(friction, (1.0, share * friction), nu=nu, shear_history=history)
    marched = march(scene, nodes=240, length=2.5)
    fields = marched.interface
    strength = friction * fields.pressure
    assert (np.abs(fields.shear_traction) <= strength + 1e-12).all()
    slips, inside = fields.slip_rate != 0, in_excess(marched, strength)
    # Without friction the ripples of the grid slip too, in either sense.
    assert not friction or inside.sum() >= 0.3 * slips.sum()
    np.testing.assert_allclose(
        fields.shear_traction[inside], (np.sign(fields.slip_rate) * strength)[inside], atol=1e-12
    )
    assert (fields.slip_rate * fields.shear_traction >= 0).all()
    assert (marched.final_work_density >= 0).all()
    np.testing.assert_allclose(marched.final_work_density, friction * marched.final_path, atol=1e-9)
    assert (np.abs(fields.slip[-1]) <= marched.final_path + 1e-12).all()
    ahead = fields.x > scene.material.longitudinal_speed * fields.t[:, None] + 0.1
    assert np.abs(fields.slip_rate[ahead]).max(initial=0.0) <= 0.02 * np.abs(fields.slip_rate).max()


def test_direction_of_the_load_is_that_of_the_slip():
    run = march(preloaded(shear_history=sf.Harmonic(1.0)), nodes=100)
    other = march(preloaded(shear=-1.0, shear_history=sf.Harmonic(1.0)), nodes=100)
    np.testing.assert_array_equal(run.interface.slip_rate, -other.interface.slip_rate)


def test_ramp_without_rise_is_a_step():
    step, ramp = (march(preloaded(shear_history=f), nodes=50) for f in (sf.Step(), sf.Ramp(0)))
    np.testing.assert_array_equal(step.interface.slip, ramp.interface.slip)


def test_jump_within_the_run_falls_on_a_time_level():
    """A rectangle pulse is a step until it ends, whatever the spacing."""
    pulse = march(preloaded(shear_history=sf.Pulse(0.371)), nodes=300)
    end = int(np.argmin(np.abs(pulse.interface.t - 0.371)))
    assert pulse.interface.t[end] == pytest.approx(0.371, abs=1e-14)
    x = pulse.interface.x
    seen = (x > 0.02) & (x < 0.7)
    wanted = sf.solve(preloaded()).slip_rate(x[seen], 0.371)
    assert relative_l1(pulse.interface.slip_rate[end, seen], wanted) < 4e-3


@pytest.mark.slow
def test_second_order_for_smooth_loads():
    """Against a grid four times finer than the last one, errors of a smooth pulse fall fast."""
    scene = preloaded(shear_history=sf.Pulse(0.8, "haversine"))
    fine = march(scene, nodes=4096, every=10**6, estimate=False)
    errors = []
    for nodes in (128, 256, 512, 1024):
        coarse = march(scene, nodes=nodes, every=10**6, estimate=False)
        wanted = np.interp(coarse.interface.x, fine.interface.x, fine.interface.slip[-1])
        errors.append(relative_l1(coarse.interface.slip[-1], wanted))
    assert errors[-1] < 1e-4
    assert total_error_of_order(errors) > 1.2


# --- friction laws --------------------------------------------------------------------------


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("law", "least_gain", "most_gain"),
    [
        (sf.RateWeakening(1.0, 0.5, 0.5), 1.05, 2.0),
        (sf.SlipWeakening(1.0, 0.4, 0.3), 1.05, 2.0),
        (sf.Coulomb(1.0, viscosity=0.3), 0.5, 0.8),
    ],
    ids=["rate", "slip", "viscous"],
)
def test_friction_laws_hold_at_every_point(law, least_gain, most_gain):
    marched = march(preloaded(law=law), nodes=300)
    fields = marched.interface
    rate = fields.slip_rate
    step = np.diff(fields.t)[:, None]
    path = np.zeros(rate.shape)
    path[1:] = np.cumsum(step / 2 * (np.abs(rate[1:]) + np.abs(rate[:-1])), axis=0)
    scene = marched.scene
    strength = scene.strength(1.0, rate, path)
    assert (np.abs(fields.shear_traction) <= strength + 2e-3).all()
    slips = (np.abs(rate) > 1e-3) & in_excess(marched, scene.strength(1.0, 0.0, path))
    assert slips.sum() > 0.9 * (np.abs(rate) > 1e-3).sum()
    np.testing.assert_allclose(np.abs(fields.shear_traction[slips]), strength[slips], atol=2e-3)
    constant = march(preloaded(law=sf.Coulomb(1.0)), nodes=300)
    gain = marched.final_path.sum() / constant.final_path.sum()
    assert least_gain < gain < most_gain


def test_too_steep_rate_weakening_is_refused():
    # the pressure that rises behind the front makes a law ill posed that was not at the start
    law = sf.RateWeakening(1.0, 0.5, 0.5)
    scene = unit_scene(0.3, load=(1.0, 1.0), law=law)
    with pytest.raises(sf.SceneError, match="faster than radiation can balance"):
        march(scene, nodes=400)


def test_slip_weakening_below_the_grid_is_refused():
    with pytest.raises(sf.SceneError, match=r"raise `nodes` [\d.]+ times"):
        march(preloaded(law=sf.SlipWeakening(1.0, 0.1, 1e-4)), nodes=100)


# --- antiplane shear ------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_memory_is_the_integral_of_a_bessel_function(tolerance):
    """h(x) = int_0^x J_1(y)/y dy, which tends to 1: what lasting slip exerts over mu q / 2."""
    memory = fit_memory(Antiplane(), 200.0, tolerance)
    assert memory.poles.real.max() < 0
    assert memory.static == 1
    x = np.array([0.0, 0.3, 1.0, 3.0, 10.0, 40.0])
    exact = [quad(lambda y: j1(y) / y if y else 0.5, 0, end, limit=200)[0] for end in x]
    np.testing.assert_allclose(memory(x), exact, atol=500 * tolerance + 1e-9)


def test_grid_is_as_large_as_shear_waves_reach():
    shear = unit_scene(0.5, mode="antiplane")
    pressed = replace(shear, load=sf.Tractions(0.5, 1.0))
    sizes = [causal_grid(scene, 1.0, 1.0, 200).size for scene in (shear, pressed)]
    assert sizes[1] > 1.3 * sizes[0]
    assert march(shear, nodes=100).interface.x[-1] < UNIT.shear_speed
    assert march(pressed, nodes=100).interface.x[-1] > 1.9 * UNIT.shear_speed


@pytest.mark.thinned(6)
@pytest.mark.parametrize(
    "problem", [row for row in problems("exact") if row.scene.antiplane], ids=lambda case: case.name
)
def test_marches_converge_to_exact_solutions(problem):
    """Pressure that changes, viscosity, slip everywhere and ahead of the shear wave."""
    exact, errors = sf.solve(problem.scene, method="self-similar"), []
    for nodes in (250, 500):
        marched = march(problem.scene, nodes=nodes, estimate=False, every=10**6)
        x = marched.interface.x
        wanted = exact.slip_rate(x, marched.end_time)
        found = marched.interface.slip_rate[-1]
        errors.append(np.abs(found - wanted).sum() / max(np.abs(wanted).sum(), 1e-12))
    assert errors[-1] < 6e-3
    assert errors[-1] <= 0.75 * errors[0]


def test_laws_that_weaken_have_the_process_zone_of_mode_three():
    law = sf.SlipWeakening(1.0, 0.5, 0.1)
    in_plane, out = (unit_scene(0.5, law=law, mode=mode) for mode in MODES)
    assert process_zone(out) == pytest.approx((1 - UNIT.poisson_ratio) * process_zone(in_plane))


@pytest.mark.parametrize("name", ["preloaded", "stuck", "antiplane"])
def test_work_and_steps_beside_a_slot_are_those_of_the_totals_and_of_a_line(name):
    """One way to read them for both kinds of march; where nothing slips there is no work."""
    slot = sf.find(name)
    if name == "stuck":
        slot = replace(slot, base=slot.load, load=sf.Tractions(0.0, 0.0), load_on="slot")
    line = replace(slot, contact=sf.Contact([(0.0, np.inf)]), period=6.0)
    beside = march(slot, end_time=1.0, nodes=128, length=2.0, estimate=False)
    along = march(line, end_time=1.0, nodes=384, estimate=False)
    for run in (beside, along):
        assert run.steps == len(run.totals.t) - 1
        assert run.work["closing"] == 0.0
        assert run.work["friction"] == pytest.approx(run.totals.frictional_work[-1], abs=1e-13)
    scale = float(beside.totals.frictional_work[-1])
    assert (scale == 0) == (name == "stuck")
    # on a periodic line the contact has a second edge, half a period away
    assert along.work["friction"] == pytest.approx(2 * scale, rel=1e-3, abs=1e-12)
