"""How marches are planned, beside a slot and along a line: nodes, memory and steps."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from semianalytic.dissimilar.pair import LARGEST_CONTRAST, check_contrast
from semianalytic.engine.advancing import Walk, advance
from semianalytic.engine.convergence import Tried, order_seen
from semianalytic.engine.estimate import (
    deciding,
    estimated,
    judged,
    line_caution,
    too_short,
    unresolved,
)
from semianalytic.engine.loads import TOLERANCES
from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import check_size, checked_entry, laid_out
from semianalytic.engine.record import MarchRecord
from semianalytic.engine.resolution import (
    WEAKENING_NODES,
    ZONE_NODES,
    nodes_for_loads,
    rounded_up,
    zone_at_edge,
)
from semianalytic.engine.stepping import tuning
from semianalytic.engine.stepping.line import fitting_nodes, with_period
from semianalytic.engine.stepping.means import LARGEST_FEEDBACK
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact, nodes_for_histories
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.scene.checks import LARGEST, checked_count, checked_number, checked_size
from semianalytic.scene.contact import process_zone, wave_slips_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

LEAST_NODES = 16
MOST_NODES = 8000
"""Largest number of nodes that a march beside a slot chooses by itself, some 20 seconds of work."""
TOLERANCE = 1e-6
"""Default tolerance of the memory's transform: for 1024 nodes as good as 1e-10."""
DAMPING, WEAKENING_DAMPING = 0.6, 0.7
"""Default least feedback of the shortest wave, and that under slip weakening.

Without any, small steps leave an odd-even mode.  With 0.5 slip weakening is 1.4 times less exact;
0.7 instead of 0.6 makes pulses 3 % less exact.
"""

Stops = Callable[[float], bool]


@dataclass(frozen=True)
class Asked:
    """What every march is asked for; see `march`."""

    end_time: float
    nodes: int | None
    rtol: float | None
    estimate: bool
    step_ratio: float
    every: int
    latest: float | None
    go_on: Marched | None


class MarchPlan(NamedTuple):
    """How a scene is marched on a number of nodes, the first of which and the most are given.

    `march` takes the nodes, and a march on fewer of them that was tried before; it returns the
    march with its estimate, and what was tried, None if it was stopped.  `fitting` returns nodes
    that suit the contacts, `error` the error that `rtol` limits.
    """

    nodes: int
    most: int
    march: Callable[[int, Tried | None], tuple[Marched, Tried | None]]
    fitting: Callable[[int], int]
    error: Callable[[Marched], float]


def checked_within(name: str, value: float, low: float, high: float = LARGEST) -> float:
    """Return a number low < value <= high as float; raise SceneError if it is not one."""
    limit = f" and at most {high:g}" if high < LARGEST else ""
    return checked_number(
        f"march: {name}", value, f"be above {low:g}{limit}", lambda given: low < given <= high
    )


def _latest_of(asked: Asked) -> float:
    """Return the time to which a march may go on [time]."""
    latest = asked.end_time if asked.latest is None else asked.latest
    # The range is open below, and `latest` may equal the end time: hence the next smaller number.
    return checked_within("latest", latest, math.nextafter(asked.end_time, 0.0))


def check_going_on(scene: Scene, marched: Marched, asked: Asked, given: dict[str, Any]) -> None:
    """Raise SceneError unless a march of the scene can go on to the end time as it began."""
    fixed = {"nodes": asked.nodes, "latest": asked.latest, **given}
    if not scene.on_line:
        fixed["rtol"] = asked.rtol
    same = {
        "nodes": marched.nodes,
        "slipping": marched.seen.slipping,
        **marched.checkpoint.settings,
    }
    free = {"memory", "times", "frames"}
    for name in (name for name, value in fixed.items() if value is not None and name not in free):
        if fixed[name] != same.get(name):
            raise SceneError(
                f"march: a march that goes on keeps its grid and steps; leave out `{name}`."
            )
    if marched.scene != scene:
        raise SceneError("march: `go_on` is a march of another scene; continue it with its own.")
    latest = marched.checkpoint.latest
    checked_within("end_time", asked.end_time, marched.end_time)
    if asked.end_time > latest:
        raise SceneError(
            f"march: this march can be continued to {latest:.6g}; for more, start again with a "
            "later `latest`."
        )


# --- beside a slot -----------------------------------------------------------------------------


def beside_slot(scene: Scene, asked: Asked, given: dict[str, Any], stops: Stops) -> MarchPlan:
    """Return how a scene with a slot is marched, with settings that were given for slots.

    Raises
    ------
    SceneError
        If an option is out of range, or the grid follows no load.
    """
    memory, nodes, rtol = given.get("memory"), asked.nodes, asked.rtol
    if asked.go_on is not None:
        return _going_on(scene, asked, given, stops)
    end_time, latest = asked.end_time, _latest_of(asked)
    length = given.get("length", scene.fastest_speed * end_time)
    length = checked_size("march: length", length, "be above 0")
    damping = given.get("damping", WEAKENING_DAMPING if process_zone(scene) < math.inf else DAMPING)
    damping = checked_number(
        "march: damping",
        damping,
        "lie between 0 and 0.95",
        lambda given: 0 <= given <= LARGEST_FEEDBACK,
    )
    tolerance = checked_within("tolerance", given.get("tolerance", TOLERANCE), *TOLERANCES)
    if nodes is not None:
        nodes = checked_count("march: nodes", nodes, LEAST_NODES, "a whole number from")
        if rtol is not None:
            raise SceneError("march: `rtol` chooses the nodes; leave out `nodes`, or `rtol`.")
    entry = checked_entry(scene, latest, length, given.get("entry"))
    slowness = scene.front_slowness  # a wave that meets the contact first is all over it before
    if slowness < 0 and wave_slips_ahead(scene, latest + length * abs(slowness)):
        raise SceneError(
            "march: the wave alone exceeds friction, so that the contact slips from its front "
            "on, before any wave from the slot arrives; lower the wave, or raise friction or the "
            "base pressure (docs/limits.md)."
        )
    options = {"latest": latest, "step_ratio": asked.step_ratio, "damping": damping, "entry": entry}

    def march(count: int, coarser: Tried | None) -> tuple[Marched, Tried | None]:
        started = time.perf_counter()
        check_size(scene, latest, length, count, memory, asked.estimate, entry)
        parts = laid_out(scene, count, length, tolerance, asked.estimate, **options)
        setup = time.perf_counter() - started
        marched = advance(
            scene, parts, end_time, asked.every, memory=memory, stops=stops, rtol=rtol, setup=setup
        )
        known = marched.checkpoint
        tried = Tried(count, known.departure.share)
        if coarser is not None and marched.end_time >= end_time:
            order = order_seen(coarser, tried)
            marched = judged(replace(marched, checkpoint=replace(known, order=order)))
        return marched, tried

    # 1000 nodes: the slip rate of `preloaded` is then off by 0.007 %, in 0.3 s.  With 250, the
    # first for an rtol, it is off by 0.6 %, in 0.05 s.
    least = 1000 if rtol is None else 250
    check_size(scene, latest, length, nodes or least, memory, asked.estimate, entry)
    count = enough_nodes(scene, end_time, length, nodes, least, options)
    return MarchPlan(count, MOST_NODES, march, int, lambda marched: marched.error_estimate)


def _going_on(scene: Scene, asked: Asked, given: dict[str, Any], stops: Stops) -> MarchPlan:
    """Return how a march beside a slot is continued, without recomputing anything."""
    marched: Any = asked.go_on
    start = marched.checkpoint
    both = [each.checkpoint for each in (marched, marched.companion) if each is not None]
    parts = [(known.grid, known.layout) for known in both]
    options = {"memory": given.get("memory"), "stops": stops, "rtol": start.rtol}

    def march(*_: object) -> tuple[Marched, None]:
        # no order: that was seen until the time that the march had reached, under its loads alone
        return advance(scene, parts, asked.end_time, start.every, earlier=marched, **options), None

    return MarchPlan(marched.nodes, MOST_NODES, march, int, lambda marched: marched.error_estimate)


def enough_nodes(
    scene: Scene,
    end_time: float,
    length: float,
    given: int | None,
    least: int,
    options: dict[str, Any],
) -> int:
    """Return the given nodes, or from `least` on as many as loads, edge and friction law need.

    The options are those of `laid_out`.

    Raises
    ------
    SceneError
        If the loads need more than are given, or more than `MOST_NODES`.
    """
    nodes, most = given, given or MOST_NODES
    if nodes is None:
        zone, weakening = zone_at_edge(scene, end_time), process_zone(scene)
        resolving = [math.ceil(WEAKENING_NODES * length / weakening)]
        resolving += [math.ceil(ZONE_NODES * length / zone)] if zone else []
        # A zone that even MOST_NODES do not resolve is marched on the usual number of nodes
        # and reported as "unresolved" (`Marched.caution`).
        nodes = max(least, LEAST_NODES, *(count for count in resolving if count <= MOST_NODES))
    # Nodes that were given are not raised silently.
    latest, ratio = options["latest"], options["step_ratio"]
    needed, name = nodes_for_loads(scene, latest, length, nodes, ratio)
    if needed > most:
        raise SceneError(
            f"march: the {name} history turns faster than {most} nodes on a length of "
            f"{length:.4g} follow; raise `nodes` to {rounded_up(needed)}, or shorten "
            f"`length` {needed / most:.2g} times (docs/limits.md)."
        )
    return needed


# --- along a line ------------------------------------------------------------------------------


def along_line(
    scene: Scene, asked: Asked, given: dict[str, Any], stops: Stops, interrupted: Stops
) -> MarchPlan:
    """Return how a scene on a line is marched, with settings that were given for lines.

    Marches on half the nodes end where `interrupted` says so.

    Raises
    ------
    SceneError
        If the interface or an option is not admissible.
    """
    end_time, go_on = asked.end_time, asked.go_on
    scene = with_period(scene, end_time)
    check_contrast(*scene.bodies, LARGEST_CONTRAST)
    options = _checked_options(given, end_time)
    options["histories"] = nodes_for_histories(scene, end_time)
    nodes = asked.nodes
    if go_on is None:
        options["latest"] = _latest_of(asked)
        options["of_steps"]["step_ratio"] = asked.step_ratio
    else:
        nodes, options["latest"] = go_on.nodes, go_on.checkpoint.latest
        options["of_steps"] = go_on.checkpoint.settings
    needed = max(options["histories"], nodes_for_contact(scene))
    most = tuning.MOST_NODES
    if nodes is None:
        least = in_fours(needed) if tuning.NODES < needed <= most else tuning.NODES
        # the run with half the nodes, which estimates the error, needs ends that fit as well
        nodes = min(fitting_nodes(scene, least, 1), most)
    elif asked.rtol is not None and go_on is None and nodes < needed <= most:
        nodes = in_fours(needed)
    count = checked_count("march: nodes", nodes, 8, "a whole number of at least")
    if count % 4 or count > most:
        raise SceneError(
            f"march: nodes must be a multiple of 4, {most} at most, got {count}; choose "
            f"{min(4 * max(round(count / 4), 1), most)}."
        )

    def march(count: int, coarser: Tried | None) -> tuple[Marched, Tried | None]:
        done = _run(scene, count, asked, options, stops)
        if done.is_interrupted or not asked.estimate:
            return done, None
        kept = {"times": list(done.interface.t), "shift": done.shift}
        fewer = replace(asked, go_on=None)

        def half(other: Scene) -> Marched:
            return _run(other, count // 2, fewer, options | kept, interrupted)

        return estimated(done, half, asked.rtol, coarser)

    return MarchPlan(
        count,
        most,
        march,
        lambda least: min(fitting_nodes(scene, in_fours(least), 1), most),
        lambda done: done.error_estimates[deciding(done, done.error_estimates)],
    )


def _checked_options(given: dict[str, Any], end_time: float) -> dict[str, Any]:
    """Return the settings of a march along a line, those of its `Stepper` apart."""
    options: dict[str, Any] = {"frames": given.get("frames", 400), "times": given.get("times")}
    checked_count("march: frames", options["frames"], 2, "a whole number of at least")
    if options["times"] is not None:
        options["times"] = sorted(float(time) for time in options["times"])
        # nan is none of these, and so refused.
        if not (options["times"] and all(0 <= time <= end_time for time in options["times"])):
            raise SceneError("march: times must lie between 0 and the end time.")
    begun = options["slipping"] = given.get("slipping")
    if begun is not None:
        checked_number("march: slipping", begun, "be 0 or more", lambda rate: rate >= 0)
    of_steps = {key: value for key, value in given.items() if key not in options}
    for name, value in of_steps.items():
        if name == "sweeps":
            checked_count("march: sweeps", value, 1, "a whole number of at least")
        elif value != math.inf:
            of_steps[name] = checked_size(f"march: {name}", value)
    return options | {"of_steps": of_steps, "shift": None}  # moved as suits the ends of contacts


def _run(scene: Scene, nodes: int, asked: Asked, options: dict[str, Any], stops: Stops) -> Marched:
    """Return a march along a line on one grid, without error estimates.

    On the grid that was asked for, friction between different bodies which it cannot follow is
    refused.
    """
    end_time, latest, earlier = asked.end_time, options["latest"], asked.go_on
    shift = options["shift"]
    stepper = Stepper(scene, nodes, end_time=latest, shift=shift, **options["of_steps"])
    if shift is None:
        stepper.check_sliding()
        stepper.ladder.check_longest()
    begun = options["slipping"]
    if begun is None:
        # Slip under rate-and-state friction has begun: at 26 mm/s for TPV101.
        begun = 1e-3 * float(stepper.pressure.max(initial=0.0)) / stepper.impedance
        begun = 0.0 if stepper.law.has_threshold else begun
        begun = begun if earlier is None else earlier.seen.slipping
    record = MarchRecord(stepper, asked.every, options["frames"], options["times"], begun)
    walk, stopped = Walk(stepper, record, end_time, latest, earlier), False

    def stopping(time: float) -> bool:
        nonlocal stopped
        stopped = stops(time)
        return stopped

    for _ in walk.steps(stopping):
        pass
    now = walk.now
    stopped = stopped and now.time < end_time
    done = walk.marched(nodes, stopped)
    if stopped:
        return replace(done, status=f"interrupted at t = {now.time:.6g}")
    pressed = done.interface.pressure[:, stepper.touching].max(axis=0)
    status = too_short(scene, now.time) or unresolved(
        stepper,
        np.maximum(stepper.pressure, pressed),
        now.state,
        float(done.totals.peak_rate.max()),
        options["histories"],
    )
    caution = line_caution(scene, nodes, now.time) if shift is None else ""
    return replace(done, status=status, caution=caution)
