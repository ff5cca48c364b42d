"""Slip under any load history: the interface alone is marched in time on a spectral grid.

The grid is long enough that no wave from x = 0 returns from a mirror at its ends to the observed
length before the latest time.  Jumps of the loads fall on time levels; between them a level takes
the load at its time, or the exact mean over a step that contains several samples of a table.  Loads
that turn faster than the grid can follow are refused (`resolution`).  The steps are those of
`stepping.blocks`.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from os import PathLike
from typing import Any

from semianalytic.engine import plan
from semianalytic.engine.advancing import advance
from semianalytic.engine.convergence import Tried, more_nodes, order_seen
from semianalytic.engine.estimate import judged
from semianalytic.engine.loads import TOLERANCES
from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import check_size
from semianalytic.engine.run import run
from semianalytic.engine.stepping.means import LARGEST_FEEDBACK
from semianalytic.engine.stepping.tuning import MOST_NODES as MOST_LINE_NODES
from semianalytic.engine.stepping.tuning import STEP_RATIO
from semianalytic.scene.checks import LARGEST, checked_count, checked_number, checked_size
from semianalytic.scene.contact import process_zone, wave_slips_ahead
from semianalytic.scene.errors import SceneError, TensionError
from semianalytic.scene.given.finding import of_scene, scene_of_one_solid
from semianalytic.scene.scene import Scene

TOLERANCE = 1e-6
"""Default tolerance of the memory's transform: for 1024 nodes as good as 1e-10."""

DAMPING, WEAKENING_DAMPING = 0.6, 0.7
"""Default least feedback of the shortest wave, and that under slip weakening.

Without any, small steps leave an odd-even mode.  With 0.5 slip weakening is 1.4 times less exact;
0.7 instead of 0.6 makes pulses 3 % less exact.
"""

LINE_NODES = 500
"""Nodes on the contact that waves reach of a scene that opens; `lift-off` is .2 % off, in 1 s."""

_log = logging.getLogger(__name__)


def refuses(scene: Scene) -> str | None:
    """Return why a scene is not marched unless that is asked for, or None."""
    if not scene.is_step:
        return None
    try:
        scene.check_front()
    except SceneError as error:
        begins = "a march depends on where on the slot the load begins; ask for it with `method` "
        return (
            begins + "space-time." if scene.front_too_slow else str(error).removeprefix("solve: ")
        )
    return None


@of_scene
def march(
    scene: Scene | str | PathLike[str],
    end_time: float | None = None,
    nodes: int | None = None,
    *,
    rtol: float | None = None,
    length: float | None = None,
    latest: float | None = None,
    estimate: bool = True,
    step_ratio: float = STEP_RATIO,
    damping: float | None = None,
    every: int = 1,
    tolerance: float = TOLERANCE,
    memory: float | None = None,
    entry: float | None = None,
    go_on: Marched | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    The method is described in docs/spacetime.md; its equation is (4.40) with the right sign
    (docs/theory.md, "Any load history").  A march needs 128 bytes per pole (about 25) and grid node
    (about 1.5 per contact node), 32 bytes per stored node and level (see `GridPressure` for
    pressure that oscillates), and half as much again for the companion.  Its time grows like
    nodes^2.

    Parameters
    ----------
    scene : Scene, str or path
        Material, friction law, tractions and load histories, or a name or file as for `find`.
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Contact nodes on 0 < x < length, at least 16.  The default is 1000, or up to 8000 where the
        loads, the slip zone at the edge or slip weakening need them.
    rtol : float, optional
        Largest acceptable `Marched.error_estimate`; excludes `nodes`.  The scene is marched on more
        and more nodes until the estimate is small enough, and the last march is returned.  It has
        at most 8000 nodes, and is "unresolved" if these are not enough.
    length : float, optional
        Length of the contact that is observed [length]; by default the distance that waves reach,
        c_l T (c_t T under antiplane shear alone).
    latest : float, optional
        Time to which the march may be continued (`go_on`) [time]; end_time unless given.  The grid
        and the steps are made for it, so that a march before it ends with the step that reaches
        its end time, and the continued march is the one march.
    estimate : bool
        Whether to march a companion on half the nodes and in half the steps, for the error
        estimate; it takes a quarter to a third more time from 1000 nodes on, half below.
    step_ratio : float
        Largest c_t dt / h; stable below about 0.57 (nu near 0.5) to 0.7 (nu = 1/3) and more.
    damping : float, optional
        Least feedback of the shortest wave, 0 (none) ... 0.95; by default 0.7 under friction that
        falls with slip, and 0.6 otherwise.
    every : int
        Store every n-th time level; the last is always stored.  The number is raised if the stored
        levels do not fit into the memory.
    tolerance : float
        Relative error of the memory's transform, above 1e-11 and up to 1e-2.
    memory : float, optional
        Memory that the march may take [bytes]; by default 70 % of what the machine has available.
    entry : float, optional
        Distance from the tip at which a load that comes along the slot begins [length].  By default
        it is so long that no wave from the beginning matters until `latest`.  If the front is no
        faster than the first wave, there is no such length, the answer depends on it, and the
        default is `length`; times then begin before 0, where the front reaches the tip.
    go_on : Marched, optional
        March of this scene that is continued to the end time, by default the latest possible, on
        its own grid and in its own steps; it is not changed.
    progress : callable, optional
        Called with (step, steps) after each step of a march, not of its companion; if it returns
        True the march ends there, or one step later where its companion has a level, and may be
        continued.  With `rtol` each march counts its own steps.

    Returns
    -------
    Marched
        Slip, tractions and totals along the interface, the fields in both bodies, and an error
        estimate.

    Raises
    ------
    SceneError
        If an option is out of range, both nodes and an rtol are given, the step is beyond the
        stable range, rate weakening is ill posed at a pressure that arises, the grid does not
        resolve the loads or sees nothing of slip weakening, or the march would take more memory
        than it may.
    TensionError
        If the pressure turns tensile at a node.
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
    """
    scene = scene_of_one_solid("march", scene)
    if go_on is not None:
        fixed = {"nodes": nodes, "rtol": rtol, "length": length, "latest": latest, "entry": entry}
        for name in (name for name, value in fixed.items() if value is not None):
            raise SceneError(f"march: a continued march keeps its grid; leave out `{name}`.")
        return _continued(go_on, scene, end_time, memory, progress)
    # By default a march lasts until a shear wave has travelled a length of 1 in the scene's units.
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    end_time = checked_size("march: end_time", end_time, "be above 0")
    length = scene.fastest_speed * end_time if length is None else length
    length = checked_size("march: length", length, "be above 0")
    latest = end_time if latest is None else latest
    # The range is open below, and `latest` may equal the end time: hence the next smaller number.
    latest = _check_range("latest", latest, math.nextafter(end_time, 0.0))
    # The feedback refuses 0.5 to 0.7 or more, by Poisson ratio.
    step_ratio = _check_range("step_ratio", step_ratio, 0.0, 2.0)
    if damping is None:
        damping = WEAKENING_DAMPING if process_zone(scene) < math.inf else DAMPING
    damping = checked_number(
        "march: damping",
        damping,
        "lie between 0 and 0.95",
        lambda given: 0 <= given <= LARGEST_FEEDBACK,
    )
    tolerance = _check_range("tolerance", tolerance, *TOLERANCES)
    if nodes is not None:
        nodes = checked_count("march: nodes", nodes, plan.LEAST_NODES, "a whole number from")
    every = checked_count("march: every", every, 1, "a whole number from")
    if rtol is not None:
        rtol = _check_range("rtol", rtol, 0.0, 1.0)
        if nodes is not None:
            raise SceneError("march: `rtol` chooses the nodes; leave out `nodes`, or `rtol`.")
        if not estimate:
            raise SceneError("march: `rtol` needs the estimate; leave `estimate` out.")
    entry = plan.checked_entry(scene, latest, length, entry)
    slowness = scene.front_slowness  # a wave that meets the contact first is all over it before
    if slowness < 0 and wave_slips_ahead(scene, latest + length * abs(slowness)):
        raise SceneError(
            "march: the wave alone exceeds friction, so that the contact slips from its front "
            "on, before anything comes from the slot; lower the wave, or raise friction or the "
            "base pressure (docs/limits.md)."
        )
    options = {"latest": latest, "step_ratio": step_ratio, "damping": damping, "entry": entry}
    given: dict[str, Any] = {"memory": memory, "progress": progress, "rtol": rtol}

    def computed(count: int) -> Marched:
        started = time.perf_counter()
        check_size(scene, latest, length, count, memory, estimate, entry)
        parts = plan.laid_out(scene, count, length, tolerance, estimate, **options)
        setup = time.perf_counter() - started
        return advance(scene, parts, end_time, every, setup=setup, **given)

    # 1000 nodes: the slip rate of `preloaded` is then off by 0.007 %, in 0.3 s.  With 250, the
    # first for an rtol, it is off by 0.6 %, in 0.05 s.
    least = 1000 if rtol is None else 250
    check_size(scene, latest, length, nodes or least, memory, estimate, entry)
    count, coarser = plan.enough_nodes(scene, end_time, length, nodes, least, options), None
    while True:
        marched, most = computed(count), plan.MOST_NODES
        done = rtol is None or marched.end_time < end_time
        tried, order = Tried(count, marched.checkpoint.departure.share), None
        if coarser is not None and not done:
            order = order_seen(coarser, tried)
            marched = judged(replace(marched, checkpoint=replace(marched.checkpoint, order=order)))
        if rtol is None or done or count >= most or (error := marched.error_estimate) <= rtol:
            break
        count, coarser = more_nodes(count, error, rtol, order, most), tried
    _log.debug("march: %r", marched)
    return marched


@wraps(march)  # whose settings these are
def solve(scene: Scene, **settings: Any) -> Marched:
    """March a scene as `march` does; one that opens is marched along a line, where contacts may."""
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
        nodes = 4 * (settings.get("nodes") or LINE_NODES)
        return run(line, end, None if "rtol" in asked else min(nodes, MOST_LINE_NODES), **asked)


def _continued(
    marched: Marched,
    scene: Scene,
    end_time: float | None,
    memory: float | None,
    progress: Callable[[int, int], object] | None,
) -> Marched:
    """Return the whole march from t = 0 to a later end time, without recomputing anything."""
    if marched.scene != scene:
        raise SceneError("march: `go_on` is a march of another scene; continue it with its own.")
    start, latest = marched.checkpoint, marched.checkpoint.latest
    end_time = latest if end_time is None else end_time
    end_time = _check_range("end_time", end_time, marched.end_time)
    if end_time > latest:
        raise SceneError(
            f"march: this run can go on to {latest:.6g}; for more, start again with a "
            "later `latest`."
        )
    both = [each.checkpoint for each in (marched, marched.companion) if each is not None]
    parts: Any = [(known.grid, known.layout) for known in both]
    given: Any = {"memory": memory, "progress": progress, "rtol": start.rtol}
    # no order: that was seen until the time that the march had reached, under its loads alone
    return advance(scene, parts, end_time, start.every, earlier=marched, **given)


def _check_range(name: str, value: float, low: float, high: float = LARGEST) -> float:
    """Return a number low < value <= high as float; raise SceneError if it is not one."""
    limit = f" and at most {high:g}" if high < LARGEST else ""
    return checked_number(
        f"march: {name}", value, f"be above {low:g}{limit}", lambda given: low < given <= high
    )
