"""How long a step may be: the longest that loads, friction and convergence allow, on a ladder."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.pace import LoadPace
from semianalytic.engine.stepping.state import State
from semianalytic.engine.stepping.tuning import LADDER
from semianalytic.engine.stepping.unilateral import Unilateral
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.law import Law


class Ladder:
    """Lengths of steps: the shortest one times a power of `LADDER`, whose exponent is the rung.

    Law, contact, loads and the opening of the contact say which rungs are allowed: `bound` is the
    step at which an iteration converges, over the traction that a slip rate meets at once
    [length / stress], and `state_share` the largest slip of a step over the slip in which the state
    of friction changes.  The impedance is the traction per relative slip rate of plane waves.
    """

    def __init__(
        self,
        law: Law,
        touching: NDArray[np.bool_],
        pace: LoadPace,
        unilateral: Unilateral | None,
        *,
        impedance: float,
        shortest: float,
        longest: float,
        bound: float,
        state_share: float,
    ) -> None:
        self._law, self._touching, self._pace = law, touching, pace
        self._unilateral, self._impedance = unilateral, impedance
        self._shortest, self._longest, self._bound = shortest, longest, bound
        # slip of a step that changes the state of friction by as much as may be
        self._slip = state_share * np.asarray(law.state_slip(), dtype=float)
        # Faces of slots that only slip are solved for (`freed_rate`); those that part as well are
        # not, and have no friction that rises with slip rate.
        self._is_free = unilateral is not None and not touching.all()

    def check_longest(self) -> None:
        """Raise SceneError if the longest step that was asked for is below the shortest one."""
        if self._longest < self._shortest:
            raise SceneError(
                f"march: `longest` must be {self._shortest:.4g} or more on this grid, got "
                f"{self._longest:.4g}; lower `step_ratio` instead."
            )

    @property
    def climbs(self) -> bool:
        """Whether steps may be longer than the shortest one, or must be looked at one by one."""
        slope = self._law.steady_slope()
        if self._unilateral is not None or not self._law.has_threshold or slope is None:
            return True
        convergent = self._bound * (float(np.min(slope)) + self._impedance)
        return min(convergent, self._longest) >= self.length(1)

    def length(self, rung: int) -> float:
        """Return the length of the steps of a rung [time]."""
        return self._shortest * LADDER**rung

    def following(self, now: State, push: Callable[[], Array | float]) -> tuple[float, int]:
        """Return length [time] and rung of the step that may follow a state.

        `push` returns the pressure that slip exerts, (n,), which is asked for where faces may part.
        """
        speed = np.abs(now.rate[self._touching])
        limit = min(self.convergent(now), self._longest)
        if now.pace > 0:
            # No other bound has regard to a load on a slow interface: slip of TPV101 (1,440 nodes)
            # is off by 2.1e-3 without it, by 1.2e-4 with 0.2 and 0.1.
            limit = min(limit, 0.2 / now.pace)
        with np.errstate(divide="ignore"):
            limit = min(limit, float(np.min(self._slip / speed)))
        rung = 0
        if limit > self._shortest:
            limit = min(limit, self._pace.longest(now.time))
        if limit > self._shortest:
            rung = min(int(math.log(limit / self._shortest) / math.log(LADDER)), now.rung + 1)
        if rung and self._unilateral is not None:
            # Free faces have no direct effect of friction, which is what permits long steps.
            rung = 0 if self._unilateral.frees(now, now.time + self.length(rung), push()) else rung
        return self.length(rung), rung

    def convergent(self, now: State) -> float:
        """Return the step up to which the iteration of a step converges at the speed of a state."""
        speed = np.abs(now.rate[self._touching])
        slope = np.asarray(self._law.rate_slope(now.felt, speed, now.state))
        least = 0.0 if self._is_free else float(slope.min())
        return self._bound * (max(least, 0.0) + self._impedance)
