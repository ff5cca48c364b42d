"""Tuning constants of the space-time solver, each with what set it.

Measurements are of docs/spacetime.md unless told otherwise.
"""

from __future__ import annotations

# --- the march --------------------------------------------------------------------------------

NODES = 1000
"""Observed nodes unless given: 0.01 % of slip rate (`preloaded`) in 0.3 s."""
LEAST_NODES = 16
MOST_NODES = 8000
"""That a march chooses by itself, some 20 seconds of work."""
MARGIN_NODES = 8
"""Beyond what waves reach on either side.  Without any 6e-4 of the largest slip rate comes back
from the mirrors (`remote-shock`, 400 nodes); from two on nothing changes."""
LARGEST_STEP_RATIO = 2.0
"""c_t dt / h that is tried at all; from 0.5 to 0.7 on, by Poisson ratio, the feedback refuses."""
SWEEPS = 2
"""Iterations of a step, an even number: with one or three marches grow without bounds.  Two and
four are off by 0.047 and 0.062 % (`preloaded`), 0.161 and 0.159 % (`remote-shock`), 0.381 and
0.380 % (`auxetic`) of slip rate, 400 nodes."""
LARGEST_FEEDBACK = 0.95
"""Of the shortest wave: the iteration of a step diverges from 1 on."""
AVERAGED_BREAKS = 2
"""Breaks of a load within a step from which on a level takes the mean: one kink is told by its
values at the levels, several are not."""
WEAKENING_NODES = 8.0
"""In the process zone of slip weakening, from which on slip and frictional work are right to 1 %:
off by 0.8 and 0.6 % with 8, 1.2 and 1.0 % with 6, in the worst of four scenes."""
LEAST_WEAKENING_NODES = 2.0
"""Below which the grid sets that length, and not the law: slip is off by 7 %, its rate by 29 %."""
TOLERANCES = (1e-11, 1e-2)
"""Of the memory's transform: 1e-11 takes 45 poles; 1e-2 is coarser than the grid."""
ONSET_SHARE = 0.01
"""Part of the largest slip rate so far that counts as the beginning of slip."""

# --- the error of a march ----------------------------------------------------------------------

ERROR_SAFETY = 1.25
"""Of the slip rate in L1, times the difference from the companion at half the nodes: the true error
is 0.35 to 1.05 of that difference in 100 scenes (`march-error`), whatever the loads."""
LARGEST_ERROR = 0.5
"""Estimate above which a march is called unresolved unless an `rtol` is given: strips of slip that
are narrower than the grid away from the edge, which nothing else tells.  True errors of 420 random
marches on 24 to 160 nodes, 284 of them in antiplane shear, were at most 0.86 of their estimates;
of one whose estimate was 0.75 almost all of the slip rate was wrong.  A limit of 1 lets that pass,
one of 0.3 refuses one march in forty more, most of them off by less than 0.15."""
READING_SAFETY = 1.6
"""Of anything else that is read off: the largest slip, which is at the edge, converges more slowly,
and single numbers less evenly; their true errors are 0.1 to 1.7 of the difference."""
MEMORY_SAFETY = 4.0
"""Times the error of the memory's transform, which march and companion share: at a tolerance of
1e-4 the slip rate is off by 3.5 times that."""
COMPANION_LAG = 64
"""Steps of a march after which its companion catches up: stepping in turn is a tenth slower."""
FIRST_NODES = 250
"""Of the first march for an `rtol`: 0.6 % in 0.05 s (`preloaded`)."""
LARGEST_GROWTH = 4.0
"""Of the nodes from one march for an `rtol` to the next: the order is not known before the second,
and a march at a quarter of the nodes costs a sixteenth."""
LEAST_GROWTH = 1.3
GROWTH_MARGIN = 1.15
"""Of the error aimed at, below `rtol`."""
ORDERS = (0.5, 2.0)
"""Within which the order seen in two marches is believed; 0.7 to 1.4 are measured."""

# --- the memory as a sum of exponentials ------------------------------------------------------

SAMPLES = 60
"""Points of the transform on each of five stretches; the fit is checked on four times as many."""
MOST_PAIRS = 60
"""Of conjugate poles; the finest tolerance takes 45."""
FAR_SAMPLE = 30.0
"""Largest s of samples: 1.5/s^2, the tail of G - 1, is right to 0.1 % there (nu = 1/3)."""
SHORTEST_SAMPLE = 0.1
"""Smallest distance of samples to the branch points, over 1 / horizon."""

# --- what a grid follows ----------------------------------------------------------------------

LARGEST_TURN = {1: 0.08, 4: 0.32}
"""Of a load within so many steps h / (2 c_t), over its largest value: frictional work is off by 1
to 3 % then."""
STEP_RATIO = 0.5
"""c_t dt / h of those steps; smaller ones do not help."""
ZONE_NODES = 4.0
"""In a slip zone at the edge, from which on it counts as resolved: frictional work is 2.3 % off."""
HALVINGS = 50
"""Bisections of the step that follows a load, ended at 0.1 %."""
TIMES = 2000
"""At which the slip zone at the edge is looked at, fewer where a load has many breaks."""
LEAST_TIMES = 40
MOST_SAMPLES = 4 * 10**6
"""Times times breaks, so that tables of thousands of samples do not hold up a march."""
NO_INTENSITY = 1e-9
"""Excess of the stress intensity over friction, relative, that is rounding."""

# --- the pressure on the grid -----------------------------------------------------------------

EXACT_KINKS = 4
"""Up to which kinks are exact at every level: 4 take 2.6 s and 8 take 6.4 s for 1,500 nodes and
1,000 levels, a table of any number 3 s."""
TABLE_SAMPLES = 2
"""Of a table per time step, so that a kink is spread over half a step."""
TABLE_ROWS = 64
"""Nodes whose responses are convolved at once, to stay in the cache."""
BLOCK_VALUES = 1 << 16
"""Pressures that are made at once, for the same reason."""

# --- the memory of the machine ----------------------------------------------------------------

LEAST_LEVELS = 16
"""That are stored at the least."""
TYPICAL_POLES = 25
"""Before the fit tells: 15 to 40."""
BYTES_PER_POLE = 80
"""And node of the grid, at the peak of a march: five complex arrays, measured."""
BYTES_PER_NODE = 400
"""Of the grid besides, measured."""
BYTES_STORED = 32
"""Per observed node and level: four fields."""
BYTES_PER_STEP = 96
"""Times, loads and totals."""
TABLE_BYTES = 8
"""Per sample of the pressure's table."""

# --- fields in the bodies -----------------------------------------------------------------------

FIELD_NODES = 128
"""Whose wavenumbers are summed, or as many as the loads need: fields after 1000 nodes are off by
1e-4 to 2e-4 in L1 then (`preloaded`, `auxetic`, kinks), by 2e-4 to 8e-4 with 64, and by 2e-5 to
7e-5 with 256, in four times the seconds."""
TAPER = 7.0
TAPER_POWER = 8
"""Wavenumbers and frequencies are tapered by exp(-7 s^8) of their share of the highest, to 1e-3: a
power of 4, or 36 or 3 in place of 7, leaves up to half as much again."""
WINDOW = 1.5
"""Length of the window in time over that of the march; 2 is no better."""
FADE = 0.25
"""Part of the march in which tractions fade out behind its end; 0.1 and 0.4 do the same."""
WRAPPED = 1e-5
"""What is left in the second window of what was in the first: 1e-3 is off by three times as much,
1e-7 gains nothing."""
FIELD_MARGIN = 8
"""Nodes beyond those that waves reach."""
FIELD_VALUES = 1 << 22
"""Tractions that are transformed at once, 32 MB."""
FIELD_LEVELS = 400
"""Depths beyond which fields are interpolated in depth, three for the shortest wave with half of
them already."""
LEVEL_DEGREE = 5
"""Of that interpolation; together below 5e-4 with 200 levels."""
FIELD_CROWD = 4
"""Pairs of a depth and a time over those with a point in them, up to which all are formed at once;
that is matrix multiplication."""
FIELD_BLOCK = 20_000
"""Pairs that are formed at once otherwise."""
FIELD_POINTS = 60
"""At which march and companion are compared."""
FIELD_SMOOTHING = 3e-4
"""What no grid mends, at the most, in L1: 2e-4 (`preloaded`), 3e-4 (kinks)."""
EDGE_SHARE = 1.0
"""Distance from the edge, over 1 / the highest wavenumber, within which the sum takes nothing more
off the stuck intensity: at a twentieth of the shortest wave stress is off by 1 to 2 times itself
(`preloaded`), with 0.6 or 2.4 up to 2.5 times, and by 5 times without."""
