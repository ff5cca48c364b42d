"""Error bars of a simulation, from the same run on coarser meshes.

The changes of a reading from mesh to mesh show how fast it converges.  Where it changes by c₁ from
element size 2h to h and by c₂ from 4h to 2h, the order is p = log₂ c₂/c₁ and c₁/(2^p − 1) is still
missing at h (Roache's grid convergence index).  Orders are bounded as by Eça & Hoekstra (2014,
J. Comput. Phys. 262).  Below `LEAST_ORDER` the meshes do not converge.  Beyond `LARGEST_ORDER` the
first change of a reading is taken to be small by chance, and a part of the second one replaces it;
norms over many nodes are not small by chance.  The bar of a sequence that does not converge is
`RANGE` times the range that it covers.

The constants were measured on 160 drawn scenes, 50 of maps around two named ones and 24 named ones,
then on 206 more at the mesh of the command; none is among those of the trial.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

LEAST_ORDER = 0.5
"""Lowest order at which readings of fields with jumps converge; below it, bars would grow without
limit.  1 % of the rows measured changed with a lower order; a limit of 1 would have made it
10 %."""
LARGEST_ORDER = 1.25
"""Highest order of convergence that is believed.  Errors, above all those of slip, fall faster at
first than later, and motion at kinks and jumps does not converge with the order of the scheme, 2.
Among 2,800 rows of 144 scenes one was beyond 1.5 bars and twelve beyond one bar with a limit of
1.36; with 1.17, none and two.  Slip and slip rate of 142 drawn cases were at most 0.9 bars off."""
SAFETY = 1.25
"""Safety factor of the bar of a converging sequence.  97 % of the rows were within their bar and
none was beyond 1.5 bars, except where no mesh showed the feature; with half this factor, one in six
would have been."""
ROUNDING = 1e-6
"""Part of the uncertainty of the nodes up to which both changes are rounding: the slip of a contact
that sticks is 1e-17 on each mesh.  Changes that are small by chance are a millionth of it on two
pairs of meshes once in 1e12 readings; half and twice the value change these odds fourfold."""
RANGE = 3.0
"""Bar of a sequence that does not converge, over its range, and bar of two meshes, which show no
order, over their change.  The value is that of order 1/2, rounded up.  One of 330 fronts was beyond
1.5 bars as long as changes between two meshes that are small by chance were believed."""


@dataclass(frozen=True)
class ErrorBar:
    """Error bar of a reading: how far it may be off, judged by coarser meshes."""

    size: float  # length of the bar, in the unit of the changes
    # observed order of convergence; None with two meshes only, or where nothing changes
    order: float | None
    # Largest error of the finest mesh that the coarser meshes alone allow, if it converges at all.
    # A faulty finest mesh widens `size` but not this limit. Infinite with two meshes.
    limit: float
    converges: bool  # whether the last change is no larger than `LEAST_ORDER` allows


def error_bar(
    changes: Sequence[float],
    floor: float = 0.0,
    most: float = LARGEST_ORDER,
    norm: bool = False,
) -> ErrorBar:
    """Error bar of a reading, or of a norm.

    Changes are differences from the mesh 2h to h and, if there is such a mesh, from 4h to 2h:
    signed ones of one value, or norms of those of a field.  The floor is the uncertainty due to
    nodes, steps and rounding, in the same unit: changes that do not fall with `LEAST_ORDER` and are
    no larger than it allows show no order, and the last one counts as no smaller than it.  `most`
    is the largest order that is believed, and `norm` says that no change is small by chance.
    """
    order = observed_order(changes)
    if len(changes) == 1:
        size = RANGE * max(abs(changes[0]), floor) + floor  # it may be small by chance
        return ErrorBar(size, order, math.inf, converges=True)
    last, before = abs(changes[0]), abs(changes[1])
    # the uncertainty of the nodes on both meshes may change the reading by itself
    slowest = before / 2**LEAST_ORDER + 3 * floor
    limit = SAFETY * slowest / (2**LEAST_ORDER - 1) + floor
    if last > slowest:
        size = RANGE * max(last, before, abs(changes[0] + changes[1])) + floor
        return ErrorBar(size, order, limit, converges=False)
    seen = order if order is not None else math.inf if last == 0 else 0.0
    if seen < LEAST_ORDER and max(last, before) > ROUNDING * floor:
        last = max(last, floor)  # only the uncertainty of the nodes allows it: small by chance
    believed = min(max(seen, LEAST_ORDER), most)
    missing = (last if norm else max(last, before / 2**most)) / (2**believed - 1)
    return ErrorBar(min(SAFETY * missing + floor, limit), order, limit, converges=True)


def slowest_bar(error: ErrorBar, changes: Sequence[float], floor: float = 0.0) -> ErrorBar:
    """Error bar of a reading that converges by itself, although its changes together with those of
    what drives it do not: the changes are taken to fall with `LEAST_ORDER`.

    The error is that of the changes; these and the floor are as for `error_bar`.
    """
    last = max(abs(change) / 2 ** (LEAST_ORDER * older) for older, change in enumerate(changes))
    size = SAFETY * last / (2**LEAST_ORDER - 1) + floor
    return replace(error, size=size, converges=True)


def observed_order(changes: Sequence[float], ratio: float = 2.0) -> float | None:
    """Order of convergence shown by two mesh differences; None where they show none."""
    if len(changes) < 2 or not all(changes[:2]):
        return None
    return math.log(abs(changes[1] / changes[0]), ratio)
