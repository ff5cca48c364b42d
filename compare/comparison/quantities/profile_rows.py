"""Fields along the interface at the end of a run, predicted and simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from compare.comparison.bars import error_bar, observed_order
from compare.comparison.case import EDGE_CELLS, NARROW, Case, own_wear, worn_by
from compare.comparison.measures import NOTHING, norm
from compare.comparison.rows import Row
from compare.comparison.snapshots import SlipRateProfile
from semianalytic import InterfaceHistory

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]
Answers = Callable[[ArrayLike, ArrayLike], Array]

NEAREST, FARTHEST = 0.02, 1.9
"""Positions over c_t T between which slip is compared: not at the edge, nor where P arrives."""
SINGLE_STEPS = 3.0
"""Error of the slip rate of single steps over that of means; 2 on average (docs/fem.md)."""
POINTS = 2000
"""At which a prediction is integrated apart from the nodes."""


def slip_rate_rows(case: Case) -> Iterator[Row]:
    """Relative errors of slip rate and slip at the end."""
    yield _slip_row(case, "slip rate", "slip_rate", case.rate, "V₀")
    yield _slip_row(case, "slip", "slip", case.rate * case.end_time, "V₀ T")


def gap_rows(case: Case) -> Iterator[Row]:
    """Relative error of the gap at the end, and the largest gap; nothing where none opens."""
    if not case.opens:
        return
    scale, reach = case.rate * case.end_time, _disturbed(case)
    opens = case.at_nodes.gap[-1] > 0
    narrow = opens & ~scipy.ndimage.binary_opening(opens, np.ones(NARROW, dtype=bool))
    yield case.profile_row(
        "gap",
        "gap",
        at_nodes(case, "gap"),
        partial(_last, "gap"),
        reach,
        exact=_norm(case, case.prediction.gap, reach, scale),
        unseen=case.unseen_norm(np.where(narrow, case.at_nodes.gap[-1], 0.0) / scale, reach),
        scale=(scale, "V₀ T"),
        smooth=True,
    )
    yield _largest_gap_row(case, scale, reach)


def _largest_gap_row(case: Case, scale: float, reach: tuple[float, float]) -> Row:
    """The largest gap at the end, beyond the first node of the coarsest mesh.

    Its bar is of the largest difference of meshes anywhere: that of their largest gaps may be small
    by chance.
    """
    runs = (case.simulation, *case.coarser)
    start = max(reach[0], runs[-1].interface.x[0])
    places = np.append(start, case.seen.x[case.seen.x > start])

    def gap(history: InterfaceHistory) -> Array:
        return np.interp(places, history.x, history.gap[-1]) / scale

    fields = [gap(run.interface) for run in runs]
    changes = [float(np.abs(fine - coarse).max()) for fine, coarse in pairwise(fields)]
    exact = case.prediction.gap(_between(case, (start, reach[1])), case.end_time) / scale
    at_nodes, simulated = float(gap(case.at_nodes).max()), float(fields[0].max())
    row = Row(
        "largest gap",
        "gap",
        float(exact.max()),
        at_nodes,
        simulated,
        simulated - at_nodes,
        error_bar("gap", changes) + NOTHING if changes else None,
        "V₀ T",
        order=observed_order(changes),
    )
    return case.judged(row, None)


def wear_rows(case: Case) -> Iterator[Row]:
    """Accumulated |slip| and frictional work per area at the end, from the stored levels."""
    slip = case.rate * case.end_time
    unseen = _unseen_wear(case)
    companion, doubted = getattr(case.prediction, "companion", None), None
    if companion is not None and case.doubted is not None:
        doubted = worn_by(companion, case.doubted)
    for part, (name, kind, field, scale, symbol) in enumerate(
        (
            ("accumulated |slip|", "slip", "final_path", slip, "V₀ T"),
            ("frictional work", "work", "final_work_density", slip * case.stress, "τ₀ V₀ T"),
        )
    ):
        if kind == "work" and case.scene.friction == 0 == case.prediction.scene.friction:
            continue
        start = NEAREST * case.length
        if kind == "work" and case.scene.load.pressure:
            start = max(start, _beside_edge(case))  # where pressure can be singular
        reach = start, FARTHEST * case.length
        yield case.profile_row(
            name,
            kind,
            np.array([case.worn_at_nodes[part], *([] if doubted is None else [doubted[part]])]),
            partial(_own, field),
            reach,
            exact=_worn_norm(case, part, reach, scale),
            unseen=case.unseen_norm(unseen[part] / scale, reach),
            scale=(scale, symbol),
        )


def snapshot_row(case: Case, profile: SlipRateProfile) -> Row:
    """The slip rate read back from a field snapshot.

    Snapshots hold single steps and histories means over some: the bar is `SINGLE_STEPS` times that
    of the slip rate at the end.
    """
    shown = (profile.x > NEAREST * case.length) & (profile.x < FARTHEST * case.length)
    x = profile.x[shown]
    predicted = case.prediction.slip_rate(x, profile.time) / case.rate
    written = profile.slip_rate[shown] / case.rate
    likewise = _slip_row(case, "slip rate", "slip_rate", case.rate, "V₀")
    if likewise.relative:
        size = norm(predicted, x / case.length, 1)
        values = size, norm(written, x / case.length, 1)
        difference = norm(written - predicted, x / case.length, 1) / size
    else:
        values = (float(np.abs(predicted).max()), float(np.abs(written).max()))
        difference = float(np.abs(written - predicted).max())
    row = replace(
        likewise,
        name=likewise.name.replace("slip rate", "slip rate of snapshot", 1),
        at_nodes=values[0],
        simulated=values[1],
        difference=difference,
        bar=None if likewise.bar is None else SINGLE_STEPS * likewise.bar,
        obstacle="",
        resolution=None,
    )
    return case.judged(row, 1.0 if row.relative else None)


def traction_rows(case: Case) -> Iterator[Row]:
    """Relative L1 errors of shear traction and pressure at the end.

    Over the disturbed interface, without the four elements next to the edge, where tractions can
    be singular.
    """
    start = _beside_edge(case)
    for name in ("shear_traction", "pressure"):
        words = name.replace("_", " ")
        reach = start, _disturbed(case)[1]
        answer = getattr(case.prediction, name)
        yield case.profile_row(
            words,
            words,
            at_nodes(case, name),
            partial(_last, name),
            reach,
            exact=_norm(case, answer, reach, case.stress),
            unseen=case.unseen_norm(_unseen_stick(case) / case.stress, reach)
            if name == "shear_traction"
            else 0.0,
            scale=(case.stress, "τ₀"),
        )


def at_nodes(case: Case, field: str) -> Array:
    """A field of the prediction at the end (n,), or with that of its companion (2, n)."""
    histories = [case.at_nodes] if case.doubted is None else [case.at_nodes, case.doubted]
    return np.array([getattr(history, field)[-1] for history in histories])


def _last(field: str, run: Simulation) -> Array:
    """A field of a run at its end, (n,)."""
    return np.asarray(getattr(run.interface, field)[-1])


def _own(field: str, run: Simulation) -> Array:
    """What a run has summed over all its steps, (n,)."""
    return np.asarray(getattr(run, field))


def _slip_row(case: Case, name: str, field: str, scale: float, symbol: str) -> Row:
    """A row of slip or slip rate at the end; what is too narrow for the mesh is in its bar."""
    reach, answer = _reach(case), getattr(case.prediction, field)
    if field == "slip":
        unseen = _unseen_wear(case)[0]
    else:
        unseen = np.where(case.narrow()[-1], case.at_nodes.slip_rate[-1], 0.0)
    return case.profile_row(
        name,
        "slip" if field == "slip" else "slip rate",
        at_nodes(case, field),
        partial(_last, field),
        reach,
        exact=_norm(case, answer, reach, scale),
        unseen=case.unseen_norm(unseen / scale, reach),
        scale=(scale, symbol),
    )


def _unseen_wear(case: Case) -> tuple[Array, Array]:
    """|slip| and frictional work per area of the prediction at nodes that only ever slip in zones
    too narrow for the mesh, (n,) each."""
    narrow = case.narrow()
    ever = np.abs(case.at_nodes.slip_rate) > NOTHING * case.rate
    unseen = (narrow == ever).all(axis=0)
    path, work = case.worn_at_nodes
    return np.where(unseen, path, 0.0), np.where(unseen, work, 0.0)


def _unseen_stick(case: Case) -> Array:
    """How far the shear traction of the prediction leaves that of slip on either side at the end,
    in gaps between zones that too few nodes lie in, (n,)."""
    slips = np.abs(case.at_nodes.slip_rate[-1]) > NOTHING * case.rate
    gaps = scipy.ndimage.binary_closing(np.pad(slips, NARROW), np.ones(NARROW, dtype=bool))[
        NARROW:-NARROW
    ]
    gaps &= ~slips
    traction, x = case.at_nodes.shear_traction[-1], case.seen.x
    if not gaps.any():
        return np.zeros(len(x))
    return np.asarray(np.interp(x, x[~gaps], traction[~gaps]) - traction)


def _beside_edge(case: Case) -> float:
    """Where the elements end that are left out next to the edge [length]."""
    return (EDGE_CELLS + 0.5) * case.simulation.element_size


def _reach(case: Case) -> tuple[float, float]:
    return NEAREST * case.length, FARTHEST * case.length


def _disturbed(case: Case) -> tuple[float, float]:
    return NEAREST * case.length, case.scene.fastest_speed * case.end_time


def _norm(case: Case, answer: Answers, reach: tuple[float, float], scale: float) -> float:
    """L1 norm of a prediction between two positions at the end, over its scale and c_t T."""
    x = _between(case, reach)
    return norm(answer(x, case.end_time) / scale, x / case.length, 1)


def _worn_norm(case: Case, part: int, reach: tuple[float, float], scale: float) -> float | None:
    """The same of accumulated |slip| (part 0) or work per area (1); None if only nodes have it."""
    x = _between(case, reach)
    own = own_wear(case.prediction, x, case.end_time)
    return None if own is None else norm(own[part] / scale, x / case.length, 1)


def _between(case: Case, reach: tuple[float, float]) -> Array:
    """Positions between two, as far as the contact was simulated, apart from its nodes."""
    end = min(reach[1], float(case.seen.x[-1]))
    return np.linspace(max(reach[0], end / POINTS), end, POINTS)
