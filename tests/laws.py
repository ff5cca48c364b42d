"""Laws that every answer must keep, and random scenes to hold them against."""

from dataclasses import replace

import numpy as np
from catalogue import under
from hypothesis import strategies as st

from semianalytic import Coulomb, Material, Scene, SceneError, TensionError, Tractions
from semianalytic.engine.march import march
from semianalytic.regimes import opening_threshold
from semianalytic.selfsimilar.solver import solve


def opening_scene(random):
    """A scene whose contact opens: from its edge, or ahead of a sudden pressure; with a step of
    shear, a base at rest, both, or neither."""
    poisson_ratio = random.uniform(-0.9, 0.49)
    friction = 10 ** random.uniform(-2, 1) if random.random() < 0.5 else random.uniform(0.1, 1)
    if random.random() < 0.4:
        base, step = 10 ** random.uniform(-2, 1), -1.0
    else:
        share = random.uniform() if random.random() < 0.7 else 10 ** random.uniform(-4, 0)
        base, step = share * opening_threshold(poisson_ratio), 1.0
    shear = random.choice([0.0, 1.0, -1.0]) * 10 ** random.uniform(-2, 1)
    held = random.choice([0.0, 1.0, -1.0]) * friction * base * random.uniform()
    material = Material(1.0, 1.0, poisson_ratio)
    return Scene(material, friction, Tractions(base, held), Tractions(step, shear))


def viscous_scene(random):
    """A scene with a film of any viscosity, in plane or out of it, a third of them opening."""
    law = Coulomb(1.0, viscosity=10 ** random.uniform(-6, 8))
    mode = "antiplane" if random.random() < 1 / 3 else "in-plane"
    if random.random() < 1 / 3:
        return under(replace(opening_scene(random), mode=mode), law)
    poisson_ratio, friction = random.uniform(-0.9, 0.49), 10 ** random.uniform(-2, 0.5)
    shear, pressure = random.normal(), random.choice([0.0, abs(random.normal())])
    base, load, load_on = Tractions(1.0, 0.0), Tractions(pressure, shear), "slot"
    if random.random() < 1 / 3:
        base, load, load_on = Tractions(0.0, 0.0), Tractions(1.0, shear), "remote"
    elif random.random() < 0.5:
        base = Tractions(1.0, random.uniform(-1, 1) * friction)
    material = Material(1.0, 1.0, poisson_ratio)
    return Scene(material, law.with_coefficient(friction), base, load, mode=mode, load_on=load_on)


def inside(x, parts):
    """Whether positions at t = 1 lie in zones or openings."""
    result = np.zeros(len(x), dtype=bool)
    for part in parts:
        result |= (part.inner < x) & (part.outer > x)
    return result


def check_contact(solution, x, parted):
    """No pull and no overlap at t = 1, pressure or a gap but not both."""
    pressure, gap = solution.pressure(x, 1.0), solution.gap(x, 1.0)
    scene = solution.scene
    held, load = scene.superposition
    size = held.pressure + abs(load.pressure)
    tolerance = 10 * solution.error_estimate * size
    assert pressure.min() >= -tolerance
    assert gap.min() >= -tolerance
    assert np.all(pressure[parted] == 0)
    assert np.all(gap[~parted] == 0)
    assert np.all(solution.gap_rate(x, 1.0)[~parted] == 0)


@st.composite
def scenes(draw):
    """Admissible scenes: preload and shear step, remote shock, or any base and step."""
    number = st.floats(-2, 2).map(lambda value: round(value, 3))
    poisson_ratio = draw(st.floats(-0.9, 0.49).map(lambda value: round(value, 3)))
    friction = round(10 ** draw(st.floats(-2, 0.5)), 4)
    kind = draw(st.sampled_from(["shear step", "remote shock", "any"]))
    shear = draw(number.filter(lambda value: value != 0))
    if kind == "shear step":
        base, load = Tractions(1.0, 0.0), Tractions(0.0, shear)
    elif kind == "remote shock":
        base, load = Tractions(0.0, 0.0), Tractions(1.0, shear)
    else:
        share = draw(st.floats(-0.99, 0.99).map(lambda value: round(value, 3)))
        base = Tractions(1.0, share * friction)
        load = Tractions(abs(draw(number)), shear)
    viscosity = draw(st.sampled_from([0.0, 0.0, 0.0, 1e-4, 0.01, 0.1, 0.5, 3.0]))
    law = Coulomb(1.0, viscosity=viscosity) if viscosity else Coulomb(1.0)
    place = "remote" if kind == "remote shock" else "slot"
    solid = Material(1.0, 1.0, poisson_ratio)
    return Scene(solid, law.with_coefficient(friction), base, load, load_on=place)


def check_march_converges(exact, nodes):
    """Marched slip at t = 1 comes to the exact one by more than first order, grid by grid."""
    errors = []
    for count in nodes:
        marched = march(exact.scene, nodes=count, every=10**6)
        x = marched.interface.x
        slip = exact.slip(x[x > 0], 1.0)
        errors.append(np.abs(marched.interface.slip[-1][x > 0] - slip).sum() / slip.sum())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-4
    assert orders.min() > 1.0


# Positions over all velocities, denser towards the edge.
XI = np.concatenate([np.geomspace(1e-3, 0.05, 12), np.linspace(0.06, 1.99, 120)])


def check_invariants(scene):
    """Coulomb's law, dissipation, causality and self-similarity of the answer to a scene."""
    try:
        solution = solve(scene)
    except TensionError:
        return  # nothing holds the contact together
    if solution.status != "converged":
        # Allowed only next to a threshold, where a zone is about to close at the contact edge.
        assert solution.zones[0].inner == 0
        assert solution.zones[0].outer < 0.01 * scene.material.shear_speed
        return
    x = XI * scene.material.shear_speed
    rate, traction = solution.slip_rate(x, 1.0), solution.shear_traction(x, 1.0)
    strength = scene.strength(solution.pressure(x, 1.0), rate)
    largest = max(np.abs(rate).max(), abs(solution.edge_slip_rate), 1e-300)
    load = solution.stress_unit
    slips, parted = (inside(x, parts) for parts in (solution.zones, solution.openings))
    tolerance = 100 * solution.error_estimate
    # Coulomb's law at every point
    assert np.all(np.abs(traction) <= strength + tolerance * (load + strength))
    assert np.all(rate[~slips & ~parted] == 0)
    assert np.all(traction * rate >= -tolerance * largest * (load + strength))
    check_contact(solution, x, parted)
    assert np.all(np.abs(traction[parted]) <= tolerance * load)
    strength = np.where(parted, 0.0, strength)
    sliding = slips & (np.abs(rate) > tolerance * largest)
    np.testing.assert_allclose(
        np.abs(traction[sliding]), strength[sliding], rtol=0, atol=tolerance * load
    )
    # Causality
    held = scene.superposition.in_place
    if (
        solution.zones
        and solution.zones[-1].outer >= (1 - 1e-13) * scene.material.longitudinal_speed
    ):
        strength = scene.coefficient * held.pressure  # what is below friction sticks at first
        assert abs(held.shear) >= strength * (1 - 1e-12) or strength < 1e-12 * load
    ahead = np.array([1.001, 2.0]) * scene.material.longitudinal_speed
    np.testing.assert_allclose(solution.slip_rate(ahead, 1.0), scene.far_slip_rate, rtol=1e-15)
    assert np.all(solution.pressure(ahead, 1.0) == held.pressure)
    # Self-similarity, to the rounding of t/x
    np.testing.assert_allclose(
        solution.shear_traction(3 * x, 3.0), traction, rtol=1e-9, atol=1e-9 * load
    )


def random_scenes(count, rtol=1e-12):
    """Scenes of any load, a third of them with a base at friction; always the same ones."""
    random = np.random.default_rng(11)
    while count:
        nu = float(random.choice([1 / 3, 0.25, 0.0, 0.45, -0.5, random.uniform(-0.9, 0.49)]))
        friction = float(np.exp(random.uniform(np.log(0.02), np.log(3))))
        base = float(random.choice([0, 1, random.lognormal()]))
        share = float(random.choice([0, random.uniform(-1, 1), 1.0]))
        load = Tractions(float(random.choice([0, 1, random.lognormal()])), float(random.normal()))
        scene = Scene(
            Material(1.0, 1.0, nu), friction, Tractions(base, share * friction * base), load
        )
        try:
            exact = solve(scene, rtol=rtol)
        except SceneError:
            continue  # tension
        if exact.openings:
            continue  # `opening_scene` draws those
        if exact.status == "converged":  # rounding may not leave twelve digits
            count -= 1
            yield exact
