"""Slip under any load history: the interface alone is marched in time on a spectral grid.

Next to a slot the grid is half of a line that is even about its ends, so long that no wave from
x = 0 returns from a mirror to the observed length before the latest time; along a line it is one
period (`plan`).  Jumps of the loads fall on time levels; between them a level takes the load
at its time, or the exact mean over a step that contains several samples of a table.  Loads that
turn faster than the grid can follow are refused, or make the march unresolved.
"""

from __future__ import annotations

import inspect
import logging
import math
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from os import PathLike
from typing import Any

from semianalytic.engine.convergence import more_nodes, order_seen
from semianalytic.engine.marched import Marched
from semianalytic.engine.plan import Asked, along_line, beside_slot, check_going_on, checked_within
from semianalytic.engine.stepping.tuning import MOST_NODES, STEP_RATIO
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.arguments import taking_quantities
from semianalytic.scene.checks import checked_count, checked_size
from semianalytic.scene.errors import SceneError, TensionError
from semianalytic.scene.given.finding import any_scene, scene_of_one_solid
from semianalytic.scene.scene import Scene

LINE_NODES = 500
"""Nodes on the contact that waves reach of a scene that opens; `lift-off` is .2 % off, in 1 s."""
_log = logging.getLogger(__name__)


def settings_of(scene: Scene) -> list[str]:
    """Return the settings of `march` that it takes for a scene, by name."""
    common = list(inspect.signature(march).parameters)[1:-1]
    if scene.on_line:
        of_steps = ["sweeps", "tolerance", "state_share", "bound_share", "longest"]
        return [*common, "frames", "times", "slipping", *of_steps]
    return [*common, "length", "damping", "tolerance", "memory", "entry"]


def refuses(scene: Scene) -> str | None:
    """Return why a scene is not marched unless that is asked for, or None."""
    if scene.on_line or not scene.is_step:
        return None
    try:
        scene.check_front()
    except SceneError as error:
        begins = "a march depends on where on the slot the load begins; ask for it with `method` "
        return (
            begins + "space-time." if scene.front_too_slow else str(error).removeprefix("solve: ")
        )
    return None


def march(
    scene: Scene | str | PathLike[str],
    end_time: float | None = None,
    nodes: int | None = None,
    *,
    rtol: float | None = None,
    estimate: bool = True,
    step_ratio: float = STEP_RATIO,
    every: int = 1,
    latest: float | None = None,
    go_on: Marched | None = None,
    progress: Callable[[float, float], object] | None = None,
    **settings: Any,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    The method is described in docs/spacetime.md and docs/engine.md; its equation is (4.40) with the
    right sign (docs/theory.md, "Any load history").  Next to a slot steps are equal.  Along a line
    they are as long as friction and convergence allow: shortest in an event, up to a million times
    longer between events.  A second march on half the nodes gives the error estimates.  Ctrl-C ends
    a march early and returns what was computed until then.

    Next to a slot a march needs 128 bytes per pole (about 25) and grid node (about 1.5 per contact
    node), 32 bytes per stored node and level (see `GridPressure` for pressure that oscillates), and
    half as much again for its companion.  Its time grows like nodes^2.

    Parameters
    ----------
    scene : Scene, str or path
        The scene to march, or its name or file as for `find`.
    end_time : float, optional
        Last time [time]; next to a slot by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Next to a slot contact nodes on 0 < x < length, at least 16; by default 1000, or up to 8000
        where the loads, the slip zone at the edge or slip weakening need them.  Along a line nodes
        of one period, a multiple of 4; by default 512, or as many as the histories of loads and the
        narrowest contact or slot need, and up to twice as many, so that ends of contacts lie midway
        between nodes or close to it.  The grid is moved to have them there (`Marched.shift`) unless
        the interface is even; what it displaces still counts as error (`Marched.caution`).
    rtol : float, optional
        Largest acceptable `Marched.error_estimate` next to a slot, and error of slip and gap along
        a line.  The number of nodes is raised, by as much as the order of convergence requires, up
        to 8000 next to a slot and 16,384 along a line; the march is "unresolved" if these are not
        enough.  Next to a slot it excludes `nodes`.
    estimate : bool
        Whether to march on half the nodes as well, for the error estimates; next to a slot it takes
        a quarter to a third more time from 1000 nodes on, half below.
    step_ratio : float
        Shortest step, c_t dt over the node distance; stable below about 0.5 (nu near 0.5) to 0.65
        (nu = 1/3) and more.
    every : int
        Store every n-th time level; the last is always stored.  It is raised if the stored levels
        next to a slot do not fit into the memory, and doubled along a line if they exceed `frames`.
    latest : float, optional
        Time to which the march may be continued (`go_on`) [time]; end_time unless given.  Grid,
        steps and memory are made for it.
    go_on : Marched, optional
        March of this scene that is continued to the end time; it is not changed.  Next to a slot it
        keeps its grid and steps, and ends at the latest possible time by default.  Along a line the
        last step, which was shortened to end there, is repeated.  The result is that of an
        uninterrupted march, along a line to the last bit.
    progress : callable, optional
        Called with time and end time after each step of a march, not of its companion; if it
        returns True the march ends there, next to a slot one step later where its companion has no
        level, and may be continued.

    Returns
    -------
    Marched
        Slip, tractions and totals along the interface, the fields in both bodies, and an error
        estimate.

    Other Parameters
    ----------------
    length : float, optional
        Next to a slot, observed length of the contact [length]; by default the distance that waves
        reach, c_l T (c_t T under antiplane shear alone).
    damping : float, optional
        Next to a slot, least feedback of the shortest wave, 0 (none) ... 0.95; by default 0.7 under
        friction that falls with slip, and 0.6 otherwise.
    tolerance : float
        Relative error of the memory's transform, above 1e-11 and up to 1e-2.
    memory : float, optional
        Next to a slot, memory that the march may take [bytes]; by default 70 % of what the machine
        has available.
    entry : float, optional
        Next to a slot, distance from the tip at which a load that comes along it begins [length].
        By default it is so long that no wave from the beginning matters until `latest`.  If the
        front is no faster than the first wave, there is no such length, the answer depends on it,
        and the default is `length`; times then begin before 0, where the front reaches the tip.
    frames : int
        Along a line, the largest number of stored levels, 400 by default.
    times : sequence of float, optional
        Along a line, times at which fields are stored instead [time].
    slipping : float, optional
        Along a line, |slip rate| beyond which slip has begun [length / time].  By default it is 0
        for laws that stick, and a thousandth of the largest pressure over the impedance for
        rate-and-state friction, which always slips.
    sweeps, state_share, bound_share, longest : optional
        Along a line, those of `Stepper`.

    Raises
    ------
    SceneError
        If an option is out of range, both nodes and an rtol are given, the step is beyond the
        stable range, rate weakening is ill posed at a pressure that arises, the grid does not
        resolve the loads or slip weakening, or the march would take too much memory.
    TensionError
        If the pressure next to a slot turns tensile at a node.
    ComputationError
        If the memory cannot be fitted or values are no longer finite.

    Examples
    --------
    A shear load that rises within 15 microseconds makes the contact slip from the edge on:

    >>> from semianalytic import Material, Ramp, Scene, Tractions, solve
    >>> steel = Material(shear_modulus=80e9, density=7800.0, poisson_ratio=1 / 3)
    >>> scene = Scene(
    ...     steel, 0.1, Tractions(5e6, 0.0), Tractions(0.0, 5e6), shear_history=Ramp(1.5e-5)
    ... )
    >>> run = solve(scene, end_time=3e-5, nodes=128)
    >>> run.status
    'resolved'
    >>> bool(run.error_estimate < 0.05)
    True
    >>> f"{float(run.slip(0.01, 3e-5)):.1e} m"
    '3.0e-06 m'
    >>> part = solve(scene, end_time=2e-5, nodes=128, latest=3e-5)
    >>> solve(scene, end_time=3e-5, go_on=part).end_time
    3e-05

    On a fault that is pushed everywhere:

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
    scene = any_scene("march", scene)
    given = {name: value for name, value in settings.items() if value is not None}
    if rtol is not None:
        rtol = checked_within("rtol", rtol, 0.0, 1.0)
        if not estimate:
            raise SceneError("march: `rtol` needs the estimate; leave `estimate` out.")
    if go_on is not None:
        end_time = go_on.checkpoint.latest if end_time is None else end_time
    elif end_time is None and scene.on_line:
        raise SceneError("solve: the scene does not say how long it is marched; give end_time.")
    # By default a march lasts until a shear wave has travelled a length of 1 in the scene's units.
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    end_time = checked_size("march: end_time", end_time, "be above 0")
    if go_on is not None and scene.on_line and scene.period == math.inf:
        scene = replace(scene, period=go_on.scene.period)
    asked = Asked(
        end_time=end_time,
        nodes=nodes,
        rtol=rtol,
        estimate=estimate,
        step_ratio=checked_size("march: step_ratio", step_ratio, "be above 0"),
        every=checked_count("march: every", every, 1, "a whole number of at least"),
        latest=latest,
        go_on=go_on,
    )
    if go_on is not None:
        check_going_on(scene, go_on, asked, given)
    told = False
    with deferred_interrupt() as interruption:

        def stops(time: float) -> bool:
            nonlocal told
            told = told or (progress is not None and bool(progress(time, end_time)))
            told = told or interruption.pressed
            return told

        if scene.on_line:
            plan = along_line(scene, asked, given, stops, lambda _: interruption.pressed)
        else:
            plan = beside_slot(scene_of_one_solid("march", scene), asked, given, stops)
        count, coarser = plan.nodes, None
        while True:
            marched, tried = plan.march(count, coarser)
            if rtol is None or go_on is not None or told or tried is None or count >= plan.most:
                break
            if (error := plan.error(marched)) <= rtol:
                break
            order = None if coarser is None else order_seen(coarser, tried)
            least = more_nodes(count, error, rtol, order, plan.most)
            count, coarser = plan.fitting(least), tried
    if told and marched.end_time < end_time:
        marched = replace(marched, status=f"interrupted at t = {marched.end_time:.6g}")
    _log.debug("march: %r", marched)
    return marched


@taking_quantities
@wraps(march)  # whose settings these are
def solve(scene: Scene, **settings: Any) -> Marched:
    """March a scene as `march` does; a slot that opens is marched along a line, where it may."""
    try:
        return march(scene, **settings)
    except TensionError as tension:
        # what else was asked of a march has no meaning on the line
        if settings.keys() - {"end_time", "nodes", "rtol", "progress"}:
            raise
        end = settings.get("end_time") or 1 / scene.material.shear_speed
        # waves that leave the contact at the end of the period do not come back
        period = 4 * scene.fastest_speed * end
        try:
            line = replace(scene, period=period)
        except SceneError:  # loads of antiplane lines have no pressure
            raise tension from None
        asked = {name: settings[name] for name in ("rtol", "progress") if name in settings}
        # a quarter of the period is the part of the contact that waves reach
        nodes = min(4 * (settings.get("nodes") or LINE_NODES), MOST_NODES)
        return march(line, end, None if "rtol" in asked else nodes, **asked)
