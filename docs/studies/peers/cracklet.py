"""Onset of sliding under rate-and-state friction against results that cRacklet tests itself by.

``python -m docs.studies.peers.cracklet FOLDER`` writes rows of docs/data/peers.csv.  FOLDER is a
checkout of github.com/Xinyuan-yang/MycRacklet, which holds tests/friction/*.verified and is no part
of this package.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import semianalytic as sf
from docs.studies.lines import scene_along
from docs.studies.peers.rows import Array, GridRun, places, record, timed_run

COMMAND = "python -m docs.studies.peers.cracklet FOLDER"
STEP = 3.90625e-7
"""Their time step [s]; the state is disturbed after the sixth of them."""
KICK = 1e-7
"""Amplitude of the wave that is added to the state [s]."""
DISTANCE, SLOPE, RATE, MEMORY, PRESSURE = 5e-7, 0.075, 1e-7, 3.3e-4, 1e6


@dataclass(frozen=True)
class Pmma(sf.Law):
    """The friction of their two tests, with theta' = 1 - V theta / L.

    Without `rest` it is f + a ln(1 + V/V*) + b f ln(1 + theta/theta*); with `rest` = v0 it is
    (f / sqrt(1 + (v0/V)^2) + a ln(1 + V/V*)) (1 + b ln(1 + theta/theta*)).
    """

    f: float
    a: float
    theta: object
    rest: float = 0.0

    has_threshold = False

    def friction(self, speed: Array, state: Array) -> Array:
        """Return the coefficient of friction at a speed and a state."""
        direct = self.a * np.log1p(speed / RATE)
        aged = SLOPE * np.log1p(state / MEMORY)
        if not self.rest:
            return np.asarray(self.f * (1 + aged) + direct)
        smooth = speed / np.hypot(speed, self.rest)
        return np.asarray((self.f * smooth + direct) * (1 + aged))

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return friction times pressure."""
        return pressure * self.friction(speed, state)

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the state after a time at a mean speed, exactly."""
        share = np.maximum(np.hypot(speed, self.rest) * time / DISTANCE, 1e-12)
        return np.asarray(state * np.exp(-share) - time * np.expm1(-share) / share)

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return the disturbed state at t = 0."""
        return np.asarray(self.theta, dtype=float).copy()

    def state_slip(self) -> float:
        """Return L."""
        return DISTANCE


@dataclass(frozen=True)
class Problem:
    """A test of theirs: friction, load [Pa], elements, length [m], and name of its files."""

    name: str
    f: float
    a: float
    rest: float
    load: float
    elements: int
    length: float


PROBLEMS = (
    Problem("PMMA", 0.285, 0.005, 0.0, 0.36e6, 512, 0.5),
    Problem("PMMA_regularized", 5 / 18, 0.0055, 1e-9, 1.005 * 0.34475668e6, 2048, 2.0),
)


def verified(path: Path) -> tuple[float, Array, Array]:
    """Return the slip rate at the start, times, and the largest slip rate less the first node's."""
    text = path.read_text()
    start = re.search(r"element V=(\S+)", text)
    if start is None:
        raise SystemExit(f"{path} does not say the slip rate at the start.")
    t = np.array([float(match) for match in re.findall(r"Simulation at t \d+ = (\S+)", text)])
    rise = np.array([float(match) for match in re.findall(r"v_max-v_av = (\S+)", text)])
    return float(start[1]), t[1:], rise[1:]


def our_run(problem: Problem, times: Array, nodes: int, near: float) -> tuple[Array, float]:
    """Return the largest slip rate less that of the first node, and seconds of the processor."""
    bare = Pmma(problem.f, problem.a, 0.0, problem.rest)

    def missing(rate: float) -> float:
        state = DISTANCE / np.hypot(rate, problem.rest)
        return float(bare.friction(np.array(rate), np.array(state))) - problem.load / PRESSURE

    rate = float(brentq(missing, 0.98 * near, 1.02 * near, xtol=1e-16, rtol=1e-14))
    steady = DISTANCE / np.hypot(rate, problem.rest)

    def theta(x: Array) -> Array:
        return np.asarray(steady + KICK * np.sin(2 * np.pi * (x / problem.length + 0.5)))

    body = sf.Material(3e8, 1200.0, 0.33)
    fault = scene_along(
        body,
        Pmma(problem.f, problem.a, theta, problem.rest),
        problem.length,
        pressure=PRESSURE,
        shear=problem.load,
        rate=rate,
        plate_rate=rate,
        mode="antiplane",
    )
    done, seconds = timed_run(fault, float(times[-1]), nodes, times)
    print(f"{nodes} nodes: slip rate at the start {rate:.7g}, theirs {near:.7g} m/s", flush=True)
    return done.interface.slip_rate.max(axis=1) - done.interface.slip_rate[:, 0], seconds


def main() -> None:
    """Write the rows."""
    (folder,) = places(__doc__, "FOLDER")
    for problem in PROBLEMS:
        rate, t, theirs = verified(
            folder / f"tests/friction/test_rate_and_state_{problem.name}.verified"
        )
        grows = np.arange(len(t)) < (np.argmax(theirs > rate) if theirs.max() > rate else len(t))
        parts = {"growing wave": grows, "event after it": ~grows}
        spans = {f"slip rate, {words}": part for words, part in parts.items() if part.any()}
        known = {name: theirs[part] for name, part in spans.items()}
        pairs = []
        for nodes in (problem.elements // 8, problem.elements // 4, problem.elements // 2):
            rise, seconds = our_run(problem, t - 6 * STEP, nodes, rate)
            found = {name: rise[part] for name, part in spans.items()}
            their = GridRun(f"{problem.elements} elements", known, None)
            pairs.append((their, GridRun(f"{nodes} nodes", found, seconds)))
        record("cRacklet", f"test_rate_and_state_{problem.name}", COMMAND, pairs)


if __name__ == "__main__":
    main()
