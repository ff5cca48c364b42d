"""Runs of an interface until an end time, with error estimates, and their continuation."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.pair import LARGEST_CONTRAST, check_contrast
from semianalytic.engine.advancing import Walk
from semianalytic.engine.convergence import more_nodes, order_seen
from semianalytic.engine.estimate import (
    deciding,
    estimated,
    line_caution,
    too_short,
    unresolved,
)
from semianalytic.engine.marched import Marched
from semianalytic.engine.record import Record
from semianalytic.engine.stepping.line import fitting_nodes, with_period
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact, nodes_for_histories
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import MOST_NODES, NODES, STEP_RATIO
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.arguments import taking_quantities
from semianalytic.scene.checks import checked_count, checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]
Progress = Callable[[float, float], bool | None]


def refuses(scene: Scene) -> None:
    """Return None: every scene on a line is marched."""


def run(
    scene: Scene,
    end_time: float,
    nodes: int | None = None,
    *,
    rtol: float | None = None,
    step_ratio: float = STEP_RATIO,
    every: int = 1,
    frames: int = 400,
    times: Sequence[float] | None = None,
    slipping: float | None = None,
    estimate: bool = True,
    go_on: Marched | None = None,
    latest: float | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Marched:
    """Compute what happens on an interface from t = 0 until an end time.

    Steps are as long as friction and convergence allow: shortest in an event, up to a million times
    longer between events.  A second run with half the nodes gives the error estimates.  Ctrl-C ends
    a run early and returns what was computed until then.

    Parameters
    ----------
    scene : Scene
        The interface to compute.
    end_time : float
        Last time [time].
    nodes : int, optional
        Nodes of one period, a multiple of 4.  By default they are 512, or as many as the histories
        of loads and the narrowest contact or slot need, and up to twice as many, so that ends of
        contacts lie midway between nodes or close to it.  The grid is moved to have them there
        (`Marched.shift`) unless the interface is even; what it displaces still counts as error, and
        `Marched.caution` tells it.
    rtol : float, optional
        Wanted relative error of slip and gap; more nodes are taken, as many as the order of
        convergence asks for, until the estimates are below it, up to 16,384.
    step_ratio : float
        Shortest step c_t dt / h; stable below about 0.5 (nu near 0.5) to 0.65 (nu = 1/3) and more.
        Slip rate is mostly as exact with 0.5 as with 0.3.
    every, frames : int
        Fields are stored after every `every` steps; if there are more than `frames` of them, every
        second one is dropped and `every` doubles.
    times : sequence of float, optional
        Times at which fields are stored instead [time].
    slipping : float, optional
        |slip rate| beyond which slip has begun [length / time].  By default it is 0 for laws that
        stick, and a thousandth of the largest pressure over the impedance for rate-and-state
        friction, which always slips.
    estimate : bool
        Whether to compute the second run, on which the error estimates rest.
    go_on : Marched, optional
        A run of the same interface to continue.  The result is the same to the last bit as that of
        a run which was not interrupted; after an end time, the last step, which was cut to end
        there, is taken anew.
    latest : float, optional
        Time up to which `go_on` may continue this run [time]; the end time by default.  The memory
        is made for it.
    progress : function, optional
        Called with time and end time after every step; the run ends where it returns True.
    **settings
        `sweeps`, `tolerance`, `state_share`, `bound_share`, `longest` of `Stepper`.

    Returns
    -------
    Marched

    Raises
    ------
    SceneError
        If the interface or an option is not admissible.
    ComputationError
        If the run goes unstable.

    Examples
    --------
    >>> import semianalytic as sf
    >>> law = sf.RateAndState(a=0.01, b=0.006, f0=0.6, v0=1e-6, distance=1e-5)
    >>> rock = sf.Material(shear_modulus=30e9, density=2700.0, poisson_ratio=0.25)
    >>> pushed = sf.InterfaceLoad(lambda x: 2e5 * (abs(x) < 1), history=lambda t: t)
    >>> base, everywhere = sf.Tractions(1e6, 0.6e6), sf.Contact()
    >>> fault = sf.Scene(rock, law, base, pushed, contact=everywhere, period=8.0, rate=1e-6)
    >>> slow = sf.solve(fault, end_time=0.5, nodes=32)
    >>> bool(slow.max_slip(0.5) > 2e-6), slow.status
    (True, 'done')
    """
    end_time = checked_size("run: end_time", end_time)
    scene = with_period(scene, end_time)
    check_contrast(*scene.bodies, LARGEST_CONTRAST)
    every = checked_count("run: every", every, 1, "a whole number of at least")
    frames = checked_count("run: frames", frames, 2, "a whole number of at least")
    step_ratio = checked_size("run: step_ratio", step_ratio)
    if rtol is not None:
        rtol = checked_size("run: rtol", rtol)
    if times is not None:
        times = sorted(float(time) for time in times)
        # nan is none of these, and so refused.
        if not (times and all(0 <= time <= end_time for time in times)):
            raise SceneError("run: times must lie between 0 and the end time.")
    if slipping is not None:
        slipping = checked_number("run: slipping", slipping, "be 0 or more", lambda n: n >= 0)
    settings = _checked_settings(settings)
    options: dict[str, Any] = {
        "step_ratio": step_ratio,
        "every": every,
        "frames": frames,
        "times": times,
    }
    options |= {"slipping": slipping, "shift": None}  # moved as suits the ends of contacts
    latest = end_time if latest is None else checked_size("run: latest", latest)
    options["latest"] = max(latest, end_time)
    if go_on is not None:
        nodes = go_on.nodes if nodes is None else nodes
    histories = nodes_for_histories(scene, end_time)
    options["histories"] = histories
    needed = max(histories, nodes_for_contact(scene))
    if nodes is None:
        least = in_fours(needed) if NODES < needed <= MOST_NODES else NODES
        # the run with half the nodes, which estimates the error, needs ends that fit as well
        nodes = min(fitting_nodes(scene, least, 1), MOST_NODES)
    elif rtol is not None and go_on is None and nodes < needed <= MOST_NODES:
        nodes = in_fours(needed)
    count, coarser = _checked_nodes(nodes), None
    while True:
        with deferred_interrupt() as options["interruption"]:
            done = _one(scene, end_time, count, options, settings, go_on, progress, check=True)
            tried = None
            if not done.is_interrupted and (estimate or rtol is not None):
                half = _half(done, end_time, options, settings)
                done, tried = estimated(done, half, rtol, coarser)
        if not done.error_estimates or rtol is None or go_on is not None:
            return done
        error = done.error_estimates[deciding(done, done.error_estimates)]
        if error <= rtol or count == MOST_NODES:
            return done
        order = None if coarser is None or tried is None else order_seen(coarser, tried)
        least = in_fours(more_nodes(count, error, rtol, order, MOST_NODES))
        count, coarser = min(fitting_nodes(scene, least, 1), MOST_NODES), tried


def _half(
    done: Marched, end_time: float, options: dict[str, Any], settings: dict[str, Any]
) -> Callable[[Scene], Marched]:
    """Return what runs an interface on half the nodes of a run, at its frames."""
    options = {**options, "times": list(done.interface.t), "shift": done.shift}
    return lambda scene: _one(scene, end_time, done.nodes // 2, options, settings, None, None)


@taking_quantities
@wraps(run)
def solve(scene: Scene, **settings: Any) -> Marched:
    """March a scene as `run` does."""
    if "end_time" not in settings:
        raise SceneError("solve: the scene does not say how long it is marched; give end_time.")
    return run(scene, **settings)


def _checked_settings(settings: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of a `Stepper`, all of them positive numbers."""
    known = ("sweeps", "tolerance", "state_share", "bound_share", "longest")
    for name, value in settings.items():
        if name not in known:
            others = [*list(inspect.signature(run).parameters)[1:-1], *known]
            raise SceneError(
                f"solve: {name} is no setting of space-time for a scene on a line, which takes "
                f"{', '.join(others)}."
            )
        if name == "sweeps":
            settings[name] = checked_count("run: sweeps", value, 1, "a whole number of at least")
        elif value != math.inf:
            settings[name] = checked_size(f"run: {name}", value)
    return settings


def _checked_nodes(nodes: int) -> int:
    count = checked_count("run: nodes", nodes, 8, "a whole number of at least")
    if count % 4 or count > MOST_NODES:
        raise SceneError(
            f"run: nodes must be a multiple of 4, {MOST_NODES} at most, got {count}; choose "
            f"{min(4 * max(round(count / 4), 1), MOST_NODES)}."
        )
    return count


def _one(
    scene: Scene,
    end_time: float,
    nodes: int,
    options: dict[str, Any],
    settings: dict[str, Any],
    go_on: Marched | None,
    progress: Progress | None,
    check: bool = False,
) -> Marched:
    """Return a run on one grid, without error estimates.

    With `check`, friction between different bodies that this grid cannot follow is refused.
    """
    latest = options["latest"]
    if go_on is not None:
        latest = max(go_on.checkpoint.latest, end_time)
    ratio, shift = options["step_ratio"], options["shift"]
    stepper = Stepper(scene, nodes, ratio, end_time=latest, shift=shift, **settings)
    if check:
        stepper.check_sliding()
        stepper.ladder.check_longest()
    begun = options["slipping"]
    if begun is None:
        # Slip under rate-and-state friction has begun: at 26 mm/s for TPV101.
        begun = 1e-3 * float(stepper.pressure.max(initial=0.0)) / stepper.impedance
        begun = 0.0 if stepper.law.has_threshold else begun
        begun = begun if go_on is None else go_on.seen.slipping
    record = Record(stepper, options["every"], options["frames"], options["times"], begun)
    walk, stopped = Walk(stepper, record, end_time, latest, go_on), False

    def asked(time: float) -> bool:
        nonlocal stopped
        told = progress is not None and progress(time, end_time)
        stopped = bool(options["interruption"].pressed or told)
        return stopped

    for _ in walk.steps(asked):
        pass
    now = walk.now
    stopped = stopped and now.time < end_time
    done = walk.marched(nodes, stopped)
    loaded = done.interface.pressure[:, stepper.touching].max(axis=0)
    most = np.maximum(stepper.pressure, loaded)
    status = too_short(scene, now.time) or unresolved(
        stepper, most, now.state, float(record.totals.peak_rate.max()), options["histories"]
    )
    if stopped:
        status = f"interrupted at t = {now.time:.6g}"
    caution = line_caution(scene, nodes, now.time) if check else ""
    return replace(done, status=status, caution=caution)
