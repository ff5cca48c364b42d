"""What a march says of its own error: against true errors, kept by files, met by an `rtol`."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, SHOCK, gone_on, over, under, unit_scene

import semianalytic as sf
from compare.comparison.documents import march_document
from docs.studies.accuracy.march import WEAKENING, judged, rate_error
from semianalytic.engine import plan as march_plan
from semianalytic.engine.convergence import MEMORY_SAFETY, SAFETY, more_nodes, safety
from semianalytic.engine.plan import MOST_NODES
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.memory.impedance import InPlane
from semianalytic.results.reading import SAMPLED_SAFETY
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main
from tests.semianalytic.engine.scenes.runs import march

WEAK = unit_scene(0.6, (1.0, 0.4), (0.0, 0.4), nu=0.25, law=sf.SlipWeakening(1.0, 1 / 3, 0.05))


# --- the estimate is honest -----------------------------------------------------------------


def check_honest(marched, truth):
    """A bound of the slip rate's error, and not much more."""
    true = rate_error(marched, truth)
    assert true <= marched.error_estimate < 6 * true


@pytest.mark.thinned(18)
@over("exact")
def test_error_is_honest(problem):
    """Measured 1.2 to 3.3 times the true error."""
    scene = problem.scene
    solution = sf.solve(scene)
    end = 1 / scene.material.shear_speed
    for nodes in (128, 300):
        marched = march(scene, end_time=end, nodes=nodes)
        if solution.zones:
            check_honest(marched, solution)
        else:
            assert marched.error_estimate == 0


@pytest.mark.slow
@over("march")
def test_error_of_histories_and_of_slip_weakening_is_honest(problem):
    check_honest(*(march(problem.scene, end_time=1.0, nodes=nodes) for nodes in (96, 768)))


def test_error_counts_the_memory_of_both():
    """March and companion share the transform, so its error does not show in their difference."""
    rough, fine = (march(PRELOADED, end_time=1.0, nodes=512, tolerance=tol) for tol in (1e-3, 1e-6))
    assert rate_error(rough, sf.solve(PRELOADED)) <= rough.error_estimate
    assert rough.error_estimate - fine.error_estimate > rough.checkpoint.layout.kernel.error


def test_error_of_any_reading():
    marched, solution = (march(SHOCK, end_time=1.0, nodes=200), sf.solve(SHOCK))
    found = {row["quantity"]: row for row in judged("", marched, solution)}
    assert {"slip", "shear traction", "largest slip", "frictional work"} <= found.keys()
    for quantity in ("slip", "shear traction", "largest slip"):
        assert found[quantity]["true"] <= found[quantity]["estimate"] < 6 * found[quantity]["true"]
    x = np.linspace(0.1, 1.0, 5)
    by_hand = SAMPLED_SAFETY * np.abs(marched.slip(x, 0.7) - marched.companion.slip(x, 0.7))
    np.testing.assert_array_equal(marched.error_of(lambda run: run.slip(x, 0.7)), by_hand)


def test_error_does_not_depend_on_what_is_stored():
    scene = find_scene("pulse")
    whole, thin = (march(scene, end_time=1.0, nodes=101, every=number) for number in (1, 10**6))
    assert whole.error_estimate == thin.error_estimate > 0
    assert len(thin.companion.interface.t) <= 3


def test_error_is_the_difference_from_the_companion():
    """As if both were stored and compared afterwards, for a load that jumps and odd numbers."""
    scene = unit_scene(
        0.2, shear_history=sf.Tabulated((0.05, 0.27, 0.27, 0.6), (0.0, 1.0, -1.0, 0.5))
    )
    marched = march(scene, end_time=1.0, nodes=201)
    own, coarse = marched.interface, marched.companion.interface
    np.testing.assert_allclose(coarse.x[0], 2 * own.x[0])
    x, t = own.x[:-1].reshape(-1, 2).mean(axis=1), coarse.t
    assert np.abs(coarse.x[: len(x)] - x).max() < 1e-12
    rate = marched.slip_rate(x, t[:, None])
    difference = np.abs(rate - coarse.slip_rate[:, : len(x)])
    share = np.trapezoid(difference.sum(axis=1), t) / np.trapezoid(np.abs(rate).sum(axis=1), t)
    expected = SAFETY["slot"][0] * share + MEMORY_SAFETY * marched.checkpoint.layout.kernel.error
    assert marched.error_estimate == pytest.approx(expected, rel=0.02)


def test_nothing_slips_and_something_must():
    stuck = march(find_scene("stuck"), end_time=1.0, nodes=64)
    assert (stuck.error_estimate, stuck.status) == (0.0, "resolved")
    unseen = march(unit_scene(30.0), end_time=1.0, nodes=64)
    assert (unseen.error_estimate, unseen.status) == (math.inf, "unresolved")
    assert json.loads(json.dumps(march_document(unseen)["caution"]))


def test_a_strip_narrower_than_the_grid_is_told_wherever_it_is():
    """Two strips of 1e-3 c_t T, one of them far from the edge: 256 nodes slip a thousand times as
    much."""
    scene = unit_scene(0.67, (1.0, -0.67), (0.096, 0.094), nu=0.03)
    zones = sf.solve(scene).zones
    assert len(zones) == 2
    assert max(zone.outer - zone.inner for zone in zones) < 2e-3
    marched = march(scene, end_time=1.0, nodes=256)
    assert marched.status == "unresolved"
    assert "the error of the slip rate is estimated as" in marched.caution


# --- the companion --------------------------------------------------------------------------


def test_companion_changes_nothing():
    with_one, alone = (march(SHOCK, end_time=1.0, nodes=100, estimate=on) for on in (True, False))
    np.testing.assert_array_equal(with_one.interface.slip_rate, alone.interface.slip_rate)
    assert alone.companion is None
    assert math.isnan(alone.error_estimate)
    assert np.isnan(alone.error_of(lambda run: run.slip([0.1, 0.2], 0.5))).all()
    assert "no error estimate" in repr(alone)
    assert f"error estimate {with_one.error_estimate:.1e}" in repr(with_one)


@pytest.mark.parametrize("nodes", [120, 121])
def test_companion_is_the_march_at_half_the_nodes(nodes):
    marched, half = (march(SHOCK, end_time=1.0, nodes=nodes), (nodes + 1) // 2)
    alone = march(
        SHOCK, end_time=1.0, nodes=half, length=2 * marched.spacing * half, estimate=False
    )
    assert 2 * marched.companion.steps == marched.steps
    assert marched.companion.end_time == marched.end_time
    found, wanted = (answer.slip(alone.interface.x, 1.0) for answer in (marched.companion, alone))
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=1e-4)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("stop", [1, 2, 30, 31, 99, 100])
@pytest.mark.parametrize("every", [1, 7])
def test_an_interrupted_march_keeps_what_it_has_and_its_companion_stops_there(stop, every):
    scene = unit_scene(0.2, shear_history=sf.Harmonic(1.3))
    counted = []

    def progress(time, end):
        counted.append(round(100 * time / end))
        return counted[-1] == stop

    options = {"end_time": 1.0, "nodes": 100, "every": every, "step_ratio": 0.5}
    part, whole = (march(scene, progress=call, **options) for call in (progress, None))
    assert counted == list(range(1, stop + 1))
    assert part.companion.end_time == part.companion.interface.t[-1] == part.end_time
    assert (np.diff(part.companion.interface.t) > 0).all()
    assert not math.isnan(part.error_estimate)
    kept = range(stop // every + 1)
    np.testing.assert_array_equal(part.interface.slip[kept], whole.interface.slip[kept])
    np.testing.assert_array_equal(part.interface.t[kept], whole.interface.t[kept])
    # the companion has every second level
    assert part.steps == stop + stop % 2 == 2 * part.companion.steps
    if part.end_time < 1.0:
        rest = gone_on(part, 1.0)
        found, wanted = (answer.interface.slip[-1] for answer in (rest, whole))
        # the memory of a small grid has single precision
        np.testing.assert_allclose(found, wanted, atol=3e-8)
        assert rest.error_estimate == pytest.approx(whole.error_estimate, rel=0.05)
        assert (np.diff(rest.companion.interface.t) > 0).all()


def test_companion_is_counted_in_the_memory():
    scene = find_scene("ramp")
    alone, with_one = (
        march(scene, nodes=400, memory=4_000_000, estimate=choice) for choice in (False, True)
    )
    assert with_one.checkpoint.every > alone.checkpoint.every > 1
    kept = sum(32 * answer.interface.slip.size for answer in (with_one, with_one.companion))
    assert kept < 2_500_000


# --- nodes by an rtol -----------------------------------------------------------------------


@pytest.mark.thinned(10)
@pytest.mark.parametrize("rtol", [2e-2, 5e-3])
@pytest.mark.parametrize("name", ["preloaded", "remote-shock", "pulse"])
def test_march_within_an_rtol(name, rtol):
    marched = march(find_scene(name), end_time=1.0, rtol=rtol, every=10**6)
    assert marched.error_estimate <= rtol
    assert marched.status == "resolved"
    assert marched.error_estimate > rtol / 10 or marched.nodes == 250
    if name != "pulse":
        fields = march(find_scene(name), end_time=1.0, nodes=marched.nodes)
        assert rate_error(fields, sf.solve(find_scene(name))) <= rtol


@pytest.mark.parametrize("order", [0.7, 1.0, 1.1, 1.35, 1.6])
def test_nodes_follow_the_order_that_is_seen(order):
    """Errors that fall as nodes^-order are met at once, on few nodes more than they need."""

    def estimate(nodes, seen):
        return safety(seen, "slot") * (2**order - 1) * nodes**-order

    rtol = estimate(1000, order) / 2
    nodes = more_nodes(1000, estimate(1000, order), rtol, order, 8000)
    assert estimate(nodes, order) <= rtol
    assert nodes <= 1.45 * 1000 * 2 ** (1 / order)
    assert estimate(nodes, order) >= min(1.0, 1.25 * (2**order - 1)) * nodes**-order


@pytest.mark.slow
def test_out_of_reach_of_the_nodes(monkeypatch, capsys):
    monkeypatch.setattr(march_plan, "MOST_NODES", 300)
    marched = march(PRELOADED, end_time=1.0, rtol=1e-4, every=10**6)
    assert marched.nodes == 300
    assert marched.status == "unresolved"
    assert "above the `rtol` of 1.0e-04; raise `nodes`" in marched.caution
    times = float(marched.caution.split("raise `nodes` ")[1].split()[0])
    assert times == pytest.approx(marched.error_estimate / 1e-4, rel=0.1)
    options = ["solve", "preloaded", "--method", "space-time", "--rtol", "1e-4"]
    assert main([*options, "--json"]) == sf.ComputationError.exit_code
    said = capsys.readouterr()
    assert json.loads(said.out)["error_estimate"] == marched.error_estimate
    assert "is not within --rtol" in said.err


def test_a_stop_ends_the_search():
    marched = march(PRELOADED, end_time=1.0, rtol=1e-4, progress=lambda time, _: time > 0.2)
    assert 0 < marched.end_time < 1
    assert marched.nodes == 250


def test_rtol_of_either_solver():
    ramp = replace(PRELOADED, shear_history=sf.Ramp(0.3))
    assert sf.solve(ramp, end_time=1.0, rtol=2e-2).error_estimate <= 2e-2
    assert sf.solve(PRELOADED, rtol=1e-4).error_estimate <= 1e-4
    with pytest.raises(sf.SceneError, match="leave out `nodes`"):
        sf.solve(ramp, end_time=1.0, nodes=100, rtol=2e-2)


# --- slip weakening -------------------------------------------------------------------------


def in_zone(scene, nodes, end_time=1.0):
    """Nodes on c_l T of which so many lie in the process zone."""
    length = scene.material.longitudinal_speed * end_time
    return math.ceil(nodes * length / process_zone(scene))


def test_coarse_weakening_is_unresolved_with_what_would_do():
    coarse = march(WEAK, end_time=1.0, nodes=in_zone(WEAK, 3.0))
    assert coarse.status == "unresolved"
    assert (
        "weakens within about 0.17 of length, over 3.1 nodes where 8 resolve it" in coarse.caution
    )
    times = float(coarse.caution.split("raise `nodes` ")[1].split()[0])
    assert march(WEAK, end_time=1.0, nodes=int(times * coarse.nodes)).status == "resolved"
    with pytest.raises(sf.SceneError, match="do not resolve; raise `nodes` 6 times"):
        march(WEAK, end_time=1.0, nodes=in_zone(WEAK, 1.5))
    assert march(PRELOADED, end_time=1.0, nodes=50).status == "resolved"


@pytest.mark.slow
@pytest.mark.parametrize("name", WEAKENING)
def test_weakening_that_is_called_resolved_is_right_to_a_percent(name):
    """In slip and frictional work; and the limit is not far from where that ends."""
    scene, end = WEAKENING[name]
    truth = march(scene, end_time=end, nodes=in_zone(scene, 64, end), estimate=False)
    errors = {}
    for count in (3, 8):
        marched = march(scene, end_time=end, nodes=in_zone(scene, count, end))
        assert (marched.status == "resolved") == (count == 8)
        errors[count] = {row["quantity"]: row for row in judged("", marched, truth)}
        assert errors[count]["slip rate"]["true"] < marched.error_estimate
    for quantity in ("slip", "frictional work"):
        assert errors[8][quantity]["true"] < 0.01
    assert errors[3]["slip rate"]["true"] > 0.05


@pytest.mark.slow
def test_nodes_are_chosen_for_the_process_zone():
    sharp = under(WEAK, sf.SlipWeakening(1.0, 1 / 3, 7e-4))
    assert in_zone(sharp, 8, 0.2) > 1000
    chosen = march(sharp, end_time=0.2, every=10**6)
    assert chosen.nodes == in_zone(sharp, 8, 0.2)
    assert chosen.status == "resolved"
    sharper = under(WEAK, sf.SlipWeakening(1.0, 1 / 3, 5e-5))
    assert in_zone(sharper, 8, 0.2) > MOST_NODES
    with pytest.raises(sf.SceneError, match="do not resolve"):
        march(sharper, end_time=0.2)


@pytest.mark.parametrize(("nu", "growth"), [(1 / 3, 0.055), (0.1, 0.107)])
@pytest.mark.parametrize("share", [0.05, 0.3])
def test_any_rate_weakening_lets_short_waves_grow(nu, growth, share):
    """Slip of wavenumber q exp(q c_t s t) needs no load where the impedance G(s) is what friction
    gives back, a share of the radiated traction."""
    factors = rayleigh_factors(nu)
    rayleigh = float(sf.Material(1.0, 1.0, nu).rayleigh_speed)
    s = np.array([1e-3 + 1j * rayleigh])
    for _ in range(50):
        value = InPlane(factors.a)(s) - share
        slope = (InPlane(factors.a)(s + 1e-6) - share - value) / 1e-6
        s = s - value / slope
    assert np.abs(InPlane(factors.a)(s) - share).max() < 1e-9
    assert s[0].real == pytest.approx(growth * share, rel=0.05)
    assert s[0].imag == pytest.approx(rayleigh, rel=0.02)
