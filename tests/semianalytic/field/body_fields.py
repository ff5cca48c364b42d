"""Laws that fields in both bodies keep, for answers of one solid and of two."""

import numpy as np

CENTRAL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Eighth-order differences."""


def edges_of(answer):
    """Speeds of the ends of all zones and openings."""
    return [v for part in (*answer.zones, *answer.openings) for v in (part.inner, part.outer)]


def check_faces(answer, x, t, within, units=(1.0, 1.0, 1.0), rtol=None):
    """Faces at x, t move and carry what the interface does, within a share of the units given.

    Units are those of stress, velocity and displacement.
    """
    stress, velocity, displacement = units
    slip, shear = (2, 4) if len(answer.velocity(x, 0.0, t)) == 3 else (0, 2)
    rtol = within if rtol is None else rtol

    def close(found, name, unit):
        known = getattr(answer, name)(x, t)
        np.testing.assert_allclose(found, known, atol=within * unit, rtol=rtol, err_msg=name)

    above, below = (answer.velocity(x, face, t) for face in (0.0, -0.0))
    close(above[slip] - below[slip], "slip_rate", velocity)
    close(above[1] - below[1], "gap_rate", velocity)
    above, below = (answer.displacement(x, face, t) for face in (0.0, -0.0))
    close(above[slip] - below[slip], "slip", displacement)
    close(above[1] - below[1], "gap", displacement)
    for face in (0.0, -0.0):
        held = answer.stress(x, face, t)
        close(held[shear], "shear_traction", stress)
        close(-held[1], "pressure", stress)


def smooth_points(answer, body, speeds, t=1.0, *, side=1, count=40, apart=0.03):
    """Points x, y, t of one body that no front is near: of waves, of head waves, of edges.

    `speeds` are those of all waves of both bodies; `apart` is how far fronts are at least, over t.
    """
    far, rng = max(speeds) * t, np.random.default_rng(4)
    x, y = rng.uniform(-far, far, 8000), rng.uniform(0.2, 1.0, 8000) * far
    fronts = []
    for speed in (body.longitudinal_speed, body.shear_speed):
        fronts += [np.hypot(x, y) / speed, y / speed]
        for along in (*speeds, *edges_of(answer)):
            if speed < along < np.inf:
                rise = y * np.sqrt(1 / speed**2 - 1 / along**2)
                fronts += [x / along + rise, -x / along + rise]
    clear = np.min(np.abs(np.array(fronts) / t - 1), axis=0) > apart
    assert np.count_nonzero(clear) >= count
    return x[clear][:count], side * y[clear][:count], np.full(count, t)


def departures_from_laws(answer, at, body, step):
    """Largest departures from motion, from Hooke's law and from u' = v, all as stresses.

    The first is along y, and an answer out of the plane has three more at the end.
    """

    def differences(field, axis):
        total, size = 0.0, step if axis < 2 else step / body.shear_speed
        for weight, shift in zip(CENTRAL, range(-4, 5), strict=True):
            moved = list(at)
            moved[axis] = moved[axis] + shift * size
            total = total + weight * field(*moved)
        return total / size

    mu, bulk = body.shear_modulus, body.density * body.longitudinal_speed**2
    reach = body.shear_speed * at[2]
    change = answer.stress(*at) - answer.stress(at[0], at[1], 0.0)
    by_x, by_y = (differences(answer.stress, axis) for axis in (0, 1))
    moved_x, moved_y, moved_t = (differences(answer.displacement, axis) for axis in (0, 1, 2))
    rate = body.density * differences(answer.velocity, 2)
    pairs = [
        (reach * rate[1], reach * (by_x[2] + by_y[1])),
        (reach * rate[0], reach * (by_x[0] + by_y[2])),
        (change[0], bulk * moved_x[0] + (bulk - 2 * mu) * moved_y[1]),
        (change[1], bulk * moved_y[1] + (bulk - 2 * mu) * moved_x[0]),
        (change[2], mu * (moved_y[0] + moved_x[1])),
        (body.shear_impedance * answer.velocity(*at), body.shear_impedance * moved_t),
    ]
    if len(change) > 3:
        pairs += [
            (change[3], mu * moved_x[2]),
            (change[4], mu * moved_y[2]),
            (reach * rate[2], reach * (by_x[3] + by_y[4])),
        ]
    return np.array([np.abs(pair - other).max() for pair, other in pairs])
