"""Runs of an interface until an end time, with error estimates, and their continuation."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.checks import missed_slip, too_short, wrong_beside_slots
from semianalytic.engine.record import Record, checkpoint, fingerprint, resumed
from semianalytic.engine.result import Run
from semianalytic.engine.stepping.advance import advanced
from semianalytic.engine.stepping.line import fitting_nodes
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact, nodes_for_histories
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.engine.stepping.tuning import (
    ERROR_SAFETY,
    LEAST_GAP,
    MOST_NODES,
    NODES,
    STEP_RATIO,
    ZONE_NODES,
)
from semianalytic.engine.stepping.window import doubt_of
from semianalytic.interface.fields import sampled
from semianalytic.interface.files import InterfaceFile
from semianalytic.interface.interface import Interface
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.checks import checked_count, checked_number, checked_size
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Progress = Callable[[float, float], bool | None]


def refuses(problem: Interface | InterfaceFile) -> None:
    """Return None: every interface is run."""


def run(
    interface: Interface,
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
    go_on: Run | None = None,
    latest: float | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Run:
    """Compute what happens on an interface from t = 0 until an end time.

    Steps are as long as friction and convergence allow: shortest in an event, up to a million times
    longer between events.  A second run with half the nodes gives the error estimates.  Ctrl-C ends
    a run early and returns what was computed until then.

    Parameters
    ----------
    interface : Interface
        The interface to compute.
    end_time : float
        Last time [time].
    nodes : int, optional
        Nodes of one period, a multiple of 4.  By default they are 512, or as many as the histories
        of loads and the narrowest contact or slot need, and up to twice as many, so that ends of
        contacts lie midway between nodes or close to it.  The grid is moved to have them there
        (`Run.shift`) unless the interface is even; what it displaces still counts as error, and
        `Run.caution` tells it.
    rtol : float, optional
        Wanted relative error of slip and gap; nodes are doubled until the estimates are below it,
        up to 16,384.
    step_ratio : float
        Shortest step c_t dt / h; stable below about 0.5 (nu near 0.5) to 0.65 (nu = 1/3) and more.
        Slip rate is mostly as exact with 0.5 as with 0.3.
    every, frames : int
        Fields are stored after every `every` steps; if there are more than `frames` of them, every
        second one is dropped and `every` doubles.
    times : sequence of float, optional
        Times at which fields are stored instead [time].
    slipping : float, optional
        |slip rate| beyond which slip has begun, for `Run.onset` [length / time].  By default it is
        0 for laws that stick, and a thousandth of the largest pressure over the impedance for
        rate-and-state friction, which always slips.
    estimate : bool
        Whether to compute the second run, on which the error estimates rest.
    go_on : Run, optional
        A run of the same interface to continue.  After an interruption the result is the same to
        the last bit as that of a run which was not interrupted; after an end time, whose last step
        was cut to end there, to rounding.
    latest : float, optional
        Time up to which `go_on` may continue this run [time]; the end time by default.  The memory
        is made for it.
    progress : function, optional
        Called with time and end time after every step; the run ends where it returns True.
    **settings
        `sweeps`, `tolerance`, `state_share`, `bound_share`, `longest` of `Stepper`.

    Returns
    -------
    Run

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
    >>> fault = sf.Interface(rock, law, length=8.0, pressure=1e6, shear=0.6e6, rate=1e-6,
    ...                      loads=[pushed])
    >>> slow = sf.solve(fault, end_time=0.5, nodes=32)
    >>> bool(slow.slip.max() > 2e-6), slow.status
    (True, 'done')
    """
    end_time = checked_size("run: end_time", end_time)
    every = checked_count("run: every", every, 1, "a whole number of at least")
    frames = checked_count("run: frames", frames, 2, "a whole number of at least")
    step_ratio = checked_size("run: step_ratio", step_ratio)
    if rtol is not None:
        rtol = checked_size("run: rtol", rtol)
    if times is not None:
        times = sorted(float(one) for one in times)
        # nan is none of these, and so refused.
        if not (times and all(0 <= one <= end_time for one in times)):
            raise SceneError("run: times must lie between 0 and the end time.")
    if slipping is not None:
        slipping = checked_number("run: slipping", slipping, "be 0 or more", lambda one: one >= 0)
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
    histories = nodes_for_histories(interface, end_time)
    options["histories"] = histories
    needed = max(histories, nodes_for_contact(interface))
    if nodes is None:
        least = in_fours(needed) if NODES < needed <= MOST_NODES else NODES
        # the run with half the nodes, which tells the error, needs ends that fit as well
        nodes = min(fitting_nodes(interface, least, 1), MOST_NODES)
    elif rtol is not None and go_on is None and nodes < needed <= MOST_NODES:
        nodes = in_fours(needed)
    count = _checked_nodes(nodes)
    while True:
        with deferred_interrupt() as options["interruption"]:
            done = _one(interface, end_time, count, options, settings, go_on, progress, check=True)
            if not done.is_interrupted and (estimate or rtol is not None):
                done = _estimated(done, end_time, options, settings, rtol)
        if not done.error_estimates:
            return done
        error = done.error_estimates[_deciding(done, done.error_estimates)]
        if rtol is None or error <= rtol or 2 * count > MOST_NODES or go_on is not None:
            return done
        # The order is two where fields are smooth and one beside edges: at order one, four times as
        # many nodes reduce the error to a quarter.
        growth = 2 if error / rtol < 4 else 4
        count = min(count * growth, MOST_NODES)


@wraps(run)  # whose parameters are those of an interface; a file has some of them
def solve(problem: Interface | InterfaceFile, **settings: Any) -> Run:
    """Run an interface as `run` does, with the settings of its file where others are not given."""
    if isinstance(problem, InterfaceFile):
        planned = {"end_time": problem.end_time, **problem.options}
        if "go_on" in settings:
            planned.pop("nodes", None)  # which are those of the run that goes on
        problem, settings = problem.interface, planned | settings
    if "end_time" not in settings:
        raise SceneError("solve: an Interface does not say how long it is run; give end_time.")
    return run(problem, **settings)


def _checked_settings(settings: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of a `Stepper`, all of them positive numbers."""
    known = ("sweeps", "tolerance", "state_share", "bound_share", "longest")
    for name, value in settings.items():
        if name not in known:
            others = [*list(inspect.signature(run).parameters)[1:-1], *known]
            raise SceneError(
                f"solve: {name} is no setting of space-time for an Interface, which knows "
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
    interface: Interface,
    end_time: float,
    nodes: int,
    options: dict[str, Any],
    settings: dict[str, Any],
    go_on: Run | None,
    progress: Progress | None,
    check: bool = False,
) -> Run:
    """Return a run on one grid, without error estimates.

    With `check`, friction between different bodies that this grid cannot follow is refused.
    """
    latest = (
        options["latest"] if go_on is None else max(float(go_on.checkpoint["latest"]), end_time)
    )
    ratio, shift = options["step_ratio"], options["shift"]
    stepper = Stepper(interface, nodes, ratio, end_time=latest, shift=shift, **settings)
    if check:
        stepper.check_sliding()
        stepper.ladder.check_longest()
    begun = options["slipping"]
    if begun is None:
        begun = _slipping(stepper) if go_on is None else float(go_on.checkpoint["slipping"])
    record = Record(stepper, options["every"], options["frames"], options["times"], begun)
    if go_on is None:
        now = stepper.begin()
        record.begin(now)
    else:
        now = resumed(stepper, record, go_on, end_time)
        if now.time in interface.jumps:
            # the earlier run ended with the values before the jump
            now = stepper.jump(now)
    stops = [at for at in interface.jumps if now.time < at < end_time] + [end_time]

    def asked(time: float) -> bool:
        told = progress is not None and progress(time, end_time)
        return bool(options["interruption"].pressed or told)

    stopped = False
    while stops and not stopped:
        now, stopped = advanced(stepper, now, stops[0], record.add, asked)
        if now.time >= stops[0]:
            stopped = stopped and len(stops) > 1
            stops.pop(0)
            if stops:
                now = stepper.jump(now)
    record.end(now)
    loaded = record.fields["pressure"] if stepper.unilateral is not None else []
    most = np.maximum.reduce([stepper.pressure, *(one[stepper.touching] for one in loaded)])
    status = too_short(interface, now.time) or _resolution(
        stepper, most, now.state, max(record.peak_rates), options["histories"]
    )
    if stopped:
        status = f"interrupted at t = {now.time:.6g}"
    return Run(
        interface=interface,
        nodes=nodes,
        x=stepper.grid.x,
        touching=stepper.touching,
        t=np.array(record.t),
        slip=np.array(record.fields["slip"]),
        slip_rate=np.array(record.fields["slip_rate"]),
        shear_traction=np.array(record.fields["shear_traction"]),
        state=np.array(record.fields["state"]),
        pressure=np.array(record.fields["pressure"]),
        felt_pressure=np.array(record.fields["felt_pressure"]),
        gap=np.array(record.fields["gap"]),
        onset=record.onset,
        step_times=np.array(record.step_times),
        peak_rates=np.array(record.peak_rates),
        status=status,
        checkpoint=checkpoint(stepper, record, now, fingerprint(stepper, latest))
        | {"latest": latest},
    )


def _slipping(stepper: Stepper) -> float:
    """Return the slip rate beyond which slip has begun, by default [length / time]."""
    if stepper.law.has_threshold:
        return 0.0
    # Slip under rate-and-state friction has begun: at 26 mm/s for TPV101.
    return 1e-3 * float(stepper.pressure.max(initial=0.0)) / stepper.impedance


def _estimated(
    done: Run,
    end_time: float,
    options: dict[str, Any],
    settings: dict[str, Any],
    rtol: float | None,
) -> Run:
    """Return a run with estimates of its error from runs with half the nodes.

    There is one, and another whose contacts are shorter where the grid displaces their ends.
    """
    interface = done.interface
    options = {**options, "times": list(done.t), "shift": done.shift}
    coarse = _one(interface, end_time, done.nodes // 2, options, settings, None, None)
    shorter, misplaced = coarse, done.contact_misfit / 2
    if misplaced and not coarse.is_interrupted:
        contact = interface.contact.shortened(interface.length, done.nodes, done.shift)
        cut = replace(interface, contact=contact)
        shorter = _one(cut, end_time, done.nodes // 2, options, settings, None, None)
    if coarse.is_interrupted or shorter.is_interrupted:
        return replace(
            done, status="interrupted in the estimate of its error: complete, without one"
        )
    between = not interface.contact.is_whole
    touching = coarse.touching
    if between:
        # a coarse node at the end of a contact may stand for a node of the slot as well
        touching = shorter.touching & touching & done.touching[::2] & done.touching[1::2]

    def thinned(values: Array) -> Array:
        pairs = (values[:, ::2] + values[:, 1::2]) / 2 if between else values[:, ::2]
        return np.asarray(pairs[:, touching])

    spacing = interface.length / done.nodes
    base = thinned(sampled("run: shear", interface.shear, done.x, spacing)[None])
    beside = wrong_beside_slots(done)
    errors = {}
    names = ["slip", "slip_rate", "shear_traction"]
    if done.interface.may_open:
        names += ["gap", "pressure"]
    for name in names:
        fine, other = thinned(getattr(done, name)), getattr(coarse, name)[:, touching]
        moved = getattr(shorter, name)[:, touching] - other
        # Against the base, whichever frames are stored: a sudden load has come at the first.
        scale = fine - base if name == "shear_traction" else fine
        apart = float((np.abs(fine - other) + misplaced * np.abs(moved)).sum())
        # where the finer grid has nothing and the coarser one something, the error is all of it
        size = max(float(np.abs(scale).sum()), apart)
        # `thinned` has every other node, or the mean of two.
        apart = ERROR_SAFETY * apart + beside.get(name, 0.0) / 2
        errors[name] = apart / size if size else 0.0
    largest = 0.5 if rtol is None else rtol
    slip, (zone, missed) = float(np.abs(thinned(done.slip)).sum()), missed_slip(done)
    # `thinned` has every other node, or the mean of two.
    missed = missed / (2 * spacing)
    # A contact that sticks up to 2e-7 node distances beside an edge asked for 1e10 nodes.
    if zone < 1e-5 * spacing:
        missed = 0.0
    if missed > 0:
        share = missed / (slip + missed)
        for name in ("slip", "slip_rate"):
            errors[name] += share * (1 - errors[name])
    status, name = done.status, _deciding(done, errors)
    if status == "done" and missed > largest * (slip + missed):
        # Slip at a slot that is pushed is 7, 1.6 and 0.4 % off with 2, 4 and 8 nodes on it.
        needed = in_fours(interface.length * 4.0 / zone)
        status = (
            f"unresolved: the contact slips beside an edge over about {zone:.2g}, which nodes "
            f"{spacing:.2g} apart do not resolve; use {needed} nodes or more."
        )
    if status == "done" and errors[name] > largest:
        what = "slip" if name == "slip" else "the gap"
        status = f"unresolved: {what} may be off by {errors[name]:.1g} of itself; raise `nodes`."
    return replace(done, error_estimates=errors, status=status)


def _deciding(done: Run, errors: Mapping[str, float]) -> str:
    """Return which error counts, that of slip or that of a gap which is not much smaller."""
    slip, gap = (float(np.abs(one[:, done.touching]).sum()) for one in (done.slip, done.gap))
    larger = errors.get("gap", 0.0) > errors["slip"]
    return "gap" if larger and gap > LEAST_GAP * slip else "slip"


def _resolution(
    stepper: Stepper, pressure: Array, state: Array, fastest: float, needed: float
) -> str:
    """Return "done", or why the grid cannot follow the loads, or the law at the largest pressures
    and rate; `needed` are the nodes that histories of loads need."""
    nodes = stepper.grid.nodes
    if nodes < 0.999 * needed:
        remedy = "smooth it or the samples that lie beside each other"
        if needed < math.inf:
            remedy = f"use {in_fours(needed)} nodes or more, or smooth it"
        return f"unresolved: the history of a load turns faster than {nodes} nodes follow; {remedy}"
    if stepper.pair is not None:
        doubt = doubt_of(stepper.pair, stepper.law, pressure, state, fastest, stepper.grid.spacing)
        if doubt:
            return f"unresolved: {doubt}"
    needed = nodes_for_contact(stepper.interface)
    if nodes < 0.999 * needed:
        narrow = stepper.interface.contact.narrowest(stepper.interface.length)
        return (
            f"unresolved: a contact or slot of width {narrow:.3g} has "
            f"{narrow / stepper.grid.spacing:.2g} nodes; use {in_fours(needed)} nodes or more."
        )
    weakening = stepper.law.weakening(pressure)
    if stepper.unilateral is not None and stepper.unilateral.adhesion is not None:
        bonds = stepper.unilateral.adhesion
        weakening = max(weakening, float(np.max(bonds.strength / bonds.length)))
    if not weakening > 0:
        return "done"
    bodies = (stepper.interface.material, stepper.interface.lower_material)
    zone = min(body.shear_modulus for body in bodies if body is not None) / weakening
    found = zone / stepper.grid.spacing
    if found >= ZONE_NODES:
        return "done"
    least = in_fours(stepper.interface.length * ZONE_NODES / zone)
    return (
        f"unresolved: the strength falls over {found:.2g} node distances of "
        f"{stepper.grid.spacing:.3g}; use {least} nodes or more."
    )
