"""What docs/peers.md is made from: the friction of another code and our answer of its cut."""

from __future__ import annotations

import numpy as np
import pytest

from docs.studies.peers import adhesion, cracklet
from semianalytic.scene.laws.law import check_law


@pytest.mark.parametrize("rest", [0.0, 1e-9])
def test_friction_of_cracklet_is_steady_at_the_slip_rate_it_prints(rest: float) -> None:
    """At theta = L/V the friction is that of their load, and the state stays."""
    problem = cracklet.PROBLEMS[1 if rest else 0]
    rate = np.array([0.00193049 if rest else 0.000398213])
    law = cracklet.Pmma(problem.f, problem.a, 0.0, rest)
    state = cracklet.DISTANCE / rate
    assert law.friction(rate, state)[0] == pytest.approx(problem.load / 1e6, rel=2e-5)
    assert law.evolved(state, rate, 1e-3)[0] == pytest.approx(state[0], rel=1e-9)
    check_law(law, np.full(1, 1e6), state)


def test_our_cut_grows_under_tension() -> None:
    """The cut of the comparison with UGUCA has grown to four times its length at the end."""
    fields = adhesion.ours(256).fields
    assert fields["gap"].shape == (20, 256)
    assert (fields["gap"][-1] > adhesion.GAP).sum() > 4 * 32
    assert -1.0 <= fields["pressure"].min() < -0.8
